"""Base class of the file-like objects through which HDF5 accesses a file in Python."""

import os


class Seekable:
    """File-like object with a position, and ``read`` in terms of ``readinto`` of the derived class.

    Attributes
    ----------
    end : int
        Size in bytes, from which ``seek`` counts with SEEK_END.
    """

    _position = 0

    def seek(self, offset, whence=os.SEEK_SET):
        """Set the position, and return it."""
        self._position = offset + (0, self._position, self.end)[whence]
        return self._position

    def tell(self):
        """Return the position."""
        return self._position

    def read(self, size):
        """Return up to ``size`` bytes."""
        buffer = bytearray(size)
        return bytes(buffer[: self.readinto(buffer)])
