"""The attributes of the group ``run`` of a results file: read, and checked for changes by other programs."""

import json
from collections.abc import Callable
from typing import TYPE_CHECKING, Any

import numpy as np

if TYPE_CHECKING:
    from contextlib import AbstractContextManager

    import h5py

TYPES = {
    "title": str, "deck_path": str, "started": str, "host": str, "version_mecano": str, "process": int, "threads": int,
    "plugins": str,
}  # fmt: skip
ENDS = ("complete", "stopped", "failed", "running")  # stored as run/status


def read_attributes(group: "h5py.Group", reading: "Callable[[str], AbstractContextManager[None]]") -> dict[str, Any]:
    """Return {name: text or number} of the attributes of a group; ``reading(place)`` reports damage.

    Those in ``TYPES`` must be present, with these types.
    """
    with reading("run"):
        names = list(group.attrs)
    found = {}
    for name in dict.fromkeys([*TYPES, *names]):
        with reading(f"run/{name}"):
            found[name] = _plain(group.attrs[name])
            if type(found[name]) is not TYPES.get(name, type(found[name])):
                raise TypeError(f"it is not a {'text' if TYPES[name] is str else 'whole number'}")
    with reading("run/plugins"):
        _check_plugins(json.loads(found["plugins"]))
    return found


def _plain(value):
    value = value.item() if isinstance(value, np.generic) else value
    if not isinstance(value, str | int | float):
        raise TypeError("it is neither a text nor a number")
    return value


def _check_plugins(found):
    """Raise TypeError or KeyError unless ``found`` is {source: {"names": [text], "sha256": text}}."""
    for one in dict(found).values():
        if not (isinstance(one["sha256"], str) and all(isinstance(name, str) for name in one["names"])):
            raise TypeError("the plugins are not described")
