"""Checkpoints in two slots of the results file, which are written in turn.

A slot is an array of bytes in ``/checkpoints``: a head (mark, number of the checkpoint, length, SHA-256), then a small
HDF5 file with the state written by ``save_state``. A slot is overwritten in place, which needs no disk space and
changes nothing else in the file. A kill during writing invalidates this slot only; the other one remains valid.
"""

import hashlib
import io
import struct
from typing import TYPE_CHECKING

import h5py
from h5py import h5d, h5p, h5s, h5t

from mecano.results.state import SavedState, load_state, save_state

if TYPE_CHECKING:
    from mecano.results.disk import Disk

HEAD = struct.Struct("<8sQQ32s")
MARK = b"mecano-1"
ROOM = 2  # size of a slot over that of the first state, as later states may be larger
SPARE = 16384  # bytes


class Slots:
    """The checkpoint slots of a file that is being written through a Disk."""

    def __init__(self, file: h5py.File, disk: "Disk"):
        self._group, self._disk = file.require_group("checkpoints"), disk
        self._slots = [(0, 0), (0, 0)]  # (offset in the file, size in bytes)
        self.count = 0

    def write(self, state: SavedState) -> None:
        """Write a state to the older slot; failures are kept in ``Disk.error``."""
        content = packed(state)
        number = self.count + 1
        data = HEAD.pack(MARK, number, len(content), _digest(number, content)) + content
        turn = number % 2
        if self._slots[turn][1] < len(data):
            self._slots[turn] = self._place(ROOM * len(data) + SPARE)
        if self._disk.error is None:
            self._disk.patch(self._slots[turn][0], data)
            self.count = number

    def _place(self, size):
        """Allocate a new slot of ``size`` bytes, and return (offset in the file, size)."""
        properties = h5p.create(h5p.DATASET_CREATE)
        properties.set_layout(h5d.CONTIGUOUS)
        properties.set_alloc_time(h5d.ALLOC_TIME_EARLY)
        properties.set_fill_time(h5d.FILL_TIME_NEVER)
        name = str(len(self._group)).encode()
        dataset = h5d.create(self._group.id, name, h5t.STD_U8LE, h5s.create_simple((size,)), properties)
        self._group.file.flush()
        return dataset.get_offset(), size


def packed(state: SavedState) -> bytes:
    """Return a state (results/state.py) as the bytes of an HDF5 file."""
    with h5py.File("state", "w", driver="core", backing_store=False) as file:
        save_state(file, "state", state)
        file.flush()
        return file.id.get_file_image()


def latest(group: h5py.Group) -> SavedState | None:
    """Return the state of the last valid checkpoint in the group, or None."""
    number, content = max((_content(group, name) for name in group), default=(0, b""))
    if not number:
        return None
    with h5py.File(io.BytesIO(content), "r") as file:
        return load_state(file["state"])


def _content(group, name):
    """Return (number, bytes of the state) of a slot; (0, b"") if it is empty, damaged or incomplete."""
    try:
        dataset = group[name]
        mark, number, length, digest = HEAD.unpack(dataset[: HEAD.size].tobytes())
        content = dataset[HEAD.size : HEAD.size + length].tobytes() if mark == MARK else b""
    except (KeyError, OSError, RuntimeError, ValueError, struct.error):
        return 0, b""
    return (number, content) if content and digest == _digest(number, content) else (0, b"")


def _digest(number, content):
    return hashlib.sha256(struct.pack("<Q", number) + content).digest()
