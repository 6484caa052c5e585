"""The commands by subject: arguments and help. Their implementations are imported when they are called."""

import os
import sys

import click

overrides = click.option(
    "--set", "overrides", multiple=True, metavar="A.B.C=VALUE", help="Override a value of the deck; may be repeated."
)


def show(text):
    """Print a text; a reader that closes the pipe early (such as ``head``) is no error."""
    try:
        click.echo(text)
    except BrokenPipeError:
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
