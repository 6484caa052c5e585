"""Drivers of the assembly: call the loops of all batches, with the work before and after them.

``loops`` are those of n batches; ``system`` (1,) is the record SYSTEM of the value that is written (assembly.py), ``s``
the state.
"""

from typing import NamedTuple

from mecano.jit.entry import Indices, Matrices, Matrix, Records, Vector, entry
from mecano.jit.kernel import kernel
from mecano.jit.memory import call, floats, integers, items
from mecano.maths.vector import Vec3, put, vec
from mecano.model.loop_records import BATCH, SYSTEM
from mecano.model.state import Instant

System = Records(SYSTEM)


class Loops(NamedTuple):
    """Loops of one purpose."""

    addresses: Indices  # (n,) of the C functions
    batches: Records(BATCH)  # (n,)


@kernel
def loops_at(n, addresses, batches):
    """Return the n Loops at these addresses."""
    return Loops(integers(addresses, n), items(batches, n, BATCH))


@kernel
def residual_loops(pointers):
    """Return the Loops of the residual from a record of Pointers."""
    return loops_at(pointers.n_residual_loops, pointers.residual_loops, pointers.residual_batches)


@kernel
def tangent_loops(pointers):
    """Return the Loops of the tangent from a record of Pointers."""
    return loops_at(pointers.n_tangent_loops, pointers.tangent_loops, pointers.tangent_batches)


@kernel
def constraint_loops(pointers):
    """Return the Loops of the derivatives of the constraints from a record of Pointers."""
    return loops_at(pointers.n_constraint_loops, pointers.constraint_loops, pointers.constraint_batches)


@kernel
def observe_loops(pointers):
    """Return the Loops of outputs and energies from a record of Pointers."""
    return loops_at(pointers.n_observe_loops, pointers.observe_loops, pointers.observe_batches)


@kernel
def bind_state(system, s):
    """Bind the loops to this state."""
    to = system[0]
    to.t = s.t
    to.z, to.v, to.a, to.R = s.z.ctypes.data, s.v.ctypes.data, s.a.ctypes.data, s.R.ctypes.data
    to.phases, to.memory = s.phases.ctypes.data, s.memory.ctypes.data


@kernel
def run(loops, system):
    """Call all loops; loops of the tangent compute forces only."""
    for i in range(loops.addresses.shape[0]):
        call(loops.addresses[i], loops.batches[i : i + 1].ctypes.data, system.ctypes.data)


@kernel
def run_with_columns(loops, system):
    """Call all loops of the tangent, which compute forces and the columns of the tangent."""
    system[0].columns = 1
    run(loops, system)
    system[0].columns = 0


@kernel
def clear_forces(system, k, penalty):
    """Set the forces and their sizes to zero before the loops, and the scales of the constraints."""
    s = system[0]
    s.k, s.penalty = k, penalty
    floats(s.force, s.n_slots)[:] = 0.0
    floats(s.size, s.n_slots)[:] = 0.0


@kernel
def collect(system):
    """Sum the forces and force magnitudes (including inertia) of all slots that belong to the same unknown."""
    s = system[0]
    force, size, mass = floats(s.force, s.n_slots), floats(s.size, s.n_slots), floats(s.mass, s.n_slots)
    slot_dof, a = integers(s.slot_dof, s.n_slots), floats(s.a, s.n_all)
    r_out, scale_out = floats(s.residual, s.n_all), floats(s.scale, s.n_all)
    r_out[:] = 0.0
    scale_out[:] = 0.0
    for i in range(0, 3 * s.n_vectors, 3):
        d = slot_dof[i]
        put(r_out, d, vec(r_out, d) + vec(force, i))
        x, y, z = vec(a, d)
        inertia = Vec3(mass[i] * abs(x), mass[i + 1] * abs(y), mass[i + 2] * abs(z))
        put(scale_out, d, vec(scale_out, d) + (vec(size, i) + inertia))
    for i in range(3 * s.n_vectors, s.n_slots):
        d = slot_dof[i]
        r_out[d] += force[i]
        scale_out[d] += size[i] + mass[i] * abs(a[d])


@kernel
def residual(loops, system, k, penalty):
    """Compute the residual and its scale, with the masses of the last tangent, at the bound state."""
    clear_forces(system, k, penalty)
    run(loops, system)
    collect(system)


@entry
def assemble_residual(loops: Loops, system: System, s: Instant, k: float, penalty: float):
    """Compute the residual and its scale."""
    bind_state(system, s)
    system[0].lag = 1.0
    residual(loops, system, k, penalty)


