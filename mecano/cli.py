"""The command line: arguments, exit codes, progress. Nothing else; heavy modules are imported by the commands."""

import os
import signal
import sys

import click

from mecano import __version__

STOPPED = {signal.SIGINT: 130, signal.SIGTERM: 143}

for _variable in ("OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "OMP_NUM_THREADS"):
    os.environ.setdefault(_variable, "1")  # results are then the same from run to run


class Stopped(BaseException):
    """A signal asked the run to end."""

    def __init__(self, number):
        self.number = number
        super().__init__(f"stopped by {signal.Signals(number).name}")


@click.group(context_settings={"help_option_names": ["-h", "--help"]})
@click.version_option(__version__, prog_name="mecano")
def commands():
    """Simulate flexible mechanisms: decks in, results and pictures out.

    \b
    mecano check deck.yaml          look at a deck without running it
    mecano run deck.yaml            solve it into deck.h5
    mecano post deck.h5             draw the pictures an engineer wants

    Exit codes: 0 done, 2 usage or deck error, 3 no convergence, 4 cannot be assembled or singular, 5 input or
    output, 6 not finite, 7 out of memory, 130 and 143 interrupted with a valid file, 1 a bug in mecano.
    """


overrides = click.option(
    "--set", "overrides", multiple=True, metavar="A.B.C=VALUE", help="Override a value of the deck; may be repeated."
)


@commands.command()
@click.argument("deck", type=click.Path())
@click.option("-o", "--output", type=click.Path(), help="Results file; default: the deck's name with .h5, here.")
@click.option("--force", is_flag=True, help="Replace an existing results file.")
@click.option("-q", "--quiet", is_flag=True, help="Say nothing but errors.")
@overrides
def run(deck, output, force, quiet, overrides):
    """Solve a deck into a results file."""
    from mecano.deck.read import read_deck
    from mecano.progress import Progress

    checked = read_deck(deck, overrides)
    path = output or os.path.splitext(os.path.basename(deck))[0] + ".h5"
    progress = Progress(checked.values["time"], quiet, path)
    progress.compiling()
    from mecano.run import run as solve

    for number in STOPPED:
        signal.signal(number, _stop)
    final = solve(checked, path, force=force, observers=(progress,), announce=progress.note)
    progress.done(final)


@commands.command()
@click.argument("deck", type=click.Path())
@overrides
def check(deck, overrides):
    """Check a deck without running it; print bodies, mass, unknowns, mobility, redundant constraints."""
    from mecano.deck.read import read_deck

    checked = read_deck(deck, overrides)
    from mecano.summary import summary

    click.echo(summary(checked))


def _stop(number, frame):
    raise Stopped(number)


def main():
    """Run a command; every error that a user can cause or meet ends in a message and an exit code."""
    try:
        commands(standalone_mode=False)
    except click.exceptions.Abort:
        _end(130, "interrupted")
    except click.ClickException as error:
        error.show()
        _end(2)
    except Stopped as error:
        _end(STOPPED[error.number], str(error))
    except MemoryError:
        _end(7, "out of memory")
    except BrokenPipeError:
        _end(0)
    except Exception as error:
        _report(error)


def _report(error):
    from mecano.errors import DeckError, MecanoError

    if isinstance(error, DeckError):
        from mecano.deck.format import deck_error_text

        _end(error.exit_code, deck_error_text(error))
    if isinstance(error, MecanoError):
        _end(error.exit_code, f"mecano: {error}")
    raise error


def _end(code, message=""):
    if message:
        click.echo(message, err=True)
    sys.exit(code)
