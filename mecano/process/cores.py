"""Processor cores of this machine, and threads of BLAS on them."""

import os
from collections.abc import Iterator
from contextlib import contextmanager
from functools import cache
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from threadpoolctl import ThreadpoolController


def cores() -> int:
    """Return the number of processor cores available to this process."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def blas_threads() -> int:
    """Return the number of threads of NumPy's and SciPy's linear algebra, on which the last digits depend.

    They are as many as OPENBLAS_NUM_THREADS says, else one, so that results repeat.
    """
    given = os.environ.get("OPENBLAS_NUM_THREADS", "")
    return int(given) if given.isdecimal() else 1


@contextmanager
def bounded_blas() -> Iterator[None]:
    """Bound the threads of BLAS within the block, or in the decorated function, to ``blas_threads()``.

    The commands bound them by variables of the environment, which BLAS reads when it is loaded; a calling program may
    have loaded it before.
    """
    with _libraries().limit(limits=blas_threads(), user_api="blas"):
        yield


@cache
def _libraries() -> "ThreadpoolController":
    import scipy.linalg  # noqa: F401  # loads its BLAS, which is then found
    from threadpoolctl import ThreadpoolController

    return ThreadpoolController()
