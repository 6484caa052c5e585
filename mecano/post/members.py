"""Section forces along members at one instant: the diagrams of axial force, shear, torsion and bending."""

from collections.abc import Sequence

import numpy as np

from mecano.model.mesh import divided_nodes, piece_names
from mecano.post.panels import worth_showing
from mecano.post.quantity import SAVED, Quantity
from mecano.post.runs import Run
from mecano.post.shapes import BEAM
from mecano.post.sheet import Curve, Panel, Sheet

LEVEL = 1e-3  # of a section force: a smaller variation along a member is that of its own inertia
MOST, MOST_OF_SEVERAL = 4, 2  # members shown of one run, of each of several
DIAGRAMS = (  # label, unit, component; outputs at the first node, in the middle, at the second node of each element
    ("axial force", "N", (0,), ("force", "force", "force")),
    ("shear force", "N", (1, 2), ("force", "force", "force")),
    ("torque", "N m", (0,), ("moment_start", "moment", "moment_end")),
    ("bending moment", "N m", (1, 2), ("moment_start", "moment", "moment_end")),
)
CLEARLY = 1.05  # least ratio of the largest moment to that at the last instant for a sheet of its own


def member_sheets(runs: Sequence[Run]) -> list[Sheet]:
    """Return the Sheets of diagrams at the last saved time and, if clearly larger, at that of the largest moment."""
    peaks = [_peak(run) for run in runs]
    if not any(row is not None for row, _, _ in peaks):
        return []
    sheets = [_sheet("members", "at the end", runs, [-1 for _ in runs])]
    if any(row is not None and largest > CLEARLY * last for row, largest, last in peaks):
        rows = [-1 if row is None else row for row, _, _ in peaks]
        sheets.append(_sheet("members_peak", "at the largest moment", runs, rows))
    return [sheet for sheet in sheets if sheet.panels]


def _members(run):
    """Return (name, deck values) of the members with results."""
    elements = run.deck.get("elements", {}).items()
    found = [(name, d) for name, d in elements if run.display(d).shape == BEAM]
    return [(name, d) for name, d in found if f"elements/{piece_names(name, d)[0]}/moment" in run.paths]


def _largest(run, name, d):
    """Return the magnitude of the largest section moment of a member at each saved time (n,) [N m]."""
    pieces = piece_names(name, d)
    outputs = [run.results.find(f"elements/{one}/{end}").values for one in pieces for end in DIAGRAMS[2][3]]
    return np.max(np.linalg.norm(outputs, axis=-1), axis=0)


def _peak(run):
    """Return the row of the largest moment of all members (None without members), its magnitude, and the last one."""
    sizes = [_largest(run, name, d) for name, d in _members(run)]
    if not sizes:
        return None, 0.0, 0.0
    largest = np.max(sizes, axis=0)
    return int(np.argmax(largest)), float(largest.max()), float(largest[-1])


def _sheet(name, when, runs, rows):
    panels = []
    most = MOST if len(runs) == 1 else MOST_OF_SEVERAL
    shown = [_shown(run, row, most) for run, row in zip(runs, rows, strict=True)]
    for label, unit, components, outputs in DIAGRAMS:
        curves = [
            curve
            for number, (run, row) in enumerate(zip(runs, rows, strict=True))
            for member in shown[number]
            for curve in _curves(run, number, row, member, label, unit, components, outputs)
        ]
        panels.append(Panel(label, tuple(curves), level=LEVEL))
    axis = runs[0].results.axis
    places = {f"{run.results.time[row]:.4g}" for run, row in zip(runs, rows, strict=True)}
    heading = f"Section forces along members {when}, {axis.path} {' and '.join(sorted(places))} {axis.unit}".rstrip()
    count = max(len(_members(run)) for run in runs)
    if count > most:
        heading += f" ({most} of {count}, those with the largest moments)"
    return Sheet(name, heading, tuple(worth_showing(panels, runs)), lead=0)


def _shown(run, row, most):
    """Return the ``most`` members with the largest moments at ``row``, in the order of the deck."""
    members = _members(run)
    ranked = sorted(members, key=lambda member: -_largest(run, *member)[row])[:most]
    return [member for member in members if member in ranked]


def _curves(run, number, row, member, label, unit, components, outputs):
    """Yield a Curve per component: three points of each element over the arc length at the start."""
    name, d = member
    pieces, nodes = piece_names(name, d), divided_nodes(name, d)
    start = np.array([run.results.find(f"nodes/{node}/position").values[0] for node in nodes])
    at = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(start, axis=0), axis=1))])
    along = np.stack([at[:-1], 0.5 * (at[:-1] + at[1:]), at[1:]], axis=1).ravel()
    forces = np.array([[run.results.find(f"elements/{one}/{end}").values[row] for end in outputs] for one in pieces])
    x = Quantity(f"members/{name}/distance", "m", "along the member", f"{SAVED} {name}", along, along)
    for i in components:
        what = f"{label} {i + 1}" if len(components) > 1 else label
        path = f"members/{name}/{what.replace(' ', '_')}"
        values = forces[:, :, i].ravel()
        yield Curve(x, Quantity(path, unit, label, f"{SAVED} {name}", along, values), number, name)
