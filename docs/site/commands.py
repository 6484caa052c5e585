"""The page of the command line, which is also its manual page, from the help of the commands."""

from inspect import cleandoc

import click

from mecano.cli import commands


def page():
    """Return Markdown: every command with its usage, its help and its options."""
    group = click.Context(commands, info_name="mecano")
    lines = ["# Commands", "", *_text(commands.help)]
    for name, command in sorted(commands.commands.items()):
        lines += ["", f"## mecano {name}", "", *_command(click.Context(command, group, info_name=name))]
    return "\n".join(lines) + "\n"


def _command(context):
    pieces = context.command.collect_usage_pieces(context)
    lines = ["```text", " ".join([context.command_path, *pieces]), "```", "", *_text(context.command.help)]
    options = [param for param in context.command.params if isinstance(param, click.Option)]
    for names, meaning in (option.get_help_record(context) for option in options):
        lines += ["", f"`{names}`", f": {_escaped(meaning)}"]
    return lines


def _text(text):
    """Return lines of Markdown; a paragraph behind a line of ``\\b`` keeps its lines."""
    lines = []
    for paragraph in cleandoc(text).split("\n\n"):
        if paragraph.startswith("\b\n"):
            lines += ["```text", *paragraph.splitlines()[1:], "```", ""]
        else:
            lines += [_escaped(paragraph), ""]
    return lines


def _escaped(text):
    return text.replace("*", "\\*").replace("<", "&lt;")
