"""The stages of a step of Radau IIA: prediction, correction, motions, residuals."""

import numpy as np

from mecano.jit.kernel import kernel
from mecano.jit.memory import floats, integers
from mecano.maths.so3 import exp, tangent, tangent_inverse
from mecano.maths.vector import mat, put, put_matrix, vec
from mecano.model.assembly_driver import assemble_residual, constraint_derivatives, constraint_loops, residual_loops
from mecano.model.numbering import ROTATION, SIGNAL, STATE
from mecano.solve.diagnostics.scales import SMALL
from mecano.solve.events.compliance import OF_RELEASED
from mecano.solve.linear.rounding import HUGE
from mecano.solve.time.radau_workspace import row_of, stage_of, weight
from mecano.solve.time.workspace import BEGIN, state_of, system_of

PREDICTIONS = 2  # iterations on the rates of the increments
SECOND = 2  # column of the second rates of the constraints


@kernel
def begin_stages(w, r):
    """Predict velocities and reactions by extrapolating the last step, or from the motion at the beginning."""
    s0, nodes, n_q = state_of(w, BEGIN), floats(r.nodes, 3), w.n_q
    velocities, reactions = floats(r.last_velocities, (4, n_q)), floats(r.last_reactions, (3, w.n_l))
    to_cubic, to_parabola = floats(r.to_cubic, (4, 4)), floats(r.to_parabola, (3, 3))
    for i in range(3):
        hold_fixed(w, r, i)
        v, out = row_of(r.scratch, i, n_q), row_of(r.reactions, i, w.n_l)
        if r.known:
            blend(to_cubic, 1.0 + nodes[i] * w.h / r.last_h, velocities, v)
            blend(to_parabola, 1.0 + nodes[i] * w.h / r.last_h, reactions, out)
        else:
            for d in range(n_q):
                v[d] = s0.v[d] + nodes[i] * w.h * s0.a[d]
            for j in range(w.n_l):
                out[j] = s0.z[n_q + j]
    predict(w, r)


@kernel
def blend(to_coefficients, x, values, out):
    """Evaluate the polynomial through the rows of ``values`` at x."""
    out[:] = 0.0
    for j in range(values.shape[0]):
        share = weight(to_coefficients, x, j)
        for d in range(out.shape[0]):
            out[d] += share * values[j, d]


@kernel
def hold_fixed(w, r, i):
    """Initialize stage i with the motion at the beginning, which fixed unknowns keep."""
    s0, s = state_of(w, BEGIN), stage_of(w, r, i)
    floats(r.t, 3)[i] = s0.t + floats(r.nodes, 3)[i] * w.h
    for d in range(w.n_all):
        s.z[d], s.v[d], s.a[d] = s0.z[d], s0.v[d], s0.a[d]
    for j in range(w.n_rotations):
        put_matrix(s.R[j], mat(s0.R[j]))


@kernel
def predict(w, r):
    """Compute increments (3, n_q) that have the velocities in ``scratch`` (3, n_q) at the stages."""
    A, v, n_q = floats(r.A, (3, 3)), floats(r.scratch, (3, w.n_q)), w.n_q
    rate, theta = floats(r.rates, (3, n_q)), floats(r.increments, (3, n_q))
    for i in range(3):
        for d in range(n_q):
            rate[i, d] = v[i, d]
    for iteration in range(PREDICTIONS + 1):
        for i in range(3):
            for d in range(n_q):
                theta[i, d] = w.h * (A[i, 0] * rate[0, d] + A[i, 1] * rate[1, d] + A[i, 2] * rate[2, d])
        if iteration < PREDICTIONS:
            for i in range(3):
                untangle(w, theta[i], v[i], rate[i])


@kernel
def untangle(w, theta, v, rate_out):
    """Compute T(theta)^-1 v of all free rotations."""
    rotation_dof = integers(w.rotation_dof, w.n_rotations)
    for r in range(w.n_rotations):
        d = rotation_dof[r]
        if d < w.n_q:
            put(rate_out, d, tangent_inverse(vec(theta, d)) @ vec(v, d))


@kernel
def measure_signals(w, r, share):
    """Set the sizes of signals; algebraic ones need only a ``share`` of the accuracy of the motion."""
    s0, kind, sizes, system = state_of(w, BEGIN), integers(w.kind, w.n_all), floats(r.sizes, w.n_q), system_of(w)[0]
    known = w.n_memory - system.n_states  # where the largest values so far stand
    for d in range(w.n_q):
        y, rate = abs(s0.z[d]), abs(s0.v[d])
        if kind[d] == SIGNAL:
            sizes[d] = max(y + w.h * rate, SMALL) / share
        elif kind[d] == STATE:
            sizes[d] = max(y, w.duration * rate, s0.memory[known], SMALL)
            known += 1


