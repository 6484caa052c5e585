"""Pictures and tables of results files, written to files."""

import os
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from mecano.errors import ResultsError, UsageError
from mecano.post.bode import response_figure
from mecano.post.columns import columns_of
from mecano.post.configurations import configurations_figure, times_of
from mecano.post.figure import overview_figure, save, sheet_figure
from mecano.post.info import one_line
from mecano.post.loci import sweep_figure
from mecano.post.measured import read_measured, with_measured
from mecano.post.mode_shapes import modes_figure
from mecano.post.nyquist import margins_figure
from mecano.post.overview import overview
from mecano.post.request import requested_sheets
from mecano.post.runs import opened_runs
from mecano.post.sheets import default_sheets
from mecano.post.spectrum import ALL, NO_TRANSFORMS, Transforms
from mecano.post.study_plots import study_figure
from mecano.post.study_requests import requested_figures
from mecano.results import margins_file, modes_file, response_file, study_file, sweep_file
from mecano.results.opening import format_of
from mecano.results.whole_file import make_folder, refuse_foreign, write_csv

if TYPE_CHECKING:
    from matplotlib.figure import Figure

FORMATS = ("png", "svg")
OTHER_FORMATS = ("jpg", "jpeg", "pdf", "eps", "ps", "tif", "tiff", "gif", "bmp", "webp")  # other dots are in names
ALONE: "dict[str, tuple[Callable[..., Any], Callable[..., Figure | None]]]" = {
    modes_file.FORMAT: (modes_file.read_modes, modes_figure),
    sweep_file.FORMAT: (sweep_file.read_sweep, sweep_figure),
    study_file.FORMAT: (study_file.read_study, study_figure),
    response_file.FORMAT: (response_file.read_response, response_figure),
    margins_file.FORMAT: (margins_file.read_margins, margins_figure),
}
"""By the format of a file that is drawn by itself: the functions that read and draw it."""
LONGEST_STEM = 60


def post(
    paths: Sequence[str | os.PathLike[str]],
    plots: Sequence[str] = (),
    *,
    transforms: Transforms = NO_TRANSFORMS,
    measured: str | os.PathLike[str] | None = None,
    at: str | None = None,
    band: tuple[float | None, float | None] = (None, None),
    output: str | os.PathLike[str] | None = None,
    kind: str = "png",
    columns: bool = False,
    title: str | None = None,
    force: bool = False,
) -> Iterator[Path]:
    """Draw pictures of results files, with several runs in one picture, and yield the Path of each file written.

    Files of modes, responses, margins, sweeps and studies are drawn one by one, without ``transforms``, ``measured``,
    ``at``, ``columns`` and ``title``; of these, only studies have ``plots``, of outputs and varied values.

    Parameters
    ----------
    paths : sequence of str or Path
    plots : sequence of str
        "Y[,Y2]:X"; without plots, transforms, measured outputs and times, the standard plots for the model.
    transforms : Transforms
    measured : str or Path
        CSV file of measured outputs (measured.py), drawn as points into the ``plots``; without any, its columns are
        plotted over the first.
    at : str
        Times [s] separated by commas: a picture for each file of the configurations at these times.
    band : (float, float)
        Frequencies [Hz] between which the picture of a sweep shows modes; by default ``loci.shown_modes``.
    output : str or Path
        A folder (existing or ending with /), or the prefix of the names of the pictures or, for one plot, its whole
        name ending with .png or .svg; by default the results file without its extension.
    kind : "png" or "svg"
    columns : bool
        Also write the numbers, as comma-separated values next to each picture.
    title : str
        Title of the pictures; by default that of the deck.
    force : bool
        Also replace pictures and tables that mecano has not written.

    Raises
    ------
    UsageError, UnknownNameError
        A plot is invalid or names an unknown output; the saved times of a spectrum are not equidistant.
    ResultsError
        A file cannot be read, or a picture cannot be written.
    """
    formats = {path: format_of(path) for path in paths}
    _refuse(formats, plots, transforms, band, {"--at": at, "--csv": columns, "--title": title, "--measured": measured})
    if not ALONE.keys() & formats.values():
        with opened_runs(paths) as runs:
            pictures, times = _pictures(runs, plots, transforms, at, measured)
            yield from _of_runs(runs, pictures, times, output, kind, columns, title, force)
    elif plots:
        yield from _of_studies(paths, plots, output, kind, force)
    else:
        yield from _of_others(paths, output, kind, band, force)


def _pictures(runs, plots, transforms, at, measured):
    """Return the pictures [(Sheet, function that draws it)] of runs, and the times [s] of their configurations."""
    if any(not len(run.results.time) for run in runs):
        raise ResultsError(f"{', '.join(str(run.results.path) for run in runs)}: no saved times yet")
    points = read_measured(measured, runs[0]) if measured else None
    plots = plots or (points.plots() if points else ())
    times, requested = times_of(at) if at else [], requested_sheets(plots, runs) + transforms.sheets(runs)
    if points:
        requested = with_measured(requested, points)
    return [(sheet, sheet_figure) for sheet in requested] if requested or times else _default_pictures(runs), times


