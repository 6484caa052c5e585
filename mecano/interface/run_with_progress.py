"""Solve a checked deck, dynamic or static, with progress on the standard error."""

from functools import partial
from importlib import import_module
from typing import Any

from mecano.analyses.progress import Progress, StaticProgress
from mecano.deck.deck import Deck
from mecano.errors import UsageError
from mecano.process.interrupt import Interruption
from mecano.results.file_names import refuse_other_ending


def run_with_progress(
    checked: Deck,
    path: str,
    *,
    force: bool = False,
    resume: bool = False,
    checkpoint: float | None = None,
    quiet: bool = False,
    interruption: Interruption | None = None,
) -> None:
    """Solve a checked deck and write the results file ``path``; options and errors as in ``mecano.run``."""
    refuse_other_ending(path, "`mecano export` writes columns (.csv)")
    static = checked.values["static"]
    if static and checkpoint is not None:
        raise UsageError("checkpoint: this deck asks for equilibria ('static'), which have no checkpoints")
    progress = StaticProgress(static, quiet, path) if static else Progress(checked.values["time"], quiet, path)
    runs = import_module("mecano.analyses.static" if static else "mecano.analyses.dynamic")
    begin = runs.resume if resume else partial(runs.run, force=force)
    options: dict[str, Any] = (
        {"observers": (progress,)} if static else {"reporters": (progress,), "interruption": interruption}
    )
    if checkpoint is not None:
        options["interval"] = checkpoint
    with progress.announcing_compiling():
        final = begin(checked, path, announce=progress.note, **options)
    if final is not None:
        progress.done(final)
