"""Reduced matrices of superelements: in the deck, or in .yaml, .npz and .h5 files next to it.

All have the same keys: ``positions``, ``stiffness``, ``mass``, optionally ``damping``, to recover inner motions
``interior_names``, ``interior_positions``, ``interior_basis``, and for pictures ``lines``. A .yaml file, the deck, and
texts in an .h5 file may name files .mtx (Matrix Market) or .npy (NumPy) that hold a matrix.
"""

import io
import math
import os
import zipfile
import zlib

import numpy as np

from mecano.deck.compose import Node, compose
from mecano.deck.containers import filled
from mecano.deck.named_file import bytes_of
from mecano.deck.scope import INVALID, Invalid, Scope
from mecano.deck.source import decoded
from mecano.deck.values import LARGEST
from mecano.deck.wording import quoted
from mecano.errors import DeckError
from mecano.schema import NUMBERS, ROWS, TEXT, VECTOR, Field, Values, list_of

CONTENT = (
    Field("positions", list_of(VECTOR), "m", "place of each boundary node, axes of the superelement"),
    Field("stiffness", ROWS, "-", "matrix K: N/m, N, N m, and of the modes"),
    Field("mass", ROWS, "-", "matrix M: kg, kg m, kg m2, and of the modes"),
    Field("damping", ROWS, "-", "matrix C: N s/m, N s, N m s, and of the modes", None),
    Field("interior_names", list_of(TEXT), "-", "names of inner nodes", None),
    Field("interior_positions", ROWS, "m", "place of each inner node", None),
    Field("interior_basis", ROWS, "-", "displacements of the inner nodes, 3 rows each, by the coordinates", None),
    Field("lines", ROWS, "-", "pairs of nodes, from 0, boundary before inner ones, joined by a line in pictures", None),
)
UNREADABLE = (
    ValueError, TypeError, OSError, KeyError, IndexError, EOFError, RuntimeError, OverflowError, zipfile.BadZipFile,
    zlib.error,
)  # fmt: skip
MOST_NUMBERS = 4_000_000  # of one matrix, whatever size the header of a file claims
NASTRAN = (".pch", ".bdf", ".nas", ".asm")
KEYS = {field.name: field for field in CONTENT}


def reduced(node: Node, field: Field, scope: Scope) -> Values | Invalid:
    """Return the values of CONTENT, matrices as lists of rows, from a mapping or from the file named by a text."""
    if type(node.value) is dict:
        return filled(node, field, CONTENT, scope)
    if type(node.value) is not str:
        return scope.refuse_value(node, field)
    if node.value not in scope.tables:
        scope.tables[node.value] = _read(node, field, scope)
    return scope.tables[node.value]


def _read(node, field, scope):
    name = node.value
    suffix = os.path.splitext(name)[1].lower()
    if suffix in NASTRAN:
        return scope.refuse(node, f"file {quoted(name)} is one of Nastran", f"`mecano import {name}` converts it")
    if suffix not in READERS:
        return scope.refuse_value(node, field)
    data = bytes_of(name, node, scope)
    if data is None:
        return INVALID
    try:
        return READERS[suffix](data, name, node, field, scope)
    except DeckError as error:
        scope.problems.extend(error.problems)
        return INVALID
    except UNREADABLE as error:
        return scope.refuse(node, f"file {quoted(name)} cannot be read as {suffix}: {_one_line(error)}")


def _yaml(data, name, node, field, scope):
    source = decoded(data, os.path.join(scope.folder, name))
    before = len(scope.problems)
    root = compose(source, scope.problems)
    if len(scope.problems) > before:
        return INVALID
    if root is None or type(root.value) is not dict:
        return scope.refuse(root or Node(None, source), "the file of a superelement is a mapping", _hint())
    folder, path, owner = scope.beside, scope.path, scope.owner
    scope.beside, scope.path, scope.owner = os.path.dirname(name), [], root
    try:
        return filled(root, Field("", field.type, "-", field.doc), CONTENT, scope)
    finally:
        scope.beside, scope.path, scope.owner = folder, path, owner


def _npz(data, name, node, field, scope):
    with zipfile.ZipFile(io.BytesIO(data)) as archive:
        arrays = {}
        for entry in archive.namelist():
            if (key := entry.removesuffix(".npy")) not in KEYS:
                return scope.refuse(node, f"file {quoted(name)} has an unknown key {quoted(key)}", _hint())
            with archive.open(entry) as stream:
                _refuse_large(_bytes_of_array(stream))
            with archive.open(entry) as stream:
                arrays[key] = np.lib.format.read_array(stream, allow_pickle=False)
    return _arrays(arrays, name, node, scope)


def _bytes_of_array(stream):
    """Return the size in bytes of the array in an .npy stream, from its header alone."""
    version = np.lib.format.read_magic(stream)
    read = np.lib.format.read_array_header_1_0 if version[0] == 1 else np.lib.format.read_array_header_2_0
    shape, _, dtype = read(stream)
    return math.prod(shape) * dtype.itemsize


