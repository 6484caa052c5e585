"""The command line: arguments, exit codes, progress. Nothing else; heavy modules are imported by the commands."""

import atexit
import contextlib
import gc
import os
import signal
import sys
from functools import partial

import click

from mecano import __version__
from mecano.interrupt import Interruption, again, seconds, stopped_by

for _variable in ("OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "OMP_NUM_THREADS"):
    os.environ.setdefault(_variable, "1")  # results are then the same from run to run


@click.group(context_settings={"help_option_names": ["-h", "--help"]})
@click.version_option(__version__, prog_name="mecano")
def commands():
    """Simulate flexible mechanisms: decks in, results and pictures out.

    \b
    mecano check deck.yaml          look at a deck without running it
    mecano run deck.yaml            solve it into deck.h5
    mecano modes deck.yaml          modes of small motions about its start or equilibrium
    mecano post deck.h5             draw the pictures an engineer wants
    mecano export deck.h5           write them as CSV, or for ParaView
    mecano info deck.h5             say what is in a file and how the run went
    mecano verify deck.h5           look for changed bytes
    mecano list, mecano explain     what a deck can contain
    mecano new pendulum             a deck to begin with
    mecano schema                   the grammar of decks, for editors

    Exit codes: 0 done, 2 usage or deck error, 3 no convergence, 4 cannot be assembled or singular, 5 input or
    output, 6 not finite, 7 out of memory, 75 stopped in time by --max-walltime or SIGUSR1, 130 and 143 by Ctrl-C and
    SIGTERM (all three with a file for --resume), 1 a bug in mecano.
    """


overrides = click.option(
    "--set", "overrides", multiple=True, metavar="A.B.C=VALUE", help="Override a value of the deck; may be repeated."
)


@commands.command()
@click.argument("deck", type=click.Path())
@click.option("-o", "--output", type=click.Path(), help="Results file; default: the deck's name with .h5, here.")
@click.option("--force", is_flag=True, help="Replace an existing results file.")
@click.option("--resume", is_flag=True, help="Go on with the results file from its last checkpoint, if there is one.")
@click.option("--max-walltime", "limit", metavar="TIME", help="Stop in time, for --resume: 3600, 2h30m or 02:30:00.")
@click.option(
    "--checkpoint", "interval", type=click.FloatRange(0), default=30.0, show_default=True, metavar="SECONDS",
    help="Wall-clock time between checkpoints.",
)  # fmt: skip
@click.option("-q", "--quiet", is_flag=True, help="Say nothing but errors.")
@overrides
def run(deck, output, force, resume, limit, interval, quiet, overrides):
    """Solve a deck into a results file.

    SIGINT (Ctrl-C), SIGTERM, SIGUSR1 and --max-walltime end the run after the step at hand; --resume goes on with the
    same bits. A second Ctrl-C ends it at once.
    """
    if resume and force:
        raise click.UsageError("--resume goes on with a results file, --force replaces it")
    interruption = Interruption(seconds(limit) if limit else None, again())
    interruption.listen()
    from mecano.contract import SECTIONS
    from mecano.deck.read import read_deck
    from mecano.progress import Progress, StaticProgress

    checked = read_deck(deck, overrides)
    path = output or os.path.splitext(os.path.basename(deck))[0] + ".h5"
    static = checked.values["static"]
    progress = StaticProgress(static, quiet, path) if static else Progress(checked.values["time"], quiet, path)
    kinds = {d["type"] for section in SECTIONS for d in checked.values[section].values()}
    progress.compiling(kinds)
    from importlib import import_module

    runs = import_module("mecano.static_run" if static else "mecano.run")
    solve = runs.resume if resume else partial(runs.run, force=force)
    told = {} if static else {"interruption": interruption, "interval": interval}
    final = solve(checked, path, observers=(progress,), announce=progress.note, **told)
    if final is not None:
        progress.done(final)


@commands.command()
@click.argument("deck", type=click.Path())
@click.option("--at", metavar="RESULTS.h5:TIME", help="About the saved state nearest to a time; default: the start.")
@click.option("--number", type=click.IntRange(1), help="Modes of lowest frequency; default: 10, in a sweep all.")
@click.option(
    "--sweep", "sweeps", multiple=True, metavar="NAME=FROM:TO:STEP",
    help="Over a parameter of the deck, or any number (as --set); or NAME=A,B,C. Twice: a map of stability.",
)  # fmt: skip
@click.option(
    "--frame", default="inertial", show_default=True, metavar="NODE|WX,WY,WZ|inertial",
    help="Axes in which the motions are seen: that turn with a node, or with an angular velocity [rad/s].",
)  # fmt: skip
@click.option("--solver", type=click.Choice(["automatic", "dense", "sparse"]), default="automatic", show_default=True)
@click.option(
    "-o", "--output", type=click.Path(), help="File; default: the deck's name with _modes.h5, or _sweep.h5, here."
)
@click.option("--plot", is_flag=True, help="Draw the shapes, or the root loci, into a picture beside the file.")
@click.option("--csv", "columns", is_flag=True, help="Write the numbers of a sweep beside the file, too.")
@click.option("-q", "--quiet", is_flag=True, help="No progress of a sweep.")
@click.option("--force", is_flag=True, help="Replace an existing file.")
@overrides
def modes(deck, at, number, sweeps, frame, solver, output, plot, columns, quiet, force, overrides):
    """Find the modes of small motions about the start of a deck, its equilibrium, or a saved state.

    With 'static' or 'initial: static' in the deck: about the static equilibrium, with 'initial: {steady: ...}' about
    straight steady running. Complex eigenvalues with constraints, damping, gyroscopic and follower terms; a table here,
    shapes in the file and, with --plot, in a picture. With --sweep: root loci and critical values.
    """
    if sweeps:
        if at is not None:
            raise click.BadParameter("is about one state, and --sweep about many", param_hint="--at")
        return _sweep(deck, sweeps, overrides, number, frame, solver, output, plot, columns, quiet, force)
    if columns:
        raise click.BadParameter("belongs to --sweep", param_hint="--csv")
    from mecano.deck.read import read_deck

    checked = read_deck(deck, overrides)
    path = output or os.path.splitext(os.path.basename(deck))[0] + "_modes.h5"
    from mecano.modes_run import modes as find

    text, _, _ = find(checked, path, at=at, number=number or 10, frame=frame, method=solver, force=force)
    _show(text)
    if plot:
        from mecano.post.mode_shapes import draw_modes

        _show(str(draw_modes(path)))


def _sweep(deck, sweeps, overrides, number, frame, solver, output, plot, columns, quiet, force):
    from mecano.progress import SweepProgress
    from mecano.sweep_run import sweep_into

    path = output or os.path.splitext(os.path.basename(deck))[0] + "_sweep.h5"
    progress = SweepProgress(quiet, path)
    Interruption().listen((signal.SIGINT, signal.SIGTERM))
    text, total = sweep_into(
        path, deck, overrides, sweeps, number=number, frame=frame, method=solver, columns=columns, force=force,
        progress=progress,
    )  # fmt: skip
    progress.done(total)
    _show(text)
    if plot:
        from mecano.post.loci import draw_sweep

        _show(str(draw_sweep(path)))


@commands.command(name="reduce")
@click.argument("deck", type=click.Path())
@click.option("--elements", metavar="A,B,...", help="Elements and joints of the part; default: all of the deck.")
@click.option("--nodes", metavar="A,B,...", required=True, help="Its boundary nodes, which the superelement will have.")
@click.option("--modes", "number", metavar="N|all", default="10", show_default=True, help="Modes kept.")
@click.option("-o", "--output", type=click.Path(), help="File .npz or .h5; default: the deck's name with .npz, here.")
@click.option("--force", is_flag=True, help="Replace an existing file.")
@overrides
def reduce_(deck, elements, nodes, number, output, force, overrides):
    """Reduce a part of a deck to matrices over its boundary nodes and modes: the file of a superelement.

    Of Craig and Bampton: static shapes of the boundary nodes, and the modes of lowest frequency with these held, about
    the unstressed start of the deck, without loads and gravity. Axes are those of the first boundary node.
    """
    if number != "all" and not number.isdigit():
        raise click.BadParameter("must be a whole number or 'all'", param_hint="--modes")
    from mecano.deck.read import read_deck

    checked = read_deck(deck, overrides)
    path = output or os.path.splitext(os.path.basename(deck))[0] + ".npz"
    from mecano.reduce_run import reduce_part

    told, _ = reduce_part(
        checked, path, elements=_names(elements), nodes=_names(nodes),
        number=None if number == "all" else int(number), force=force,
    )  # fmt: skip
    _show(told)


def _names(text):
    return [name.strip() for name in text.split(",") if name.strip()] if text else []


@commands.command()
@click.argument("deck", type=click.Path())
@overrides
@click.option("--all", "every", is_flag=True, help="Name all that can move, however many there are.")
def check(deck, overrides, every):
    """Check a deck without running it; print bodies, mass, unknowns, mobility, redundant constraints."""
    from mecano.deck.read import read_deck

    checked = read_deck(deck, overrides)
    from mecano.summary import summary

    _show(summary(checked, every))


@commands.command()
@click.argument("results", nargs=-1, required=True, type=click.Path())
@click.option(
    "--plot",
    "plots",
    multiple=True,
    metavar="Y[,Y2][:X]",
    help="Plot outputs over another one, or over time; may be repeated.",
)
@click.option("--spectrum", "spectra", multiple=True, metavar="Y[,Y2]", help="Plot amplitudes over the frequency.")
@click.option("--at", metavar="T1,T2,...", help="Draw the mechanism in space at these times [s], in one picture.")
@click.option("-o", "--output", type=click.Path(), help="Folder, or beginning of the names of the pictures.")
@click.option("--format", "kind", type=click.Choice(["png", "svg"]), default="png", show_default=True)
@click.option("--csv", "columns", is_flag=True, help="Write the plotted numbers too.")
@click.option("--title", help="Title of the pictures; default: that of the deck.")
@click.option(
    "--animate", "page", metavar="PAGE.html", type=click.Path(),
    help="Write a page that plays the motion; or a film, .gif or .mp4.",
)  # fmt: skip
@click.option("--report", metavar="PAGE.html", type=click.Path(), help="Write a page with everything on one run.")
def post(results, plots, spectra, at, output, kind, columns, title, page, report):
    """Draw pictures of results; several files are drawn into the same pictures.

    Without --plot, --spectrum, --at: the pictures that show this model, from the overview to the step size. Names of
    outputs are those of `mecano info RESULTS --names`, vectors have components: --plot axle.position.z,
    --plot wheel.radial_force:wheel.deformation, --plot knee.force.magnitude, --plot solver.step_size.

    --animate writes one page for a browser, without a network: the motion of one file in space, with time slider,
    colours by stress or force, and beside it the plots asked for, or the first of the overview. --report writes one
    page on the run: model, solution, energies, events, pictures (those asked for first), extremes, the deck.
    """
    if (page or report) and len(results) > 1:
        raise click.UsageError("--animate and --report are about one results file")
    if page:
        from mecano.post.animation import animate

        click.echo(animate(results[0], page, plots, title))
    if report:
        from mecano.post.report_page import write_report

        click.echo(write_report(results[0], report, title, plots, spectra))
    if page or report:
        return
    from mecano.post.pictures import post as draw

    for path in draw(results, plots, spectra, output=output, kind=kind, columns=columns, title=title, at=at):
        click.echo(path)


@commands.command()
@click.argument("results", type=click.Path())
@click.option("-o", "--output", type=click.Path(), metavar="FILE", help="File .csv or .vtkhdf.")
@click.option("--series", multiple=True, metavar="NAME", help="Only this one, or those of a pattern; may be repeated.")
@click.option("--vtk", is_flag=True, help="Cells and points for ParaView instead; without -o into RESULTS itself.")
@click.option("--force", is_flag=True, help="Replace what exists.")
def export(results, output, series, vtk, force):
    """Write results for other programs: all series, or some, as comma-separated values; or cells for ParaView.

    Without -o columns go to a file beside RESULTS with the ending .csv. Names as in `mecano post --plot`.
    """
    from mecano.post.export import export as write

    click.echo(write(results, output, series=series, vtk=vtk, force=force))


@commands.command()
@click.argument("results", type=click.Path())
@click.option(
    "--names", "pattern", is_flag=False, flag_value="*", metavar="[PATTERN]",
    help="Outputs with units and meanings, of a pattern such as 'wheel.*' or all.",
)  # fmt: skip
@click.option("--events", is_flag=True, help="List all events, each in a line of its own.")
def info(results, pattern, events):
    """Say what is in a results file and how the run went: status, steps, events, extremes."""
    from mecano.post.info import info as text

    _show(text(results, pattern, events))


@commands.command()
@click.argument("results", type=click.Path())
def verify(results):
    """Look for changed or missing bytes in a results file: exit code 5, and which data they are of."""
    from mecano.results.verify import verify as text

    _show(text(results))


@commands.command(name="list")
def list_():
    """List the kinds of elements, joints and loads, the terms of laws and the sections of a deck."""
    from mecano.deck.catalogue import catalogue

    _show(catalogue())


@commands.command()
@click.argument("name")
def explain(name):
    """Explain a kind, a term of a law or a section of the deck: fields, units, defaults, outputs, equations."""
    from mecano.deck.catalogue import explain as text

    _show(text(name).rstrip())


@commands.command()
@click.option("-o", "--output", type=click.Path(), help="File; default: the standard output.")
def schema(output):
    """Write the grammar of decks as JSON Schema, for editors that then complete, explain and check while you type."""
    from mecano.deck.new import schema_text, write_text

    if output:
        write_text(output, schema_text(), replace=True)
    else:
        _show(schema_text())


@commands.command()
@click.argument("template", required=False)
@click.argument("deck", required=False, type=click.Path())
def new(template, deck):
    """Write a commented deck to begin with, by default TEMPLATE.yaml here; without TEMPLATE: list them."""
    from mecano.deck.new import list_of_starters, starter, write_text

    if template is None:
        _show(list_of_starters())
        return
    path = deck or f"{template}.yaml"
    write_text(path, starter(template))
    _show(f"{path}: try `mecano check {path}`, then `mecano run {path}`")


def _show(text):
    """Print; a reader that has seen enough (as ``head`` has) is no error."""
    try:
        click.echo(text)
    except BrokenPipeError:
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())


