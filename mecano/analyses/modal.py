"""Modes of a deck about its start, a static equilibrium or a saved state: computation, table, file, warnings."""

from collections.abc import Iterator, Mapping, Sequence
from contextlib import nullcontext
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
import scipy.sparse as sp

from mecano.analyses.diagnostics import locating_formulas
from mecano.analyses.equilibria import follow
from mecano.analyses.initial_state import describe, set_initial_state
from mecano.analyses.load_state import rest_at, state_at
from mecano.analyses.prepare import Prepared, integrator_of, prepare, startup_warnings
from mecano.analyses.source import source_of
from mecano.element_interface import RELEASES
from mecano.errors import UsageError
from mecano.model.numbering import TRANSLATION
from mecano.post.recovered import nodes_inside, recovered
from mecano.process.interrupt import call_interruptibly
from mecano.results.file_names import refuse_existing, refuse_other_ending
from mecano.results.lock import locked
from mecano.results.modes_file import write_modes
from mecano.solve.linear.rounding import ROUNDING
from mecano.solve.modal.linearize import RESTING, Assemble, Linearization, linearize
from mecano.solve.modal.modes import CONVERGED, Modes, solve
from mecano.solve.statics.stability import motion_text
from mecano.solve.time.increments import displaced

if TYPE_CHECKING:
    import os

    from mecano.deck.deck import Deck
    from mecano.model.state import State
    from mecano.model.system import System

LARGEST = 1e100  # rad/s
CONSTANT = 1e-3  # change by a turn of one radian below which matrices count as constant
NUDGE = 1e-5  # of a shape, whose largest displacement is 1: error of the differences about 1e-10
BALANCED = 1e-6  # of the largest force: inertia forces below which a state at rest counts as an equilibrium
HELD = "delay", "sample_and_hold", "external"  # signals whose value does not depend on the present motion
NOT_CONVERGED = "not converged"
HEAD = ("mode", "damped [Hz]", "natural [Hz]", "damping", "growth [1/s]", "residual", "kind", "largest motions")


@dataclass
class OperatingPoint:
    """A state about which modes are computed: its assembly (None: that of the system) and its description."""

    prepared: Prepared
    state: "State"
    assemble: "Assemble | None"
    words: str
    warnings: tuple[str, ...] = ()
    is_start: bool = False


def operating_point(deck: "Deck", at: str | None = None, at_rest: bool = False) -> OperatingPoint:
    """Return the state of a checked deck about which modes are computed, as an OperatingPoint.

    It is that of the saved time ``at`` = "results.h5:time", otherwise the static equilibrium or the start of the run.
    ``at_rest``: the equilibrium at which the mechanism would come to rest near the saved time.
    """
    with locating_formulas(deck):
        return _operating_point(deck, at, at_rest)


def _operating_point(deck: "Deck", at: str | None, at_rest: bool) -> OperatingPoint:
    begun, held = prepare(deck), tuple(held_warnings(deck))
    prepared = begun
    if at is not None and at_rest:
        prepared, state, text, reported = rest_at(begun, at)
        return OperatingPoint(prepared, state, None, text, (*startup_warnings(prepared, begun=begun), *reported, *held))
    if at is not None:
        prepared, state, assemble, text, reported = state_at(begun, at)
        reported = (*startup_warnings(prepared, begun=begun), *reported, *held)
        return OperatingPoint(prepared, state, assemble, text, reported)
    if deck.values["static"]:
        result = follow(prepared)
        reported = (*startup_warnings(prepared), *result.warnings, *held)
        return OperatingPoint(
            prepared, result.point.state, result.assemble, f"static equilibrium at {result.where}", reported
        )
    reported = (*set_initial_state(prepared, disturbed=False), *held)
    run = integrator_of(prepared).begin(prepared.state, deck.values["time"]["step"])
    return OperatingPoint(
        prepared, run.motion, None, describe(deck), (*startup_warnings(prepared, run), *reported), is_start=True
    )


def held_warnings(deck: "Deck") -> Iterator[str]:
    """Yield a warning about signals whose values small motions do not change."""
    held = [(d["type"], name) for name, d in deck.values["signals"].items() if d["type"] in HELD]
    if held:
        names = ", ".join(f"{kind} '{name}'" for kind, name in held)
        counted = "found by `mecano margins`, or " if any(kind != "external" for kind, _ in held) else ""
        yield (
            f"{names}: modes take these values as constant, so that any feedback through them is missing; "
            f"whether it is stable is {counted}seen in a run"
        )


