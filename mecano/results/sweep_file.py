"""The file of a sweep by `mecano modes --sweep`, as HDF5 (layout in docs/results-file.md) and as CSV."""

import json
import os
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import h5py
import numpy as np

from mecano.results.disk import atomic_hdf5_file
from mecano.results.file_names import refuse_existing
from mecano.results.opening import open_format
from mecano.results.provenance import Source
from mecano.results.table import put_numbers
from mecano.results.whole_file import put_source, refuse_present, write_csv

FORMAT, FORMAT_VERSION = "mecano sweep", 1
MODES = (
    ("real_part", "1/s", "real part of the eigenvalue of a mode: growth"),
    ("imaginary_part", "rad/s", "imaginary part of the eigenvalue; of a conjugate pair the positive one"),
    ("frequency", "Hz", "damped frequency"),
    ("damping_ratio", "", "minus the real part over the modulus"),
    ("converged", "", "1 where the mode satisfies the equations, 0 where it does not"),
    ("whirl", "", "share of the kinetic energy in circles in the sense of the rotor, less that in circles against it"),
)
ROTOR = (("speed", "rad/s", "angular velocity of the rotor; nan where no state was found"),)
RESONANCES = (
    ("parameter", "", "value at which a mode has a multiple of the angular velocity of the rotor"),
    ("order", "", "this multiple"),
    ("speed", "rad/s", "angular velocity of the rotor there"),
    ("frequency", "Hz", "damped frequency of the mode there"),
    ("damping_ratio", "", "minus the real part over the modulus"),
    ("mode", "", "number of the mode, from 1"),
    ("whirl", "", "as of the modes"),
)
MAP = (
    ("growth", "1/s", "largest real part of all modes but free motions; nan where no state was found"),
    ("growing", "", "number of modes that grow; -1 where no state was found"),
    ("frequency", "Hz", "damped frequency of the mode with the largest real part"),
    ("oscillation_growth", "1/s", "largest real part of the modes that oscillate; nan where none does"),
)
CRITICAL = (
    ("parameter", "", "value at which the growth of a mode changes sign"),
    ("other", "", "value of the second parameter; nan where there is none"),
    ("frequency", "Hz", "damped frequency of the mode there"),
    ("mode", "", "number of the mode, from 1"),
    ("error", "", "bound of the rounding error of the value; not for values of an instant"),
    ("destabilizes", "", "1 where the mode becomes unstable as the parameter grows, 0 where it becomes stable"),
    ("of_instant", "", "1 where the states there are not steady: the modes and the value hold for an instant only"),
)
CLEAR = 0.1  # least whirl that is called forward or backward
GROUPS = (("modes", MODES), ("map", MAP), ("critical", CRITICAL), ("rotor", ROTOR), ("resonances", RESONANCES))


def whirl_word(whirl: float) -> str:
    """Return "forward" or "backward", or "-" for a motion in a plane, along or about the axis, or if it is nan."""
    return "forward" if whirl > CLEAR else "backward" if whirl < -CLEAR else "-"


@dataclass(frozen=True)
class SweepFile:
    """Content of a file of a sweep; ``modes`` is empty for a map of stability."""

    path: Path
    title: str
    about: str
    names: tuple[str, ...]  # of the parameters, one or two
    parameter: np.ndarray  # (n,)
    other: np.ndarray  # (m,); one nan when there is one parameter
    modes: dict[str, np.ndarray]  # name -> (modes, n)
    motions: list[str]  # (modes,) largest motions
    families: list[list[str]]  # (modes,) (n,) of their families, "" where there is none
    map: dict[str, np.ndarray]  # name -> (m, n)
    critical: dict[str, np.ndarray]  # name -> (c,)
    rotor: str = ""  # node of a Campbell diagram; "" without one
    speed: np.ndarray | None = None  # (n,) [rad/s] of the rotor
    orders: tuple[float, ...] = ()  # multiples of its speed
    resonances: dict[str, np.ndarray] | None = None  # name -> (r,)
    units: tuple[str, ...] = ()  # SI units of values, as far as sweep or deck give them, else ""


def write_sweep(path: str | os.PathLike[str], plain: Mapping[str, Any], source: Source, *, force: bool) -> None:
    """Write the ``plain`` arrays of a sweep to a file that appears only when complete. Raises ResultsError."""
    refuse_existing(path, force)
    with atomic_hdf5_file(path) as file:
        _fill(file, plain, source)


