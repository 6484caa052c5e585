"""The command line in a process of its own, as a user calls it."""

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