@entry
def assemble(
    loops: Loops, system: System, s: Instant, T: Matrices, k: float, penalty: float, cK: float, cC: float, cM: float
):  # fmt: skip
    """Compute the residual, its scale and the tangent."""
    assemble_lagging(loops, system, s, T, k, penalty, cK, cC, cM, cK / cC if cK * cC != 0.0 else 1.0)


@kernel
def assemble_lagging(loops, system, s, T, k, penalty, cK, cC, cM, lag):
    """Compute the same with a factor ``lag`` on the rows and the penalty of constraints on velocities."""
    bind_state(system, s)
    to = system[0]
    to.T, to.cK, to.cC, to.cM, to.lag = T.ctypes.data, cK, cC, cM, lag
    floats(to.mass, to.n_slots)[:] = 0.0
    floats(to.data, to.n_data)[:] = 0.0
    clear_forces(system, k, penalty)
    run_with_columns(loops, system)
    collect(system)


@entry
def add(loops: Loops, system: System, s: Instant, T: Matrices, k: float, penalty: float, cK: float, cC: float):
    """Add the tangent cK K + cC C of some batches to the current one, and their forces to the slots."""
    bind_state(system, s)
    to = system[0]
    to.T, to.cK, to.cC, to.cM, to.k, to.penalty, to.lag = T.ctypes.data, cK, cC, 0.0, k, penalty, 1.0
    run_with_columns(loops, system)


@entry
def add_scaled(
    loops: Loops, system: System, s: Instant, T: Matrices, cK: float, cC: float, cM: float, times: float, work: Matrix
):  # fmt: skip
    """Add ``times`` the forces and tangent of some batches to the current ones; overwrites ``work`` (2, n_slots)."""
    bind_state(system, s)
    to, force, size = system[0], work[0], work[1]
    to.T, to.cK, to.cC, to.cM, to.k, to.penalty = T.ctypes.data, times * cK, times * cC, times * cM, 1.0, 0.0
    own_force, own_size, own_mass = to.force, to.size, to.mass
    work[:, :] = 0.0
    to.force, to.size, to.mass = force.ctypes.data, size.ctypes.data, size.ctypes.data
    run_with_columns(loops, system)
    to.force, to.size, to.mass = own_force, own_size, own_mass
    force_out, size_out = floats(own_force, to.n_slots), floats(own_size, to.n_slots)
    for i in range(to.n_slots):
        force_out[i] += times * force[i]
        size_out[i] += abs(times) * size[i]
    collect(system)


@entry
def constraint_derivatives(loops: Loops, system: System, s: Instant, g_out: Matrix):
    """Write value, rate and second rate of all constraints, (n_l, 3)."""
    bind_state(system, s)
    system[0].constraint_derivatives = g_out.ctypes.data
    run(loops, system)


@entry
def observe(loops: Loops, system: System, s: Instant, forces: Vector):
    """Compute outputs and energies at a state, with the forces (n_slots,) of an assembly there."""
    bind_state(system, s)
    system[0].force = forces.ctypes.data
    transmitted(system)
    floats(system[0].energy, 4)[:] = 0.0
    run(loops, system)


@entry
def event_values(loops: Loops, system: System, s: Instant, values_out: Vector):
    """Write the values (n_events,) of all events."""
    bind_state(system, s)
    system[0].event_values = values_out.ctypes.data
    run(loops, system)


@entry
def commit(loops: Loops, system: System, s: Instant, memory_out: Vector):
    """Write the memories after an accepted step."""
    bind_state(system, s)
    to = system[0]
    to.memory_out = memory_out.ctypes.data
    run(loops, system)
    states, first = integers(to.states, to.n_states), memory_out.shape[0] - to.n_states
    for i in range(to.n_states):
        memory_out[first + i] = max(s.memory[first + i], abs(s.z[states[i]]))


@kernel
def transmitted(system):
    """Compute the forces of all other elements on each slot, then the transmitted ones (reaction_partition.py)."""
    s = system[0]
    n = s.n_transmitted - s.n_slots
    force, out = floats(s.force, s.n_slots), floats(s.transmitted, s.n_transmitted)
    starts = integers(s.partition_starts, n + 1)
    members, weights = integers(s.partition_members, starts[n]), floats(s.partition_weights, starts[n])
    for i in range(s.n_slots):
        out[i] = -force[i]
    for i in range(n):
        total = 0.0
        for j in range(starts[i], starts[i + 1]):
            total -= weights[j] * force[members[j]]
        out[s.n_slots + i] = total
