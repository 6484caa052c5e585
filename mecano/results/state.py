"""Storage of the state of a run as a group of arrays and attributes, restored bit for bit.

A state is a dict with text keys, whose values are

* NumPy arrays of numbers, booleans, texts or records of numbers: a dataset each;
* int, float, bool, str, None and NumPy scalars: an attribute each;
* dicts of the same: a group each.

Integers beyond 64 bits (states of random generators) are stored as texts. NumPy float64, int64 and bool scalars are
loaded as Python's float, int and bool.
"""

from typing import Any, TypeAlias

import h5py
import numpy as np

SavedState: TypeAlias = dict[str, Any]  # arrays, numbers, texts, None, and dicts of the same
BIG = "whole number: "


def save_state(group: h5py.Group, name: str, state: SavedState) -> None:
    """Write ``state`` as the new subgroup ``name`` of an h5py group.

    Raises
    ------
    TypeError
        A value has none of the types above.
    ValueError
        A key is not a valid name in HDF5, or the group exists.
    """
    target = group.create_group(name)
    for key, value in state.items():
        if not isinstance(key, str) or key in ("", ".") or "/" in key or "\0" in key:
            raise ValueError(f"{key!r} cannot be the name of a part of a state")
        if isinstance(value, dict):
            save_state(target, key, value)
        elif isinstance(value, np.ndarray):
            _save_array(target, key, value)
        else:
            target.attrs[key] = _attribute(key, value)


def load_state(group: h5py.Group) -> SavedState:
    """Return the dict that ``save_state`` wrote to this group."""
    state = {key: _scalar(value) for key, value in group.attrs.items()}
    for key, item in group.items():
        state[key] = load_state(item) if isinstance(item, h5py.Group) else _load_array(item)
    return state


def _save_array(group, key, array):
    if array.dtype.kind not in "biufcUSV" or array.dtype.hasobject:
        raise TypeError(f"'{key}': arrays of {array.dtype} cannot be saved")
    if array.dtype.kind in "US":  # HDF5 would cut NumPy's texts at their first zero
        plain = np.ascontiguousarray(array).reshape(-1).view(np.uint8)
        group.create_dataset(key, data=plain).attrs.update({"texts": array.dtype.str, "shape": array.shape})
    else:
        group.create_dataset(key, data=array)


def _load_array(dataset):
    array = dataset[()] if dataset.shape else np.array(dataset[()], dtype=dataset.dtype)
    if "texts" in dataset.attrs:
        return array.view(dataset.attrs["texts"]).reshape(tuple(dataset.attrs["shape"]))
    return array


def _attribute(key, value):
    if value is None:
        return h5py.Empty("f8")
    if isinstance(value, bool | str | float | np.bool_ | np.number):
        return value
    if isinstance(value, int):
        return value if -(2**63) <= value < 2**63 else BIG + str(value)
    raise TypeError(f"'{key}': {type(value).__name__} cannot be saved")


def _scalar(value):
    if isinstance(value, h5py.Empty):
        return None
    if isinstance(value, str):
        return int(value.removeprefix(BIG)) if value.startswith(BIG) else value
    return value.item() if isinstance(value, np.float64 | np.int64 | np.bool_) else value
