"""Compilation of several functions at the same time, by processes of their own, before the first is needed."""

import gc
import os
import struct
import threading
from contextlib import suppress

from mecano.jit import machine_code, store
from mecano.process.cores import cores

MOST = 8  # processes; each takes 0.3 GB
INDEX = struct.Struct("H")  # of a code, as it passes through a pipe; the system never splits so few bytes


def compile_ahead(codes):
    """Compile those of the ``codes`` (machine_code.Code) that no store contains, by one process per available core.

    A code that a process fails to compile is left for ``machine_code.address``, which reports why.
    """
    with machine_code.lock:
        missing = list({code.file: code for code in codes if not store.contains(code.file)}.values())
        processes = min(cores(), MOST, len(missing))
        if processes > 1:
            with suppress(OSError):  # no pipe is left: each code is compiled when it is needed
                _compile(missing, processes)


def _compile(codes, processes):
    """Compile ``codes`` in ``processes``, which end with this one."""
    with machine_code.compiling(len(codes)) as report:
        machine_code.imported_compiler().fill_tables()  # once, for all processes
        tasks, given = os.pipe()
        results, done = os.pipe()
        alive, held = os.pipe()
        os.write(given, b"".join(map(INDEX.pack, range(len(codes)))))
        os.close(given)
        children = []
        with suppress(OSError):  # no further process is left: those that have begun do the work
            while len(children) < processes:
                children.append(_start(codes, tasks, done, alive, held))
        for end in (tasks, done, alive):
            os.close(end)
        while os.read(results, INDEX.size):
            report()
        for child in children:
            os.waitpid(child, 0)
        for end in (results, held):
            os.close(end)


def _start(codes, tasks, done, alive, held):
    """Fork a process that compiles the codes whose indices it reads from ``tasks``; return its number."""
    child = os.fork()
    if child:
        return child
    try:
        os.close(held)
        gc.disable()  # a process this short needs none, and it takes a tenth of the time
        threading.Thread(target=_end_with_parent, args=(alive,), daemon=True).start()
        while index := os.read(tasks, INDEX.size):
            with suppress(Exception):
                machine_code.compile_code(codes[INDEX.unpack(index)[0]])
            os.write(done, index)
    finally:
        os._exit(0)


def _end_with_parent(alive):
    """End this process when the other end of the pipe ``alive`` is closed, since its parent has ended."""
    os.read(alive, 1)
    os._exit(0)
