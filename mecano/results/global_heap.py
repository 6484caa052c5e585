"""Global heaps of an HDF5 file, which hold texts of variable length (HDF5 file format specification, III.E).

The HDF5 library loops for ever over a heap in which free space has no size, as in pages that a crash filled with zeros.
"""

import mmap
import struct

SIGNATURE = b"GCOL\1\0\0\0"  # with the version and three reserved bytes
HEADER = struct.Struct("<8sQ")  # signature, size of the heap with this header
OBJECT = struct.Struct("<HH4xQ")  # index (0: free space), number of references, size of the data
ALIGNMENT = 8


def endless_heaps(descriptor: int, size: int) -> list[int]:
    """Return the places in an open file of ``size`` bytes of the heaps over which the HDF5 library loops for ever."""
    try:
        whole = mmap.mmap(descriptor, size, access=mmap.ACCESS_READ)
    except (OSError, ValueError):  # empty, or not a file that can be mapped
        return []
    with whole as data:
        return [place for place in _places(data) if _is_endless(data, place)]


def _places(data):
    """Yield the places of all heaps.

    ``mmap.find`` of Python before 3.11.4 reads the byte after the part it searches, which may lie in no page of the
    program. The last byte belongs to no signature, as a heap is longer.
    """
    place = data.find(SIGNATURE, 0, len(data) - 1)
    while place >= 0:
        yield place
        place = data.find(SIGNATURE, place + 1, len(data) - 1)


def _is_endless(data, place):
    """Return whether an object of the heap at ``place`` leads to itself."""
    if place + HEADER.size > len(data):
        return False
    end = min(place + HEADER.unpack_from(data, place)[1], len(data))
    place += HEADER.size
    while place + OBJECT.size <= end:
        index, _, size = OBJECT.unpack_from(data, place)
        step = -(-size // ALIGNMENT) * ALIGNMENT + OBJECT.size if index else size
        if not step:
            return True
        place += step
    return False
