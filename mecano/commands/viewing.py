"""Commands that show a model or a motion in a browser."""

import os
import signal
import sys
from collections.abc import Iterator
from contextlib import contextmanager, suppress

import click

from mecano.commands import overrides, plugins
from mecano.errors import MecanoError

UNTIL = "mecano: {} (until Ctrl-C)"


@click.command(short_help="Show a deck, or a motion, in a browser.")
@click.argument("file", type=click.Path())
@click.option("--wait", is_flag=True, help="Wait for a results file that does not exist yet.")
@overrides
@plugins
def view(file: str, wait: bool, overrides: tuple[str, ...]) -> None:
    """Show a deck before it runs, or the motion of a results file, in a browser.

    For a deck: the assembled model with the axes of its joints; point at a part to see its name. For results: the page
    of `mecano post --animate`, updated while the run continues. The printed address, which contains a token, is
    available on this machine only; Ctrl-C ends the command.
    """
    with suppress(KeyboardInterrupt):
        if wait or _is_results(file):
            if overrides:
                raise click.BadParameter("is about a deck", param_hint="--set")
            _refuse_missing(file, wait)
            _serve(file)
        else:
            _view_deck(file, overrides)


def _is_results(file):
    """Return whether a file is HDF5, by its content or its name."""
    with suppress(OSError), open(file, "rb") as content:
        return content.read(8) == b"\x89HDF\r\n\x1a\n"
    return os.path.splitext(file)[1] == ".h5"


def _refuse_missing(file, wait):
    """Raise ResultsError before anything is served, unless the file is yet to come."""
    if not wait:
        from mecano.results.opening import errors_as_damage
        from mecano.results.reader import open_results

        with errors_as_damage(file), open_results(file):
            pass


def _view_deck(file, overrides):
    from mecano.deck.read import read_deck

    checked = read_deck(file, overrides)
    from tempfile import TemporaryDirectory

    from mecano.analyses.preview import ASSEMBLED, preview
    from mecano.analyses.progress import SweepProgress

    with TemporaryDirectory(prefix="mecano-") as folder:
        path = os.path.join(folder, "model.h5")
        with SweepProgress(False, file).announcing_compiling():
            preview(checked, path)
        _serve(path, checked.values["title"] or os.path.basename(file), ASSEMBLED)


def _serve(path, title=None, status=None):
    from mecano.post.serve import Source, serve
    from mecano.process.interrupt import Interruption

    interruption = Interruption()
    interruption.listen((signal.SIGINT,))  # its exception may be lost while a thread of the server ends
    serve(
        Source(path, title, status), lambda address: click.echo(UNTIL.format(address)),
        lambda: interruption.raise_if_asked("by Ctrl-C"),
    )  # fmt: skip


@contextmanager
def live(path: str) -> Iterator[None]:
    """Show the results file ``path`` in a page while the block writes it and, when it is complete, until Ctrl-C.

    The page is served by a separate process, which ends with this one, so that the run imports nothing for it.
    """
    import subprocess

    from mecano.process.lifeline import popen_options

    command = [sys.executable, "-m", "mecano", "view", "--wait", os.fspath(path)]
    server = subprocess.Popen(command, **popen_options())
    try:
        yield
        with suppress(KeyboardInterrupt):
            server.wait()
    except MecanoError:
        if os.path.exists(path):
            click.echo(f"mecano: the page has ended; mecano view {path} shows the motion until the failure", err=True)
        raise
    finally:
        server.terminate()
        server.wait()
