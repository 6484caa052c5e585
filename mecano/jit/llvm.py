"""LLVM, which aborts the process when its library is loaded with too little memory: this is refused before."""

from mecano.process.memory import require_memory

LIBRARY = 176 * 2**20  # bytes of address space; 160 MiB of llvmlite 0.50

require_memory(LIBRARY)

import llvmlite.binding as llvm  # noqa: E402, F401
