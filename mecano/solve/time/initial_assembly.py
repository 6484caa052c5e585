"""Assembly of initial positions, or an error that names constraints that cannot be satisfied."""

from dataclasses import replace

import numpy as np

from mecano.errors import AssemblyError, name_list
from mecano.model.numbering import LENGTH_CONSTRAINT, ROTATION
from mecano.model.state import State
from mecano.model.system import System
from mecano.solve.diagnostics.joint_redundancy import contradicting
from mecano.solve.diagnostics.scales import constraint_scale
from mecano.solve.events.events import Searching
from mecano.solve.linear.sparse import LinearSolver
from mecano.solve.time.increments import displaced

MAX_ITERATIONS = 50
TOLERANCE = 1e-12  # of the length scale, or rad
FULFILLED = 100 * TOLERANCE
REGULARIZATION = 1e-9  # lets redundant constraints be solved; the iteration makes up for it
MOST_NAMES = 5  # constraints named in a refusal
MOST_TAKING_PART = 20  # elements, likewise


def assemble_start(system: System, linear: LinearSolver, s: State, length: float) -> tuple[State, float]:
    """Assemble positions, and again if the phases that follow, such as closed contacts, are not satisfied."""
    found, moved = assemble_positions(system, linear, s, length)
    if not system.n_events:
        return found, moved
    settled = Searching(system).settle(replace(found, memory=system.commit(found)))
    if _violations(system, settled, length)[1].max(initial=0.0) <= FULFILLED:
        return found, moved
    found, again = assemble_positions(system, linear, settled, length)
    return found, moved + again


def assemble_positions(system: System, linear: LinearSolver, s: State, length: float) -> tuple[State, float]:
    """Move ``s`` to the nearest positions that satisfy all constraints; return (state, largest move [m, rad]).

    Gauss-Newton with least displacement, rotations counted by the length scale. Raises AssemblyError naming the
    constraints that cannot be met together, or a joint that closed the wrong way round.
    """
    start, of = s, system.numbering
    weight = np.where(of.kind[: system.n_q] == ROTATION, length**2, 1.0)
    for iterations in range(MAX_ITERATIONS + 1):
        phi, error = _violations(system, s, length)
        if iterations == MAX_ITERATIONS or error.max(initial=0.0) <= TOLERANCE:
            break
        dq = _least_change(system, linear, s, phi, weight)
        if dq is None or not np.all(np.isfinite(dq)):
            break
        limit = max(np.abs(dq * np.sqrt(weight)).max() / (0.5 * length), 1.0)  # no leap into another assembly mode
        s = displaced(s, dq / limit, of)
    if not error.max(initial=0.0) <= FULFILLED:
        raise AssemblyError(_refusal(system, start, s, iterations, length))
    s = displaced(s, np.zeros(system.n_q), of)
    return s, _moved(system, start, s)


def _violations(system, s, length):
    """Return the values (n_l,) [m, rad] of the constraints at ``s``, and their magnitudes over their scales."""
    phi = system.constraint_derivatives(s)[:, 0] if system.n_l else np.zeros(0)
    return phi, np.abs(phi) / constraint_scale(system, length)


def _moved(system, start, s):
    """Return the largest change of a coordinate of a node [m] between two states."""
    of = system.numbering
    shift = np.abs(s.z - start.z)[of.x[:, None] + np.arange(3)] if len(of.x) else np.zeros(1)
    return float(shift.max(initial=0.0))


def _least_change(system, linear, s, phi, weight):
    data = np.zeros(system.n_data)
    data[system.diagonal[: system.n_q]] = weight
    system.add_constraints(s, 1.0, 0.0, data, rates=False)
    data[system.diagonal[system.n_q :]] -= REGULARIZATION
    b, x = np.concatenate([np.zeros(system.n_q), phi]), np.zeros(system.n)
    status = linear.solve(data, b, x)
    return x[: system.n_q] if status.ok else None


def _refusal(system, start, s, iterations, length):
    """Return the message of an assembly that failed at ``s``: gaps of joints in the deck, and those that remain."""
    phi, error = _violations(system, s, length)
    worst = [i for i in np.argsort(-error)[:MOST_NAMES] if not error[i] <= FULFILLED]
    places = dict.fromkeys(name.place for name in contradicting(system, s, length, phi))
    taking_part = [f"  taking part: {name_list(tuple(places), MOST_TAKING_PART)}"] if len(places) > 1 else []
    return "\n".join(
        [
            f"the initial positions cannot be assembled: as given, {most_off(system, start, length)}",
            f"{iterations} iterations from there moved nodes by up to {_length(_moved(system, start, s))}, and at best "
            "leave these constraints, which cannot be met together:",
            *(f"  {system.numbering.name[system.n_q + i]}: off by {_size(system, i, phi)}" for i in worst),
            *taking_part,
        ]
    )


def most_off(system: System, s: State, length: float) -> str:
    """Return as text the constraint of a system with constraints that is violated most at ``s``, and by how much."""
    phi, error = _violations(system, s, length)
    first = int(np.argmax(error))
    name = system.numbering.name[system.n_q + first]
    return f"{name.place} is most off, by {_size(system, first, phi)} ({name.what})"


def _size(system, i, phi):
    """Return the magnitude of ``phi[i]``, of ``phi`` (n_l,) [m, rad], as text with its unit."""
    from mecano.constraints.of_coordinates import SINES  # few runs describe a constraint

    number = system.n_q + i
    if system.numbering.kind[number] == LENGTH_CONSTRAINT:
        return _length(phi[i])
    size = abs(phi[i])
    angle = np.arcsin(min(size, 1.0)) if system.numbering.name[number].what in SINES else size
    return f"{np.degrees(angle):.3g} deg"


def _length(value):
    """Return the magnitude of a length [m] as text, in mm below a metre."""
    return f"{abs(value):.3g} m" if abs(value) >= 1.0 else f"{1e3 * abs(value):.3g} mm"
