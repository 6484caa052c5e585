"""Commands that solve decks."""

import os
from contextlib import ExitStack
from typing import NamedTuple

import click

from mecano.commands import (
    ABOVE,
    BELOW,
    axes,
    grouped,
    overrides,
    plugins,
    require_saved_state,
    results_path,
    saved_state,
    show,
    show_with_warnings,
)
from mecano.process.interrupt import Interruption, resume_command, seconds
from mecano.solve.modal import SOLVERS


@click.command()
@click.argument("deck", type=click.Path())
@click.option(
    "-o", "--output", type=click.Path(), help="Results file; default: the deck's name with .h5, in this folder."
)
@click.option("--force", is_flag=True, help="Replace an existing results file.")
@click.option("--resume", is_flag=True, help="Resume the results file from its last checkpoint, if it has one.")
@click.option(
    "--max-walltime", "limit", metavar="TIME", help="Stop with a checkpoint before this time: 3600, 2h30m or 02:30:00."
)
@click.option(
    "--checkpoint", "interval", type=click.FloatRange(0), metavar="SECONDS",
    help="Wall-clock time between checkpoints; default: 30.",
)  # fmt: skip
@click.option(
    "--threads", type=click.IntRange(1), metavar="N",
    help="Threads for a large model; default: one per core, at most two. The results are the same.",
)  # fmt: skip
@click.option("--live", is_flag=True, help="Show the motion in a browser while it is computed; prints the address.")
@click.option("-q", "--quiet", is_flag=True, help="Print errors only.")
@overrides
@plugins
def run(
    deck: str,
    output: str | None,
    force: bool,
    resume: bool,
    limit: str | None,
    interval: float | None,
    threads: int | None,
    live: bool,
    quiet: bool,
    overrides: tuple[str, ...],
) -> None:
    """Solve a deck and write a results file.

    SIGINT (Ctrl-C), SIGTERM, SIGHUP, SIGXCPU, SIGUSR1 and --max-walltime end the run with a checkpoint; --resume
    continues it, bit for bit. A second Ctrl-C ends it at once.
    """
    if resume and force:
        raise click.UsageError("--resume continues a results file, --force replaces it")
    interruption = Interruption(seconds(limit) if limit else None, resume_command())
    interruption.listen()
    from mecano.deck.read import read_deck
    from mecano.interface.run_with_progress import run_with_progress
    from mecano.jit import thread_pool

    if threads:
        thread_pool.use(threads)
    checked = read_deck(deck, overrides)
    path = results_path(output, f"{os.path.splitext(os.path.basename(deck))[0]}.h5")
    with ExitStack() as shown:
        if live:
            from mecano.commands.viewing import live as show

            shown.enter_context(show(path))
        run_with_progress(
            checked, path, force=force, resume=resume, checkpoint=interval, quiet=quiet, interruption=interruption
        )


class About(NamedTuple):
    """The state about which motions are small: that of the start, or a saved one."""

    at: str | None
    at_rest: bool

    @property
    def suffix(self) -> str:
        """End of the name of a file of modes: one for the start, and one for each other state."""
        if self.at is None:
            return ""
        return f"{'_at_rest' if self.at_rest else '_at'}_{os.path.basename(self.at.rpartition(':')[2])}"


class Sweep(NamedTuple):
    """The options of a sweep."""

    sweeps: tuple[str, ...]
    rotor: str | None
    orders: tuple[float, ...]
    columns: bool
    below: float | None
    above: float | None


