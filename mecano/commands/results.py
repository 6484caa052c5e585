"""Commands about results files."""

from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import click

from mecano.commands import ABOVE, BELOW, grouped, overrides, plugins, show

if TYPE_CHECKING:
    from mecano.post.spectrum import Transforms


class Pictures(NamedTuple):
    """What applies to pictures, not to pages."""

    at: str | None
    output: str | None
    kind: str
    columns: bool
    below: float | None
    measured: str | None
    above: float | None

    def parameters(self) -> dict[str, Any]:
        """Return them as parameters of ``pictures.post``."""
        given = self._asdict()
        given["band"] = given.pop("above"), given.pop("below")
        return given


class Transformed(NamedTuple):
    """Options of spectra and densities."""

    spectra: tuple[str, ...]
    densities: tuple[str, ...]
    begin: float | None
    end: float | None

    def transforms(self) -> "Transforms":
        """Return the Transforms of ``pictures.post``."""
        from mecano.post.spectrum import Transforms, Window

        return Transforms(self.spectra, self.densities, Window(self.begin, self.end))

    def given(self) -> str:
        """Return the names of the options that are given."""
        window = self.begin is not None or self.end is not None
        given = {"--spectrum": self.spectra, "--density": self.densities, "--from, --to": window}
        return ", ".join(option for option, value in given.items() if value)


class Pages(NamedTuple):
    """The pages to write in place of pictures."""

    page: str | None
    report: str | None


@click.command(short_help="Draw pictures, films, pages and reports of results.")
@click.argument("results", nargs=-1, type=click.Path(), metavar="RESULTS...")
@click.option(
    "--plot",
    "plots",
    multiple=True,
    metavar="Y[,Y2][:X]",
    help="Plot outputs over time, or over output X; for a study, columns of its table. May be repeated.",
)
@click.option("--spectrum", "spectra", multiple=True, metavar="Y[,Y2]", help="Plot amplitudes over the frequency.")
@click.option("--density", "densities", multiple=True, metavar="Y[,Y2]", help="Plot power spectral densities.")
@click.option("--from", "begin", type=float, metavar="T", help="With --spectrum, --density: first time used [s].")
@click.option("--to", "end", type=float, metavar="T", help="With --spectrum, --density: last time used [s].")
@click.option("--at", metavar="T1,T2,...", help="Draw the mechanism in space at the saved times nearest to these [s].")
@click.option(
    "-o", "--output", type=click.Path(),
    help="Folder, or prefix of the names of the pictures; default: next to the results file, with its name.",
)  # fmt: skip
@click.option("--format", "kind", type=click.Choice(["png", "svg"]), default="png", show_default=True)
@click.option("--csv", "columns", is_flag=True, help="Also write the plotted numbers.")
@click.option("--title", help="Title of the pictures; default: the title of the deck.")
@click.option("--below", type=click.FloatRange(min=0.0, min_open=True), metavar="HZ", help=BELOW)
@click.option("--above", type=click.FloatRange(min=0.0, min_open=True), metavar="HZ", help=ABOVE)
@click.option(
    "--measured", metavar="FILE.csv", type=click.Path(),
    help="Measured curves: draw each column, whose header names an output, as points into the plots of it.",
)  # fmt: skip
@click.option(
    "--animate", "page", metavar="PAGE.html", type=click.Path(),
    help="Write a page that plays the motion; or a film, .gif, .webp or .mp4.",
)  # fmt: skip
@click.option("--report", metavar="PAGE.html", type=click.Path(), help="Write a report page on one run or study.")
@click.option("--force", is_flag=True, help="Also replace films, and files that mecano has not written.")
@plugins
@grouped(transformed=Transformed, pictures=Pictures, pages=Pages)
def post(
    results: tuple[str, ...],
    plots: tuple[str, ...],
    title: str | None,
    transformed: Transformed,
    pictures: Pictures,
    pages: Pages,
    force: bool,
) -> None:
    """Draw pictures of results; several files are drawn into the same pictures.

    Without --plot, --spectrum, --density and --at it draws the standard plots: an overview and a picture for each group
    of elements.
    `mecano info RESULTS --names` lists the names of outputs; vectors have components: --plot axle.position.z,
    --plot wheel.radial_force:wheel.deformation, --plot knee.force.magnitude, --plot solver.step_size.

    --animate writes one self-contained page for a browser: the motion of one file in space, with a time slider, colours
    by stress or force, and next to it the requested plots, or the first of the overview; a file of modes is played mode
    after mode. --report writes one page on the run: model, solution, energies, events, pictures (requested ones first),
    extremes, the deck.

    Pictures, pages and tables of mecano are replaced; films and files from elsewhere only with --force.
    """
    _refuse_no_results(results, pages)
    _refuse_names(results, plots)
    if any(pages):
        _refuse_strays(results, pictures)
    if pages.page and not pages.report and (given := transformed.given()):
        raise click.UsageError(f"{given}: the page of --animate has plots over time only")
    with _reading(*results):
        if any(pages):
            _write_pages(results[0], plots, transformed, title, pages, force)
        else:
            from mecano.post.pictures import post as draw

            options = {"transforms": transformed.transforms(), "title": title, "force": force} | pictures.parameters()
            for path in draw(results, plots, **options):
                click.echo(path)


@contextmanager
def _reading(*results):
    """Warn of results files that are cut short; attribute unexpected errors in the block to damage of files."""
    from mecano.results.opening import cut_short, errors_as_damage

    for warning in cut_short(results):
        click.echo(f"mecano: {warning}", err=True)
    with errors_as_damage(*results):
        yield


