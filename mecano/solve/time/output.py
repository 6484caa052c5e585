"""Output of steps for the results file: saved times, solver history, extremes, unresolved oscillations.

Compiled code collects them in buffers, which Python empties when they are full, and at intervals.
"""

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING

import numpy as np

from mecano.jit.entry import Records, entry
from mecano.jit.kernel import kernel
from mecano.jit.memory import call, floats, integers, items
from mecano.model import loops
from mecano.model.assembly import Observation
from mecano.model.assembly_driver import observe, observe_loops
from mecano.model.extremes import Extremes, update
from mecano.model.loop_records import SYSTEM, fields, record
from mecano.model.sampler import Nodes, Observed, Sampler, blend, fill, node_rows
from mecano.model.state import Instant
from mecano.solve.time.interpolate import between_states
from mecano.solve.time.unresolved_oscillation import OscillationMonitor, count_changes
from mecano.solve.time.workspace import (
    BEGIN,
    BETWEEN,
    STEP,
    TRIAL,
    Workspace,
    copy_state,
    state_of,
    system_of,
    time_of,
    unknowns_of,
)

if TYPE_CHECKING:
    from mecano.jit.entry import PackedCall
    from mecano.solve.time.step_info import StepInfo
    from mecano.solve.time.time_integration import Accepted

DONE, FULL, NOT_FINITE, ENDED = range(4)
SAMPLE, ENTER, SAVE = range(3)
NEGLIGIBLE_TIME = 1e-9  # of the interval between saved times: times so near are the same
NUMBERS, BLOCK = 2**15, 2**18  # in a buffer, and in one of long rows
STEP_NUMBERS = 9  # time, size, iterations, error, its share, rejected trials, three norms

OUTPUT = fields(
    floats="every start end wanted h iterations error share rejected forces constraints increment dissipated given",
    words="stage code which saved row_size n_rows rows most_rows n_steps steps most_steps row0 row1 between "
    "high high_time low low_time n_outputs outputs energy n_nodes x r rotation first n_pairs pairs n_turned turned "
    "n_geometric geometric observation "
    "n_forces columns difference signs swing swing_time largest n_ends end_columns "
    "end_required end_sizes "
    "stages stages_words within within_words stage_rows",
    loops="observe",
)


@entry
def record_step(output: Records(OUTPUT), work: Records(STEP)):
    """Record the step from BEGIN to TRIAL, with its outputs and energies; ``code`` reports the outcome.

    A method whose steps have stages compares these with the extremes and interpolates within the step by functions of
    its own.

    FULL: call again when the buffers are empty. NOT_FINITE: entry ``which`` of the row is not finite; nothing was
    recorded. ENDED: element ``which`` of those monitored has reached the end of its range.
    """
    o, w = output[0], work[0]
    row0, row = floats(o.row0, o.row_size), floats(o.row1, o.row_size)
    t = time_of(w, TRIAL)[0]
    if o.stage == SAMPLE:
        o.code, o.which = NOT_FINITE, -1
        sample(o, w, TRIAL, row)
        if o.stages:
            call(o.stages, o.stages_words, 0)
        if o.which < 0:
            o.which = extend_extremes(o, t, row)
        if o.which >= 0:
            return
        o.stage = ENTER
    if o.stage == ENTER:
        o.code = FULL
        if o.n_steps == o.most_steps:
            return
        enter_step(o, t)
        o.stage = SAVE
    if not save(o, w, t, row0, row):
        o.code = FULL
        return
    o.stage = SAMPLE
    monitor(o, t, row0, row)
    for i in range(o.row_size):
        row0[i] = row[i]
    o.which = ended(o, row)
    o.code = ENDED if o.which >= 0 else DONE


@kernel
def sample(o, w, which, row):
    """Write the numbers of one of the states into the row."""
    observed = Observed(floats(o.outputs, o.n_outputs), floats(o.energy, 4))
    fill(row, nodes_of(o), observed, state_of(w, which), o.dissipated, o.given)


@kernel
def begin_row(o, w):
    """Begin the next step with the row at BEGIN, where forces have jumped; ``code`` reports as for a step."""
    row, signs = floats(o.row0, o.row_size), integers(o.signs, o.n_forces)
    sample(o, w, BEGIN, row)
    floats(o.difference, o.n_forces)[:] = 0.0
    for i in range(o.n_forces):
        signs[i] = 0
    o.which = extend_extremes(o, time_of(w, BEGIN)[0], row)
    o.code = NOT_FINITE if o.which >= 0 else DONE


@kernel
def nodes_of(o):
    """Return the indices of the motion of each node."""
    return Nodes(integers(o.x, o.n_nodes), integers(o.r, o.n_nodes), integers(o.rotation, o.n_nodes))


