"""Machine code that comes with an installed package, for all processors of one level.

Such code needs neither numba nor its version: only mecano's own modules, Python, and the instructions of the processor.
It is trusted as a shared store is: nobody but those who installed the package could have written it (trust.py).
"""

import hashlib
import platform
import sys
from functools import cache
from pathlib import Path

from mecano.jit import processor

OBJECTS = Path(__file__).with_name("objects")  # of the package; empty in a clone
LEVELS = {
    "x86-64-v3": "avx avx2 bmi1 bmi2 f16c fma abm movbe xsave cx16 lahf_lm popcnt pni sse4_1 sse4_2 ssse3",
    "x86-64-v2": "cx16 lahf_lm popcnt pni sse4_1 sse4_2 ssse3",
    "generic": "",
}
"""Instructions, as Linux names them, that a processor of a level has (System V ABI for x86-64), best first;
"generic", the name of LLVM for any processor of an architecture, is the level of those that are no x86-64."""


@cache
def folder(sources):
    """Return the folder with machine code for this processor, made from these ``sources`` (digest), or None."""
    if not OBJECTS.is_dir():
        return None
    features = {*processor.description().get("flags", "").split()}
    levels = (level for level, needed in LEVELS.items() if features.issuperset(needed.split()))
    return next((path for level in levels if (path := place(sources, level)).is_dir()), None)


def place(sources, level):
    """Return where the code for a level of processors belongs that was made from ``sources`` (digest)."""
    depends = " ".join(
        [sources, sys.implementation.cache_tag, getattr(sys, "abiflags", ""), sys.platform, platform.machine()]
    )
    return OBJECTS / f"{level}-{hashlib.sha256(depends.encode()).hexdigest()[:16]}"