def main():
    """Run a command; every error that a user can cause or meet ends in a message and an exit code."""
    try:
        commands(prog_name="mecano", standalone_mode=False)
    except click.exceptions.Abort as error:
        stopped = stopped_by(error)
        _end(stopped.exit_code if stopped else 130, f"mecano: {stopped or 'interrupted'}")
    except click.ClickException as error:
        error.show()
        _end(2)
    except MemoryError:
        _end(7, "out of memory")
    except Exception as error:
        _report(error)


def program():
    """``main`` as a process of its own: the objects of numba and of the model all live to its end.

    To look for dead ones among them again and again would take 0.1 s, to take them apart at the end 0.3 s.
    """
    gc.set_threshold(50_000, 20, 20)
    try:
        main()
        code = 0
    except SystemExit as ended:
        code = ended.code or 0
    atexit._run_exitfuncs()  # os._exit leaves them out
    for stream in (sys.stdout, sys.stderr):
        with contextlib.suppress(OSError):
            stream.flush()
    os._exit(code)


def _report(error):
    from mecano.errors import DeckError, MecanoError

    if stopped := stopped_by(error):
        _end(stopped.exit_code, f"mecano: {stopped}")
    if isinstance(error, DeckError):
        from mecano.deck.format import deck_error_text

        _end(error.exit_code, deck_error_text(error))
    if isinstance(error, MecanoError):
        _end(error.exit_code, f"mecano: {error}")
    raise error


def _end(code, message=""):
    if message:
        click.echo(message, err=True)
    sys.exit(code)
