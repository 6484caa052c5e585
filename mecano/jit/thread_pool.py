"""Threads on which compiled code calls a function for several parts of its work.

The parts are fixed by the work, not by the number of threads, and share nothing that one of them writes: any number of
threads gives the same bits. The thread that has the work takes parts like the others, so the work is done even while
the others get no processor, or do not exist, as in a process made by a fork.

A part is taken by the one thread that finds its semaphore (POSIX) raised.
"""

import atexit
import ctypes
import os
import signal
import threading

import numpy as np

from mecano.errors import UsageError
from mecano.jit.entry import Indices, entry
from mecano.jit.kernel import kernel
from mecano.jit.memory import call, call_for_int, integers
from mecano.process.cores import cores

VARIABLE = "MECANO_THREADS"  # environment variable: number of threads
PARTS = 2  # of all work
SEMAPHORE = 64  # B, a line of the cache; that of a C library has 16 or 32
WATCH = 20_000  # looks at a semaphore before the thread sleeps, some 0.1 ms
STACK = 2**20  # B for a helper

# Words of the pool: addresses of semaphores, the first of the parts; of C functions; the state; the work at hand.
WAKE, DONE, TAKE, POST, WAIT, TRY, THREADS, CLOSING, FUNCTION, FIRST, STRIDE = range(11)
LENGTH = 11


@kernel
def run_parts(pool, function, first, stride):
    """Call the C function for every part; it gets the address of the part, and 0.

    ``pool``: address (``pool()``); the parts lie ``stride`` bytes apart, the first at the address ``first``.
    """
    p = integers(pool, LENGTH)
    p[FUNCTION], p[FIRST], p[STRIDE] = function, first, stride
    if p[THREADS] == 1:
        for i in range(PARTS):
            call(function, first + i * stride, 0)
        return
    for i in range(PARTS):
        call_for_int(p[POST], p[TAKE] + i * SEMAPHORE)
    for _ in range(p[THREADS] - 1):
        call_for_int(p[POST], p[WAKE])
    for _ in range(PARTS - take_parts(p)):
        wait(p, p[DONE])
    while call_for_int(p[TRY], p[WAKE]) == 0:  # of helpers that come too late
        pass


@kernel
def take_parts(p):
    """Do the parts that no other thread has taken; return their number."""
    taken = 0
    for i in range(PARTS):
        if call_for_int(p[TRY], p[TAKE] + i * SEMAPHORE) == 0:
            call(p[FUNCTION], p[FIRST] + i * p[STRIDE], 0)
            taken += 1
    return taken


@kernel
def wait(p, semaphore):
    """Wait until a semaphore can be lowered: watch it for a while, since it takes longer to wake a thread."""
    for _ in range(WATCH):
        if call_for_int(p[TRY], semaphore) == 0:
            return
    while call_for_int(p[WAIT], semaphore) != 0:
        pass


@entry
def help_out(pool: Indices):
    """Take parts of all work until the pool is closed."""
    while True:
        wait(pool, pool[WAKE])
        if pool[CLOSING]:
            return
        for _ in range(take_parts(pool)):
            call_for_int(pool[POST], pool[DONE])


_pool, _semaphores = np.zeros(LENGTH, np.int64), np.zeros((2 + PARTS, SEMAPHORE // 8), np.int64)
_pool[THREADS] = 1
_helpers = []
_wanted = None  # number of threads


def use(n):
    """Use ``n`` threads from now on; more than PARTS have nothing to do."""
    global _wanted
    _wanted = n
    if _pool[WAKE]:
        _start()


def threads():
    """Return the number of threads to be used: that of ``use``, of the environment, or of the cores.

    Raises UsageError.
    """
    if _wanted is not None:
        return _wanted
    given = os.environ.get(VARIABLE)
    if given is None:
        return min(cores(), PARTS)
    if not given.isdecimal() or int(given) < 1:
        raise UsageError(f"{VARIABLE} must be a number of threads, 1 or more, not '{given}'")
    return int(given)


def pool():
    """Return the address of the pool, whose threads run."""
    if not _pool[WAKE]:
        _pool[WAKE], _pool[DONE], _pool[TAKE] = (_semaphores[i].ctypes.data for i in range(3))
    _start()
    return _pool.ctypes.data


def _start():
    """Start the threads that are missing; without semaphores, or where no thread can be started, one does all work."""
    wanted = min(threads(), PARTS)
    if wanted > 1 and not _pool[POST] and not _initialize_semaphores():
        wanted = 1
    while len(_helpers) < wanted - 1:
        helper = threading.Thread(target=_help, args=(help_out.address,), name="mecano helper", daemon=True)
        usual = threading.stack_size(STACK)
        try:
            helper.start()
        except RuntimeError:
            wanted = 1 + len(_helpers)
            break
        finally:
            threading.stack_size(usual)
        _helpers.append(helper)
    _pool[THREADS] = wanted


def _initialize_semaphores():
    """Initialize the semaphores, all at zero; return whether the C library has them."""
    library = ctypes.CDLL(None)
    if any(library.sem_init(ctypes.c_void_p(s.ctypes.data), 0, 0) for s in _semaphores):
        return False
    for place, name in ((POST, "sem_post"), (WAIT, "sem_wait"), (TRY, "sem_trywait")):
        _pool[place] = ctypes.cast(getattr(library, name), ctypes.c_void_p).value
    return True


def _help(address):
    """Take part in all work, without the lock of the interpreter; signals are for the main thread."""
    signal.pthread_sigmask(signal.SIG_BLOCK, signal.valid_signals())
    function = ctypes.CFUNCTYPE(None, ctypes.c_char_p, ctypes.c_void_p)(address)
    function(help_out.call_from_compiled_code(_pool).words.tobytes(), None)


@atexit.register
def _close():
    """End the helpers, before the memory that they read is freed."""
    _pool[CLOSING] = 1
    for _ in _helpers:
        ctypes.CDLL(None).sem_post(ctypes.c_void_p(int(_pool[WAKE])))
    for helper in _helpers:
        helper.join()


def _forget_helpers():
    """A process made by a fork has no helpers."""
    _helpers.clear()
    _pool[THREADS] = 1


os.register_at_fork(after_in_child=_forget_helpers)