@kernel
def extend_extremes(o, t, row):
    """Update the extremes with a row; return the index of an entry that is not finite, or -1."""
    n = o.row_size
    return update(t, row, floats(o.high, n), floats(o.high_time, n), floats(o.low, n), floats(o.low_time, n))


@kernel
def enter_step(o, t):
    """Append the step to the history of the solver."""
    line = floats(o.steps + 8 * STEP_NUMBERS * o.n_steps, STEP_NUMBERS)
    line[0], line[1], line[2], line[3], line[4] = t, o.h, o.iterations, o.error, o.share
    line[5], line[6], line[7], line[8] = o.rejected, o.forces, o.constraints, o.increment
    o.n_steps += 1


@kernel
def next_time(o):
    """Return the next time to be saved; the last one is the end."""
    return min(o.start + (o.saved + 1) * o.every, o.end)


@kernel
def save(o, w, t, row0, row):
    """Save the motion at every multiple of the interval in the step, or the step; false when the buffer is full.

    No step is shortened to meet a multiple of the interval: between two steps the motion is interpolated.
    """
    if o.every == 0.0:
        return append(o, t, row)
    while o.saved >= 0 and next_time(o) <= t + NEGLIGIBLE_TIME * o.every:
        if o.n_rows == o.most_rows:
            return False
        wanted = next_time(o)
        if wanted > t - NEGLIGIBLE_TIME * o.every:
            append(o, wanted, row)
        else:
            found, o.wanted = floats(o.between, o.row_size), wanted
            if o.within:
                call(o.within, o.within_words, 0)
            else:
                interpolate_row(o, w, wanted, row0, row, found)
            extend_extremes(o, wanted, found)
            append(o, wanted, found)
        o.saved = o.saved + 1 if wanted < o.end else -1
    return True


@kernel
def append(o, t, row):
    """Append a row to the saved ones; false when the buffer is full."""
    if o.n_rows == o.most_rows:
        return False
    line = floats(o.rows + 8 * (1 + o.row_size) * o.n_rows, 1 + o.row_size)
    line[0] = t
    for i in range(o.row_size):
        line[1 + i] = row[i]
    o.n_rows += 1
    return True


@kernel
def interpolate_row(o, w, t, row0, row, out):
    """Write the row at a time within the step: motions may peak there."""
    copy_state(w, TRIAL, BETWEEN)
    s0, s1, s = state_of(w, BEGIN), state_of(w, TRIAL), state_of(w, BETWEEN)
    h = s1.t - s0.t
    between_states((t - s0.t) / h, h, unknowns_of(w), s0, s1, s)
    pairs, turned = integers(o.pairs, (o.n_pairs, 2)), integers(o.turned, o.n_turned)
    blend((t - s0.t) / o.h, o.h, o.first, pairs, turned, row0, row, out)
    node_rows(nodes_of(o), s, out)
    if o.n_geometric:
        put_geometry(o, w, Instant(t, s.z, s.v, s.a, s.R, s0.phases, s0.memory), out)


@kernel
def put_geometry(o, w, s, out):
    """Write the geometric outputs at the interpolated motion into the row."""
    observation, system = items(o.observation, 1, SYSTEM), system_of(w)[0]
    observed = observe_loops(o)
    observe(observed, observation, s, floats(system.force, system.n_slots))
    found, geometric = floats(observation[0].outputs, o.n_outputs), integers(o.geometric, o.n_geometric)
    for i in range(o.n_geometric):
        out[geometric[i]] = found[geometric[i] - o.first]


@kernel
def monitor(o, t, row0, row):
    """Count the changes of sign of force increments (unresolved_oscillation.py)."""
    n = o.n_forces
    count_changes(
        floats(o.difference, n), integers(o.signs, n), floats(o.swing, n), floats(o.swing_time, n),
        floats(o.largest, n), integers(o.columns, n), t, row0, row,
    )  # fmt: skip


@kernel
def ended(o, row):
    """Return the index of the first element at the end of its range, or -1."""
    columns, sizes = integers(o.end_columns, o.n_ends), floats(o.end_sizes, o.n_ends)
    required = integers(o.end_required, o.n_ends)
    for i in range(o.n_ends):
        if abs(row[columns[i]]) > sizes[i] and row[required[i]] != 0.0:
            return i
    return -1


