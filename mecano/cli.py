"""The command line: its commands, errors and exit codes. Nothing else; heavy modules are imported by the commands."""

import atexit
import contextlib
import gc
import os
import sys
import warnings

import click

from mecano import __version__
from mecano.commands import decks, results, shell, solving, studies, viewing
from mecano.process.interrupt import stopped_by
from mecano.process.lifeline import watch_parent
from mecano.process.memory import is_lack_of_memory

OUT_OF_MEMORY = "mecano: out of memory; `mecano check` says how much a run takes, `ulimit -v` how much is allowed"

for _variable in ("OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "OMP_NUM_THREADS"):
    os.environ.setdefault(_variable, "1")  # results are then the same from run to run


@click.group(context_settings={"help_option_names": ["-h", "--help"]})
@click.version_option(__version__, prog_name="mecano")
def commands():
    """Simulate flexible mechanisms: decks in, results and pictures out.

    \b
    mecano check deck.yaml          look at a deck without running it
    mecano run deck.yaml            solve it into deck.h5
    mecano view deck.yaml           show the model in a browser before it runs
    mecano modes deck.yaml          modes of small motions about its start or equilibrium
    mecano sweep study.yaml         run a deck many times with other values
    mecano post deck.h5             draw the pictures an engineer wants
    mecano export deck.h5           write them as CSV, or for ParaView
    mecano info deck.h5             say what is in a file and how the run went
    mecano verify deck.h5           look for changed bytes
    mecano list, mecano explain     what a deck can contain
    mecano new pendulum             a deck to begin with
    mecano example pendulum         a deck whose answer is known
    mecano schema                   the grammar of decks, for editors
    mecano completion bash          completion by the shell

    Exit codes: 0 done, 2 usage or deck error, 3 no convergence, 4 cannot be assembled or singular, 5 input or
    output, 6 not finite, 7 out of memory, 75 stopped in time by --max-walltime or SIGUSR1, 130 by Ctrl-C, 143 by
    SIGTERM, 129 by SIGHUP, 152 by SIGXCPU (all with a file for --resume), 1 a bug in mecano; 3 of a study: not all of
    its cases are complete.
    """


for _command in (
    decks.check, decks.list_, decks.explain, decks.schema, decks.new, decks.example,
    solving.run, solving.modes, solving.reduce_,
    studies.sweep, studies.warmup,
    viewing.view, results.post, results.export, results.info, results.verify,
    shell.completion,
):  # fmt: skip
    commands.add_command(_command)


def main():
    """Run a command; every error that a user can cause or meet ends in a message and an exit code."""
    if not sys.warnoptions:
        warnings.simplefilter("ignore")  # Python's and NumPy's are for developers: `python -W default -m mecano`
    try:
        commands(prog_name="mecano", standalone_mode=False)
    except click.exceptions.Abort as error:
        stopped = stopped_by(error)
        _end(stopped.exit_code if stopped else 130, f"mecano: {stopped or 'interrupted'}")
    except click.ClickException as error:
        error.show()
        _end(2)
    except Exception as error:
        _report(error)


def program():
    """``main`` as a process of its own: the objects of the model all live to its end.

    To look for dead ones among them again and again would take 0.1 s, to take them apart at the end 0.3 s.
    """
    gc.set_threshold(200_000, 20, 20)
    watch_parent()
    try:
        main()
        code = 0
    except SystemExit as ended:
        code = ended.code or 0
    except BaseException as error:
        if not (stopped := stopped_by(error)):
            raise
        code = stopped.exit_code  # of a signal that came again while the first one was answered
    atexit._run_exitfuncs()  # os._exit leaves them out
    for stream in (sys.stdout, sys.stderr):
        with contextlib.suppress(OSError):
            stream.flush()
    os._exit(code)


def _report(error):
    from mecano.errors import DeckError, MecanoError

    if stopped := stopped_by(error):
        _end(stopped.exit_code, f"mecano: {stopped}")
    if isinstance(error, DeckError):
        from mecano.deck.format import deck_error_text

        _end(error.exit_code, deck_error_text(error))
    if is_lack_of_memory(error):
        _end(7, OUT_OF_MEMORY)
    if isinstance(error, MecanoError):
        _end(error.exit_code, f"mecano: {error}")
    raise error


def _end(code, message=""):
    if message:
        with contextlib.suppress(OSError):  # nobody may listen any more: the terminal was closed
            click.echo(message, err=True)
    sys.exit(code)