def imbalance_warnings(base: OperatingPoint, w: np.ndarray, what: str = "the modes are those") -> Iterator[str]:
    """Yield a warning if a start at rest in axes with the angular velocity ``w`` (3,) is not an equilibrium there.

    A body accelerates relative to them, by more than rounding. Bodies may turn in place, as the pylon of a rotor does
    as seen from its blades. ``what``: words for what was computed.
    """
    system, s = base.prepared.system, base.state
    a = _relative_accelerations(system, s, w) if base.is_start else None
    if a is None:
        return
    M, size = _matrix(system, s, 0.0, 1.0)
    stiffness = np.abs(_matrix(system, s, 1.0, 0.0)[0].data).max(initial=0.0)
    rounding = ROUNDING * stiffness * np.abs(s.z[system.numbering.kind == TRANSLATION]).max(initial=0.0)
    if np.abs(M @ a).max(initial=0.0) > max(BALANCED * size, rounding):
        remedy = (
            "write 'initial: {steady: {angular_velocity: ..., about: ...}}'" if np.any(w) else "write 'initial: static'"
        )
        yield (
            f"the start is not an equilibrium: {what} of this shape, without the forces in the members that its loads "
            f"cause; for those about the equilibrium {remedy}"
        )


def _relative_accelerations(system: "System", s: "State", w: np.ndarray) -> np.ndarray | None:
    """Return the accelerations (n_q,) relative to axes with the angular velocity ``w``, None if the state moves there.

    The axes turn about the origin or about any other point. Angular accelerations of nodes that turn in place are zero.
    """
    of, n_q = system.numbering, system.n_q
    v, a = s.v[:n_q].copy(), s.a[:n_q].copy()
    at = of.x[of.x < n_q][:, None] + np.arange(3)  # nodes may share a position
    a[at] -= np.cross(w, v[at])
    v[at] -= np.cross(w, s.z[at])
    if np.any(w):
        v[at] -= v[at[:1]]
    free = of.rotation_dof < n_q
    rotations = of.rotation_dof[free][:, None] + np.arange(3)
    v[rotations] -= w @ s.R[free]
    rounding = max(ROUNDING * np.abs(s.v[:n_q]).max(initial=0.0), RESTING)
    in_place = rotations[np.abs(v[rotations]).max(axis=1) > rounding]
    a[in_place], v[in_place] = 0.0, 0.0
    return None if np.any(np.abs(v[~system.signals]) > rounding) else a


def _matrix(system, s, cK, cM):
    """Return cK K + cM M (n_q, n_q) and the largest force or moment on a node."""
    assembly, n_q = system.assemble(s, 1.0, 0.0, cK, 0.0, cM), system.n_q
    whole = sp.csr_matrix((assembly.data[: system.nnz], (system.rows, system.cols)), shape=(system.n, system.n))
    return whole[:n_q, :n_q], assembly.size.max(initial=0.0)


def modes(
    deck: "Deck",
    path: "str | os.PathLike[str] | None",
    *,
    at: str | None = None,
    at_rest: bool = False,
    number: int = 10,
    frame: str = "inertial",
    method: str = "automatic",
    force: bool = False,
) -> tuple[str, Modes, OperatingPoint]:
    """Compute modes, write them to ``path`` unless it is None, and return (text of the table, Modes, OperatingPoint).

    ``at``, ``at_rest`` as in ``operating_point``; ``frame``: "inertial", the name of a node with which the axes turn,
    or "wx,wy,wz" [rad/s]. Raises UsageError, the errors of ``mecano run``, and, before anything is computed,
    ResultsError if ``path`` exists.
    """
    if path is not None:
        refuse_other_ending(path, "the command prints the table of modes")
    with nullcontext() if path is None else locked(path):
        if path is not None:
            refuse_existing(path, force)
        return _find(deck, path, at, at_rest, number, frame, method, force)


