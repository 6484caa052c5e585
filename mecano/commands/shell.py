"""Completion of commands, options, names and files by the shell."""

import click
from click.shell_completion import get_completion_class

from mecano.commands import show


@click.command(short_help="Print the script for completion by a shell.")
@click.argument("shell", type=click.Choice(["bash", "zsh", "fish"]))
@click.pass_context
def completion(context: click.Context, shell: str) -> None:
    """Print the script by which a shell completes commands, options, files, and names of examples and kinds.

    \b
    bash  echo 'eval "$(mecano completion bash)"' >> ~/.bashrc
    zsh   echo 'eval "$(mecano completion zsh)"' >> ~/.zshrc
    fish  mecano completion fish > ~/.config/fish/completions/mecano.fish
    """
    commands = context.find_root().command
    kind = get_completion_class(shell)
    assert kind is not None, "click completes for each shell that it offers"
    show(kind(commands, {}, "mecano", "_MECANO_COMPLETE").source())
