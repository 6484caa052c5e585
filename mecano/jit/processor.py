"""The processor for which functions are compiled: this one, or another that variables of numba name."""

import os
import platform
import sys
from functools import cache

DESCRIPTION = "/proc/cpuinfo"
LASTING = {  # keys of the file that identify a type of processor and its instructions
    "vendor_id", "cpu family", "model", "stepping", "flags",
    "CPU implementer", "CPU architecture", "CPU variant", "CPU part", "Features",
}  # fmt: skip


@cache
def description() -> dict[str, str]:
    """Return what Linux says of the first processor; {} elsewhere, or where it says something else."""
    try:
        with open(DESCRIPTION, encoding="utf-8", errors="replace") as file:
            lines = file.read(8192).partition("\n\n")[0].splitlines()
    except OSError:
        return {}
    pairs = [[part.strip() for part in line.partition(":")[::2]] for line in lines]
    return {name: value for name, value in pairs if name in LASTING}


def target() -> tuple[str, str]:
    """Return the name and the features of the processor for which functions are compiled, in the words of LLVM."""
    if given := _given():
        return given
    from mecano.jit.llvm import llvm  # slow to load

    return llvm.get_host_cpu_name(), llvm.get_host_cpu_features().flatten()


def key() -> str:
    """Return a text that distinguishes processors and systems for which functions are compiled."""
    return f"{sys.platform} {platform.machine()} {_given() or description() or target()}"


def _given():
    name, features = os.environ.get("NUMBA_CPU_NAME"), os.environ.get("NUMBA_CPU_FEATURES")
    return None if name is None or features is None else (name, features)