def _find(
    deck: "Deck",
    path: "str | os.PathLike[str] | None",
    at: str | None,
    at_rest: bool,
    number: int,
    frame: str,
    method: str,
    force: bool,
) -> tuple[str, Modes, OperatingPoint]:
    """Do as ``modes``, with the lock on the file held."""
    base = operating_point(deck, at, at_rest)
    prepared, system = base.prepared, base.prepared.system
    turning = angular_velocity_of(system, base.state, frame)
    lin = linearize(system, base.state, prepared.length, turning, base.assemble, prepared.compliance)
    found = call_interruptibly(solve, lin, number, method)
    reported = [
        *base.warnings,
        *imbalance_warnings(base, turning),
        *sticking_warnings(deck, system, base.state),
        *accuracy_warnings(lin.variation, found.residuals),
    ]
    if path is not None:
        inner = inner_motions(deck, system, base.state, found.shapes)
        plain = contents(system, base.state, found, base.words, turning, inner)
        write_modes(path, plain, source_of(deck, warnings=reported), force=force)
    head = f"modes about: {base.words}; {found.method}; {found.found} computed"
    lines = [head, *table(system, base.state, found, lin)]
    return "\n".join([*lines, *(f"mecano: {text}" for text in reported)]), found, base


def angular_velocity_of(system: "System", s: "State", frame: str) -> np.ndarray:
    """Return the angular velocity (3,) [rad/s] of the axes ``frame``. Raises UsageError."""
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
    if not np.all(np.abs(turning) <= LARGEST):  # nor not a number
        raise UsageError(f"--frame '{frame}': an angular velocity [rad/s] is out of range")
    return turning


def sticking_warnings(deck: "Deck", system: "System", s: "State") -> Iterator[str]:
    """Yield a warning about joints whose friction is in its regularized range, where it acts as a viscous damper."""
    first = {joint.name: joint.nodes[:2] for joint in system.model.elements if joint.kind.section == "joints"}
    stuck = [  # a coupler has no nodes of its own: its friction opposes the rate of its first coordinate
        f"{d['type']} '{name}'"
        for name, d in deck.values["joints"].items()
        if (friction := d.get("friction"))
        and _sliding(system, s, d.get("nodes", first[name]), friction) < friction["regularization"]
    ]
    if stuck:
        yield (
            f"{', '.join(stuck)}: regularized friction acts as a strong viscous damper while the joint sticks, and "
            "small motions include that damper; for those of a sliding joint remove the friction, for those of a "
            "sticking joint replace it by a fixed joint"
        )


def _sliding(system, s, pair, friction):
    """Return an upper bound [m/s] of the sliding speed of two nodes, rotation taken at the largest radius given."""
    of, names = system.numbering, [node.name for node in system.nodes]
    motion = []
    for i in (names.index(name) for name in pair if name in names):
        x, r = of.x[i], of.r[i]
        motion.append((s.v[x : x + 3], s.R[of.rotation[i]] @ s.v[r : r + 3]))
    v, omega = (np.linalg.norm(m[-1] - m[0] if len(m) > 1 else m[0]) for m in zip(*motion, strict=True))
    radius = max((value for key, value in friction.items() if "radius" in key and value), default=1.0)
    return max(float(v), radius * float(omega))


def accuracy_warnings(
    variation: float, residuals: np.ndarray | Sequence[float], what: str = "the modes hold"
) -> Iterator[str]:
    """Yield warnings about variable matrices, and about modes that do not satisfy the equations.

    ``what``: words for what was computed.
    """
    if variation > CONSTANT:
        yield (
            f"the linearized equations are not constant in these axes (they change by {variation:.2g} when the "
            f"fastest body turns by 1 rad): {what} for this instant only; see --frame"
        )
    worst = float(np.max(residuals, initial=0.0))
    if worst > CONVERGED:
        yield (
            f"modes marked '{NOT_CONVERGED}' do not satisfy the equations (residual up to {worst:.2g} of the terms): "
            "neither their eigenvalues nor their shapes are reliable; try the other --solver, dense or sparse"
        )


def table(system: "System", s: "State", found: Modes, lin: Linearization) -> list[str]:
    """Return the lines of the table for a terminal."""
    rows = [HEAD]
    columns = zip(found.values, found.frequency, found.natural_frequency, found.damping_ratio, found.residuals,
                  found.kinds, found.converged, found.shapes, strict=True)  # fmt: skip
    for i, (value, damped, natural, ratio, residual, kind, converged, shape) in enumerate(columns, start=1):
        what = largest_motions(system, s, lin, value, shape)
        ratio_text = "" if value == 0.0 else f"{round(float(ratio), 5) + 0.0:.5f}"
        numbers = (str(i), f"{damped:.6g}", f"{natural:.6g}", ratio_text, f"{value.real + 0.0:.4g}", f"{residual:.1e}")
        rows.append((*numbers, kind if converged else f"{kind}, {NOT_CONVERGED}", what))
    widths = [max(len(row[i]) for row in rows) for i in range(7)]
    return ["  ".join([*(f"{row[i]:>{widths[i]}}" for i in range(7)), row[7]]) for row in rows]


