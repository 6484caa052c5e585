"""A page that plays a motion in space: one file with everything in it, for any browser, without a network.

Points are kept relative to the middle of the mechanism at each instant and rounded to 1/65535 of its size; numbers
are little-endian, as text in base64.
"""

import base64
import json
from importlib import resources
from pathlib import Path

import numpy as np

from mecano.errors import UsageError
from mecano.post.quantity import SAVED
from mecano.post.request import Request, requested_sheet
from mecano.post.runs import open_runs
from mecano.post.scene import scene_of
from mecano.post.sheet import Panel, event_marks
from mecano.post.sheets import default_sheets, overview
from mecano.results.whole_file import appearing, make_folder

MOST_FRAMES = 600
FILMS = (".gif", ".webp", ".mp4")
MOST_PLOTS = 4
STEPS_OF_ROUNDING = 65535


def animate(path, page, plots=(), title=None):
    """Write the ``page`` that plays the results file ``path``, or a film where its name ends so; the Path written.

    ``plots``: texts as of ``mecano post --plot``, over time; without any, the first of the overview. A film has none.

    Raises
    ------
    UsageError, UnknownNameError
        The page has no name of its own, or a plot cannot be understood or names what is not in the file.
    ResultsError
        The file cannot be read or holds nothing that moves, or the page cannot be written.
    """
    page = Path(page)
    if page.suffix in FILMS:
        from mecano.post.film import film  # matplotlib, which the page does without

        if plots:
            raise UsageError(f"--animate {page}: a film has no plots; a page, .html, has")
        return film(path, page, title)
    if page.suffix not in (".html", ".htm"):
        raise UsageError(f"--animate {page}: the name ends with .html, {' or '.join(FILMS)}")
    [run] = open_runs([path])
    scene = scene_of(run, MOST_FRAMES)
    data = {
        "title": title or run.title, **_motion(scene),
        "plots": [_plot(panel, scene.rows) for panel in _panels(run, plots)],
        "events": [[mark.time, f"{mark.element}: {mark.text}"] for mark in event_marks([run])],
    }  # fmt: skip
    template = resources.files("mecano.post").joinpath("animation.html").read_text(encoding="utf-8")
    text = script_text(data)
    make_folder(page.parent)
    with appearing(page) as hidden:
        hidden.write_text(template.replace('"DATA"', text), encoding="utf-8")
    return page


def script_text(data):
    """Return plain data as JSON that may stand in a script of a page: nothing in it ends or opens one."""
    text = json.dumps(data, separators=(",", ":"))
    return text.replace("&", "\\u0026").replace("<", "\\u003c").replace(">", "\\u003e")


def _motion(scene):
    """Times, shapes, colours and grounds, as the page wants them."""
    middle, size = scene.middle, scene.size
    return {
        "times": _floats(scene.times), "axis": scene.axis, "middle": _floats(middle), "size": size,
        "follow": scene.follow, "up": scene.up, "quantities": scene.ranges,
        "shapes": [
            {
                "style": shape.style, "name": shape.name, "points": _rounded((shape.points - middle[:, None]) / size),
                "count": shape.points.shape[1], "colours": {what: _floats(values) for what, values in colours.items()},
            }
            for shape, colours in zip(scene.shapes, scene.colours, strict=True)
        ],
        "grounds": [_floats(line) for line in scene.grounds],
    }  # fmt: skip


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
    drawn = sorted(panel.curves, key=lambda curve: not curve.reference)  # references lie behind
    curves = [[f"{c.subject} {c.y.what}".strip(), _floats(c.y.values[rows]), c.reference] for c in drawn]
    return {"label": panel.label, "unit": panel.curves[0].y.unit, "curves": curves}


def _floats(values):
    return base64.b64encode(np.ascontiguousarray(values, "<f4").tobytes()).decode()


def _rounded(values):
    whole = np.round((np.clip(values, -1.0, 1.0) + 1.0) * 0.5 * STEPS_OF_ROUNDING)
    return base64.b64encode(whole.astype("<u2").tobytes()).decode()
