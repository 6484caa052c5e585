"""Web page with an animation of a motion in space: one self-contained file for any browser.

Points are relative to the middle of the mechanism at each instant and rounded to 1/65535 of its size; numbers are
little-endian, encoded in base64.
"""

import base64
import json
import os
import re
from collections.abc import Mapping, Sequence
from importlib import resources
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np

from mecano.errors import UsageError
from mecano.post.deformation import quaternions
from mecano.post.event_marks import event_marks
from mecano.post.ground import bars_across
from mecano.post.overview import overview
from mecano.post.quantity import SAVED
from mecano.post.request import requested_sheets
from mecano.post.runs import Run, opened_runs
from mecano.post.scene import scene_of
from mecano.post.sheet import Panel
from mecano.post.sheets import default_sheets
from mecano.post.verdict import is_sound, verdict
from mecano.results import modes_file
from mecano.results.opening import format_of
from mecano.results.whole_file import write_page

MOST_FRAMES = 600
FILMS = (".gif", ".webp", ".mp4")
MOST_PLOTS = 4
FILES = {
    "styles": ("uplot/uPlot.min.css", "page.css"),
    "libraries": ("three/three.min.js", "uplot/uPlot.iife.min.js"),
    "program": ("motion.js", "solids.js", "stage.js", "curves.js", "player.js"),
}
"""Files that replace {{styles}}, {{libraries}} and {{program}} in page.html, in this order."""
STEPS_OF_ROUNDING = 65535
BARS = 0.25, 1e-3  # distance of bars across a ground: of the size of the mechanism, and at least of the ground


def animate(
    path: str | os.PathLike[str], page: str | os.PathLike[str], plots: Sequence[str] = (), title: str | None = None
) -> Path:
    """Write an animation of the results file ``path`` as a ``page``, or as a film by its extension; return the Path.

    A file of modes is played mode after mode, each for two cycles. ``plots``: texts as for ``mecano post --plot``, over
    time; by default the first panels of the overview. Films and modes have no plots.

    Raises
    ------
    UsageError, UnknownNameError
        The name of the page is invalid, or a plot is invalid or names an output that is not in the file.
    ResultsError
        The file cannot be read or contains nothing that moves, or the page cannot be written.
    """
    page = Path(page)
    if format_of(path) == modes_file.FORMAT:
        return _animate_modes(path, page, plots, title)
    if page.suffix in FILMS:
        from mecano.post.film import film  # imports matplotlib, which pages do not need

        if plots:
            raise UsageError(f"--animate {page}: a film has no plots; a page, .html, has")
        return film(path, page, title)
    if page.suffix not in (".html", ".htm"):
        raise UsageError(f"--animate {page}: the name must end with .html, {' or '.join(FILMS)}")
    with opened_runs([path]) as [run]:
        text = page_text(page_data(run, plots, title))
    return write_page(page, text)


def _animate_modes(path, page, plots, title):
    from mecano.post.mode_motion import write_motions  # imports matplotlib, which other pages do not need

    if plots:
        raise UsageError(f"--animate {page}: {path} is a file of modes, which has no plots over time")
    with TemporaryDirectory() as folder:
        motions = Path(folder) / "modes.h5"
        write_motions(modes_file.read_modes(path), motions)
        return animate(motions, page, (), title)


def page_data(run: Run, plots: Sequence[str] = (), title: str | None = None) -> dict[str, Any]:
    """Return the data of a page for a run, as plain data. Raises as ``animate``."""
    scene, results = scene_of(run, MOST_FRAMES), run.results
    return {
        "title": title or run.title, "status": verdict(results), "sound": is_sound(results), **_motion(scene),
        "plots": [_plot(panel, scene.rows) for panel in _panels(run, plots)],
        "events": [{"time": mark.time, "element": mark.element, "name": mark.text} for mark in event_marks([run])],
    }  # fmt: skip


def page_text(data: Mapping[str, Any]) -> str:
    """Return the text of the page for plain data, with styles, libraries and program."""
    folder = resources.files("mecano.post").joinpath("browser")
    parts = {name: "\n".join(folder.joinpath(one).read_text("utf-8") for one in files) for name, files in FILES.items()}
    parts["data"] = script_text(data)
    page = folder.joinpath("page.html").read_text("utf-8")
    return re.sub(r"\{\{(\w+)\}\}", lambda match: parts[match[1]], page)


