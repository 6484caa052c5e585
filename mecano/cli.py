"""The command line: commands, errors and exit codes. Heavy modules are imported by the commands."""

import atexit
import contextlib
import os
import signal
import sys
import warnings
from collections.abc import Mapping
from importlib import import_module

import click

from mecano import __version__
from mecano.commands import refuse_empty
from mecano.process.interrupt import stopped_by
from mecano.process.lifeline import watch_parent
from mecano.process.memory import guard_imports, is_lack_of_memory

OUT_OF_MEMORY = "mecano: out of memory; `mecano check` estimates the memory of a run, `ulimit -v` shows the limit"

for _variable in ("OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "OMP_NUM_THREADS"):
    os.environ.setdefault(_variable, "1")  # for reproducible results


COMMANDS = {
    "check": "decks.check", "check-kind": "decks.check_kind", "completion": "shell.completion",
    "example": "decks.example", "explain": "decks.explain", "export": "results.export", "import": "solving.import_",
    "info": "results.info", "list": "decks.list_", "margins": "response.margins", "modes": "solving.modes",
    "momentum": "results.momentum", "new": "decks.new", "post": "results.post", "reduce": "solving.reduce_",
    "response": "response.response", "run": "solving.run", "schema": "decks.schema", "sweep": "studies.sweep",
    "verify": "results.verify", "view": "viewing.view", "warmup": "studies.warmup",
}  # fmt: skip
"""The function of each command, of a module of mecano/commands."""
MEANT = {".yaml": "run", ".yml": "run", ".h5": "post"}  # ending of a file in place of a command -> command
OTHER_NAMES = {"report": "post --report", "animate": "post --animate", "simulate": "run", "help": "--help"}


class _OnDemand(Mapping):
    """The commands by name; the module of one is imported when it is called, or listed by the help."""

    def __getitem__(self, name):
        module, function = COMMANDS[name].split(".")
        command = getattr(import_module(f"mecano.commands.{module}"), function)
        for option in command.params:
            option.callback = option.callback or refuse_empty
        return command

    def __iter__(self):
        return iter(COMMANDS)

    def __len__(self):
        return len(COMMANDS)


class _Commands(click.Group):
    """The group of the commands, which answers a file in place of a command."""

    def resolve_command(self, ctx, args):
        """Return the command of the arguments. Raises click.UsageError."""
        if args[0] not in COMMANDS and (ending := os.path.splitext(args[0])[1]) in MEANT:
            ctx.fail(f"No such command '{args[0]}'. Did you mean 'mecano {MEANT[ending]} {args[0]}'?")
        if meant := OTHER_NAMES.get(args[0]):
            ctx.fail(f"No such command '{args[0]}'. Did you mean 'mecano {meant}'?")
        return super().resolve_command(ctx, args)


@click.group(cls=_Commands, commands=_OnDemand(), context_settings={"help_option_names": ["-h", "--help"]})
@click.version_option(__version__, prog_name="mecano")
def commands() -> None:
    """Simulate flexible mechanisms: solve a deck, write a results file, draw pictures.

    \b
    mecano check deck.yaml          check a deck without running it
    mecano run deck.yaml            solve it and write deck.h5
    mecano view deck.yaml           show the model in a browser before it runs
    mecano modes deck.yaml          modes of small motions, root loci
    mecano response deck.yaml       transfer functions, linear model
    mecano margins deck.yaml        stability margins of a control loop
    mecano sweep study.yaml         run a deck many times with varied values
    mecano post deck.h5             draw the standard plots
    mecano export deck.h5           write results as CSV, or for ParaView
    mecano info deck.h5             summarize a results file and its run
    mecano momentum deck.yaml ...   momentum and centre of mass over a run
    mecano verify deck.h5           check a file for changed bytes
    mecano reduce deck.yaml         make a superelement of a part
    mecano import part.pch          make a superelement from Nastran
    mecano list, mecano explain     describe what a deck can contain
    mecano new pendulum             write a starter deck
    mecano example pendulum         write an example with a known answer
    mecano schema                   write the JSON Schema of decks
    mecano completion bash          print the script for completion

    Exit codes: 0 done, 2 usage or deck error, 3 no convergence, 4 cannot be assembled or singular, 5 input or
    output, 6 not finite, 7 out of memory, 1 a bug in mecano. Stopped, with a file for --resume: 75 by --max-walltime
    or SIGUSR1, 130 by Ctrl-C, 143 by SIGTERM, 129 by SIGHUP, 152 by SIGXCPU. Of a study: 3 some cases are not
    complete, 8 all are complete, but some are beyond the limits of its outputs.
    """


def main() -> None:
    """Run a command; report every error that a user can cause or encounter by a message and an exit code."""
    if not sys.warnoptions:
        warnings.simplefilter("ignore")  # those of Python and NumPy are for developers: `python -W default -m mecano`
    try:
        _refuse_other_bytes()
        commands(prog_name="mecano", standalone_mode=False)
    except click.exceptions.Abort as error:
        stopped = stopped_by(error)
        _end(stopped.exit_code if stopped else 130, f"mecano: {stopped or 'interrupted'}")
    except click.ClickException as error:
        error.show()
        _end(2)
    except Exception as error:
        try:
            _report(error)
        except MemoryError:  # not enough is left for the modules that word the report
            _end(7, OUT_OF_MEMORY)


def _refuse_other_bytes():
    """Raise UsageError for an argument that is not UTF-8: results files, pictures and pages name files as text."""
    for word in sys.argv[1:]:
        if not word.isprintable() and any("\ud800" <= letter <= "\udfff" for letter in word):
            from mecano.errors import UsageError  # import takes 1 % of the time of `mecano --help`

            raise UsageError(f"the argument {ascii(word)} is not UTF-8 text; give the file another name")


def program() -> None:
    """Run ``main`` as the whole process, without destruction of objects at exit, which may take 0.3 s."""
    if signal.getsignal(signal.SIGINT) is signal.SIG_DFL:  # set by __main__
        signal.signal(signal.SIGINT, signal.default_int_handler)
    watch_parent()
    guard_imports()
    try:
        main()
        code = 0
    except SystemExit as ended:
        code = int(ended.code or 0)
    except BaseException as error:
        if not (stopped := stopped_by(error)):
            raise
        code = stopped.exit_code  # of a second signal during the handling of the first
    atexit._run_exitfuncs()  # os._exit skips them
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
        with contextlib.suppress(OSError):  # the terminal may have been closed
            click.echo(message, err=True)
    sys.exit(code)
