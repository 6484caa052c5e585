"""Child processes that end with their parent, even if it is killed.

A child inherits the reading end of a pipe to which nothing is ever written, and waits for it: the system closes the
writing end when the parent ends, for any reason. (Linux could send the child a signal instead, but does so already at
the end of the thread that started it; other systems cannot.)
"""

import os
import signal
import threading
from typing import Any

VARIABLE = "MECANO_PARENT"  # environment variable of a child: the file descriptor of the pipe
_pipe: list[int] = []  # its ends for reading and writing, once there is a child


def popen_options() -> dict[str, Any]:
    """Return options of ``subprocess.Popen`` for a process of mecano that ends, as by SIGTERM, with this process."""
    if not _pipe:
        _pipe.extend(os.pipe())
    return {"pass_fds": _pipe[:1], "env": {**os.environ, VARIABLE: str(_pipe[0])}}


def watch_parent() -> None:
    """Start a thread that terminates this process when the parent that started it with ``popen_options`` ends."""
    descriptor = os.environ.pop(VARIABLE, "")
    if descriptor.isdecimal():
        threading.Thread(target=_end_with_parent, args=(int(descriptor),), daemon=True).start()


def _end_with_parent(descriptor):
    try:
        os.read(descriptor, 1)
    except OSError:  # the variable belongs to another process
        return
    os.kill(os.getpid(), signal.SIGTERM)
