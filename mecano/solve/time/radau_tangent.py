r"""Tangent of the stages of Radau IIA, frozen within a step: simplified Newton iteration.

A variation :math:`\varphi e^{st}` of the increments varies velocities by :math:`(s + W)\varphi` and accelerations by
:math:`s (s + W) \varphi`, W = hat(Omega)/2 of each rotation, and the equations of motion and second rates of the
constraints by

.. math:: \begin{bmatrix} K + C (s + W) + M s (s + W) & -k B^T \\ -k (G_2 s^2 + G_1 s + G_0)/s^2 & -k^2 c
          \end{bmatrix}

with :math:`G_2 = B`, :math:`G_1 = 2 (\dot B - B W)`, :math:`G_0 = \ddot B - 2 \dot B W` of constraints on positions.
s is an eigenvalue of the method over the step size: the stages decouple into one real and one complex system (Hairer
& Wanner 1996, IV.8).
"""

from typing import Any

import numpy as np

from mecano.jit.kernel import kernel
from mecano.jit.memory import call, floats, integers
from mecano.model.assembly_driver import assemble, tangent_loops
from mecano.model.system import System
from mecano.solve.linear.newton import NOT_FINITE, SINGULAR, STALE
from mecano.solve.time.increments import extrapolate
from mecano.solve.time.radau_stages import place
from mecano.solve.time.radau_workspace import stage_of
from mecano.solve.time.workspace import BEGIN, RENEWED, TANGENT, copy_to_state, state_of, system_of

DIFFERENCE = 0.02  # of a step, for the rates of the gradients of the constraints
MOTION, POSITION, RATE = range(3)  # equations of motion, constraints on positions, constraints on velocities
NEXT, LAST = (1, 2, 0), (2, 0, 1)  # components after and before each in the cycle of x, y, z
K, C, M, K_LATER, C_LATER, K_BEFORE, C_BEFORE = range(7)
N_PARTS = 7
MIDDLE = 1  # stage at which a tangent is renewed


@kernel
def renew(w, r):
    """Evaluate and factor the tangent in the middle of the step; return STALE, or NOT_FINITE or SINGULAR.

    That is half a step along the motion at the beginning, or, once increments are known, at the second stage.
    """
    if r.iterations:
        place(w, r)
        copy_to_state(w, stage_of(w, r, MIDDLE), TANGENT)
    else:
        extrapolate(w, BEGIN, 0.5 * w.h, TANGENT)
    s, turn, dt = state_of(w, TANGENT), floats(r.turn, w.n_all), DIFFERENCE * w.h
    for i in range(w.n_all):
        turn[i] = s.z[i]
    differentiate(w, r, dt)
    if not is_finite(floats(r.parts, N_PARTS * w.nnz)):
        return NOT_FINITE
    weigh(w, r, s.v, dt)
    soften(w, r)
    add_constraints(w, r)
    scale(w, r)
    w.factorizations += 1
    return STALE if factored(r) or (hold_idle(w, r) and factored(r)) else SINGULAR


@kernel
def is_finite(values):
    """Return whether all values are finite numbers."""
    total = 0.0
    for i in range(values.shape[0]):
        total += 0.0 * values[i]
    return total == 0.0


@kernel
def differentiate(w, r, dt):
    """Evaluate K, C, M at TANGENT, and K and C of the constraints dt later and before."""
    for part in range(3):
        cK, cC, cM = 1.0 if part == K else 0.0, 1.0 if part == C else 0.0, 1.0 if part == M else 0.0
        assemble_part(w, r, TANGENT, part, cK, cC, cM)
    for side in range(2 if w.n_l else 0):
        extrapolate(w, TANGENT, -dt if side else dt, RENEWED)
        assemble_part(w, r, RENEWED, K_BEFORE if side else K_LATER, 1.0, 0.0, 0.0)
        if r.has_rates:
            assemble_part(w, r, RENEWED, C_BEFORE if side else C_LATER, 0.0, 1.0, 0.0)