@click.command(short_help="Compute modes, root loci and critical values.")
@click.argument("deck", type=click.Path())
@saved_state
@click.option(
    "--number", type=click.IntRange(1), help="Number of modes, from the lowest frequency; default: 10, in a sweep all."
)
@click.option(
    "--sweep", "sweeps", multiple=True, metavar="NAME=FROM:TO:STEP",
    help="Vary a parameter, or any number of the deck (as --set); also NAME=A,B,C, with units 'NAME=1 m,2 ft'. Twice: "
    "a map of stability.",
)  # fmt: skip
@click.option(
    "--campbell", "rotor", metavar="NODE",
    help="With --sweep over a speed: Campbell diagram of the rotor with NODE, critical speeds, whirl of the modes.",
)  # fmt: skip
@click.option(
    "--order", "orders", type=click.FloatRange(min=0.0, min_open=True), multiple=True, metavar="N",
    help="Multiple of the angular velocity of the rotor; may be repeated; default: 1.",
)  # fmt: skip
@axes
@click.option(
    "--solver",
    type=click.Choice(SOLVERS),
    default=SOLVERS[0],
    show_default=True,
    help="dense: all modes; sparse: modes of lowest frequency, for large models; automatic: by size.",
)
@click.option(
    "-o",
    "--output",
    type=click.Path(),
    help="File; default: the deck's name with _modes.h5, _modes_at_TIME.h5 or _sweep.h5, in this folder.",
)
@click.option("--plot", is_flag=True, help="Draw the shapes, or the root loci, into a picture next to the file.")
@click.option("--below", type=click.FloatRange(min=0.0, min_open=True), metavar="HZ", help=BELOW)
@click.option("--above", type=click.FloatRange(min=0.0, min_open=True), metavar="HZ", help=ABOVE)
@click.option("--csv", "columns", is_flag=True, help="Also write the numbers of a sweep next to the file.")
@click.option("-q", "--quiet", is_flag=True, help="Do not print the progress of sweeps and compilation.")
@click.option("--force", is_flag=True, help="Replace an existing file.")
@overrides
@plugins
@grouped(about=About, swept=Sweep)
def modes(
    deck: str,
    about: About,
    swept: Sweep,
    number: int | None,
    frame: str,
    solver: str,
    output: str | None,
    plot: bool,
    quiet: bool,
    force: bool,
    overrides: tuple[str, ...],
) -> None:
    """Compute modes of small motions about the initial state of a deck, its equilibrium, or a saved state.

    With 'static' or 'initial: static' in the deck, modes are about the static equilibrium; with 'initial: {steady:
    ...}', about steady running, a turn or a rotation; with --at, about a saved state (of that instant, if it moves);
    with --at-rest, about the equilibrium near it. Modes are complex, with constraints, damping, gyroscopic and follower
    terms. The command prints a table, and writes the shapes to a file and, with --plot, to a picture. With --sweep it
    finds root loci and critical values, with --campbell also critical speeds.
    """
    _refuse_unfit(about, swept)
    stem = os.path.splitext(os.path.basename(deck))[0]
    options = {"frame": frame, "method": solver, "force": force}
    if swept.sweeps:
        path = results_path(output, f"{stem}_sweep.h5")
        _sweep(path, deck, overrides, swept, quiet, number=number, **options)
        if plot:
            from mecano.post.pictures import draw_alone

            show(str(draw_alone(path, below=swept.below, above=swept.above)))
    else:
        path = results_path(output, f"{stem}_modes{about.suffix}.h5")
        found = _modes_about(path, deck, overrides, quiet, number=number or 10, **about._asdict(), **options)
        if plot:
            from mecano.post.mode_shapes import NO_SHAPES
            from mecano.post.pictures import draw_alone

            show(str(draw_alone(path)) if len(found.values) else NO_SHAPES)


def _refuse_unfit(about, swept):
    """Raise BadParameter for an option without the one to which it belongs."""
    of_sweeps = {
        "--csv": swept.columns, "--below": swept.below, "--above": swept.above, "--campbell": swept.rotor,
        "--order": swept.orders,
    }  # fmt: skip
    given = [option for option, value in of_sweeps.items() if value]
    if swept.sweeps and (about.at is not None or about.at_rest):
        raise click.BadParameter(
            "takes one state, but --sweep has many; for modes about a saved state at each value use "
            "--set initial.from=FILE:TIME",
            param_hint="--at",
        )
    if swept.sweeps and "--order" in given and "--campbell" not in given:
        raise click.BadParameter("belongs to --campbell", param_hint="--order")
    if given and not swept.sweeps:
        raise click.BadParameter("belongs to --sweep", param_hint=given[0])
    require_saved_state(*about)


def _modes_about(path, deck, overrides, quiet, **options):
    """Write the modes about one state to ``path``, print their table, and return the Modes."""
    from mecano.analyses.modal import modes as find
    from mecano.analyses.progress import SweepProgress
    from mecano.deck.read import read_deck

    checked = read_deck(deck, overrides)
    with SweepProgress(quiet, path).announcing_compiling():
        text, found, _ = find(checked, path, **options)
    show_with_warnings(text)
    return found


