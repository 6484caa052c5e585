"""A page that plays a motion in space: one file with everything in it, for any browser, without a network.

Points are kept relative to the middle of the mechanism at each instant and rounded to 1/65535 of its size; numbers
are little-endian, as text in base64.
"""

import base64
import json
from importlib import resources
from pathlib import Path

import numpy as np

from mecano.errors import ResultsError, UsageError
from mecano.model.mesh import piece_names
from mecano.post.ground import ground_path
from mecano.post.quantity import SAVED
from mecano.post.request import Request, requested_sheet
from mecano.post.runs import open_runs
from mecano.post.shapes import WHEEL, Motion, shapes
from mecano.post.sheet import Panel, event_marks
from mecano.post.sheets import default_sheets, overview

MOST_FRAMES = 600
MOST_PLOTS = 4
STEPS_OF_ROUNDING = 65535
FAR = 3.0  # sizes: the view follows a mechanism that travels farther
COLOURED = (("stress", "Pa", ("stress",)), ("axial force", "N", ("force", "tension")))
"""Name on the page, unit, outputs of elements; of the section force of a beam the first component."""


def animate(path, page, plots=(), title=None):
    """Write the ``page`` that plays the results file ``path``; the Path written.

    ``plots``: texts as of ``mecano post --plot``, over time; without any, the first of the overview.

    Raises
    ------
    UsageError, UnknownNameError
        The page has no name of its own, or a plot cannot be understood or names what is not in the file.
    ResultsError
        The file cannot be read or holds nothing that moves, or the page cannot be written.
    """
    page = Path(page)
    if page.suffix not in (".html", ".htm"):
        raise UsageError(f"--animate {page}: the name of a page ends with .html")
    [run] = open_runs([path])
    rows = _rows(run)
    data = {
        "title": title or run.title, **_motion(run, rows),
        "plots": [_plot(panel, rows) for panel in _panels(run, plots)],
        "events": [[mark.time, f"{mark.element}: {mark.text}"] for mark in event_marks([run])],
    }  # fmt: skip
    template = resources.files("mecano.post").joinpath("animation.html").read_text(encoding="utf-8")
    text = json.dumps(data, separators=(",", ":")).replace("</", "<\\/")
    try:
        page.parent.mkdir(parents=True, exist_ok=True)
        page.write_text(template.replace('"DATA"', text), encoding="utf-8")
    except OSError as error:
        raise ResultsError(f"cannot write {page}: {error.strerror}") from error
    return page


def _rows(run):
    """Numbers of the saved times that are played, evenly chosen."""
    count = len(run.results.time)
    if not count:
        raise ResultsError(f"{run.results.path}: no saved times yet")
    return np.unique(np.linspace(0, count - 1, min(count, MOST_FRAMES)).round().astype(int))


def _motion(run, rows):
    """Times, shapes, colours and grounds, as the page wants them."""
    drawn = shapes(Motion(run, rows))
    if not drawn:
        raise ResultsError(f"{run.results.path}: nothing to be drawn, no node has a position")
    cloud = np.concatenate([s.points[:, -1:] if s.style == WHEEL else s.points for s in drawn], axis=1)
    middle = 0.5 * (cloud.min(axis=1) + cloud.max(axis=1))
    size = max(float(np.abs(s.points - middle[:, None]).max()) for s in drawn) or 1.0
    coloured = [_colours(run, shape, rows) for shape in drawn]
    gravity = run.deck.get("gravity")
    return {
        "times": _floats(run.results.time[rows]), "axis": [run.results.axis.path, run.results.axis.unit],
        "middle": _floats(middle), "size": size, "follow": bool(np.ptp(middle, axis=0).max() > FAR * size),
        "up": 2 if gravity is None or not any(gravity) else int(np.argmax(np.abs(gravity))),
        "shapes": [
            {
                "style": shape.style, "name": shape.name, "points": _rounded((shape.points - middle[:, None]) / size),
                "count": shape.points.shape[1], "colours": {what: _floats(values) for what, values in colours.items()},
            }
            for shape, colours in zip(drawn, coloured, strict=True)
        ],
        "quantities": list(_ranges(coloured)),
        "grounds": [_floats(line) for line in _grounds(run, drawn)],
    }  # fmt: skip


def _colours(run, shape, rows):
    """What an element can be coloured by: name -> values (instants, pieces)."""
    d, found = run.deck.get("elements", {}).get(shape.name), {}
    for what, _, outputs in COLOURED if d else ():
        for output in outputs:
            paths = [f"elements/{piece}/{output}" for piece in piece_names(shape.name, d)]
            if all(path in run.paths for path in paths):
                values = np.stack([run.results.find(path).values[rows] for path in paths], axis=1)
                if values.ndim == 2 or d["type"] == "beam":
                    found[what] = values.reshape(*values.shape[:2], -1)[..., 0]
    return found


def _ranges(coloured):
    """Name, unit, lowest and highest value of everything that something can be coloured by."""
    for what, unit, _ in COLOURED:
        arrays = [colours[what] for colours in coloured if what in colours]
        if arrays:
            yield [what, unit, min(float(a.min()) for a in arrays), max(float(a.max()) for a in arrays)]


def _grounds(run, drawn):
    """Lines (k, 3) on the ground along the way of each wheel."""
    for shape in drawn:
        d = run.deck.get("elements", {}).get(shape.name, {})
        if shape.style == WHEEL and "ground" in d:
            radius = np.ptp(shape.points[0, :-1], axis=0).max() * 0.5
            yield from ground_path(run.deck, run.deck["grounds"][d["ground"]], shape.points[:, -1], radius)


def _panels(run, plots):
    """Panels of curves over time."""
    if plots:
        sheets = [requested_sheet(Request.parse(text), [run]) for text in plots]
        found = [panel for sheet in sheets for panel in sheet.panels]
    else:
        sheets = default_sheets([run])
        found = overview(sheets).panels if sheets else ()
    shown = [p for p in found if isinstance(p, Panel) and p.over_time and all(c.y.clock == SAVED for c in p.curves)]
    return shown if plots else shown[:MOST_PLOTS]


def _plot(panel, rows):
    curves = [[f"{curve.subject} {curve.y.what}".strip(), _floats(curve.y.values[rows])] for curve in panel.curves]
    return {"label": panel.label, "unit": panel.curves[0].y.unit, "curves": curves}


def _floats(values):
    return base64.b64encode(np.ascontiguousarray(values, "<f4").tobytes()).decode()


def _rounded(values):
    whole = np.round((np.clip(values, -1.0, 1.0) + 1.0) * 0.5 * STEPS_OF_ROUNDING)
    return base64.b64encode(whole.astype("<u2").tobytes()).decode()