def script_text(data: Any) -> str:
    """Return plain data as JSON that is safe inside a script element of a page."""
    text = json.dumps(data, separators=(",", ":"))
    return text.replace("&", "\\u0026").replace("<", "\\u003c").replace(">", "\\u003e")


def _motion(scene):
    """Return times, shapes, colours, forces and grounds of a Scene as plain data."""
    return {
        "times": _floats(scene.times), "axis": scene.axis, "middle": _floats(scene.middle), "size": scene.size,
        "follow": bool(scene.followed.any()), "followed": scene.followed.tolist(),
        "up": scene.up.tolist(), "eye": scene.eye.tolist(), "quantities": scene.ranges,
        "shapes": [_shape(scene, i) for i in range(len(scene.shapes))],
        "groups": [
            {"places": _floats((part.places - scene.middle) / scene.size), "turns": _floats(quaternions(part.turns))}
            for part in scene.parts
        ],
        "arrows": [
            {
                "kind": arrow.kind, "name": arrow.name, "values": _floats(arrow.values),
                "places": _floats((arrow.places - scene.middle) / scene.size),
            }
            for arrow in scene.arrows
        ],
        "grounds": [_ground(sides, scene.size) for sides in scene.grounds],
    }  # fmt: skip


def _ground(sides, size):
    """Return the sides of a ground, and bars across it."""
    pitch = max(BARS[0] * size, BARS[1] * float(np.linalg.norm(sides[0, -1] - sides[0, 0])))
    return [_floats(sides), _floats(bars_across(sides, pitch))]


def _shape(scene, i):
    """Return one shape as plain data; points of flexible parts, whose deformation can be magnified, are not rounded."""
    shape, orientation = scene.shapes[i], scene.orientations[i]
    points = (shape.points - scene.middle[:, None]) / scene.size
    data = {
        "style": shape.style, "name": shape.name, "kind": scene.kinds[i], "count": shape.points.shape[1],
        "colours": {what: _floats(values) for what, values in scene.colours[i].items()},
    }  # fmt: skip
    group = next((number for number, part in enumerate(scene.parts) if i in part.shapes), None)
    if group is None:
        data["points"] = _rounded(points)
    else:
        rest = (shape.points[0] - scene.parts[group].start) / scene.size
        data |= {"exact": _floats(points), "group": group, "rest": _floats(rest)}
    if shape.shown is not None:
        data["shown"] = shape.shown.tolist()
    if orientation.turn is not None:
        data["turn"] = _floats(orientation.turn)
    if orientation.axis is not None:
        data["axis"] = _floats(orientation.axis)
    return data | ({"radius": orientation.radius} if orientation.radius else {})


def _panels(run, plots):
    """Return the requested panels of curves over time, or the first of the overview; none of modes."""
    if plots:
        sheets = requested_sheets(plots, [run])
    elif run.results.axis.path == modes_file.MOTIONS.path:
        sheets = []
    else:
        sheets = [overview(standard)] if (standard := default_sheets([run])) else []
    found = [panel for sheet in sheets for panel in sheet.panels]
    shown = [p for p in found if isinstance(p, Panel) and p.over_time and all(c.y.clock == SAVED for c in p.curves)]
    return shown if plots else shown[:MOST_PLOTS]


def _plot(panel, rows):
    drawn = sorted(panel.curves, key=lambda curve: not curve.reference)  # references in the background
    curves = [[c.y.owned, _floats(c.y.values[rows]), c.reference] for c in drawn]
    return {"label": panel.label, "unit": panel.curves[0].y.unit, "curves": curves}


def _floats(values):
    return base64.b64encode(np.ascontiguousarray(values, "<f4").tobytes()).decode()


def _rounded(values):
    whole = np.round((np.clip(values, -1.0, 1.0) + 1.0) * 0.5 * STEPS_OF_ROUNDING)
    return base64.b64encode(whole.astype("<u2").tobytes()).decode()
