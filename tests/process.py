"""The command line in a separate process, as called by a user."""

import atexit
import functools
import json
import os
import resource
import subprocess
import sys
import tempfile
from pathlib import Path

COMMAND = (sys.executable, "-m", "mecano")


def mecano_process(*arguments, cwd=None, **environment):
    """Run ``mecano`` with the arguments, without standard input: (exit code, output, errors)."""
    with tempfile.NamedTemporaryFile("r") as out, tempfile.NamedTemporaryFile("r") as errors:
        environment = {**os.environ, **environment}
        request = ([*map(str, arguments)], str(cwd or Path.cwd()), environment, out.name, errors.name)
        server = _fork_server()
        print(json.dumps(request), file=server.stdin, flush=True)
        return int(server.stdout.readline()), out.read(), errors.read()


@functools.cache
def _fork_server():
    """A process that has imported what ``mecano`` needs; it ends with this one."""
    words = [sys.executable, Path(__file__).with_name("fork_server.py")]
    server = subprocess.Popen(words, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)
    atexit.register(server.communicate)
    return server


def flowing(text):
    """A text without its line breaks and indents."""
    return " ".join(text.split())


def settings(*overrides):
    """Arguments of the command line for overrides "a.b=value"."""
    return [word for text in overrides for word in ("--set", text)]


def processor_time(*arguments, cwd=None, command=COMMAND):
    """Processor time [s] of a process of ``mecano``, or another command, with the arguments; it must succeed."""
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    subprocess.run([*command, *map(str, arguments)], cwd=cwd, check=True, capture_output=True)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
