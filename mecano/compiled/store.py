"""Machine code on the disk, and its functions in memory.

One file for each function, in a folder named by a hash of what the code depends on: all sources that are compiled, the
processor, the compiler, Python. A process that finds there what it needs imports neither numba nor LLVM's compiler.
"""

import atexit
import hashlib
import os
import secrets
import shutil
import sys
import tempfile
import time
import zlib
from contextlib import suppress
from functools import cache
from importlib.util import find_spec
from pathlib import Path

import llvmlite
import llvmlite.binding as llvm

COMPILED = ("compiled", "maths", "laws", "constraints", "elements", "model", "solve", "results")
RECORDS = "contract.py"  # makes the types of records
UNUSED = 90 * 86400.0  # s after which a folder is removed when a new one is made
FOLDER = "MECANO_CACHE_DIR"  # environment variable: where the folders of compiled code are

_kept = []  # what LLVM has loaded, which lives as long as this
_times = []  # s by the clock that each function took that this process has compiled


@cache
def folder():
    """The folder of the store; one for this process only where the usual one is not there and cannot be made."""
    base = os.environ.get(FOLDER) or os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache"
    found = Path(base).absolute() / f"mecano-{_key()}"
    if found.is_dir():
        with suppress(OSError):
            os.utime(found)
        return found
    try:
        found.mkdir(parents=True, exist_ok=True)
    except OSError:
        found = Path(tempfile.mkdtemp(prefix="mecano-"))
        atexit.register(shutil.rmtree, found, ignore_errors=True)
        return found
    _remove_old(found.parent)
    return found


def _key():
    """What tells apart the folders of sources, processors, compilers and Pythons."""
    here = Path(__file__).parent.parent
    files = [here / RECORDS, *sorted(path for part in COMPILED for path in (here / part).glob("*.py"))]
    files.append(Path(find_spec("numba").origin).with_name("_version.py"))
    processor = llvm.get_process_triple(), llvm.get_host_cpu_name(), llvm.get_host_cpu_features().flatten()
    depends = " ".join([llvmlite.__version__, sys.implementation.cache_tag, getattr(sys, "abiflags", ""), *processor])
    return hashlib.sha256(b"".join(path.read_bytes() for path in files) + depends.encode()).hexdigest()[:16]


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
        begun = time.monotonic()
        from mecano.compiled import compiler

        found = code(compiler)
        _write(name, *found)
        _times.append(time.monotonic() - begun)
    return _load(name, *found)


def compile_time():
    """Time by the clock [s] that this process has spent on compiling."""
    return sum(_times)


def has(name):
    """True when the disk has this function."""
    return (folder() / f"{name}.o").exists()


def size():
    """Bytes on the disk."""
    return sum(path.stat().st_size for path in folder().iterdir() if path.is_file())


def put(path, data):
    """Make a file that is there as a whole or not at all, whoever else writes it; without one if there is no room."""
    own = path.with_name(f"{path.name}.{secrets.token_hex(8)}")
    try:
        own.write_bytes(data)
        own.replace(path)
    except OSError:
        with suppress(OSError):
            own.unlink()


def _read(name):
    """(symbol, machine code), or None when there is none, or not what was written."""
    try:
        head, code = (folder() / f"{name}.o").read_bytes().split(b"\n", 1)
        symbol, check = head.decode().split()
        return (symbol, code) if int(check) == zlib.crc32(code) else None
    except (OSError, ValueError):
        return None


def _write(name, symbol, code):
    """Keep a function, unless the sources have changed since this process has read them."""
    if folder().name.endswith(_key()):
        put(folder() / f"{name}.o", f"{symbol} {zlib.crc32(code)}\n".encode() + code)


@cache
def _linker():
    llvm.initialize_native_target()
    llvm.initialize_native_asmprinter()
    return llvm.create_lljit_compiler()


def _load(name, symbol, code):
    """Each function is a library of its own, for compilers in different processes give functions the same symbols."""
    library = llvm.JITLibraryBuilder().add_object_img(code).add_current_process().export_symbol(symbol)
    loaded = library.link(_linker(), f"{name} {len(_kept)}")
    _kept.append(loaded)
    return loaded[symbol]
