"""Functions for compiled code.

A kernel is compiled into the loops and entries that call it; called from Python it is the Python function that it is.
numba is imported when something must be compiled, not before: most processes find all they need in the store.
"""

from functools import cached_property, update_wrapper


class Kernel:
    """A function that compiled functions may call."""

    def __init__(self, function):
        update_wrapper(self, function)

    def __call__(self, *arguments):  # noqa: D102
        return self.__wrapped__(*arguments)

    @property
    def py_func(self):
        """The Python function, under the name by which numba asks for it."""
        return self.__wrapped__

    @cached_property
    def _compiled(self):
        from mecano.jit.compiler import compiled

        return compiled(self.__wrapped__)

    @property
    def _numba_type_(self):
        """What numba asks of an object that it does not know: here, the type of the function compiled by numba."""
        return self._compiled


class Inlined(Kernel):
    """A kernel that becomes part of its callers before they are optimized."""

    targetoptions = {"inline": "always"}  # as numba asks for it


kernel, inlined = Kernel, Inlined
