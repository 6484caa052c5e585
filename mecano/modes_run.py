"""Modes of a deck: about its start, its static equilibrium or a saved state; table, file and what to tell."""

from dataclasses import dataclass

import numpy as np

from mecano.errors import UsageError
from mecano.prepare import march_of, prepare, remarks
from mecano.results.modes_file import write_modes
from mecano.results.provenance import Source
from mecano.snapshot import state_at
from mecano.solve.linearize import linearize
from mecano.solve.modes import solve
from mecano.solve.stability import words
from mecano.start import bring_to_start
from mecano.start import words as start_in_words
from mecano.statics import follow

CONSTANT = 1e-3  # change by a turn of one radian below which matrices count as constant
DOUBTFUL = 1e-6  # residual above which a mode is told to be inaccurate
HEAD = ("mode", "damped [Hz]", "natural [Hz]", "damping", "growth [1/s]", "residual", "kind", "what moves most")


@dataclass
class About:
    """The state that modes are about: how it is assembled (None: as the system does), and in words."""

    prepared: object
    state: object
    assemble: object
    words: str
    remarks: tuple = ()


def about(deck, at=None):
    """The state of a checked deck: of a saved time "results.h5:time", the equilibrium, or the start of the march."""
    prepared = prepare(deck)
    if at is not None:
        state, assemble, text = state_at(prepared, at)
        return About(prepared, state, assemble, text, tuple(remarks(prepared)))
    if deck.values["static"]:
        result = follow(prepared)
        text = f"static equilibrium at {result.where}"
        return About(prepared, result.point.state, result.assemble, text, (*remarks(prepared), *result.remarks))
    told = bring_to_start(prepared, disturbed=False)
    run = march_of(prepared).begin(prepared.state, deck.values["time"]["step"])
    return About(prepared, run.motion, None, start_in_words(deck), (*remarks(prepared, run), *told))


def modes(deck, path, *, at=None, number=10, frame="inertial", method="automatic", force=False):
    """Find the modes and write them to ``path`` unless it is None: (text of the table, Modes, About).

    ``frame``: "inertial", the name of a node with which the axes turn, or "wx,wy,wz" [rad/s]. Raises UsageError and
    what ``mecano run`` of the deck may raise.
    """
    base = about(deck, at)
    prepared, system = base.prepared, base.prepared.system
    turning = turning_of(system, base.state, frame)
    lin = linearize(system, base.state, prepared.length, turning, base.assemble, prepared.compliance)
    found = solve(lin, number, method)
    told = [*base.remarks, *doubts(lin.variation, found.residuals)]
    if path is not None:
        source = Source(deck.text, deck.resolved(), deck.file, deck.values["title"], deck.overrides, deck.files,
                        remarks=told)  # fmt: skip
        write_modes(path, contents(system, base.state, found, base.words, turning), source, force=force)
    head = f"modes about: {base.words}; {found.method}; {found.found} computed"
    lines = [head, *table(system, base.state, found, lin)]
    return "\n".join([*lines, *(f"mecano: {text}" for text in told)]), found, base


def turning_of(system, s, frame):
    """Angular velocity (3,) of the axes [rad/s] that a user names."""
    names = [node.name for node in system.nodes]
    if frame == "inertial":
        return np.zeros(3)
    if frame in names:
        i, of = names.index(frame), system.numbering
        return s.R[of.rotation[i]] @ s.v[of.r[i] : of.r[i] + 3]
    try:
        turning = np.array([float(part) for part in frame.split(",")])
    except ValueError:
        turning = np.zeros(0)
    if turning.shape != (3,):
        raise UsageError(f"there is no node '{frame}'; --frame takes 'inertial', a node, or three numbers [rad/s]")
    return turning


def doubts(variation, residuals):
    """Texts on matrices that are not constant, and on modes that do not fulfil the equations."""
    if variation > CONSTANT:
        yield (
            f"the equations of small motions are not constant in these axes (they change by {variation:.2g} when "
            "the fastest body turns by 1 rad): the modes are those of this instant only; see --frame"
        )
    worst = float(np.max(residuals, initial=0.0))
    if worst > DOUBTFUL:
        yield f"the modes are inaccurate: what they leave of the equations is up to {worst:.2g} of their terms"


def table(system, s, found, lin):
    """Lines of the table for a terminal."""
    length = float(lin.root.max(initial=1.0))
    rows = [HEAD]
    columns = zip(found.values, found.frequency, found.natural_frequency, found.damping_ratio, found.residuals,
                  found.kinds, found.shapes, strict=True)  # fmt: skip
    for i, (value, damped, natural, ratio, residual, kind, shape) in enumerate(columns, start=1):
        what = words(system, s, shape.real, length, inertial=True, most=2)
        ratio_text = "" if value == 0.0 else f"{ratio + 0.0:.5f}"
        numbers = (str(i), f"{damped:.6g}", f"{natural:.6g}", ratio_text, f"{value.real + 0.0:.4g}", f"{residual:.1e}")
        rows.append((*numbers, kind, what))
    widths = [max(len(row[i]) for row in rows) for i in range(7)]
    return ["  ".join([*(f"{row[i]:>{widths[i]}}" for i in range(7)), row[7]]) for row in rows]


def contents(system, s, found, words_, turning):
    """What the file holds, as plain arrays: see docs/results-file.md."""
    of, zero = system.numbering, np.zeros((len(found.values), 3), complex)
    nodes = {}
    for i, node in enumerate(system.nodes):
        if " " in node.name:
            continue
        x, r = of.x[i], of.r[i]
        nodes[node.name] = {
            "position": s.z[x : x + 3].copy(),
            "orientation": s.R[of.rotation[i]].copy(),
            "translation": found.shapes[:, x : x + 3] if x < of.n_q else zero,
            "rotation": found.shapes[:, r : r + 3] if r < of.n_q else zero,
        }
    return {"modes": found, "nodes": nodes, "about": words_, "time": s.t, "frame": turning}
