"""Processes that end with the one that started them, even where that is killed.

A child inherits the reading end of a pipe in which nothing is ever written, and waits there: the system closes the
writing end with the parent, however that ends. (Linux could send the child a signal instead, but does so already when
the thread ends that started it; other systems cannot.)
"""

import os
import signal
import threading

VARIABLE = "MECANO_PARENT"  # of the environment of a child: the file descriptor of the pipe
_pipe: list[int] = []  # its ends, for reading and for writing, once there is a child


def popen_options():
    """Options of ``subprocess.Popen`` for a process of mecano that ends, as by SIGTERM, when this process has ended."""
    if not _pipe:
        _pipe.extend(os.pipe())
    return {"pass_fds": _pipe[:1], "env": {**os.environ, VARIABLE: str(_pipe[0])}}


def watch_parent():
    """From now on end this process by SIGTERM when the one that started it, ``popen_options``, has ended."""
    descriptor = os.environ.pop(VARIABLE, "")
    if descriptor.isdigit():
        threading.Thread(target=_end_with_parent, args=(int(descriptor),), daemon=True).start()


def _end_with_parent(descriptor):
    try:
        os.read(descriptor, 1)
    except OSError:  # the variable was meant for another process
        return
    os.kill(os.getpid(), signal.SIGTERM)
