"""The commands by subject: arguments and help. What they do lives on its floor and is imported when they are called."""

import os
import sys

import click

overrides = click.option(
    "--set", "overrides", multiple=True, metavar="A.B.C=VALUE", help="Override a value of the deck; may be repeated."
)


def show(text):
    """Print; a reader that has seen enough (as ``head`` has) is no error."""
    try:
        click.echo(text)
    except BrokenPipeError:
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