def _sweep(path, deck, overrides, swept, quiet, **options):
    """Write the modes of a sweep to ``path``, and print its table."""
    from mecano.analyses.progress import SweepProgress
    from mecano.analyses.sweep import sweep_into

    progress = SweepProgress(quiet, path)
    Interruption().listen()
    with progress.announcing_compiling():
        text, total = sweep_into(
            path, deck, overrides, swept.sweeps, progress=progress, columns=swept.columns, rotor=swept.rotor or "",
            orders=swept.orders or (1.0,), **options,
        )  # fmt: skip
    progress.done(total)
    show_with_warnings(text)


@click.command(name="reduce")
@click.argument("deck", type=click.Path())
@click.option("--elements", metavar="A,B,...", help="Elements and joints of the part; default: all in the deck.")
@click.option("--nodes", metavar="A,B,...", required=True, help="Boundary nodes of the part and superelement.")
@click.option(
    "--modes",
    "number",
    metavar="N|all",
    default="10",
    show_default=True,
    help="Number of modes with fixed boundary nodes.",
)
@click.option(
    "-o", "--output", type=click.Path(), help="File .npz or .h5; default: the deck's name with .npz, in this folder."
)
@click.option("--force", is_flag=True, help="Replace an existing file.")
@overrides
@plugins
def reduce_(
    deck: str,
    elements: str | None,
    nodes: str,
    number: str,
    output: str | None,
    force: bool,
    overrides: tuple[str, ...],
) -> None:
    """Reduce a part of a deck to matrices for a superelement.

    Method of Craig and Bampton: static shapes of the boundary nodes, and the modes of lowest frequency with fixed
    boundary nodes, about the unstressed start of the deck, without loads and gravity. The axes of the matrices are
    those of the first boundary node.
    """
    if number != "all" and not number.isdecimal():
        raise click.BadParameter("must be a whole number or 'all'", param_hint="--modes")
    from mecano.deck.read import read_deck

    checked = read_deck(deck, overrides)
    path = output or os.path.splitext(os.path.basename(deck))[0] + ".npz"
    from mecano.analyses.reduction import reduce_part

    reported, _ = reduce_part(
        checked, path, elements=_names(elements), nodes=_names(nodes),
        number=None if number == "all" else int(number), force=force,
    )  # fmt: skip
    show(reported)


@click.command(name="import")
@click.argument("file", type=click.Path())
@click.option(
    "--length", metavar="UNIT", default="m", show_default=True, help="Unit of length of the file, such as mm."
)
@click.option(
    "--mass",
    metavar="UNIT",
    default="kg",
    show_default=True,
    help="Unit of mass of the file, such as t or 'lbf s2/in'.",
)
@click.option(
    "-o", "--output", type=click.Path(), help="File .npz or .h5; default: the file's name with .npz, in this folder."
)
@click.option("--force", is_flag=True, help="Replace an existing file.")
def import_(file: str, length: str, mass: str, output: str | None, force: bool) -> None:
    """Import matrices of a part from Nastran for a superelement.

    FILE is the punch file (.pch) of an external superelement, written by EXTSEOUT(EXTBULK,EXTID=1,DMIGPCH), with a
    boundary of nodes with all six components. The command converts it to SI units and prints mass, centre of mass,
    inertia and frequencies, to be compared with those of Nastran.
    """
    from mecano.analyses.nastran_matrices import Units, import_matrices

    units = Units(_size(length, "m", "--length"), _size(mass, "kg", "--mass"))
    path = output or os.path.splitext(os.path.basename(file))[0] + ".npz"
    show(import_matrices(file, path, units, force=force))


def _size(unit, of, option):
    """Return the size of a unit in the SI unit ``of``."""
    from mecano.deck.units import UnitError, factor_of

    try:
        return factor_of(unit, of)
    except UnitError as error:
        raise click.BadParameter(str(error), param_hint=option) from None


def _names(text):
    return [name.strip() for name in text.split(",") if name.strip()] if text else []
