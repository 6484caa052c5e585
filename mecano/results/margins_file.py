"""The file of margins that `mecano margins` writes: HDF5, layout in docs/results-file.md; the loop transfer as CSV."""

import os
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from mecano.results.disk import atomic_hdf5_file
from mecano.results.file_names import refuse_existing
from mecano.results.opening import open_format
from mecano.results.provenance import Source
from mecano.results.table import put_numbers
from mecano.results.whole_file import put_source, write_csv

FORMAT, FORMAT_VERSION = "mecano margins", 1
LOOP = (
    ("frequency", "Hz", "frequency"),
    ("real_part", "", "real part of the loop transfer function L"),
    ("imaginary_part", "", "imaginary part of L"),
)
CROSSOVERS = (
    ("of_gain", "", "1 where L has the magnitude 1, 0 where it has the phase -180 deg"),
    ("frequency", "Hz", "frequency of the crossover; 0 for the limit at low frequency"),
    ("real_part", "", "real part of L there"),
    ("imaginary_part", "", "imaginary part of L there"),
    ("gain_margin", "", "factor of the gain that brings poles to this frequency; nan where the phase is another"),
    ("phase_margin", "rad", "lag that brings poles to this frequency; nan where the magnitude is not 1"),
    ("delay_margin", "s", "delay that brings poles to this frequency; nan where the magnitude is not 1"),
)
POLES = (
    ("real_part", "1/s", "growth of the poles of the samples of the closed loop, s of z = exp(s T)"),
    ("imaginary_part", "1/s", "their circular frequency, at most half that of sampling; none where not determined"),
)
MARGINS = (
    ("gain", "", "least factor above 1 of the gain at which poles cross the imaginary axis; nan if none"),
    ("gain_frequency", "Hz", "frequency of these poles"),
    ("gain_reduction", "", "largest factor below 1 of the gain at which poles cross the imaginary axis; nan if none"),
    ("gain_reduction_frequency", "Hz", "frequency of these poles"),
    ("phase", "rad", "phase margin with the least modulus; nan if none"),
    ("phase_frequency", "Hz", "its crossover"),
    ("delay", "s", "least delay at which poles cross the imaginary axis; nan if none"),
    ("delay_frequency", "Hz", "frequency of these poles"),
    ("sensitivity_peak", "", "largest modulus of 1/(1 + L)"),
    ("sensitivity_peak_frequency", "Hz", "its frequency"),
    ("growing", "", "number of poles of the closed loop that grow; -1 where it was not determined"),
    ("static_gain", "", "limit of L at low frequency; nan if none"),
)


@dataclass(frozen=True)
class MarginsFile:
    """Content of a file of margins."""

    path: Path
    title: str
    about: str
    signal: str
    frequency: np.ndarray  # (n,) [Hz]
    values: np.ndarray  # (n,) complex L
    crossovers: dict[str, np.ndarray]  # name -> (k,)
    sample_poles: np.ndarray  # (m,) complex [1/s]
    margins: dict[str, float]  # name, and name_frequency -> value


def write_margins(path: str | os.PathLike[str], plain: Mapping[str, Any], source: Source, *, force: bool) -> None:
    """Write the ``plain`` numbers of margins to a file that appears only when complete. Raises ResultsError.

    ``plain``: the texts ``about`` and ``signal``, and the mappings ``loop``, ``crossovers``, ``sample_poles`` and
    ``margins``, whose names are those of LOOP, CROSSOVERS, POLES and MARGINS, of margins at a frequency also
    name_frequency.
    """
    refuse_existing(path, force)
    with atomic_hdf5_file(path) as file:
        groups = ("", LOOP), ("crossovers/", CROSSOVERS), ("sample_poles/", POLES), ("margins/", MARGINS)
        for group, columns in groups:
            for name, unit, doc in columns:
                put_numbers(file, f"{group}{name}", plain[group.rstrip("/") or "loop"][name], unit, doc)
        put_source(file, source, FORMAT, FORMAT_VERSION, about=plain["about"], signal=plain["signal"])


def read_margins(path: str | os.PathLike[str]) -> MarginsFile:
    """Read a file of margins. Raises ResultsError."""
    with open_format(path, FORMAT, "a file of margins; `mecano margins` writes them") as file:
        run = file["run"].attrs
        return MarginsFile(
            Path(path), run["title"], run["about"], run["signal"], file["frequency"][:],
            file["real_part"][:] + 1j * file["imaginary_part"][:],
            {name: file[f"crossovers/{name}"][:] for name, _, _ in CROSSOVERS}, _poles(file),
            {name: float(values[()]) for name, values in file["margins"].items()},
        )  # fmt: skip


def _poles(file):
    """Return the poles of the samples, which files of mecano 0.1 may lack."""
    if "sample_poles" not in file:
        return np.zeros(0, complex)
    return file["sample_poles/real_part"][:] + 1j * file["sample_poles/imaginary_part"][:]


def write_table(path: str | os.PathLike[str], plain: Mapping[str, Any], force: bool) -> None:
    """Write the loop transfer function as CSV next to a file, a row for each frequency. Raises ResultsError."""
    write_csv(Path(path).with_suffix(".csv"), _rows(plain["loop"]), force)


def _rows(loop) -> Iterator[list[str]]:
    yield ["frequency [Hz]", "L: magnitude", "L: phase [deg]", "1/(1 + L): magnitude"]
    values = np.asarray(loop["real_part"]) + 1j * np.asarray(loop["imaginary_part"])
    for frequency, L in zip(loop["frequency"].tolist(), values.tolist(), strict=True):
        sensitivity = np.inf if L == -1.0 else 1.0 / abs(1.0 + L)
        yield [repr(float(x)) for x in (frequency, abs(L), np.degrees(np.angle(L)), sensitivity)]