@kernel
def assemble_part(w, r, which, part, cK, cC, cM):
    """Assemble the tangent of these weights at one of the states."""
    system, T = system_of(w), floats(w.T, (3 * w.n_rotations, 3, 3))
    assemble(tangent_loops(w), system, state_of(w, which), T, w.k, 0.0, cK, cC, cM)
    data, out = floats(system[0].data, w.nnz), floats(r.parts + 8 * part * w.nnz, w.nnz)
    for i in range(w.nnz):
        out[i] = data[i]


@kernel
def spun(data, turned, i, omega):
    """Return entry i of the matrix of ``data`` times W = hat(omega)/2, with the tables of ``turned``."""
    if turned[i, 0] < 0:
        return 0.0
    return 0.5 * (data[turned[i, 0]] * omega[turned[i, 2]] - data[turned[i, 1]] * omega[turned[i, 3]])


@kernel
def weigh(w, r, omega, dt):
    """Write the values of the real and of the complex matrix from the parts."""
    kind, turned = integers(r.entry_kinds, w.nnz), integers(r.turned, (w.nnz, 4))
    parts, s = floats(r.parts, (N_PARTS, w.nnz)), r.real / w.h
    s2 = (r.complex_real + 1j * r.complex_imaginary) / w.h
    for i in range(w.nnz):
        if kind[i] == MOTION:
            c0 = parts[K, i] + spun(parts[C], turned, i, omega)
            c1 = parts[C, i] + spun(parts[M], turned, i, omega)
            c2 = parts[M, i]
            x, y = c0 + s * (c1 + s * c2), c0 + s2 * (c1 + s2 * c2)
        else:
            if kind[i] == POSITION:
                B, B1 = parts[K, i], (parts[K_LATER, i] - parts[K_BEFORE, i]) / (2.0 * dt)
                spin = spun(parts[K], turned, i, omega)
                later, before = spun(parts[K_LATER], turned, i, omega), spun(parts[K_BEFORE], turned, i, omega)
                c2, c1 = B, 2.0 * (B1 - spin)
                c0 = (parts[K_LATER, i] + parts[K_BEFORE, i] - 2.0 * B) / (dt * dt) - (later - before) / dt
            else:
                later, before = spun(parts[C_LATER], turned, i, omega), spun(parts[C_BEFORE], turned, i, omega)
                c2 = parts[C, i]
                c1 = (
                    spun(parts[C], turned, i, omega)
                    + (parts[C_LATER, i] - parts[C_BEFORE, i]) / (2.0 * dt)
                    + parts[K, i]
                )
                c0 = (later - before + parts[K_LATER, i] - parts[K_BEFORE, i]) / (2.0 * dt)
            x, y = c2 + (c1 + c0 / s) / s, c2 + (c1 + c0 / s2) / s2
        put_pair(r, i, x, y)


@kernel
def put_pair(r, place, x, y):
    """Write an entry of the real and of the complex matrix."""
    floats(r.real_values + 8 * place, 1)[0] = x
    out = floats(r.complex_values + 16 * place, 2)
    out[0], out[1] = y.real, y.imag


@kernel
def soften(w, r):
    """Add the compliances -k^2 c, which count as accelerations of the real system."""
    entries, places = integers(r.soft_entries, r.n_soft), integers(r.soft_places, r.n_soft)
    c, in_tangent = floats(w.soft_values, w.n_entries), floats(w.soft_in_tangent, w.n_entries)
    s = r.complex_real + 1j * r.complex_imaginary
    ratio = (r.real / s) * (r.real / s)
    for i in range(r.n_soft):
        value = -w.k * w.k * c[entries[i]] * in_tangent[entries[i]]
        floats(r.real_values + 8 * places[i], 1)[0] += value
        out = floats(r.complex_values + 16 * places[i], 2)
        out[0] += ratio.real * value
        out[1] += ratio.imag * value