class Output:
    """The buffers of a run, and the record OUTPUT that holds their addresses.

    Parameters
    ----------
    sampler : Sampler
    observation : Observation
        Where outputs and energies at the ends of the steps are written.
    extremes : Extremes
    ringing : OscillationMonitor
    times : tuple
        Start and end of the run, and the interval between saved times [s], 0 to save every step.
    ends : list
        (column of the row, column that must not be zero, largest magnitude) at the end of the range of an element.
    """

    def __init__(
        self,
        sampler: Sampler,
        observation: "Observation",
        extremes: Extremes,
        ringing: OscillationMonitor,
        times: tuple[float, float, float],
        ends: Sequence[tuple[int, int, float]],
    ):
        n = len(sampler.row)
        start, end, every = times
        most_rows, most_steps = max(NUMBERS // (1 + n), min(BLOCK // (1 + n), 64), 16), 4096
        self.rows, self.steps = np.zeros((most_rows, 1 + n)), np.zeros((most_steps, STEP_NUMBERS))
        self.row = np.zeros(n)  # at the beginning of the next step, behind the events there
        x, r, rotation = sampler.nodes
        self._within = Observation(sampler.system)
        observing = sampler.system.loops(loops.observe)
        arrays = {
            "rows": self.rows, "steps": self.steps, "row0": self.row, "row1": np.zeros(n), "between": np.zeros(n),
            "high": extremes.high, "high_time": extremes.high_time, "low": extremes.low, "low_time": extremes.low_time,
            "outputs": observation.outputs, "energy": observation.energy, "x": x, "r": r, "rotation": rotation,
            "pairs": sampler.pairs, "turned": sampler.rotations, "columns": ringing.columns,
            "difference": ringing.difference, "signs": ringing.signs, "swing": ringing.swing,
            "swing_time": ringing.time, "largest": ringing.largest,
            "geometric": sampler.geometric, "observe_loops": observing.addresses, "observe_batches": observing.batches,
            "observation": self._within.record,
            "end_columns": np.array([column for column, *_ in ends], np.int64),
            "end_required": np.array([required for _, required, _ in ends], np.int64),
            "end_sizes": np.array([size for *_, size in ends]),
        }  # fmt: skip
        self._arrays: dict[str, np.ndarray] = arrays
        self._enter_stages: Callable[[StepInfo], None] = lambda info: None
        self.record = record(
            OUTPUT, every=every, start=start, end=end, row_size=n, most_rows=most_rows, most_steps=most_steps,
            n_outputs=len(observation.outputs), n_nodes=len(x), first=sampler.node_size, n_pairs=len(sampler.pairs),
            n_turned=len(sampler.rotations), n_geometric=len(sampler.geometric),
            n_observe_loops=len(observing.addresses),
            n_forces=len(ringing.columns), n_ends=len(ends),
            **{name: array.ctypes.data for name, array in arrays.items()},
        )  # fmt: skip

    def use_stages(self, sample: "PackedCall", within: "PackedCall", enter: Callable[["StepInfo"], None]) -> None:
        """Use the functions of a method whose steps have stages.

        Parameters
        ----------
        sample, within : PackedCall
            Called by ``record_step`` for the rows of the stages, and for the row at the ``wanted`` time.
        enter : callable
            Enters the stages of a step that Python made.
        """
        self._enter_stages = enter
        self._arrays |= {"stage_rows": np.zeros((3, len(self.row))), "sample": sample.words, "within": within.words}
        r = self.record
        r["stage_rows"] = self._arrays["stage_rows"].ctypes.data
        r["stages"], r["stages_words"] = sample.function, sample.words.ctypes.data
        r["within"], r["within_words"] = within.function, within.words.ctypes.data

    @property
    def stage_rows(self) -> np.ndarray:
        """The rows (2, n) of the stages before the end of the last step."""
        return self._arrays["stage_rows"][:2]

    def record_step(self, workspace: Workspace, accepted: "Accepted", share: float) -> int:
        """Record an accepted step, which Python made; returns the code of ``record_step``."""
        run, info, r = accepted.run, accepted.info, self.record[0]
        workspace.put_step(accepted.before, run.motion)
        self._enter_stages(info)
        r["h"], r["iterations"], r["error"], r["share"], r["rejected"] = (
            accepted.h, info.iterations, info.error, share, accepted.rejected,
        )  # fmt: skip
        r["forces"], r["constraints"], r["increment"] = info.norms
        r["dissipated"], r["given"] = run.dissipated, run.given
        return self.continue_record(workspace)

    def continue_record(self, workspace: Workspace) -> int:
        """Record the step in the workspace, or the rest of it; returns the code of ``record_step``."""
        record_step(self.record, workspace.record)
        return int(self.record["code"][0])

    def outcome(self) -> tuple[int, int]:
        """Return the code of the last step, and the index to which it refers."""
        return int(self.record["code"][0]), int(self.record["which"][0])

    def taken(self) -> tuple[np.ndarray, np.ndarray]:
        """Empty the buffers; return their rows and the lines of the solver's history."""
        r = self.record[0]
        rows, steps = self.rows[: r["n_rows"]], self.steps[: r["n_steps"]]
        r["n_rows"] = r["n_steps"] = 0
        return rows, steps