def _refuse_no_results(results, pages):
    """Raise UsageError if no results file is named, or if it stands in place of a page: '--animate gear.h5'."""
    if results:
        return
    for option, name in zip(("--animate", "--report"), pages, strict=True):
        if name and name.endswith(".h5"):
            page = Path(name).with_suffix(".html").name
            raise click.UsageError(f"{option} takes the name of the page to write: mecano post {name} {option} {page}")
    raise click.UsageError("Missing argument 'RESULTS...': the file that `mecano run` has written")


def _refuse_names(results, plots):
    """Raise UsageError if an output stands in place of a results file: '--plot a b'."""
    for name in results if plots else ():
        if not Path(name).exists() and not name.endswith(".h5"):
            raise click.UsageError(
                f"{name!r} is not a file; --plot takes one text: --plot {plots[0]},{name} for one panel, "
                f"--plot {plots[0]} --plot {name} for two"
            )


def _write_pages(results, plots, transformed, title, pages, force):
    """Write a page of the motion, a report, or both, of one results file."""
    from mecano.results.whole_file import refuse_foreign

    for name in filter(None, pages):
        refuse_foreign(Path(name), force)
    if pages.page:
        from mecano.post.animation import animate

        click.echo(animate(results, pages.page, plots, title))
    if pages.report:
        from mecano.post.report_page import write_report

        click.echo(write_report(results, pages.report, title, plots, transformed.transforms()))


def _refuse_strays(results, pictures):
    """Raise UsageError for options that do not apply to pages."""
    if len(results) > 1:
        raise click.UsageError("--animate and --report take one results file")
    given = pictures._asdict()
    given |= {"format": given.pop("kind") != "png", "csv": given.pop("columns")}
    strays = [f"--{name}" for name, value in given.items() if value]
    if strays:
        raise click.UsageError(f"{', '.join(strays)}: only for pictures, not drawn with --animate or --report")


@click.command(short_help="Write results as CSV, or for ParaView.")
@click.argument("results", type=click.Path())
@click.option("-o", "--output", type=click.Path(), metavar="FILE", help="File .csv or .vtkhdf (added if omitted).")
@click.option(
    "--series", multiple=True, metavar="NAME", help="Only this output, or all that match a pattern; may be repeated."
)
@click.option("--vtk", is_flag=True, help="Write cells and points for ParaView instead; without -o, to RESULTS itself.")
@click.option("--force", is_flag=True, help="Replace an existing file or group.")
def export(results: str, output: str | None, series: tuple[str, ...], vtk: bool, force: bool) -> None:
    """Write results for other programs: all series, or some, as comma-separated values; or cells for ParaView.

    Without -o, columns are written to a file .csv next to RESULTS. Names as in `mecano post --plot`.
    """
    from mecano.post.export import export as write

    with _reading(results):
        click.echo(write(results, output, series=series, vtk=vtk, force=force))


@click.command(short_help="Summarize a results file and its run.")
@click.argument("results", type=click.Path(), required=False, metavar="RESULTS")
@click.option(
    "--names", "pattern", is_flag=False, flag_value="*", metavar="[PATTERN]",
    help="List outputs with units and descriptions: all, those of an element, of a name or a pattern, 'w*.force'.",
)  # fmt: skip
@click.option(
    "--events", is_flag=False, flag_value="**", metavar="[PATTERN]",
    help="List events alone, with many repeated ones merged; of a pattern, an element or a name, each: '*', 'hinge_*'.",
)  # fmt: skip
def info(results: str | None, pattern: str | None, events: str | None) -> None:
    """Summarize a results file and its run: status, steps, events, extremes."""
    from mecano.post.info import info as text

    if results is None and pattern is None and events is not None:  # `mecano info --events RESULTS`
        results, events = events, "**"
    if results is None:
        raise click.UsageError("Missing argument 'RESULTS': the file that `mecano run` has written")
    with _reading(results):
        show(text(results, pattern, events))


@click.command(short_help="Compute the momentum of a run and its change.")
@click.argument("deck", type=click.Path())
@click.argument("results", type=click.Path())
@click.option(
    "--about", nargs=3, type=float, default=(0.0, 0.0, 0.0), show_default=True, metavar="X Y Z",
    help="Inertial point to which the angular momentum refers [m].",
)  # fmt: skip
@click.option("--csv", "table", metavar="FILE.csv", type=click.Path(), help="Also write the values at all saved times.")
@click.option("--force", is_flag=True, help="Replace a file that mecano has not written.")
@overrides
@plugins
def momentum(
    deck: str, results: str, about: tuple[float, float, float], table: str | None, force: bool,
    overrides: tuple[str, ...],
) -> None:  # fmt: skip
    """Compute linear and angular momentum, mass and centre of mass at the saved times of a run of DECK.

    Without loads, and without joints to the ground, the momentum is constant; its largest change is then an error of
    the run. Give the same --set as for the run: other masses are refused.
    """
    from mecano.analyses.momentum import momentum as find
    from mecano.analyses.momentum import rows
    from mecano.deck.read import read_deck
    from mecano.results.whole_file import write_csv

    with _reading(results):
        found = find(read_deck(deck, overrides), results, about)
    show(str(found))
    if table:
        write_csv(Path(table), rows(found), force)


@click.command(short_help="Check a results file for changed or missing bytes.")
@click.argument("results", type=click.Path())
def verify(results: str) -> None:
    """Check a results file for changed or missing bytes; if any, name the data affected, with exit code 5."""
    from mecano.results.verify import verify as text

    show(text(results))
