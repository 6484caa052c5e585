"""A report as a self-contained HTML page, for browsers and for print."""

import base64
import io
import os
import re
from collections.abc import Sequence
from html import escape
from importlib import resources
from pathlib import Path

from mecano.errors import UsageError
from mecano.post.figure import save
from mecano.post.report import Picture, Report, Table, report_of
from mecano.post.runs import opened_runs
from mecano.post.spectrum import NO_TRANSFORMS, Transforms
from mecano.post.study_report import study_report
from mecano.results import study_file
from mecano.results.opening import format_of
from mecano.results.whole_file import write_page


def write_report(
    path: str | os.PathLike[str],
    page: str | os.PathLike[str],
    title: str | None = None,
    plots: Sequence[str] = (),
    transforms: Transforms = NO_TRANSFORMS,
) -> Path:
    """Write the report on a results file, or on the table of a study, to ``page``, and return its Path.

    ``plots`` and ``transforms``, as for ``mecano post``, are shown before the standard plots.

    Raises
    ------
    UsageError, UnknownNameError
        The name of the page does not end with .html, or a plot is invalid, names an unknown output, or is for a study.
    ResultsError
        The file cannot be read or has no saved times, or the page cannot be written.
    """
    page = Path(page)
    if page.suffix not in (".html", ".htm"):
        raise UsageError(
            f"--report {page}: the name of a page must end with .html; print it in a browser to get a PDF, as by\n"
            f"chromium --headless --print-to-pdf={page.stem}.pdf {page.stem}.html"
        )
    text = page_of(_report(path, title, plots, transforms))
    return write_page(page, text)


def _report(path, title, plots, transforms):
    if format_of(path) == study_file.FORMAT:
        if plots or transforms != NO_TRANSFORMS:
            raise UsageError("--plot, --spectrum and --density are of runs, not of the table of a study")
        return study_report(path, title)
    with opened_runs([path]) as [run]:
        return report_of(run, title, plots, transforms)


def page_of(report: Report) -> str:
    """Return the page of a Report as text."""
    template = resources.files("mecano.post").joinpath("report.html").read_text(encoding="utf-8")
    filled = {
        "title": escape(report.title), "verdict": escape(report.verdict), "reason": escape(report.reason),
        "soundness": "sound" if report.sound else "",
        "contents": "".join(f'<a href="#{_anchor(s)}">{escape(s.heading)}</a>' for s in report.sections),
        "sections": "\n".join(_section(s) for s in report.sections),
    }  # fmt: skip
    return re.sub(r"\{\{(\w+)\}\}", lambda match: filled[match[1]], template)


def _section(section):
    parts = "\n".join(_part(part) for part in section.parts)
    return f'<section id="{_anchor(section)}">\n<h2>{escape(section.heading)}</h2>\n{parts}\n</section>'


def _anchor(section):
    return section.heading.lower().replace(" ", "-")


def _part(part):
    if isinstance(part, Table):
        return _collapsed(part.title, _table(part)) if part.title else _table(part)
    if isinstance(part, Picture):
        return f'<figure><img alt="{escape(part.title)}" src="{_image(part.figure)}"></figure>'
    if part.verbatim:
        return _collapsed(part.title, f"<pre>{escape(part.text)}</pre>")
    return f"<p>{escape(part.text)}</p>"


def _collapsed(title, inner):
    return f"<details><summary>{escape(title)}</summary>{inner}</details>"


def _table(table):
    def row(texts, tag, number=None):
        cells = (f"<{tag}{_class(table, number, i)}>{escape(text)}</{tag}>" for i, text in enumerate(texts))
        return f"<tr>{''.join(cells)}</tr>"

    head = f"<thead>{row(table.columns, 'th')}</thead>" if any(table.columns) else ""
    body = "\n".join(row(texts, "td", i) for i, texts in enumerate(table.rows))
    return f"<table>{head}<tbody>\n{body}\n</tbody></table>"


def _class(table, row, column):
    """Return the attribute of the class of a cell; ``row`` is None in the head."""
    if (row, column) in table.marked:
        return ' class="number beyond"'
    if (row, column) in table.governing:
        return ' class="number governing"'
    return " class=number" if column >= table.first_number else ""


def _image(figure):
    """Return the figure as a data URL of SVG, which stays sharp in print."""
    stream = io.BytesIO()
    save(figure, stream, "svg")
    return f"data:image/svg+xml;base64,{base64.b64encode(stream.getvalue()).decode()}"
