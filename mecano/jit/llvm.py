"""LLVM, which aborts the process when its library is loaded with too little memory: this is refused before."""

from functools import cache

from mecano.process.memory import require_memory

LIBRARY = 176 * 2**20  # bytes of address space; 160 MiB of llvmlite 0.50
TO_LOAD = 16 * 2**20  # bytes that must be free

require_memory(LIBRARY)

import llvmlite.binding as llvm  # noqa: E402


@cache
def _linker():
    llvm.initialize_native_target()
    llvm.initialize_native_asmprinter()
    return llvm.create_lljit_compiler()


def load(files: list[bytes]) -> tuple[list[int], object]:
    """Load object files, each after a line with its symbol; return addresses, and what keeps the memory alive."""
    require_memory(TO_LOAD)
    library, symbols = llvm.JITLibraryBuilder().add_current_process(), []
    for symbol, code in (one.split(b"\n", 1) for one in files):
        symbols.append(symbol.decode())
        library.add_object_img(code).export_symbol(symbols[-1])
    loaded = library.link(_linker(), f"library of {symbols[0]}")
    return [loaded[symbol] for symbol in symbols], loaded