def _refuse_large(size):
    """Raise ValueError if an array of this size in bytes is too large."""
    if size > 8 * MOST_NUMBERS:
        raise ValueError(f"a matrix of {size:.3g} bytes is too large; {MOST_NUMBERS} numbers are allowed")


def _hdf5(data, name, node, field, scope):
    import h5py

    with h5py.File(io.BytesIO(data), "r") as file:
        datasets = {key: item for key, item in file.items() if isinstance(item, h5py.Dataset)}
        for item in datasets.values():
            _refuse_large(item.size * item.dtype.itemsize)
        arrays = {key: item[()] for key, item in datasets.items()}
    found = {}
    for key, value in arrays.items():
        if isinstance(value, bytes):
            value = _matrix(os.path.join(os.path.dirname(name), value.decode()), node, scope)
            if value is None:
                return INVALID
        found[key] = np.array([text.decode() for text in value]) if value.dtype == object else value
    return _arrays(found, name, node, scope)


READERS = {".yaml": _yaml, ".yml": _yaml, ".npz": _npz, ".h5": _hdf5, ".hdf5": _hdf5}


def _one_line(error):
    """Return the text of an error on one printable line."""
    return "".join(c if c.isprintable() else " " for c in str(error))


def _hint():
    return "its keys: " + ", ".join(KEYS)


def _arrays(arrays, name, node, scope):
    """Return values from arrays, checked for keys, dimensions and numbers."""
    values = dict.fromkeys(KEYS)
    unknown = next((key for key in arrays if key not in KEYS), None)
    missing = next((field.name for field in CONTENT if field.required and field.name not in arrays), None)
    what = f"has an unknown key {quoted(unknown)}" if unknown else f"has no {quoted(missing)}" if missing else ""
    if what:
        return scope.refuse(node, f"file {quoted(name)} {what}", _hint())
    for key, array in arrays.items():
        if key == "interior_names":
            values[key] = [str(text) for text in np.atleast_1d(array)]
            continue
        problem = _array_problem(array, 3 if KEYS[key].name.endswith("positions") else None)
        if problem:
            return scope.refuse(node, f"file {quoted(name)}: {quoted(key)} {problem}")
        values[key] = np.asarray(array, float).tolist()
    return values


def _array_problem(array, width=None):
    """Return the reason why an array cannot be a matrix, or ""."""
    if array.ndim != 2 or array.dtype.kind not in "fiu" or 0 in array.shape:
        return f"must be a matrix of real numbers, is an array {array.shape} of {array.dtype}"
    if width and array.shape[1] != width:
        return f"must have {width} columns, has {array.shape[1]}"
    return "" if np.all(np.abs(array.astype(float)) <= LARGEST) else "has numbers that are not finite or out of range"


def rows(node: Node, field: Field, scope: Scope) -> list[list[float]] | Invalid:
    """Return a matrix as a list of rows of numbers, in place or from the file named by a text."""
    if type(node.value) is str:
        array = _matrix(os.path.join(scope.beside, node.value), node, scope)
        return INVALID if array is None else array.tolist()
    if type(node.value) is not list or not node.value:
        return scope.refuse_value(node, field)
    inner = Field(f"{field.name}", NUMBERS, field.unit, field.doc)
    values = [scope.checks["numbers"](row, inner, scope) for row in node.value]
    if INVALID in values:
        return INVALID
    return values if len({len(row) for row in values}) == 1 else scope.refuse_value(node, field)


def _matrix(name, node, scope):
    """Return the matrix of a .mtx or .npy file, or None after reporting the problem."""
    suffix = os.path.splitext(name)[1].lower()
    if suffix not in (".mtx", ".npy"):
        scope.refuse(node, f"file {quoted(name)} must be .mtx (Matrix Market) or .npy (NumPy)")
        return None
    data = bytes_of(name, node, scope)
    if data is None:
        return None
    try:
        array = _market(data) if suffix == ".mtx" else _npy(data)
    except UNREADABLE as error:
        scope.refuse(node, f"file {quoted(name)} cannot be read as {suffix}: {_one_line(error)}")
        return None
    problem = _array_problem(array)
    if problem:
        scope.refuse(node, f"file {quoted(name)} {problem}")
        return None
    return array.astype(float)


def _npy(data):
    _refuse_large(_bytes_of_array(io.BytesIO(data)))
    return np.lib.format.read_array(io.BytesIO(data), allow_pickle=False)


def _market(data):
    from scipy.io import mminfo, mmread

    rows, columns, entries, *_ = mminfo(io.BytesIO(data))
    _refuse_large(8 * max(rows * columns, entries))
    array = mmread(io.BytesIO(data))
    return array.toarray() if hasattr(array, "toarray") else array
