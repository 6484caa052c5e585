"""Compiled loops over all elements of one kind: gather, call the element's function, scatter.

A loop made by a closure over the element is never found in numba's cache again; a copy of the loop's code with
the element among its globals and a name of its own is (see docs/architecture.md).
"""

import math
import types
from functools import cache, partial

from numba import njit, typeof

from mecano.maths.nowhere import NOWHERE


@njit
def gather(dofs, rots, z_in, v_in, a_in, R_in, q_out, v_out, a_out, R_out):
    """Local unknowns, velocities, accelerations (n_local,) and rotations (n_rotations, 3, 3) of one element."""
    for i in range(dofs.shape[0]):
        d = dofs[i]
        q_out[i] = z_in[d]
        v_out[i] = v_in[d]
        a_out[i] = a_in[d]
    for r in range(rots.shape[0]):
        for i in range(3):
            for j in range(3):
                R_out[r, i, j] = R_in[rots[r], i, j]


def _assemble(
    # elements, for good
    p, laws, dofs, rots, slots, columns, entries,
    # work
    q, v, a, R, f, K, C, M,
    # elements, now
    memory, mode,
    # coefficients
    t, k, penalty, cK, cC, cM,
    # state in
    z_in, v_in, a_in, R_in, T_in,
    # out, added to
    force_out, size_out, mass_out, data_out,
):  # fmt: skip
    n = dofs.shape[1]
    for e in range(dofs.shape[0]):
        for i in range(n):
            f[i] = 0.0
            for j in range(n):
                K[i, j] = 0.0
                C[i, j] = 0.0
                M[i, j] = 0.0
        gather(dofs[e], rots[e], z_in, v_in, a_in, R_in, q, v, a, R)
        function(p[e], memory[e], mode[e], t, k, penalty, laws, q, v, a, R, f, K, C, M)  # noqa: F821
        for i in range(n):
            s = slots[e, i]
            force_out[s] += f[i]
            size_out[s] += abs(f[i])
            mass_out[s] += abs(M[i, i])
        # K is the derivative by the material variation; T turns it into one by the rotation increment
        for r in range(rots.shape[1]):
            c, s = columns[r], rots[e, r]
            for i in range(n):
                k0, k1, k2 = K[i, c], K[i, c + 1], K[i, c + 2]
                for j in range(3):
                    K[i, c + j] = k0 * T_in[s, 0, j] + k1 * T_in[s, 1, j] + k2 * T_in[s, 2, j]
        for i in range(n):
            for j in range(n):
                data_out[entries[e, i, j]] += cK * K[i, j] + cC * C[i, j] + cM * M[i, j]


def _residual(
    p, laws, dofs, rots, slots, q, v, a, R, f, memory, mode, t, k, penalty, z_in, v_in, a_in, R_in,
    force_out, size_out,
):  # fmt: skip
    n = dofs.shape[1]
    for e in range(dofs.shape[0]):
        f[:] = 0.0
        gather(dofs[e], rots[e], z_in, v_in, a_in, R_in, q, v, a, R)
        function(  # noqa: F821
            p[e], memory[e], mode[e], t, k, penalty, laws, q, v, a, R, f, NOWHERE, NOWHERE, NOWHERE
        )
        for i in range(n):
            s = slots[e, i]
            force_out[s] += f[i]
            size_out[s] += abs(f[i])


def _levels(
    p, laws, dofs, rots, multipliers, q, v, a, R, g, memory, mode, t, z_in, v_in, a_in, R_in, g_out,
):  # fmt: skip
    for e in range(dofs.shape[0]):
        gather(dofs[e], rots[e], z_in, v_in, a_in, R_in, q, v, a, R)
        function(p[e], memory[e], mode[e], t, laws, q, v, a, R, g)  # noqa: F821
        for i in range(multipliers.shape[1]):
            for j in range(3):
                g_out[multipliers[e, i], j] = g[i, j]


def _write(p, laws, dofs, rots, q, v, a, R, memory, mode, t, z_in, v_in, a_in, R_in, y_out):
    for e in range(dofs.shape[0]):
        gather(dofs[e], rots[e], z_in, v_in, a_in, R_in, q, v, a, R)
        function(p[e], memory[e], mode[e], t, laws, q, v, a, R, y_out[e])  # noqa: F821


def _watch(p, laws, dofs, rots, q, v, a, R, before, g_out, memory, mode, t, z_in, v_in, a_in, R_in):
    for e in range(dofs.shape[0]):
        gather(dofs[e], rots[e], z_in, v_in, a_in, R_in, q, v, a, R)
        function(p[e], memory[e], mode[e], t, laws, q, v, a, R, g_out[e])  # noqa: F821
        for i in range(before.shape[0]):
            if mode[e] != before[i]:
                g_out[e, i] = -math.inf


def _observe(
    p, laws, dofs, rots, slots, q, v, a, R, F, force_in, y_out, e_out, total_out, memory, mode, t,
    z_in, v_in, a_in, R_in,
):  # fmt: skip
    for e in range(dofs.shape[0]):
        gather(dofs[e], rots[e], z_in, v_in, a_in, R_in, q, v, a, R)
        for i in range(slots.shape[1]):
            F[i] = force_in[slots[e, i]]
        y_out[e] = 0.0
        e_out[e] = 0.0
        function(p[e], memory[e], mode[e], t, laws, q, v, a, R, F, y_out[e], e_out[e])  # noqa: F821
        for i in range(4):
            total_out[i] += e_out[e, i]


@njit(cache=True)
def clear(force_out, size_out, mass_out, data_out, residual_only):
    """Zero the arrays that the loops add to; masses and the values of the tangent only if they are wanted."""
    force_out[:] = 0.0
    size_out[:] = 0.0
    if not residual_only:
        mass_out[:] = 0.0
        data_out[:] = 0.0


@njit(cache=True)
def collect(force_in, size_in, mass_in, slot_dof, r_out, size_out, a_in):
    """Sum the forces of all slots that are one unknown, and their sizes, those of the forces of inertia included."""
    r_out[:] = 0.0
    size_out[:] = 0.0
    for s in range(slot_dof.shape[0]):
        d = slot_dof[s]
        r_out[d] += force_in[s]
        size_out[d] += size_in[s] + mass_in[s] * abs(a_in[d])


@njit(cache=True)
def transmitted(force_in, slots, starts, members, out, total_out):
    """out = forces that the rest exerts on each slot; then, for each joint, sums over its side of the model.

    Zeroes the sums of energies and powers total_out (4,), to which the loops over the outputs add.
    """
    total_out[:] = 0.0
    for s in range(slots):
        out[s] = -force_in[s]
    for i in range(starts.shape[0] - 1):
        total = 0.0
        for j in range(starts[i], starts[i + 1]):
            slot = members[j]
            total += force_in[~slot] if slot < 0 else -force_in[slot]
        out[slots + i] = total


@cache
def loop_over(template, function, name):
    """The loop ``template`` bound to the compiled ``function`` of one element; cached on disk by ``name``."""
    bound = types.FunctionType(template.__code__, {**template.__globals__, "function": function}, name)
    bound.__qualname__ = name
    return njit(cache=True)(bound)


def direct(function, first, others):
    """``function`` with its first arguments given, and called without numba's dispatch.

    ``others`` are examples of the arguments that are left; those of every call must have their types, dimensions and
    order in memory. The dispatch looks at every array again, which takes longer than the work of many a kernel.
    """
    if hasattr(function, "compile"):
        function = function.compile(tuple(typeof(argument) for argument in (*first, *others)))
    return partial(function, *first)
