"""A place in a file that HDF5 reads through Python."""

import os


class Seekable:
    """What files for HDF5 share: the position, and reading from it by ``readinto``.

    Attributes
    ----------
    end : int
        Bytes from which ``seek`` counts with SEEK_END.
    """

    _position = 0

    def seek(self, offset, whence=os.SEEK_SET):
        """Move, and return the new position."""
        self._position = offset + (0, self._position, self.end)[whence]
        return self._position

    def tell(self):
        """Return the position."""
        return self._position

    def read(self, size):
        """Read bytes."""
        buffer = bytearray(size)
        return bytes(buffer[: self.readinto(buffer)])
