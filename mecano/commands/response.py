"""The commands for responses to sinusoidal inputs, for linear models, and for margins of stability."""

import os

import click

from mecano.commands import at_equilibrium, at_saved_state, axes, overrides, plugins, require_saved_state, show

lowest = click.option("--from", "low", type=float, required=True, metavar="HZ", help="Lowest frequency.")
highest = click.option("--to", "high", type=float, required=True, metavar="HZ", help="Highest frequency.")
equal_distances = click.option("--linear", is_flag=True, help="Frequencies at equal distances.")


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
@lowest
@highest
@click.option(
    "--number", type=click.IntRange(1), default=200, show_default=True,
    help="Frequencies, at equal ratios; more are added around resonances.",
)  # fmt: skip
@equal_distances
@click.option("--unrefined", is_flag=True, help="Add no frequencies around resonances, and locate no peaks.")
@at_saved_state
@at_equilibrium
@axes
@click.option(
    "--state-space", "matrices", type=click.Path(), metavar="FILE.npz|.mat",
    help="Also write the linear model: matrices A, B, C, D, names and units of states, inputs and outputs.",
)  # fmt: skip
@click.option(
    "-o", "--output-file", "path", type=click.Path(),
    help="File; default: the deck's name with _response.h5, in this folder.",
)  # fmt: skip
@click.option("--plot", is_flag=True, help="Draw a Bode diagram into a picture next to the file.")
@click.option("--csv", "columns", is_flag=True, help="Also write magnitudes and phases as a table next to the file.")
@click.option("-q", "--quiet", is_flag=True, help="Do not print the progress of compilation.")
@click.option("--force", is_flag=True, help="Replace existing files.")
@overrides
@plugins
def response(
    deck: str,
    inputs: tuple[str, ...],
    outputs: tuple[str, ...],
    low: float,
    high: float,
    number: int,
    linear: bool,
    unrefined: bool,
    at: str | None,
    at_rest: bool,
    frame: str,
    matrices: str | None,
    path: str | None,
    plot: bool,
    columns: bool,
    quiet: bool,
    force: bool,
    overrides: tuple[str, ...],
) -> None:
    """Compute the response of small motions to a small sinusoid of each input.

    As in `mecano modes`, the motions are about the initial state of a deck, its equilibrium, its steady motion, or a
    saved state. The command prints the static gain, the bandwidth and the peaks of each transfer function, and writes
    all of them to a file and, with --plot, to a picture.
    """
    require_saved_state(at, at_rest)
    from mecano.analyses.progress import SweepProgress
    from mecano.analyses.response import ResponseRequest
    from mecano.analyses.response import response as find
    from mecano.deck.read import read_deck

    path = path or f"{os.path.splitext(os.path.basename(deck))[0]}_response.h5"
    request = ResponseRequest(
        inputs=inputs, outputs=outputs, low=low, high=high, number=number, linear=linear, refined=not unrefined,
        at=at, at_rest=at_rest, frame=frame,
    )  # fmt: skip
    request.check()
    checked = read_deck(deck, overrides)
    with SweepProgress(quiet, path).announcing_compiling():
        text, _ = find(checked, path, request, state_space=matrices, columns=columns, force=force)
    show(text)
    if plot:
        from mecano.post.bode import draw_response

        show(str(draw_response(path)))


@click.command(short_help="Compute gain, phase and delay margins of a loop.")
@click.argument("deck", type=click.Path())
@click.option(
    "--open-loop", "signal", metavar="NAME", required=True,
    help="The signal at which the loop is opened, or a load that is a formula of signals (motor.value).",
)  # fmt: skip
@lowest
@highest
@click.option(
    "--number", type=click.IntRange(1), default=200, show_default=True,
    help="Frequencies, at equal ratios; more are added around resonances and crossovers.",
)  # fmt: skip
@equal_distances
@at_saved_state
@at_equilibrium
@axes
@click.option(
    "-o", "--output-file", "path", type=click.Path(),
    help="File; default: the deck's name with _margins.h5, in this folder.",
)  # fmt: skip
@click.option("--plot", is_flag=True, help="Draw Bode and Nyquist diagrams into a picture next to the file.")
@click.option("--csv", "columns", is_flag=True, help="Also write magnitude and phase as a table next to the file.")
@click.option("-q", "--quiet", is_flag=True, help="Do not print the progress of compilation.")
@click.option("--force", is_flag=True, help="Replace existing files.")
@overrides
@plugins
def margins(
    deck: str,
    signal: str,
    low: float,
    high: float,
    number: int,
    linear: bool,
    at: str | None,
    at_rest: bool,
    frame: str,
    path: str | None,
    plot: bool,
    columns: bool,
    quiet: bool,
    force: bool,
    overrides: tuple[str, ...],
) -> None:
    """Compute the margins of stability of a loop that is opened at a signal.

    In place of the signal, a small sinusoid u goes to whatever reads it; the signal returns y. The loop transfer
    function is L = -y/u, so that the closed loop has the sensitivity 1/(1 + L). The command prints gain, phase and
    delay margins, the sensitivity peak, all crossovers, and whether the closed loop is stable, and writes L to a file.
    """
    require_saved_state(at, at_rest)
    from mecano.analyses.margins import LoopRequest
    from mecano.analyses.margins import margins as find
    from mecano.analyses.progress import SweepProgress
    from mecano.deck.read import read_deck

    path = path or f"{os.path.splitext(os.path.basename(deck))[0]}_margins.h5"
    request = LoopRequest(
        signal=signal, low=low, high=high, number=number, linear=linear, at=at, at_rest=at_rest, frame=frame
    )
    request.check()
    checked = read_deck(deck, overrides)
    with SweepProgress(quiet, path).announcing_compiling():
        text, _ = find(checked, path, request, columns=columns, force=force)
    show(text)
    if plot:
        from mecano.post.nyquist import draw_margins

        show(str(draw_margins(path)))
