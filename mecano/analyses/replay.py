"""Reconstruct the state of a model at a saved time of a results file by replaying its rows and events.

Memory (angles over many turns, the places at which latches hold) and phases follow from the rows and events before that
time; positions, rotations, velocities and scalars are those of its row. Between two rows each node spins with the mean
of its angular velocities there, so that turns faster than the rows are counted.
"""

from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING, TypeAlias

import numpy as np

from mecano.errors import name_list
from mecano.model.sampler import Sampler, StaticSample
from mecano.solve.events.events import EventMonitor
from mecano.solve.events.impact_candidates import ImpactCandidates
from mecano.solve.events.shocks import touching_gaps
from mecano.solve.time.signals import solve_signals

if TYPE_CHECKING:
    from mecano.deck.deck import Deck
    from mecano.model.state import State
    from mecano.model.system import System
    from mecano.results.reader import Results

Scalar: TypeAlias = tuple[int, np.ndarray, np.ndarray]  # index in z, values and rates (n_rows,) in the results
COLUMNS = ("position", "rotation", "velocity", "angular_velocity")
MOST = 8  # names in a text
AT_ONCE = 1.0 + 1e-12  # factor of a time up to which events happen at it: the sum of steps may end before their time
TURN = 1.0  # [rad] largest rotation of a node between two replayed places; counting needs less than half a turn


def replayed(
    system: "System",
    state: "State",
    results: "Results",
    row: int,
    nodes: Sequence[tuple[int, str]],
    scalars: Sequence[Scalar],
    near: np.ndarray,
) -> "State":
    """Return the State of a row of results; ``state``, that of the deck, supplies the values that the results lack.

    Parameters
    ----------
    nodes : list of (int, str)
        Indices and names of the nodes whose motion is in the results.
    scalars : list of (int, values, rates)
        Index in z, values and rates (n_rows,) of scalar unknowns in the results.
    near : ndarray (n_l,)
        Gaps up to which contacts touch at the start, see ``gaps_at_start``; they are open unless an event closed them.
    """
    rows = range(row + 1) if any(b.kind.memory for b in system.batches) else sorted({0, row})
    traces = traces_of(results, nodes)
    monitor, state = EventMonitor(system), state.copy()
    touching = np.where(monitor.lasting, np.inf, ImpactCandidates(system).touching(near))
    events = [event for event in results.events if event.time <= AT_ONCE * results.time[row]]
    for r in rows:
        now = AT_ONCE * results.time[r]
        if r - 1 in rows:
            _spin(system, state, results.time, r, nodes, traces)
        place_row(system, state, results.time, r, nodes, traces, scalars)
        state.memory = system.commit(solve_signals(system, state))
        state = monitor.settle(state, touching) if r == 0 else state  # later changes and lasting ones are events
        while events and events[0].time <= now:  # positions do not determine whether a contact is open
            event = events.pop(0)
            state = monitor.entered(state, event.element, event.name, event.before, event.after)
    return state


def traces_of(results: "Results", nodes: Sequence[tuple[int, str]]) -> list[list[np.ndarray]]:
    """Return the COLUMNS of each of the ``nodes`` (index, name), in all rows of the results."""
    return [[results.find(f"nodes/{name}/{column}").values for column in COLUMNS] for _, name in nodes]


def place_row(
    system: "System",
    state: "State",
    times: np.ndarray,
    row: int,
    nodes: Sequence[tuple[int, str]],
    traces: Sequence[Sequence[np.ndarray]],
    scalars: Sequence[Scalar],
) -> None:
    """Set the time and the motion of a state to those of a row, in place; arguments as in ``replayed``."""
    for (i, _), trace in zip(nodes, traces, strict=True):
        _place_node(system, state, i, *(values[row] for values in trace))
    for place, value, rate in scalars:
        state.z[place], state.v[place] = value[row], rate[row]
    state.t = float(times[row])


