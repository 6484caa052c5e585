"""The LLVM code of a kernel, optimized once, when it is complete.

numba optimizes each function that it compiles, loads its machine code, and optimizes the function again within every
function that calls it. Kernels are loaded from object files, so all of this is needed only for a whole kernel; without
the rest, compilation takes two thirds of the time.
"""

from contextlib import contextmanager

from numba.core.codegen import JITCodeLibrary
from numba.core.compiler_lock import global_compiler_lock
from numba.core.registry import cpu_target


class Library(JITCodeLibrary):
    """A function and the functions that it calls, not optimized and not loaded."""

    def _optimize_final_module(self):
        pass

    def _finalize_final_module(self):
        self._finalized = True

    def get_pointer_to_function(self, name):
        """Return 0, as no function has an address."""
        self._ensure_finalized()
        return 0

    def optimized(self, name):
        """Return the LLVM module of the function ``name``, optimized, in which only this function is visible.

        Variables that numba adds for Python objects, of which nothing reads, are left out then.
        """
        module = self._final_module
        for value in (*module.functions, *module.global_variables):
            if not value.is_declaration and value.name != name:
                value.linkage = "internal"
        super()._optimize_final_module()
        return self._final_module


@contextmanager
def not_loaded():
    """Have numba collect the functions that it compiles in objects of class ``Library``."""
    with global_compiler_lock:
        code_generator = cpu_target.target_context.codegen()
        code_generator._library_class = Library
        code_generator.set_env = lambda name, environment: None  # of a function without address
        try:
            yield
        finally:
            del code_generator._library_class, code_generator.set_env