@kernel
def gradient(w, r, entry):
    """Return the gradient of a constraint of which this is an entry of the tangent."""
    part = C if integers(r.entry_kinds, w.nnz)[entry] == RATE else K
    return -floats(r.parts + 8 * part * w.nnz, w.nnz)[entry] / w.k


@kernel
def add_constraints(w, r):
    """Subtract from the rows of unknowns without mass those of the constraints, times their gradients.

    These rows then have pivots even where only constraints hold a node, so that the order of elimination can be fixed,
    as with the penalty of generalized-alpha; the solution is the same.
    """
    subtract(w, r, integers(r.sums, (r.n_sums, 3)), floats(r.real_values, w.nnz), floats(r.complex_values, (w.nnz, 2)))


@kernel
def add_right_sides(w, r, real, other):
    """Do the same to the right-hand sides (n,) and (n, 2)."""
    subtract(w, r, integers(r.right_sums, (r.n_right_sums, 3)), real, other)


@kernel
def subtract(w, r, sums, real, other):
    """Subtract entries times gradients from others of both systems: ``sums`` are (entry, entry, gradient), (n, 3)."""
    for i in range(sums.shape[0]):
        to, source, B = sums[i, 0], sums[i, 1], gradient(w, r, sums[i, 2])
        real[to] -= B * real[source]
        other[to, 0] -= B * other[source, 0]
        other[to, 1] -= B * other[source, 1]


@kernel
def scale(w, r):
    """Set the factors of the rows of both systems: 1, and h^2 over that of the eigenvalue for constraints."""
    real, other = floats(r.real_scale, w.n), floats(r.complex_scale, (w.n, 2))
    s = (r.complex_real + 1j * r.complex_imaginary) / w.h
    t = 1.0 / (s * s)
    for i in range(w.n_q, w.n):
        real[i] = (w.h / r.real) * (w.h / r.real)
        other[i, 0], other[i, 1] = t.real, t.imag


@kernel
def factored(r):
    """Factor both matrices; return whether they are regular."""
    call(r.factor_real, r.factor_real_words, 0)
    if integers(r.real_outcome, 1)[0] != 0:
        return False
    call(r.factor_complex, r.factor_complex_words, 0)
    return integers(r.complex_outcome, 1)[0] == 0


@kernel
def hold_idle(w, r):
    """Keep the values of unknowns that nothing resists or moves, with rows and columns of zeros; return if any.

    An example is the rotation of a node without inertia on which no moment acts.
    """
    rows, columns, values = integers(w.rows, w.nnz), integers(w.columns, w.nnz), floats(r.real_values, w.nnz)
    touched, residual, found = floats(r.scratch, w.n), floats(w.residual, w.n), False
    touched[:] = 0.0
    for i in range(w.nnz):
        x = abs(values[i])
        touched[rows[i]] += x
        touched[columns[i]] += x
    diagonal = integers(w.diagonal, w.n)
    for i in range(w.n):
        if touched[i] == 0.0 and residual[i] == 0.0:
            put_pair(r, diagonal[i], 1.0, 1.0 + 0.0j)
            found = True
    return found


