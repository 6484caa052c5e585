"""States to resume from, in two places of the results file that are written in turn.

A place is an array of bytes in ``/checkpoints``: a head (mark, number of the checkpoint, length, SHA-256), then a small
HDF5 file in which ``save_state`` has put the state. It is overwritten where it stands, which needs no room on the disk
and changes nothing else in the file; a kill in between spoils this one, and the other still holds.
"""

import hashlib
import io
import struct

import h5py
from h5py import h5d, h5p, h5s, h5t

from mecano.results.state import load_state, save_state

HEAD = struct.Struct("<8sQQ32s")
MARK = b"mecano-1"
ROOM = 2  # times what the first state takes: later ones may hold more
SPARE = 16384  # bytes


class Slots:
    """The places of a file that is being written through a Disk."""

    def __init__(self, file, disk):
        self._group, self._disk = file.require_group("checkpoints"), disk
        self._slots = [(0, 0), (0, 0)]  # (place in the file, bytes)
        self.count = 0

    def write(self, state):
        """Overwrite the older of the two; failures stand in the Disk."""
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
        """A new array of bytes, in the file before anything is written to it: (place in the file, bytes)."""
        properties = h5p.create(h5p.DATASET_CREATE)
        properties.set_layout(h5d.CONTIGUOUS)
        properties.set_alloc_time(h5d.ALLOC_TIME_EARLY)
        properties.set_fill_time(h5d.FILL_TIME_NEVER)
        name = str(len(self._group)).encode()
        dataset = h5d.create(self._group.id, name, h5t.STD_U8LE, h5s.create_simple((size,)), properties)
        self._group.file.flush()
        return dataset.get_offset(), size


def packed(state):
    """A state (results/state.py) as bytes."""
    with h5py.File("state", "w", driver="core", backing_store=False) as file:
        save_state(file, "state", state)
        file.flush()
        return file.id.get_file_image()


def latest(group):
    """The state of the last checkpoint in the group that is whole, or None."""
    number, content = max((_content(group, name) for name in group), default=(0, b""))
    if not number:
        return None
    with h5py.File(io.BytesIO(content), "r") as file:
        return load_state(file["state"])


def _content(group, name):
    """(number, bytes of the state) of one place, (0, b"") if it holds none or a spoilt one, or was just being made."""
    try:
        dataset = group[name]
        mark, number, length, digest = HEAD.unpack(dataset[: HEAD.size].tobytes())
        content = dataset[HEAD.size : HEAD.size + length].tobytes() if mark == MARK else b""
    except (KeyError, OSError, RuntimeError, ValueError, struct.error):
        return 0, b""
    return (number, content) if content and digest == _digest(number, content) else (0, b"")


def _digest(number, content):
    return hashlib.sha256(struct.pack("<Q", number) + content).digest()
