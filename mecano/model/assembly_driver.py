"""Drivers of the assembly: call the loops of all batches, with the work before and after them.

``loops`` (n,) are the addresses of the loops of n batches, ``batches`` (n,) their records BATCH; ``system`` (1,) is the
record SYSTEM of the value that is written (assembly.py).
"""

from mecano.jit.entry import Indices, Matrices, Matrix, Records, Vector, entry
from mecano.jit.kernel import kernel
from mecano.jit.memory import call, floats, integers
from mecano.model.loops import BATCH, SYSTEM

Batches, System = Records(BATCH), Records(SYSTEM)


@kernel
def bind_state(system, t, z, v, a, R, phases, memory):
    """Bind the loops to this state."""
    s = system[0]
    s.t = t
    s.z, s.v, s.a, s.R = z.ctypes.data, v.ctypes.data, a.ctypes.data, R.ctypes.data
    s.phases, s.memory = phases.ctypes.data, memory.ctypes.data


@kernel
def run(loops, batches, system):
    """Call all loops."""
    for i in range(loops.shape[0]):
        call(loops[i], batches[i : i + 1].ctypes.data, system.ctypes.data)


@kernel
def collect(system):
    """Sum the forces and force magnitudes (including inertia) of all slots that belong to the same unknown."""
    s = system[0]
    force, size, mass = floats(s.force, s.n_slots), floats(s.size, s.n_slots), floats(s.mass, s.n_slots)
    slot_dof, a = integers(s.slot_dof, s.n_slots), floats(s.a, s.n_all)
    r_out, scale_out = floats(s.residual, s.n_all), floats(s.scale, s.n_all)
    r_out[:] = 0.0
    scale_out[:] = 0.0
    for i in range(s.n_slots):
        d = slot_dof[i]
        r_out[d] += force[i]
        scale_out[d] += size[i] + mass[i] * abs(a[d])


@kernel
def residual(loops, batches, system, k, penalty):
    """Compute the residual and its scale, with the masses of the last tangent, at the bound state."""
    s = system[0]
    s.k, s.penalty = k, penalty
    floats(s.force, s.n_slots)[:] = 0.0
    floats(s.size, s.n_slots)[:] = 0.0
    run(loops, batches, system)
    collect(system)


@entry
def assemble_residual(
    loops: Indices, batches: Batches, system: System,
    t: float, z: Vector, v: Vector, a: Vector, R: Matrices, phases: Indices, memory: Vector,
    k: float, penalty: float,
):  # fmt: skip
    """Compute the residual and its scale."""
    bind_state(system, t, z, v, a, R, phases, memory)
    system[0].lag = 1.0
    residual(loops, batches, system, k, penalty)


@entry
def assemble(
    loops: Indices, batches: Batches, system: System,
    t: float, z: Vector, v: Vector, a: Vector, R: Matrices, phases: Indices, memory: Vector,
    T: Matrices, k: float, penalty: float, cK: float, cC: float, cM: float,
):  # fmt: skip
    """Compute the residual, its scale and the tangent."""
    bind_state(system, t, z, v, a, R, phases, memory)
    s = system[0]
    s.T, s.cK, s.cC, s.cM = T.ctypes.data, cK, cC, cM
    s.lag = cK / cC if cK * cC != 0.0 else 1.0
    floats(s.mass, s.n_slots)[:] = 0.0
    floats(s.data, s.n_data)[:] = 0.0
    residual(loops, batches, system, k, penalty)


@entry
def add(
    loops: Indices, batches: Batches, system: System,
    t: float, z: Vector, v: Vector, a: Vector, R: Matrices, phases: Indices, memory: Vector,
    T: Matrices, k: float, penalty: float, cK: float, cC: float,
):  # fmt: skip
    """Add the tangent cK K + cC C of some batches to the one present; also adds their forces to the slots."""
    bind_state(system, t, z, v, a, R, phases, memory)
    s = system[0]
    s.T, s.cK, s.cC, s.cM, s.k, s.penalty, s.lag = T.ctypes.data, cK, cC, 0.0, k, penalty, 1.0
    run(loops, batches, system)