def _fill(file, plain, source):
    file["parameter"], file["other"] = plain["parameter"], plain["other"]
    for group, columns in GROUPS:
        for name, unit, doc in (column for column in columns if column[0] in plain.get(group, {})):
            put_numbers(file, f"{group}/{name}", plain[group][name], unit, doc)
    if plain["modes"]:
        for name, texts in (("motion", plain["motions"]), ("family", plain["families"])):
            words = np.array(texts, dtype=object)
            file.create_dataset(f"modes/{name}", data=words, dtype=h5py.string_dtype(), shape=words.shape)
    facts = {"about": plain["about"], "parameters": json.dumps(plain["names"]), "units": json.dumps(plain["units"])}
    if "node" in plain:
        facts |= {"rotor": plain["node"], "orders": json.dumps(plain["orders"])}
    put_source(file, source, FORMAT, FORMAT_VERSION, **facts)


def read_sweep(path: str | os.PathLike[str]) -> SweepFile:
    """Read a file of a sweep. Raises ResultsError."""
    with open_format(path, FORMAT, "a file of a sweep") as file:
        groups = {key: _columns(file.get(key, {}), columns) for key, columns in GROUPS}
        motions = [text.decode() for text in file["modes/motion"][:]] if groups["modes"] else []
        families = [[text.decode() for text in row] for row in file["modes/family"][:]] if groups["modes"] else []
        run = file["run"].attrs
        return SweepFile(Path(path), run["title"], run["about"], tuple(json.loads(run["parameters"])),
                         file["parameter"][:], file["other"][:], groups["modes"], motions, families,
                         groups["map"], groups["critical"], run.get("rotor", ""), groups["rotor"].get("speed"),
                         tuple(json.loads(run.get("orders", "[]"))), groups["resonances"],
                         tuple(json.loads(run.get("units", "[]"))))  # fmt: skip


def _columns(group, columns):
    """Return {name: values} of the columns that a group has."""
    return {name: group[name][:] for name, _, _ in columns if name in group}


def refuse_tables(path: str | os.PathLike[str], force: bool) -> None:
    """Raise ResultsError if a file with the name of a table of ``write_tables`` exists, unless ``force``."""
    for target in _tables(path):
        refuse_present(target, force)


def write_tables(path: str | os.PathLike[str], plain: Mapping[str, Any], force: bool) -> None:
    """Write the states as CSV, a row each, the critical values as ``..._critical.csv``, and ``..._resonances.csv``.

    The last is written with a rotor only. Raises ResultsError as ``write_csv``.
    """
    tables = [_rows(plain), _critical_rows(plain), *([_resonance_rows(plain)] if "node" in plain else [])]
    for target, rows in zip(_tables(path), tables, strict=False):
        write_csv(target, rows, force)


def _tables(path):
    """Return the Paths of the tables of states, of critical values, and of resonances."""
    path = Path(path)
    return path, *(path.with_name(f"{path.stem}_{what}.csv") for what in ("critical", "resonances"))


def _resonance_rows(plain):
    """Yield a row for each resonance."""
    names = {"parameter": plain["names"][0]}
    yield [names.get(name, name) + (f" [{unit}]" if unit else "") for name, unit, _ in RESONANCES]
    for row in zip(*(plain["resonances"][name] for name, _, _ in RESONANCES), strict=True):
        yield [repr(float(x)) for x in row]


def _critical_rows(plain):
    """Yield a row for each critical value; missing values are empty fields."""
    names = dict(zip(("parameter", "other"), plain["names"], strict=False))
    kept = [(name, unit) for name, unit, _ in CRITICAL if name != "other" or "other" in names]
    yield [names.get(name, name) + (f" [{unit}]" if unit else "") for name, unit in kept]
    for row in zip(*(plain["critical"][name] for name, _ in kept), strict=True):
        yield ["" if np.isnan(x) else repr(float(x)) for x in row]


def _rows(plain):
    kinds = [(name, f" [{unit}]" if unit else "") for name, unit, _ in (MODES if plain["modes"] else MAP)
             if name in plain["modes" if plain["modes"] else "map"]]  # fmt: skip
    if not plain["modes"]:
        yield [plain["names"][1], plain["names"][0], *(name + unit for name, unit in kinds)]
        for i, other in enumerate(plain["other"]):
            for j, value in enumerate(plain["parameter"]):
                yield [repr(float(x)) for x in (other, value, *(plain["map"][name][i, j] for name, _ in kinds))]
        return
    count = len(plain["modes"]["real_part"])
    names = [*(name + unit for name, unit in kinds), "family"]
    speed = plain.get("rotor", {})
    yield [plain["names"][0], *(f"{name} [rad/s]" for name in speed),
           *(f"mode {b + 1} {name}" for b in range(count) for name in names)]  # fmt: skip
    for j, value in enumerate(plain["parameter"]):
        row = [repr(float(value)), *("" if np.isnan(x[j]) else repr(float(x[j])) for x in speed.values())]
        for b in range(count):
            numbers = [plain["modes"][name][b, j] for name, _ in kinds]
            row += [*("" if np.isnan(x) else repr(float(x)) for x in numbers), plain["families"][b][j]]
        yield row
