"""The command line in a separate process, as called by a user."""

import resource
import subprocess
import sys

COMMAND = (sys.executable, "-m", "mecano")


def mecano_process(*arguments, cwd=None):
    """Run ``mecano`` with the arguments: (exit code, output, errors)."""
    ended = subprocess.run([*COMMAND, *map(str, arguments)], cwd=cwd, capture_output=True, text=True)
    return ended.returncode, ended.stdout, ended.stderr


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