@kernel
def solve(w, r):
    """Solve for the corrections (3, n) of increments and multipliers of the stages, from their residuals F (3, n)."""
    F, real, other = floats(r.F, (3, w.n)), floats(r.real_right, w.n), floats(r.complex_right, (w.n, 2))
    to_real, to_both = floats(r.to_real, 3), floats(r.to_both, (3, 2))
    scale, scale2 = floats(r.real_scale, w.n), floats(r.complex_scale, (w.n, 2))
    for j in range(w.n):
        f0, f1, f2 = F[0, j], F[1, j], F[2, j]
        real[j] = scale[j] * (to_real[0] * f0 + to_real[1] * f1 + to_real[2] * f2)
        x = to_both[0, 0] * f0 + to_both[1, 0] * f1 + to_both[2, 0] * f2
        y = to_both[0, 1] * f0 + to_both[1, 1] * f1 + to_both[2, 1] * f2
        p, q = scale2[j, 0], scale2[j, 1]
        other[j, 0], other[j, 1] = p * x - q * y, p * y + q * x
    add_right_sides(w, r, real, other)
    call(r.solve_real, r.solve_real_words, 0)
    call(r.solve_complex, r.solve_complex_words, 0)
    out, from_both = floats(r.correction, (3, w.n)), floats(r.from_both, (3, 3))
    for i in range(3):
        for j in range(w.n):
            x = from_both[i, 0] * real[j] + from_both[i, 1] * other[j, 0] + from_both[i, 2] * other[j, 1]
            out[i, j] = w.k * x if j >= w.n_q else x


@kernel
def solve_real(w, r, f):
    """Return the solution (n,) for the residual f (n,) of the real system; multipliers over k."""
    b, scale = floats(r.real_right, w.n), floats(r.real_scale, w.n)
    for i in range(w.n):
        b[i] = scale[i] * f[i]
    add_right_sides(w, r, b, floats(r.complex_right, (w.n, 2)))
    call(r.solve_real, r.solve_real_words, 0)
    return b


def tables_of(system: System) -> dict[str, Any]:
    """Return the tables of entries that the tangent needs: fields of RADAU."""
    kind = np.full(system.n, MOTION)
    kind[system.n_q :] = np.where(system.numbering.of_rates, RATE, POSITION)
    sums, right_sums = _sums(system)
    return {
        "entry_kinds": kind[system.rows], "turned": _turned(system), "sums": sums, "n_sums": len(sums),
        "right_sums": right_sums, "n_right_sums": len(right_sums),
    }  # fmt: skip


def _sums(system):
    """Return the tables for adding rows of constraints to rows of unknowns without mass (``add_constraints``).

    (n, 3) entry changed, entry of the constraint in the same column, entry of its gradient by the unknown; and (m, 3)
    row of the unknown, row of the constraint, the same entry.
    """
    n, n_q = system.n, system.n_q
    mass = system.assemble(system.initial_state(), cM=1.0).data[system.diagonal[:n_q]]
    without = np.append((mass == 0.0) & ~system.signals, np.zeros(system.n_l, bool))
    gradients = np.flatnonzero((system.rows >= n_q) & without[system.cols])
    starts, code = np.searchsorted(system.rows, np.arange(n + 1)), system.rows * n + system.cols
    constraint = system.rows[gradients]
    number = (starts[1:] - starts[:-1])[constraint]
    pair = np.repeat(np.arange(len(gradients)), number)
    sources = starts[constraint][pair] + np.arange(len(pair)) - np.repeat(np.cumsum(number) - number, number)
    wanted = system.cols[gradients][pair] * n + system.cols[sources]
    places = np.minimum(np.searchsorted(code, wanted), len(code) - 1)
    found = code[places] == wanted
    sums = np.stack([places[found], sources[found], gradients[pair][found]], axis=1)
    return sums, np.stack([system.cols[gradients], constraint, gradients], axis=1)


def _turned(system: System) -> np.ndarray:
    """Return (nnz, 4): in the row of an entry of a rotation, the entries of its two other columns; their unknowns.

    The first is -1 for an entry of another column.
    """
    of, first = system.numbering, np.full(system.n, -1)
    for d in of.rotation_dof[of.rotation_dof < of.n_q]:
        first[d : d + 3] = d
    start = first[system.cols]
    component = np.where(start >= 0, system.cols - start, 0)
    code = system.rows * system.n + system.cols
    later, before = start + np.take(NEXT, component), start + np.take(LAST, component)
    places = [np.searchsorted(code, system.rows * system.n + of_other) for of_other in (later, before)]
    found = np.stack([*places, before, later], axis=1)
    found[start < 0] = -1
    return found