def largest_motions(system: "System", s: "State", lin: Linearization, value: complex, shape: np.ndarray) -> str:
    """Return the nodes with the largest motions of a mode as text, those of an oscillation by their kinetic energies.

    Rotations would otherwise exceed the displacements of members with waves shorter than the length scale. A decay or a
    divergence may need no inertia: its motions are compared as displacements.
    """
    M = lin.M if value.imag or value == 0.0 else None
    return motion_text(system, s, shape.real, float(lin.root.max(initial=1.0)), inertial=True, most=2, M=M)


def contents(
    system: "System",
    s: "State",
    found: Modes,
    words_: str,
    turning: np.ndarray,
    inner: Mapping[str, tuple[np.ndarray, np.ndarray]],
) -> dict[str, Any]:
    """Return the content of the file as plain arrays; see docs/results-file.md."""
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
    return {
        "modes": found, "nodes": nodes, "inner": inner, "about": words_, "time": s.t, "frame": turning,
        "released": list(_released(system, s)),
    }  # fmt: skip


def _released(system, s):
    """Yield the names of the joints and elements that have been released in state ``s``: "hinge 'pin'"."""
    for b in system.batches:
        after = {b.kind.phases.index(event.after) for event in b.kind.events if event.name == RELEASES}
        yield from (name for name, phase in zip(b.names, s.phases[b.phases], strict=True) if phase in after)


def inner_motions(
    deck: "Deck", system: "System", s: "State", shapes: np.ndarray
) -> dict[str, tuple[np.ndarray, np.ndarray]]:
    """Return the motions of nodes inside superelements: {name: (positions (k, 3) [m], translations (m, k, 3))}.

    ``shapes`` (m, n_q) as in Modes. The motions are central differences of the outputs of the displaced elements.
    """
    elements = deck.values["elements"]
    if not any(nodes_inside(d) for d in elements.values()):
        return {}
    at = _inside(elements, system, s)
    moves = []
    for shape in shapes:
        dq = _material(system, s, shape)
        parts = []
        for part in (dq.real, dq.imag):
            ends = [
                _inside(elements, system, displaced(s, sign * NUDGE * part, system.numbering)) for sign in (1.0, -1.0)
            ]
            parts.append({name: (ends[0][name] - ends[1][name]) / (2.0 * NUDGE) for name in at})
        moves.append({name: parts[0][name] + 1j * parts[1][name] for name in at})
    return {name: (x, np.array([move[name] for move in moves]).reshape(-1, *x.shape)) for name, x in at.items()}


def _material(system, s, shape):
    """Return a shape (n_q,) with rotations in the material axes of the nodes."""
    of, out = system.numbering, shape.astype(complex)
    for r, rotation in set(zip(of.r.tolist(), of.rotation.tolist(), strict=True)):
        if r < system.n_q:
            out[r : r + 3] = s.R[rotation].T @ shape[r : r + 3]
    return out


def _inside(elements, system, s):
    """Return the positions (k, 3) [m] of the nodes inside each superelement in state ``s``."""
    found, outputs = {}, system.observe(s).outputs
    for b in system.batches:
        ends = np.cumsum([int(np.prod(output.shape, dtype=int)) for output in b.kind.outputs])
        places = dict(zip((output.name for output in b.kind.outputs), ends, strict=True))
        widths = {output.name: output.shape for output in b.kind.outputs}
        for (path, _), y in zip(b.paths, b.outputs(outputs), strict=True):
            section, _, name = path.partition("/")
            if section == "elements" and nodes_inside(elements.get(name, {})):
                found[name] = recovered(elements[name], _reading(y, places, widths)).positions[0]
    return found


def _reading(y, ends, widths):
    """Return a function that gives an output by name, with a time axis of length 1, from the row ``y``."""

    def value(output):
        size = int(np.prod(widths[output], dtype=int))
        return y[ends[output] - size : ends[output]].reshape(1, *widths[output])

    return value