def _of_runs(runs, pictures, times, output, kind, columns, title, force):
    """Draw pictures and configurations; yield the Path of each file."""
    title = title or " | ".join(dict.fromkeys(run.title for run in runs))
    names = [sheet.name for sheet, _ in pictures] + ["configurations"] * (len(runs) if times else 0)
    targets = _targets(names, output, kind, runs[0].results.path, _stem(runs))
    for target in targets:
        refuse_foreign(target, force)
    for run, target in zip(runs if times else [], targets[len(pictures) :], strict=True):
        yield _save(configurations_figure(run, times, title), target)
    for (sheet, draw), target in zip(pictures, targets, strict=False):
        yield _save(draw(sheet, title), target)
        if sheet.table or (columns and sheet.curves and draw is sheet_figure):
            table = target.with_suffix(".csv")
            write_csv(table, sheet.table or columns_of(sheet.curves, sheet.run_labels), force)
            yield table


def _refuse(formats, plots, transforms, band, options):
    """Raise UsageError if files other than results of runs come with such results, or with options of runs.

    ``formats``: {path: format}; ``options``: {option: value} of further ones for runs; ``plots`` are also for studies,
    and a ``band`` of frequencies is only for sweeps.
    """
    given = [name for name, value in zip(("--above", "--below"), band, strict=True) if value is not None]
    if given and {*formats.values()} != {sweep_file.FORMAT}:
        raise UsageError(f"{', '.join(given)}: only for files of `mecano modes --sweep`")
    others = [path for path, format in formats.items() if format in ALONE]
    if not others:
        return
    what = f"{others[0]} is a file of modes, of a response, of margins, of a sweep or of a study"
    if len(others) < len(formats):
        raise UsageError(f"{what}: it is not drawn together with results of runs")
    of_runs = {
        "--spectrum": transforms.spectra, "--density": transforms.densities, "--from, --to": transforms.window != ALL,
        **options,
    }  # fmt: skip
    if any(formats[path] != study_file.FORMAT for path in others):
        of_runs |= {"--plot": plots}
    if options := [option for option, value in of_runs.items() if value]:
        raise UsageError(f"{what}: {', '.join(options)} for results of runs only")


def _of_others(paths, output, kind, band, force):
    """Draw files of modes, sweeps and studies, and yield the Path of each picture."""
    if len(paths) > 1 and output and not _is_folder(output):
        raise UsageError(f"{output} names one picture, but there will be {len(paths)}: give a folder")
    for path in paths:
        prefix = _prefix(output, Path(path), Path(path).stem)
        target = _whole_name(output) or prefix.with_name(f"{prefix.name}.{kind}")
        refuse_foreign(target, force)
        yield draw_alone(path, target, above=band[0], below=band[1])


def draw_alone(path: str | os.PathLike[str], target: Path | None = None, **band: float | None) -> Path:
    """Draw a file of modes, a response, margins, a sweep or a study beside it, or at ``target``; return the Path.

    ``band``: ``below`` and ``above`` as in ``post``. Raises ResultsError, also if there is nothing to draw.
    """
    read, figure_of = ALONE[format_of(path)]
    figure = figure_of(read(path), **{name: value for name, value in band.items() if value is not None})
    if figure is None:
        raise ResultsError(f"there is nothing to draw in {path}: it has no outputs, or nothing is varied")
    return _save(figure, target or Path(path).with_suffix(".png"))


def _of_studies(paths, plots, output, kind, force):
    """Draw columns of the tables of studies over one another, and yield the Path of each picture."""
    for path in paths:
        figures = list(requested_figures(study_file.read_study(path), plots))
        targets = _targets([name for name, _ in figures], output, kind, Path(path), Path(path).stem)
        for (_, figure), target in zip(figures, targets, strict=True):
            refuse_foreign(target, force)
            yield _save(figure, target)


def _default_pictures(runs):
    """Return the overview and all sheets, each with the function that draws it."""
    sheets = default_sheets(runs)
    if not sheets:
        raise ResultsError("nothing moves and no force acts in these results; ask for a plot by name")
    facts = one_line(runs)

    def draw_overview(sheet, title):
        return overview_figure(sheet, title, facts)

    return [(overview(sheets), draw_overview), *((sheet, sheet_figure) for sheet in sheets)]


def _targets(names, output, kind, first, stem):
    """Return the Path of each picture with the suffixes ``names``, next to the file ``first`` or by ``output``."""
    if whole := _whole_name(output):
        if len(names) > 1:
            raise UsageError(f"{output} names one picture, but there will be {len(names)}: give a folder or a prefix")
        return [whole]
    prefix, ends = _prefix(output, first, stem), []
    for i, name in enumerate(names):
        before = names[:i].count(name)
        ends.append(f"{name}_{before + 1}" if before else name)
    return [prefix.with_name(f"{prefix.name}_{end}.{kind}") for end in ends]


def _whole_name(output):
    """Return the Path ``output`` if it is the whole name of a picture, else None; raise for other formats."""
    if not output or _is_folder(output):
        return None
    ending = Path(output).suffix[1:]
    if ending.lower() in OTHER_FORMATS:
        raise UsageError(f"{output}: pictures are written as {' or '.join(FORMATS)}")
    return Path(output) if ending in FORMATS else None


def _prefix(output, first, stem):
    """Return the Path with which names of pictures begin: next to the file ``first``, in a folder, or as given."""
    if not output:
        return first.with_name(stem)
    return Path(output) / stem if _is_folder(output) else Path(output)


def _is_folder(output):
    return os.path.isdir(output) or str(output).endswith(("/", os.sep))


def _stem(runs):
    stems = list(dict.fromkeys(run.results.path.stem for run in runs))
    together = "+".join(stems)
    return together if len(together) <= LONGEST_STEM else f"{stems[0]}_and_{len(runs) - 1}_more"


def _save(figure, path):
    make_folder(path.parent)
    save(figure, path)
    return path
