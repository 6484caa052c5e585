"""The process that forks the processes of cases: it has loaded what they need, and executed the start of their deck.

``python -m mecano.study.fork_server LOADED`` reads requests from its standard input, one a line: a JSON list of the
words of a command and the file for its output. It writes the number of each process as it starts, and the number, exit
code and processor time [s] of each as it ends. It ends with its standard input. LOADED is a JSON list of the deck, its
overrides and the files of plugins.
"""

import contextlib
import gc
import json
import os
import runpy
import signal
import sys
import traceback
from collections.abc import Sequence

from mecano.analyses.warmup import warmup
from mecano.elements import plugins
from mecano.process.lifeline import VARIABLE
from mecano.study.case_processes import end_of


def serve(deck: str, overrides: Sequence[str], plugin_files: Sequence[str]) -> None:
    """Execute the start of the ``deck``, then start and await processes, until the standard input ends."""
    replies = os.dup(1)
    os.dup2(2, 1)
    with contextlib.suppress(Exception):  # of a plugin or the deck: each case reports its own
        for file in plugin_files:
            plugins.load(file)
        list(warmup([deck], overrides))
    gc.collect()
    signal.signal(signal.SIGINT, signal.SIG_DFL)  # ends a fork silently until it handles signals, as in __main__
    gc.freeze()  # later collections would copy the pages that all processes share
    signal.signal(signal.SIGCHLD, lambda *_: _report(replies))
    for request in sys.stdin:
        words, log = json.loads(request)
        number = os.fork()
        if not number:
            os.close(replies)
            _run(words, log)
        _write(replies, number)


def _report(replies):
    """Write the ends of all processes that have ended."""
    with contextlib.suppress(ChildProcessError):  # there are no others
        while ended := end_of(-1, os.WNOHANG):
            _write(replies, *ended)


def _write(replies, *values):
    with contextlib.suppress(BrokenPipeError):  # the client has ended
        os.write(replies, f"{json.dumps(values)}\n".encode())


def _run(words, log):
    """Execute `mecano WORDS` in this process as in one of its own, with its output appended to the file ``log``."""
    signal.signal(signal.SIGCHLD, signal.SIG_DFL)
    os.setpgid(0, 0)
    os.dup2(os.open(os.devnull, os.O_RDONLY), 0)
    output = os.open(log, os.O_WRONLY | os.O_APPEND | os.O_CREAT, 0o666)
    os.dup2(output, 1)
    os.dup2(output, 2)
    os.environ[VARIABLE] = LIFELINE
    sys.argv[1:] = words
    try:
        runpy.run_module("mecano", run_name="__main__", alter_sys=True)
    except BaseException:
        traceback.print_exc()
    os._exit(1)


if __name__ == "__main__":
    LIFELINE = os.environ.pop(VARIABLE)  # of all processes; this one ends with its standard input
    serve(*json.loads(sys.argv[1]))
