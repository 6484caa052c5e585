"""Base class of the file-like objects through which HDF5 accesses a file in Python."""

import os
from typing import Any, TypeAlias

Buffer: TypeAlias = Any  # bytes, an array, ...: collections.abc.Buffer, which Python has from 3.12 on


class Seekable:
    """File-like object with a position, and ``read`` in terms of ``readinto`` of the derived class."""

    _position = 0

    @property
    def end(self) -> int:
        """Size in bytes, from which ``seek`` counts with SEEK_END."""
        raise NotImplementedError

    def readinto(self, buffer: Buffer) -> int:
        """Fill a buffer from the position on, which advances, and return the number of bytes."""
        raise NotImplementedError

    def seek(self, offset: int, whence: int = os.SEEK_SET) -> int:
        """Set the position, and return it."""
        self._position = offset + (0, self._position, self.end)[whence]
        return self._position

    def tell(self) -> int:
        """Return the position."""
        return self._position

    def read(self, size: int) -> bytes:
        """Return up to ``size`` bytes."""
        buffer = bytearray(size)
        return bytes(buffer[: self.readinto(buffer)])