@entry
def add_scaled(
    loops: Indices, batches: Batches, system: System,
    t: float, z: Vector, v: Vector, a: Vector, R: Matrices, phases: Indices, memory: Vector,
    T: Matrices, cK: float, cC: float, cM: float, times: float, force: Vector, size: Vector,
):  # fmt: skip
    """Add ``times`` the forces and tangent of some batches to those present; force, size (n_slots,) are work arrays."""
    bind_state(system, t, z, v, a, R, phases, memory)
    s = system[0]
    s.T, s.cK, s.cC, s.cM, s.k, s.penalty = T.ctypes.data, times * cK, times * cC, times * cM, 1.0, 0.0
    own_force, own_size, own_mass = s.force, s.size, s.mass
    force[:] = 0.0
    size[:] = 0.0
    s.force, s.size, s.mass = force.ctypes.data, size.ctypes.data, size.ctypes.data
    run(loops, batches, system)
    s.force, s.size, s.mass = own_force, own_size, own_mass
    force_out, size_out = floats(own_force, s.n_slots), floats(own_size, s.n_slots)
    for i in range(s.n_slots):
        force_out[i] += times * force[i]
        size_out[i] += abs(times) * size[i]
    collect(system)


@entry
def constraint_derivatives(
    loops: Indices, batches: Batches, system: System,
    t: float, z: Vector, v: Vector, a: Vector, R: Matrices, phases: Indices, memory: Vector,
    g_out: Matrix,
):  # fmt: skip
    """Write value, rate and second rate of all constraints, (n_l, 3)."""
    bind_state(system, t, z, v, a, R, phases, memory)
    system[0].constraint_derivatives = g_out.ctypes.data
    run(loops, batches, system)


@entry
def observe(
    loops: Indices, batches: Batches, system: System,
    t: float, z: Vector, v: Vector, a: Vector, R: Matrices, phases: Indices, memory: Vector,
    forces: Vector,
):  # fmt: skip
    """Compute outputs and energies at a state, with the forces (n_slots,) of an assembly there."""
    bind_state(system, t, z, v, a, R, phases, memory)
    system[0].force = forces.ctypes.data
    transmitted(system)
    floats(system[0].energy, 4)[:] = 0.0
    run(loops, batches, system)


@entry
def event_values(
    loops: Indices, batches: Batches, system: System,
    t: float, z: Vector, v: Vector, a: Vector, R: Matrices, phases: Indices, memory: Vector,
    values_out: Vector,
):  # fmt: skip
    """Write the values (n_events,) of all events."""
    bind_state(system, t, z, v, a, R, phases, memory)
    system[0].event_values = values_out.ctypes.data
    run(loops, batches, system)


@entry
def commit(
    loops: Indices, batches: Batches, system: System,
    t: float, z: Vector, v: Vector, a: Vector, R: Matrices, phases: Indices, memory: Vector,
    memory_out: Vector,
):  # fmt: skip
    """Write the memories after an accepted step."""
    bind_state(system, t, z, v, a, R, phases, memory)
    s = system[0]
    s.memory_out = memory_out.ctypes.data
    run(loops, batches, system)
    states, first = integers(s.states, s.n_states), memory.shape[0] - s.n_states
    for i in range(s.n_states):
        memory_out[first + i] = max(memory[first + i], abs(z[states[i]]))


@kernel
def transmitted(system):
    """Compute the forces of the rest on each slot, then, for each joint, the sums over one side of the model."""
    s = system[0]
    n = s.n_transmitted - s.n_slots
    force, out = floats(s.force, s.n_slots), floats(s.transmitted, s.n_transmitted)
    starts = integers(s.partition_starts, n + 1)
    members = integers(s.partition_members, starts[n])
    for i in range(s.n_slots):
        out[i] = -force[i]
    for i in range(n):
        total = 0.0
        for j in range(starts[i], starts[i + 1]):
            slot = members[j]
            total += force[~slot] if slot < 0 else -force[slot]
        out[s.n_slots + i] = total
