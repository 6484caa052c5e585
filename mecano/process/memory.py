"""Lack of memory, which libraries below Python rarely report as MemoryError: its recognition, and a test for it."""

import errno
import mmap
import sys
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from types import ModuleType

    import numpy as np

WORDS = (  # in errors of the dynamic loader, of threads, of C++ and of HDF5
    "failed to map segment from shared object",
    "cannot allocate memory",
    "can't start new thread",
    "memory allocation failed",
    "bad_alloc",
    "unable to allocate",
)
BLAS_BUFFER = 40 * 2**20  # bytes: OpenBLAS allocates 32 MiB and a little more
SCIPY = 144 * 2**20  # bytes of address space: the libraries of scipy.linalg, and the buffer of its BLAS
WITH_BLAS = ("scipy.linalg", "scipy.sparse.linalg")  # modules that load it first


def is_lack_of_memory(error: BaseException | None) -> bool:
    """Decide whether an exception, or one in its chain of causes, reports a lack of memory."""
    seen = set()
    while error is not None and id(error) not in seen:
        seen.add(id(error))
        if isinstance(error, MemoryError) or getattr(error, "errno", None) == errno.ENOMEM:
            return True
        text = str(error).lower()
        if isinstance(error, OSError | ImportError | RuntimeError) and any(words in text for words in WORDS):
            return True
        if isinstance(error, SystemError) and not _is_room():  # C code of Python that could not create its exception
            return True
        error = error.__cause__ or error.__context__
    return False


def _is_room():
    try:
        require_memory(BLAS_BUFFER)
    except MemoryError:
        return False
    return True


def require_memory(size: int) -> None:
    """Raise MemoryError if ``size`` bytes are not available, before a library would abort the process without them."""
    try:
        mmap.mmap(-1, size).close()
    except OSError:
        raise MemoryError from None


def reserve_blas_buffer(solve: "Callable[[np.ndarray, np.ndarray], object] | None" = None) -> None:
    """Make a BLAS allocate its buffer, as OpenBLAS does at its first use; raise MemoryError if there is no room for it.

    Without room, OpenBLAS itself would end the process with exit code 1 (that of NumPy) or retry forever (that of
    SciPy, a separate library). ``solve(A, b)`` is a function that uses the BLAS; default: that of NumPy.
    """
    import numpy as np  # not for `mecano --help`

    require_memory(BLAS_BUFFER)
    (solve or np.linalg.solve)(np.eye(1), np.ones(1))


class RoomForSciPy:
    """Finder of modules that finds none, but raises MemoryError without room for the libraries of SciPy.

    Without room, the OpenBLAS of SciPy would retry forever while it is loaded.
    """

    @classmethod
    def find_spec(cls, name: str, path: Sequence[str] | None = None, target: "ModuleType | None" = None) -> None:
        """Require memory before the first module that loads a BLAS."""
        if name in WITH_BLAS:
            require_memory(SCIPY)
            sys.meta_path.remove(cls)


def guard_imports() -> None:
    """Make the import of SciPy raise MemoryError in this process if there is no room for it."""
    sys.meta_path.insert(0, RoomForSciPy)
