"""The file of modes that `mecano modes` writes: HDF5, layout in docs/results-file.md."""

import json
import os
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import h5py
import numpy as np

from mecano.element_interface import Display
from mecano.results.disk import atomic_hdf5_file
from mecano.results.file_names import refuse_existing
from mecano.results.layout import Series
from mecano.results.opening import open_format
from mecano.results.provenance import Source, read_displays
from mecano.results.table import put_numbers
from mecano.results.whole_file import put_source

FORMAT, FORMAT_VERSION = "mecano modes", 1
MOTIONS = Series("mode", "", "number of the mode, and the share of its cycles")  # axis of files of motions
NUMBERS = (
    ("real_part", "1/s", "real part of the eigenvalue: growth"),
    ("imaginary_part", "rad/s", "imaginary part of the eigenvalue; of a conjugate pair the positive one"),
    ("frequency", "Hz", "damped frequency"),
    ("natural_frequency", "Hz", "modulus of the eigenvalue over 2 pi"),
    ("damping_ratio", "", "minus the real part over the modulus; nan for free motions"),
    ("residual", "", "residual of the equations, relative to the magnitudes of their terms"),
)
SHAPES = {
    "translation": ("", "displacement, inertial, real and imaginary part; the largest of a mode is 1"),
    "rotation": ("rad", "rotation vector, inertial, for the same motion; real and imaginary part"),
}
PLACES = {
    "position": ("m", "position of the state, inertial"),
    "orientation": ("", "rotation matrix of the state, material to inertial"),
}


@dataclass(frozen=True)
class ModesFile:
    """Content of a file of modes; shapes are complex, (m, 3) for each node."""

    path: Path
    title: str
    about: str
    values: np.ndarray  # (m,) complex eigenvalues
    kinds: list[str]
    converged: np.ndarray  # (m,) bool
    numbers: dict[str, np.ndarray]  # name -> (m,)
    nodes: dict[str, dict[str, np.ndarray]]
    """name -> {position (3,), orientation (3, 3), translation (m, 3), rotation (m, 3)}"""
    inner: dict[str, dict[str, np.ndarray]]
    """superelement -> {position (k, 3), translation (m, k, 3)} of the nodes inside it"""
    resolved: dict[str, Any]  # the deck
    displays: dict[str, Display]  # of its kinds
    released: frozenset[str]  # joints and elements that have been released in the state: "hinge 'pin'"


def write_modes(path: str | os.PathLike[str], contents: Mapping[str, Any], source: Source, *, force: bool) -> None:
    """Write a file of modes, which appears only when complete. Raises ResultsError."""
    refuse_existing(path, force)
    with atomic_hdf5_file(path) as file:
        _fill(file, contents, source)


def _fill(file, contents, source):
    found = contents["modes"]
    given = {"real_part": found.values.real, "imaginary_part": found.values.imag, "residual": found.residuals}
    file["mode"] = np.arange(1, len(found.values) + 1)
    file["mode"].make_scale("mode")
    for name, unit, doc in NUMBERS:
        _put(file, name, given[name] if name in given else getattr(found, name), unit, doc, file["mode"])
    file.create_dataset("kind", data=[kind.encode() for kind in found.kinds], dtype=h5py.string_dtype())
    doc = "1 where the mode satisfies the equations, 0 where it does not"
    _put(file, "converged", found.converged, "", doc, file["mode"])
    for name, node in contents["nodes"].items():
        group = file.create_group(f"nodes/{name}")
        for key, (unit, doc) in PLACES.items():
            _put(group, key, node[key], unit, doc)
        for key, (unit, doc) in SHAPES.items():
            parts = np.stack([node[key].real, node[key].imag], axis=-1)
            _put(group, key, parts, unit, doc, file["mode"])
    for name, (position, translation) in contents["inner"].items():
        group = file.create_group(f"inner/{name}")
        _put(group, "position", position, *PLACES["position"])
        parts = np.stack([translation.real, translation.imag], axis=-1)
        _put(group, "translation", parts, *SHAPES["translation"], file["mode"])
    file["released"] = np.array([name.encode() for name in contents["released"]], h5py.string_dtype())
    put_source(
        file, source, FORMAT, FORMAT_VERSION, method=found.method, computed=found.found,
        about=contents["about"], time=contents["time"], frame=contents["frame"],
    )  # fmt: skip


def _put(group, name, values, unit, doc, scale=None):
    dataset = put_numbers(group, name, values, unit, doc)
    if scale is not None:
        dataset.dims[0].attach_scale(scale)


def read_modes(path: str | os.PathLike[str]) -> ModesFile:
    """Read a file of modes. Raises ResultsError."""
    with open_format(path, FORMAT, "a file of modes; `mecano modes` writes them") as file:
        numbers = {name: file[name][:] for name, _, _ in NUMBERS}
        nodes = {name: _places(group, PLACES, SHAPES) for name, group in _groups(file, "nodes")}
        inner = {name: _places(group, ("position",), ("translation",)) for name, group in _groups(file, "inner")}
        values = numbers["real_part"] + 1j * numbers["imaginary_part"]
        kinds, run = [text.decode() for text in file["kind"][:]], file["run"].attrs
        resolved = json.loads(file["deck/resolved"][()])
        converged = file["converged"][:] > 0
        released = frozenset(name.decode() for name in file["released"][:])
        return ModesFile(Path(path), run["title"], run["about"], values, kinds, converged, numbers, nodes, inner,
                         resolved, read_displays(file), released)  # fmt: skip


def _groups(file, name):
    return file[name].items() if name in file else ()


def _places(group, real, complex_):
    found = {key: group[key][()] for key in real}
    return found | {key: group[key][..., 0] + 1j * group[key][..., 1] for key in complex_}
