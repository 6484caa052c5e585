"""A process that has imported what `mecano` needs, and forks a process for each command line: imports take longer.

One line of standard input per command line, one exit code on standard output.
"""

import importlib
import json
import os
import sys
import time

import mecano.__main__
import mecano.analyses.dynamic
import mecano.commands.decks
import mecano.commands.results
import mecano.commands.solving
import mecano.elements
import mecano.post.info  # noqa: F401
from mecano.cli import program
from mecano.process import interrupt

IMPORTED = {  # by commands and options with these words; here when one is first asked for, for all that follow
    "check-kind": ["mecano.analyses.plugin_check", "mecano.jit.compiler"],
    "--plugin": ["mecano.jit.compiler"],
    "modes": ["mecano.analyses.modal", "mecano.solve.modal.modes_dense"],
    "post": ["mecano.post.pictures", "mecano.post.report_page", "matplotlib.backends.backend_agg"],
    "sweep": ["mecano.commands.studies", "mecano.study.pool"],
}


def execute(words, folder, environment, out, errors):
    """Run the command line, with output and errors to two files, and end the process."""
    for path, descriptor in ((os.devnull, 0), (out, 1), (errors, 2)):
        opened = os.open(path, os.O_RDWR)
        os.dup2(opened, descriptor)
        os.close(opened)
    os.environ.clear()
    os.environ.update(environment)
    os.chdir(folder)
    sys.argv[1:] = words
    interrupt.BEGUN = time.monotonic()
    program()


for line in sys.stdin:
    request = json.loads(line)
    for name in [name for word in request[0] for name in IMPORTED.get(word, ())]:
        importlib.import_module(name)
    child = os.fork()
    if child == 0:
        execute(*request)
    code = os.waitstatus_to_exitcode(os.waitpid(child, 0)[1])
    print(code, flush=True)
