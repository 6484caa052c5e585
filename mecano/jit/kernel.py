"""Kernels: functions that compiled functions can call, marked by ``@kernel``.

A kernel is compiled into the loops and entries that call it; called from Python, it runs as a Python function. numba is
imported only when something must be compiled: most processes find all they need in the store.
"""

from functools import cached_property


class Kernel:
    """A function that compiled functions can call."""

    def __init__(self, function):
        self.__wrapped__, self.__doc__, self.__module__ = function, function.__doc__, function.__module__
        self.__name__, self.__qualname__ = function.__name__, function.__qualname__

    def __call__(self, *arguments):  # noqa: D102
        return self.__wrapped__(*arguments)

    @property
    def py_func(self):
        """The Python function, under the name that numba expects."""
        return self.__wrapped__

    @cached_property
    def _compiled(self):
        from mecano.jit.compiler import compiled

        return compiled(self.__wrapped__)

    @property
    def _numba_type_(self):
        """Type of the function compiled by numba, which numba reads from objects that it does not know."""
        return self._compiled


class Inlined(Kernel):
    """A kernel that is inlined into its callers before they are optimized."""

    targetoptions = {"inline": "always"}  # attribute read by numba


kernel, inlined = Kernel, Inlined
