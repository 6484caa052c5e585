"""The file of a response that `mecano response` writes: HDF5, layout in docs/results-file.md; its table as CSV."""

import os
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Protocol

import h5py
import numpy as np

from mecano.results.disk import atomic_hdf5_file
from mecano.results.file_names import refuse_existing
from mecano.results.opening import open_format
from mecano.results.provenance import Source
from mecano.results.table import put_numbers
from mecano.results.whole_file import put_source, refuse_present, write_csv

FORMAT, FORMAT_VERSION = "mecano response", 1
PEAKS = (
    ("output", "", "number of the output, from 1"),
    ("input", "", "number of the input, from 1"),
    ("frequency", "Hz", "frequency of the peak of the magnitude"),
    ("magnitude", "", "magnitude there, output unit per input unit; infinite without damping"),
    ("phase", "rad", "phase there; nan without damping"),
)


class FoundPeak(Protocol):
    """A peak of a transfer function."""

    output: str
    input: str
    frequency: float
    value: complex


class Found(Protocol):
    """A response to be written."""

    frequency: np.ndarray
    values: np.ndarray
    inputs: tuple[str, ...]
    outputs: tuple[str, ...]
    input_units: tuple[str, ...]
    output_units: tuple[str, ...]
    static_gain: np.ndarray
    peaks: Sequence[FoundPeak]
    about: str


@dataclass(frozen=True)
class ResponseFile:
    """Content of a file of a response."""

    path: Path
    title: str
    about: str
    frequency: np.ndarray  # (n,) [Hz]
    values: np.ndarray  # (n, p, m) complex
    inputs: tuple[str, ...]
    outputs: tuple[str, ...]
    input_units: tuple[str, ...]
    output_units: tuple[str, ...]
    static: np.ndarray  # (p, m); nan where there is no static gain
    peaks: dict[str, np.ndarray]  # name -> (k,)


def ratio_unit(output: str, of_input: str) -> str:
    """Return the unit of a transfer function from those of its output and input: "m per N"."""
    return " per ".join("1" if unit == "-" else unit for unit in (output, of_input))


def write_response(path: str | os.PathLike[str], found: Found, source: Source, *, force: bool) -> None:
    """Write a file of a response, which appears only when complete. Raises ResultsError."""
    refuse_existing(path, force)
    with atomic_hdf5_file(path) as file:
        put_numbers(file, "frequency", found.frequency, "Hz", "frequency").make_scale("frequency")
        for name, units in (("input", found.input_units), ("output", found.output_units)):
            names = found.inputs if name == "input" else found.outputs
            file.create_dataset(name, data=[text.encode() for text in names], dtype=h5py.string_dtype())
            file.create_dataset(f"{name}_unit", data=[text.encode() for text in units], dtype=h5py.string_dtype())
            file[name].make_scale(name)
        for name, part in (("real_part", found.values.real), ("imaginary_part", found.values.imag)):
            doc = f"{name.replace('_', ' ')} of the transfer functions, output unit per input unit"
            dataset = put_numbers(file, name, part, "", doc)
            for axis, scale in enumerate(("frequency", "output", "input")):
                dataset.dims[axis].attach_scale(file[scale])
        doc = "limit at low frequency, output unit per input unit; nan if none"
        put_numbers(file, "static_gain", found.static_gain, "", doc)
        for name, values in _peaks(found).items():
            unit, doc = next((unit, doc) for one, unit, doc in PEAKS if one == name)
            put_numbers(file, f"peaks/{name}", values, unit, doc)
        put_source(file, source, FORMAT, FORMAT_VERSION, about=found.about)


def _peaks(found):
    values = np.array([peak.value for peak in found.peaks], complex)
    finite = np.isfinite(values)
    return {
        "output": np.array([1 + found.outputs.index(peak.output) for peak in found.peaks], float),
        "input": np.array([1 + found.inputs.index(peak.input) for peak in found.peaks], float),
        "frequency": np.array([peak.frequency for peak in found.peaks], float),
        "magnitude": np.where(finite, np.abs(values), np.inf),
        "phase": np.where(finite, np.angle(np.where(finite, values, 1.0)), np.nan),
    }


def read_response(path: str | os.PathLike[str]) -> ResponseFile:
    """Read a file of a response. Raises ResultsError."""
    with open_format(path, FORMAT, "a file of a response; `mecano response` writes them") as file:
        texts = {
            name: tuple(text.decode() for text in file[name][:])
            for name in ("input", "output", "input_unit", "output_unit")
        }
        run = file["run"].attrs
        return ResponseFile(
            Path(path), run["title"], run["about"], file["frequency"][:],
            file["real_part"][:] + 1j * file["imaginary_part"][:], texts["input"], texts["output"],
            texts["input_unit"], texts["output_unit"], file["static_gain"][:],
            {name: file[f"peaks/{name}"][:] for name, _, _ in PEAKS},
        )  # fmt: skip


def refuse_table(path: str | os.PathLike[str], force: bool) -> None:
    """Raise ResultsError if the table next to a file of a response exists, unless ``force``."""
    refuse_present(Path(path).with_suffix(".csv"), force)


def write_table(path: str | os.PathLike[str], found: Found, force: bool) -> None:
    """Write the transfer functions as CSV next to a file, a row for each frequency. Raises ResultsError."""
    write_csv(Path(path).with_suffix(".csv"), _rows(found), force)


def _rows(found) -> Iterator[list[str]]:
    pairs = [(i, j) for j in range(len(found.inputs)) for i in range(len(found.outputs))]
    heading = ["frequency [Hz]"]
    for i, j in pairs:
        name, unit = f"{found.outputs[i]} by {found.inputs[j]}", ratio_unit(found.output_units[i], found.input_units[j])
        heading += [f"{name}: magnitude [{unit}]", f"{name}: phase [deg]"]
    yield heading
    for frequency, H in zip(found.frequency.tolist(), found.values, strict=True):
        numbers = [x for i, j in pairs for x in (float(np.abs(H[i, j])), float(np.degrees(np.angle(H[i, j]))))]
        yield [repr(frequency), *(repr(x) for x in numbers)]
