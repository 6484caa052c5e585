"""Machine code on the disk, and its functions in memory.

One file for each function, in a folder named by a hash of what the code depends on: all sources that are compiled, the
processor, and the compiler. A process that finds there what it needs imports neither numba nor the compiler of LLVM.
"""

import hashlib
import os
import shutil
import tempfile
import time
import zlib
from contextlib import suppress
from functools import cache
from pathlib import Path

import llvmlite
import llvmlite.binding as llvm

COMPILED = ("compiled", "maths", "laws", "constraints", "elements", "model", "solve", "results")
UNUSED = 90 * 86400.0  # s after which a folder is removed when a new one is made
FOLDER = "MECANO_CACHE_DIR"  # environment variable: where the folders of compiled code are

_kept = []  # what LLVM has loaded, which lives as long as this


@cache
def folder():
    """The folder of the store; a temporary one when the usual one cannot be written."""
    sources = Path(__file__).parent.parent
    files = sorted(path for part in COMPILED for path in (sources / part).glob("*.py"))
    depends = [llvmlite.__version__, llvm.get_host_cpu_name(), llvm.get_host_cpu_features().flatten()]
    key = hashlib.sha256(b"".join(path.read_bytes() for path in files) + " ".join(depends).encode()).hexdigest()[:16]
    base = os.environ.get(FOLDER) or os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache"
    found = Path(base) / f"mecano-{key}"
    try:
        new = not found.exists()
        found.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryFile(dir=found):
            os.utime(found)
    except OSError:
        return Path(tempfile.mkdtemp(prefix="mecano-"))
    if new:
        _remove_old(found.parent)
    return found


def _remove_old(base):
    """Remove the folders of sources, processors and compilers that nobody has used for long."""
    for path in base.glob("mecano-" + 16 * "[0-9a-f]"):
        with suppress(OSError):  # another process may be faster
            if time.time() - path.stat().st_mtime > UNUSED:
                shutil.rmtree(path)


def address(name, code):
    """Address of the C function ``name``; code(compiler) -> (symbol, machine code), if the disk has none."""
    found = _read(name)
    if found is None:
        from mecano.compiled import compiler

        found = code(compiler)
        _write(name, *found)
    return _load(name, *found)


def has(name):
    """True when the disk has this function."""
    return (folder() / f"{name}.o").exists()


def size():
    """Bytes on the disk."""
    return sum(path.stat().st_size for path in folder().iterdir() if path.is_file())


def _read(name):
    """(symbol, machine code), or None when there is none, or not what was written."""
    try:
        head, code = (folder() / f"{name}.o").read_bytes().split(b"\n", 1)
        symbol, check = head.decode().split()
    except (OSError, ValueError):
        return None
    return (symbol, code) if int(check) == zlib.crc32(code) else None


def _write(name, symbol, code):
    """A file that is there as a whole or not at all, whoever else writes it."""
    with suppress(OSError), tempfile.NamedTemporaryFile(dir=folder(), delete=False) as file:
        file.write(f"{symbol} {zlib.crc32(code)}\n".encode() + code)
        file.close()
        os.replace(file.name, folder() / f"{name}.o")  # a full disk costs the next process time, nothing else


@cache
def _linker():
    llvm.initialize_native_target()
    llvm.initialize_native_asmprinter()
    return llvm.create_lljit_compiler()


def _load(name, symbol, code):
    """Each function is a library of its own, for compilers in different processes give functions the same symbols."""
    library = llvm.JITLibraryBuilder().add_object_img(code).add_current_process().export_symbol(symbol)
    _kept.append(library.link(_linker(), f"{name} {len(_kept)}"))
    return _kept[-1][symbol]