def _spin(system, state, times, row, nodes, traces):
    """Turn the nodes from the previous row to ``row`` in steps below TURN, and commit memory at each."""
    dt = times[row] - times[row - 1]
    spins = np.array([0.5 * dt * (omega[row - 1] + omega[row]) for *_, omega in traces]).reshape(-1, 3)
    steps = int(np.ceil(np.linalg.norm(spins, axis=1).max(initial=0.0) / TURN))
    if steps < 2:
        return
    from scipy.spatial.transform import Rotation  # slow to import, and rarely needed

    of, at = system.numbering, [i for i, _ in nodes]
    turning, places = of.rotation[at], of.x[at][:, None] + np.arange(3)
    before, after = (Rotation.from_quat([np.roll(q[r], -1) for _, q, *_ in traces]) for r in (row - 1, row))
    rest = (after * before.inv() * Rotation.from_rotvec(spins).inv()).as_rotvec()
    spin, correct = (Rotation.from_rotvec(turn / steps).as_matrix() for turn in (spins, rest))
    shift = np.array([x[row] - x[row - 1] for x, *_ in traces]) / steps
    spun, corrected, R = np.eye(3), np.eye(3), before.as_matrix()
    for k in range(1, steps):
        spun, corrected = spin @ spun, correct @ corrected
        state.R[turning] = corrected @ spun @ R
        state.z[places] += shift
        state.t = float(times[row - 1] + k / steps * dt)
        state.memory = system.commit(solve_signals(system, state))


def miscounted(system: "System", state: "State", results: "Results", row: int) -> Iterator[str]:
    """Yield a warning if the turns counted in a replayed ``state`` differ from those of the angles in the row.

    The count is wrong if the mean of the rates at two rows misses the rotation between them by more than half a turn.
    """
    wrong = [f"{path} by {turns:+d}" for path, turns in _turns_too_many(system, state, results, row) if turns]
    if wrong:
        yield (
            f"the saved times of {results.path} are too far apart to count the turns before {results.time[row]:.6g} s: "
            f"wrong {name_list(wrong, MOST)}; save more often there ('output.every')"
        )


def _turns_too_many(system, state, results, row):
    sampler = Sampler(system)
    outputs = sampler.take(StaticSample(state), system.observe(state))
    for column in sampler.columns:
        if column.unit == "rad" and column.rate and column.path in results.series:
            beyond = outputs[column.start] - results[column.path].values[row]
            yield column.path, round(beyond / (2.0 * np.pi)) if np.isfinite(beyond) else 0


def gaps_at_start(deck: "Deck", system: "System", length: float) -> np.ndarray:
    """Return the gaps (n_l,) [m, rad] up to which the contacts of a run of ``deck`` touch; 0 in statics.

    ``length`` is the length scale [m].
    """
    time = deck.values["time"]
    return touching_gaps(system, time["newton"]["constraint_tolerance"] if time else 0.0, length)


def scalars_in(system: "System", results: "Results") -> tuple[list[Scalar], list[tuple[str, str]]]:
    """Return the scalar unknowns that the results contain, by the outputs NAME and NAME_rate, and the missing ones.

    The former as in ``replayed``, the latter as (title of the element, name).
    """
    found, missing = [], []
    for b in system.batches:
        first = 3 * len(b.kind.layout)
        for owner, dofs in zip(b.names if b.kind.scalars else (), b.dofs, strict=False):
            path = f"{b.kind.section}/{owner.split(chr(39))[1]}"
            for i, name in enumerate(b.kind.scalars):
                value, rate = f"{path}/{name}", f"{path}/{name}_rate"
                follows = b.kind.of_signals or name in b.kind.states  # its rate, from its equation
                if value not in results.series or (rate not in results.series and not follows):
                    # algebraic signals follow from the rest
                    missing += [(owner, name)] if name in b.kind.states or not b.kind.of_signals else []
                    continue
                values = results[value].values
                rates = results[rate].values if rate in results.series else np.zeros_like(values)
                found.append((dofs[first + i], values, rates))
    return found, missing


def _place_node(system, s, i, position, quaternion, velocity, omega):
    of = system.numbering
    x, r = of.x[i], of.r[i]
    R = _matrix(quaternion)
    s.z[x : x + 3], s.v[x : x + 3] = position, velocity
    s.R[of.rotation[i]] = R
    s.z[r : r + 3], s.v[r : r + 3] = 0.0, R.T @ omega


def _matrix(q):
    """Return the rotation matrix (3, 3) of a unit quaternion (w, x, y, z)."""
    w, u = q[0], q[1:]
    H = np.array([[0.0, -u[2], u[1]], [u[2], 0.0, -u[0]], [-u[1], u[0], 0.0]])
    return np.eye(3) + 2.0 * w * H + 2.0 * H @ H