@kernel
def correct(w, r):
    """Subtract the correction (3, n) of material variations at ``turn`` and of reactions.

    Return its largest component over the size of the unknown; inf if not finite. ``moved`` is that without signals.
    """
    correction, turn, sizes = floats(r.correction, (3, w.n)), floats(r.turn, w.n_all), floats(r.sizes, w.n_q)
    theta, reactions = floats(r.increments, (3, w.n_q)), floats(r.reactions, (3, w.n_l))
    kind, change, worst = integers(w.kind, w.n_all), floats(r.scratch, w.n_q), 0.0
    r.moved = 0.0
    for i in range(3):
        for d in range(w.n_q):
            change[d] = correction[i, d]
        untangle(w, turn, correction[i], change)
        for d in range(w.n_q):
            theta[i, d] -= change[d]
            x = abs(change[d]) / sizes[d]
            if not x <= HUGE:
                return np.inf
            worst = max(worst, x)
            r.moved = max(r.moved, x) if kind[d] < SIGNAL else r.moved
        for j in range(w.n_l):
            reactions[i, j] -= correction[i, w.n_q + j]
    return worst


@kernel
def place(w, r):
    """Compute the motions of the stages from their increments and reactions."""
    s0, D, kind = state_of(w, BEGIN), floats(r.D, (3, 3)), integers(w.kind, w.n_all)
    theta, reactions, n_q = floats(r.increments, (3, w.n_q)), floats(r.reactions, (3, w.n_l)), w.n_q
    z, v, a = floats(r.z, (3, w.n_all)), floats(r.v, (3, w.n_all)), floats(r.a, (3, w.n_all))
    for i in range(3):
        for d in range(n_q):
            z[i, d] = theta[i, d] if kind[d] == ROTATION else s0.z[d] + theta[i, d]
            v[i, d] = (D[i, 0] * theta[0, d] + D[i, 1] * theta[1, d] + D[i, 2] * theta[2, d]) / w.h
        for j in range(w.n_l):
            z[i, n_q + j] = reactions[i, j]
        turn(w, s0.R, theta[i], stage_of(w, r, i))
    for i in range(3):
        for d in range(n_q):
            x0, x1, x2 = v[0, d] - s0.v[d], v[1, d] - s0.v[d], v[2, d] - s0.v[d]
            a[i, d] = (D[i, 0] * x0 + D[i, 1] * x1 + D[i, 2] * x2) / w.h


@kernel
def turn(w, R0, theta, s_out):
    """Compute rotations and angular velocities of a stage from its increments and their rates in ``v``."""
    rotation_dof = integers(w.rotation_dof, w.n_rotations)
    for j in range(w.n_rotations):
        d = rotation_dof[j]
        if d < w.n_q:
            psi = vec(theta, d)
            put_matrix(s_out.R[j], mat(R0[j]) @ exp(psi))
            put(s_out.v, d, tangent(psi) @ vec(s_out.v, d))


@kernel
def residual(w, r, s, F_out):
    """Compute the residual (n,) at a state: equations of motion, and second rates of the constraints times -k."""
    system, g, n_q, n_l = system_of(w), floats(w.derivatives, (w.n_l, 3)), w.n_q, w.n_l
    assemble_residual(residual_loops(w), system, s, w.k, 0.0)
    equations = floats(w.residual, w.n_all)
    for d in range(n_q):
        F_out[d] = equations[d]
    if n_l:
        constraint_derivatives(constraint_loops(w), system, s, g)
        for j in range(n_l):
            F_out[n_q + j] = -w.k * g[j, SECOND]
    if w.n_entries:
        soften(w, w.k * (r.real / w.h) * (r.real / w.h), s.z[n_q : w.n], F_out[n_q:])


@kernel
def soften(w, factor, reactions, F_out):
    """Subtract the compliances times the change of the reactions since the beginning from the constraints (n_l,).

    The reactions at the beginning are those of least norm. Under all of the reactions the stages would leave the
    constraints, and the projection at the end of each step would take energy from a mechanism that turns.
    """
    starts, columns = integers(w.soft_starts, w.n_l + 1), integers(w.soft_columns, w.n_entries)
    c, kinds, first = floats(w.soft_values, w.n_entries), integers(w.soft_kinds, w.n_entries), state_of(w, BEGIN).z
    for i in range(w.n_l):
        for j in range(starts[i], starts[i + 1]):
            before = 0.0 if kinds[j] == OF_RELEASED else first[w.n_q + columns[j]]
            F_out[i] -= factor * c[j] * (reactions[columns[j]] - before)
