"""The commands for responses to sinusoidal inputs, for linear models, and for margins of stability."""

import math
import os
from collections.abc import Callable
from typing import TYPE_CHECKING, Any, NamedTuple

import click

from mecano.commands import (
    axes,
    grouped,
    overrides,
    plugins,
    require_saved_state,
    results_path,
    saved_state,
    show,
    show_with_warnings,
    together,
)

if TYPE_CHECKING:
    from mecano.analyses.response import FrequencyRequest


def frequencies(around: str, low: str = "", high: str = "") -> Callable[..., Any]:
    """Return the options of the frequencies; more are added ``around`` some of them.

    ``low``, ``high``: what the lowest and highest one are by default, in words; they are required without.
    """
    ends = [
        click.option(
            name, end, type=float, required=not default, metavar="HZ",
            help=f"{which} frequency{f'; default: {default}' if default else ''}.",
        )
        for name, end, which, default in (("--from", "low", "Lowest", low), ("--to", "high", "Highest", high))
    ]  # fmt: skip
    return together(
        *ends,
        click.option(
            "--number", type=click.IntRange(1), default=200, show_default=True,
            help=f"Frequencies, at equal ratios; more are added around {around}.",
        ),
        click.option("--linear", is_flag=True, help="Frequencies at equal distances."),
    )  # fmt: skip


class Written(NamedTuple):
    """What a command writes, and what it prints."""

    path: str | None
    plot: bool
    columns: bool
    quiet: bool
    force: bool


def files(suffix: str, picture: str, numbers: str) -> Callable[..., Any]:
    """Return the options of the group ``Written``; the ``suffix`` ends the name of the file by default."""
    return together(
        click.option(
            "-o", "--output-file", "path", type=click.Path(),
            help=f"File; default: the deck's name with _{suffix}.h5, in this folder.",
        ),
        click.option("--plot", is_flag=True, help=f"Draw {picture} into a picture next to the file."),
        click.option("--csv", "columns", is_flag=True, help=f"Also write {numbers} as a table next to the file."),
        click.option("-q", "--quiet", is_flag=True, help="Do not print the progress of compilation."),
        click.option("--force", is_flag=True, help="Replace existing files."),
    )  # fmt: skip


@click.command(short_help="Compute frequency responses; export a linear model.")
@click.argument("deck", type=click.Path())
@click.option(
    "--input", "inputs", multiple=True, metavar="NAME", required=True,
    help="A signal, or a function of time of a load or prescribed motion (push.value); may be repeated.",
)  # fmt: skip
@click.option(
    "--output", "outputs", multiple=True, metavar="NAME", required=True,
    help="An output, as in formulas of signals (body.position.z, strut.force), an acceleration of a node, or a "
    "formula; may be repeated.",
)  # fmt: skip
@frequencies("resonances")
@click.option("--unrefined", is_flag=True, help="Add no frequencies around resonances, and locate no peaks.")
@saved_state
@axes
@click.option(
    "--state-space", "matrices", type=click.Path(), metavar="FILE.npz|.mat",
    help="Also write the linear model: matrices A, B, C, D, names and units of states, inputs and outputs.",
)  # fmt: skip
@files("response", "a Bode diagram", "magnitudes and phases")
@overrides
@plugins
@grouped(written=Written)
def response(
    deck: str, unrefined: bool, matrices: str | None, written: Written, overrides: tuple[str, ...], **requested: Any
) -> None:
    """Compute the response of small motions to a small sinusoid of each input.

    As in `mecano modes`, the motions are about the initial state of a deck, its equilibrium, its steady motion, or a
    saved state. The command prints the static gain, the bandwidth and the peaks of each transfer function, and writes
    all of them to a file and, with --plot, to a picture.
    """
    from mecano.analyses.response import ResponseRequest
    from mecano.analyses.response import response as find

    request = ResponseRequest(refined=not unrefined, **requested)
    path = _compute(find, request, deck, overrides, "response", written, state_space=matrices)
    if written.plot:
        from mecano.post.pictures import draw_alone

        show(str(draw_alone(path)))


@click.command(short_help="Compute gain, phase and delay margins of a loop.")
@click.argument("deck", type=click.Path())
@click.option(
    "--open-loop", "signal", metavar="NAME", required=True,
    help="The signal at which the loop is opened, or a load that is a formula of signals (motor.value).",
)  # fmt: skip
@frequencies(
    "resonances and crossovers",
    "below poles and crossovers",
    "ten times the frequency at which the loop gain falls below 1; for samples, half the sampling frequency",
)
@saved_state
@axes
@files("margins", "Bode and Nyquist diagrams", "magnitude and phase")
@overrides
@plugins
@grouped(written=Written)
def margins(deck: str, written: Written, overrides: tuple[str, ...], **requested: Any) -> None:
    """Compute gain, phase and delay margins of a control loop, opened at a signal.

    A small sinusoid u replaces the signal for everything that reads it, and the signal itself responds with y. The loop
    transfer function is L = -y/u, and the sensitivity of the closed loop 1/(1 + L). The command prints the margins, the
    sensitivity peak, all crossovers, and whether the closed loop is stable, and writes L to a file.
    """
    from mecano.analyses.margins import LoopRequest
    from mecano.analyses.margins import margins as find

    ends = {name: math.nan if requested[name] is None else requested[name] for name in ("low", "high")}
    path = _compute(find, LoopRequest(**requested | ends), deck, overrides, "margins", written)
    if written.plot:
        from mecano.post.pictures import draw_alone

        show(str(draw_alone(path)))


def _compute(
    find: Callable[..., Any], request: "FrequencyRequest", deck: str, overrides: tuple[str, ...], suffix: str,
    written: Written, **more: Any,
) -> str:  # fmt: skip
    """Answer a request by ``find``, print its table and return the path of its file."""
    require_saved_state(request.at, request.at_rest)
    from mecano.analyses.progress import SweepProgress
    from mecano.deck.read import read_deck

    path = results_path(written.path, f"{os.path.splitext(os.path.basename(deck))[0]}_{suffix}.h5")
    request.check()
    checked = read_deck(deck, overrides)
    with SweepProgress(written.quiet, path).announcing_compiling():
        text, _ = find(checked, path, request, columns=written.columns, force=written.force, **more)
    show_with_warnings(text)
    return path
