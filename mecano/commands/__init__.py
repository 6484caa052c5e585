"""Code shared by the commands: options and groups of them, refusal of empty texts, printing.

Each subject has a file of its commands. Their implementations are imported when they are called.
"""

import math
import os
import sys
from collections.abc import Callable
from contextlib import suppress
from functools import wraps
from typing import Any

import click

WARNING = "mecano: "

overrides = click.option(
    "--set",
    "overrides",
    multiple=True,
    metavar="A.B.C=VALUE",
    help="Override a value of the deck, such as time.end=2; may be repeated.",
)


def results_path(given: str | None, default: str) -> str:
    """Return the path of a results file: ``given``, with .h5 if its name has no ending, or the ``default``."""
    if given is None or os.path.exists(given):
        return given or default
    ending = os.path.splitext(given)[1][1:]
    return given if ending and not ending.isdigit() else f"{given}.h5"


def together(*options: Callable[..., Any]) -> Callable[..., Any]:
    """Return a decorator that adds several options to a command, in their order."""

    def decorate(command):
        for option in reversed(options):
            command = option(command)
        return command

    return decorate


def grouped(**groups: type[Any]) -> Callable[..., Any]:
    """Return a decorator by which a command receives the options that are the fields of a group as one argument.

    ``groups`` are named tuples, by the names of these arguments.
    """

    def decorate(command):
        @wraps(command)
        def call(**given):
            of = {name: group(**{field: given.pop(field) for field in group._fields}) for name, group in groups.items()}
            return command(**given, **of)

        return call

    return decorate


def _load(context, parameter, paths):
    """Load installed plugins, and those that the user names."""
    from mecano.elements import plugins as found

    found.load_installed()
    for path in paths:
        found.load(path)


saved_state = together(
    click.option(
        "--at", metavar="RESULTS.h5:TIME", help="Linearize about the saved state nearest to TIME; default: the start."
    ),
    click.option(
        "--at-rest", is_flag=True,
        help="Linearize about the equilibrium near the state of --at, with its latches and contacts, at zero velocity.",
    ),
)  # fmt: skip
axes = click.option(
    "--frame", default="inertial", show_default=True, metavar="NODE|WX,WY,WZ|inertial",
    help="Axes in which motions are measured, turning with a node or with an angular velocity [rad/s].",
)  # fmt: skip
BELOW = (
    "Leave modes of higher frequency out of the picture of a sweep; default: far above growing or least damped ones."
)
ABOVE = "Leave modes of lower frequency, and those that do not oscillate, out of the picture of a sweep."
plugins = click.option(
    "--plugin", multiple=True, metavar="FILE.py", callback=_load, expose_value=False, is_eager=True,
    help="Python file with your own kinds, tyre laws and laws, which is executed; may be repeated.",
)  # fmt: skip


def refuse_empty(context: click.Context, parameter: click.Parameter, value: Any) -> Any:
    """Return the value of an option or argument; raise BadParameter for an empty text or nan.

    Options that may be repeated are checked where they are read, to give the position of an empty override.
    """
    if value == "" and parameter.default != "":
        raise click.BadParameter("an empty text; leave it out, or give a value", context, parameter)
    if isinstance(value, float) and math.isnan(value):
        raise click.BadParameter("it is not a number", context, parameter)
    return value


def require_saved_state(at: str | None, at_rest: bool) -> None:
    """Raise BadParameter for --at-rest without --at."""
    if at_rest and at is None:
        raise click.BadParameter("belongs to --at RESULTS.h5:TIME", param_hint="--at-rest")


def show_with_warnings(text: str) -> None:
    """Print the lines of a table, and on the standard error those of its warnings, which begin with "mecano: "."""
    lines = text.split("\n")
    show("\n".join(line for line in lines if not line.startswith(WARNING)))
    with suppress(OSError):  # the terminal may have been closed
        click.echo("".join(f"{line}\n" for line in lines if line.startswith(WARNING)), err=True, nl=False)


def show(text: str) -> None:
    """Print a text; a reader that closes the pipe early (such as ``head``) is not an error."""
    try:
        click.echo(text)
    except BrokenPipeError:
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
