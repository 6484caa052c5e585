"""Machine code of functions: read from the store or compiled, and loaded into memory.

A process that finds all its functions in a store (store.py) imports neither numba nor LLVM's compiler.
"""

import os
import threading
import time
from collections.abc import Callable
from contextlib import contextmanager
from typing import NamedTuple

from mecano.errors import UsageError
from mecano.jit import image, store
from mecano.process.memory import require_memory

TO_COMPILE = 64 * 2**20  # bytes that must be free

_kept = []  # keeps loaded code alive
_addresses = {}  # of the functions that are loaded, by their file
_times = []  # wall-clock time of each compilation of this process [s]
_listeners = []  # called before and while something is compiled
os.register_at_fork(after_in_child=_times.clear)
lock = threading.RLock()  # held by the thread that compiles, forks processes that compile, or loads machine code


class Code(NamedTuple):
    """A C function that the store may contain."""

    name: str
    depends: str  # digest of everything that its code depends on
    generate: Callable  # generate(compiler) -> (symbol, machine code)

    @property
    def file(self):
        """The name of its file."""
        return f"{self.name}-{self.depends}.o"


def address(code):
    """Return the address of a Code, compiled if no store contains it."""
    if code.file not in _addresses:
        found = store.read(code.file)
        if found is None:
            with compiling(1):
                found = compile_code(code)
        _load({code.file: found})
    return _addresses[code.file]


def load(codes):
    """Load at once those of the ``codes`` that a store contains: one after the other, they take twice as long."""
    found = {code.file: store.read(code.file) for code in codes if code.file not in _addresses}
    if contents := {file: content for file, content in found.items() if content is not None}:
        _load(contents)


def compile_code(code):
    """Compile a Code, or wait for another thread or process that does, and return the contents of its file."""
    with lock, store.locked(code.file):
        found = store.read(code.file)
        if found is None:
            require_memory(TO_COMPILE)
            compiler = imported_compiler()
            from mecano.jit.compilation_error import compilation_errors

            with compilation_errors(code.name):
                symbol, machine_code = code.generate(compiler)
            found = image.linked(symbol, machine_code) or symbol.encode() + b"\n" + machine_code
            store.write(code.file, found)
    return found


def imported_compiler():
    """Return the module compiler.py; raises UsageError without numba, which only compilation needs."""
    try:
        from mecano.jit import compiler
    except ModuleNotFoundError as error:
        if error.name != "numba":
            raise
        text = "the model needs machine code that is not installed, and numba, which compiles it, is missing"
        raise UsageError(f"{text}: pip install numba") from None
    return compiler


@contextmanager
def compiling(n):
    """Count the wall-clock time of the block as compile time, and report the compilation of ``n`` codes.

    Yields a function to be called after each of them. Listeners get (0, n) before and (done, n) after each.
    """
    begun, done = time.monotonic(), 0

    def report():
        nonlocal done
        done += 1
        for listener in _listeners:
            listener(done, n)

    for listener in _listeners:
        listener(0, n)
    try:
        yield report
    finally:
        _times.append(time.monotonic() - begun)


@contextmanager
def while_compiling(listener):
    """Within the block, call ``listener(done, n)`` before ``n`` functions are compiled at once, and after each."""
    _listeners.append(listener)
    try:
        yield
    finally:
        _listeners.remove(listener)


def compile_time():
    """Return the wall-clock time [s] that this process has spent compiling."""
    return sum(_times)


def _load(files):
    """Load the functions of ``files`` {name: contents} at once."""
    images = {file: content for file, content in files.items() if image.is_image(content)}
    if images:
        _load_by(image.load, images)
    if len(images) < len(files):
        from mecano.jit.llvm import load  # takes long to import

        _load_by(load, {file: content for file, content in files.items() if file not in images})


def _load_by(load, files):
    with lock:
        addresses, kept = load([*files.values()])
        _kept.append(kept)
        _addresses.update(zip(files, addresses, strict=True))
