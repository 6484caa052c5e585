"""Commands about decks and their possible content."""

import os

import click

from mecano.commands import overrides, plugins, show


@click.command(short_help="Check a deck without running it; print a summary.")
@click.argument("deck", type=click.Path())
@overrides
@click.option("--all", "every", is_flag=True, help="List all free motions and redundant constraints, however many.")
@click.option("-q", "--quiet", is_flag=True, help="Print errors only.")
@plugins
def check(deck: str, overrides: tuple[str, ...], every: bool, quiet: bool) -> None:
    """Check a deck without running it: every error, with line and column, or a summary of the model.

    The summary gives the number of elements and steps, mass, unknowns, memory, mobility with the free motions,
    redundant constraints, and warnings of legal but suspicious input. Steady motion at the start is found. Exit code 0:
    no errors, 2: errors in the deck, 3: there is no steady motion, 4: its positions cannot be assembled.
    """
    from mecano.deck.read import read_deck

    checked = read_deck(deck, overrides)
    from mecano.analyses.progress import SweepProgress
    from mecano.analyses.summary import summary

    progress = SweepProgress(quiet, "")
    with progress.announcing_compiling():
        text = summary(checked, every, progress.note)
    if not quiet:
        show(text)


@click.command(name="list", short_help="List what a deck can contain.")
@plugins
@click.argument("group", default="")
def list_(group: str) -> None:
    """List the kinds of elements, joints and loads, the terms of laws and the sections of a deck.

    With a GROUP, such as joints or laws, only these.
    """
    from mecano.deck.catalogue import catalogue

    show(catalogue(group))


def _kinds(context, parameter, begun):
    from mecano.elements import MODULES

    return sorted(name for name in MODULES if name.startswith(begun))


@click.command(short_help="Explain a kind, a term of a law or a section of a deck.")
@click.argument("name", nargs=-1, shell_complete=_kinds)
@plugins
def explain(name: tuple[str, ...]) -> None:
    """Explain a kind, a term of a law or a section of the deck: fields, units, defaults, outputs, equations.

    Without NAME it lists all names, as `mecano list` does.
    For a word of other programs, such as "motor" or "ball joint", it names the counterparts in mecano.
    `mecano explain study` describes the files of `mecano sweep`.
    """
    words = " ".join(name)
    if not words:
        from mecano.deck.catalogue import catalogue

        return show(catalogue())
    if words == "study":
        from mecano.study.describe import explain_study

        return show(explain_study())
    from mecano.deck.catalogue import explain as text
    from mecano.errors import UsageError

    try:
        show(text(words).rstrip())
    except UsageError:
        parent = click.get_current_context().parent
        if parent is None or not isinstance(parent.command, click.Group) or words not in parent.command.commands:
            raise
        raise UsageError(f"'{words}' is a command: `mecano {words} --help` describes it") from None


@click.command(short_help="Write the JSON Schema of decks, for editors.")
@click.option("-o", "--output", type=click.Path(), help="File; default: the standard output.")
@click.option("--study", is_flag=True, help="Describe study files instead of decks.")
@plugins
def schema(output: str | None, study: bool) -> None:
    """Write the JSON Schema of decks, with which editors complete, explain and check decks while you type."""
    from mecano.deck.json_schema import schema_text
    from mecano.deck.new_file import write_text

    if study:
        from mecano.study.describe import study_schema as grammar
    else:
        from mecano.deck.json_schema import deck_schema as grammar
    text = schema_text(grammar())
    if output:
        write_text(output, text, replace=True)
    else:
        show(text)


@click.command(name="check-kind", short_help="Test the kinds and laws of a Python file (plugin).")
@click.argument("plugin", type=click.Path())
def check_kind(plugin: str) -> None:
    """Test the kinds, tyre laws and terms of laws of a Python file: tangents, power, invariance, declarations.

    The tests are those that all kinds of mecano pass, in the states that their 'sample' gives.
    """
    from mecano.analyses.plugin_check import check_plugin
    from mecano.elements.plugins import load
    from mecano.errors import UsageError

    text, failures = check_plugin(load(plugin))
    show(text)
    if failures:
        raise UsageError(f"{failures} test{'s' if failures > 1 else ''} of {plugin} failed")


def _starters(context, parameter, begun):
    from mecano.deck.sample_decks import starters

    return [name for name in starters() if name.startswith(begun)]


@click.command(short_help="Write a commented starter deck.")
@click.argument("template", required=False, shell_complete=_starters)
@click.argument("deck", required=False, type=click.Path())
@click.option("--list", "every", is_flag=True, help="List starter decks and examples.")
def new(template: str | None, deck: str | None, every: bool) -> None:
    """Write a commented starter deck, by default to TEMPLATE.yaml in this folder; without TEMPLATE, list them.

    DECK is a file, or a folder for TEMPLATE.yaml.
    """
    from mecano.deck.new_file import write_text
    from mecano.deck.sample_decks import list_of_examples, list_of_starters, starter

    if every or template is None:
        show("\n\n".join([list_of_starters(), list_of_examples()] if every else [list_of_starters()]))
        return
    path = _written_at(deck, template)
    write_text(path, starter(template))
    show(f"{path}: try `mecano check {path}`, then `mecano run {path}`")


def _written_at(deck, name):
    """Return the path of a deck that is written: ``deck``, or NAME.yaml in this folder or in the folder ``deck``.

    Raises UsageError for the name of a file of another format.
    """
    if not deck or os.path.isdir(deck):
        return os.path.join(deck or "", f"{name}.yaml")
    ending = os.path.splitext(deck)[1]
    if ending.lower() not in ("", ".yaml", ".yml"):
        from mecano.errors import UsageError

        hint = f"mecano run {name}.yaml -o {deck}" if ending == ".h5" else "name it .yaml"
        raise UsageError(f"a deck is YAML, not '{ending}': {hint}")
    return deck


def _examples(context, parameter, begun):
    from mecano.deck.sample_decks import examples

    return [name for name in examples() if name.startswith(begun)]


@click.command(short_help="Write an example deck with a known answer.")
@click.argument("name", required=False, shell_complete=_examples)
@click.argument("deck", required=False, type=click.Path())
def example(name: str | None, deck: str | None) -> None:
    """Write an example deck and the files it reads, by default to NAME.yaml in this folder; without NAME, list them.

    DECK is a file, or a folder for NAME.yaml.
    """
    from mecano.deck.sample_decks import list_of_examples, write_example

    if name is None:
        show(list_of_examples())
        return
    path = _written_at(deck, name)
    beside = write_example(name, path)
    show(f"{' and '.join([path, *beside])}: try `mecano check {path}`, then `mecano run {path}`")
