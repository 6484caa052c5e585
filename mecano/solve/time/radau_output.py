"""Output within a long step of Radau IIA, whose stages satisfy the equations.

Positions, velocities and coordinates follow from the motion, interpolated to the order of the method. Forces, energies
and all other outputs follow the cubic through their values at the beginning, at the stages and at the end, limited to
the range of the two neighbours: forces evaluated at an interpolated state would not satisfy the equations of motion.
"""

from mecano.jit.entry import Records, entry
from mecano.jit.kernel import kernel
from mecano.jit.memory import floats, integers, items
from mecano.model.assembly_driver import assemble_residual, observe, observe_loops, residual_loops
from mecano.model.loop_records import SYSTEM
from mecano.model.sampler import QUATERNION, Observed, fill
from mecano.model.state import Instant
from mecano.solve.time.interpolate import between_smooth_states
from mecano.solve.time.output import OUTPUT, extend_extremes, nodes_of
from mecano.solve.time.radau_workspace import RADAU, row_of, stage_of, weight
from mecano.solve.time.workspace import BEGIN, BETWEEN, STEP, TRIAL, copy_state, state_of, system_of, unknowns_of

WITHIN = 2  # stages before the end
MOTION = 2  # row of ``stage_rows`` for an interpolated motion


@entry
def sample_stages(output: Records(OUTPUT), work: Records(STEP), radau: Records(RADAU)):
    """Write the rows of the stages before the end, and compare them with the extremes.

    ``which``: index of an entry that is not finite, or -1.
    """
    o, w, r = output[0], work[0], radau[0]
    gained = floats(r.work, (3, 2))
    for i in range(WITHIN):
        s, row = stage_of(w, r, i), row_of(o.stage_rows, i, o.row_size)
        dissipated, given = o.dissipated - gained[2, 0] + gained[i, 0], o.given - gained[2, 1] + gained[i, 1]
        observed = Observed(row_of(r.outputs, i, r.n_outputs), row_of(r.energies, i, 4))
        fill(row, nodes_of(o), observed, s, dissipated, given)
        o.which = extend_extremes(o, s.t, row)
        if o.which >= 0:
            return


@entry
def interpolate_stages(output: Records(OUTPUT), work: Records(STEP), radau: Records(RADAU)):
    """Write the row at the ``wanted`` time within the step."""
    o, w, r = output[0], work[0], radau[0]
    s0, s1 = state_of(w, BEGIN), state_of(w, TRIAL)
    u, nodes, out = (o.wanted - s0.t) / (s1.t - s0.t), floats(r.nodes, 3), floats(o.between, o.row_size)
    rows = (
        floats(o.row0, o.row_size), row_of(o.stage_rows, 0, o.row_size), row_of(o.stage_rows, 1, o.row_size),
        floats(o.row1, o.row_size),
    )  # fmt: skip
    segment = 0 if u <= nodes[0] else 1 if u <= nodes[1] else 2
    to_cubic = floats(r.to_cubic, (4, 4))
    weights = weight(to_cubic, u, 0), weight(to_cubic, u, 1), weight(to_cubic, u, 2), weight(to_cubic, u, 3)
    left, right = rows[segment], rows[segment + 1]
    for i in range(o.row_size):
        x = weights[0] * rows[0][i] + weights[1] * rows[1][i] + weights[2] * rows[2][i] + weights[3] * rows[3][i]
        out[i] = min(max(x, min(left[i], right[i])), max(left[i], right[i]))
    put_motion(o, w, r, u, out)


@kernel
def put_motion(o, w, r, u, out):
    """Write the interpolated motion into the row: nodes, coordinates with their rates, quaternions."""
    s0, s1, row = state_of(w, BEGIN), state_of(w, TRIAL), row_of(o.stage_rows, MOTION, o.row_size)
    copy_state(w, TRIAL, BETWEEN)
    s = state_of(w, BETWEEN)
    between_smooth_states(u, s1.t - s0.t, unknowns_of(w), s0, s1, s)
    there = Instant(o.wanted, s.z, s.v, s.a, s.R, s0.phases, s0.memory)
    fill(row, nodes_of(o), observed_at(w, r, there), there, 0.0, 0.0)
    for i in range(o.first):
        out[i] = row[i]
    pairs, turned = integers(o.pairs, 2 * o.n_pairs), integers(o.turned, o.n_turned)
    for k in range(2 * o.n_pairs):
        out[pairs[k]] = row[pairs[k]]
    geometric = integers(o.geometric, o.n_geometric)
    for k in range(o.n_geometric):
        out[geometric[k]] = row[geometric[k]]
    for k in range(o.n_turned):
        for i in range(turned[k], turned[k] + QUATERNION[0]):
            out[i] = row[i]


@kernel
def observed_at(w, r, s):
    """Return outputs and energies at a state; they overwrite those of the end, which the integrator observes later."""
    observation, system = items(r.observation, 1, SYSTEM), system_of(w)
    assemble_residual(residual_loops(w), system, s, 1.0, 0.0)
    observation[0].outputs, observation[0].energy = r.outputs + 16 * r.n_outputs, r.energies + 64
    forces = floats(system[0].force, system[0].n_slots)
    observe(observe_loops(r), observation, s, forces)
    return Observed(row_of(r.outputs, 2, r.n_outputs), row_of(r.energies, 2, 4))
