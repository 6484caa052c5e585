r"""Contribution of a scalar constraint to residual and tangent: augmented Lagrangian, bordered.

With :math:`g = p\,\Phi - k\lambda` and B the gradient of Phi by blocks of three unknowns (theory.md section 1,
equations (12)-(14) of Cardona, Geradin & Doan 1991):

.. math::  f = B^T g, \quad f_\lambda = -k \Phi, \quad K = p B^T B + g\, \partial B^T/\partial q, \quad
           K_{q\lambda} = -k B^T, \quad K_{\lambda q} = -k B
"""

from mecano.constraints.coordinates.coordinate import add_along, rate_of
from mecano.element_interface import Place, named
from mecano.jit.kernel import kernel
from mecano.maths.dual import number
from mecano.maths.vector import add_col, add_mat, add_row, outer


@kernel
def times_penalty(at, factor):
    """Return the Place with the penalty times a factor: the loops see to it where all constraints are on angles."""
    return Place(at.t, at.phase, at.k, at.penalty * factor, at.laws, at.m, at.q, at.v, at.a, at.R)


@kernel
def add_reaction(f, at, row, Phi, blocks, side=1.0):
    """Add the constraint side Phi = 0 to a residual; return penalty Phi - side k lambda, the load along Phi [N, N m].

    ``row`` is the local index of the multiplier, ``blocks`` a tuple of (local index, gradient (3,) of Phi).
    """
    g = at.penalty * Phi - side * number(at.q[row])
    f[row] -= side * at.k * Phi
    add_along(f, g, blocks)
    return g


@kernel
def add_constraint(f, K, at, row, Phi, blocks, side=1.0):
    """Add the same to residual and tangent, without the curvature of the constraint."""
    g, k = add_reaction(f, at, row, Phi, blocks, side), side * at.k
    for i, b in blocks:
        add_col(K, i, row, -k, b)
        add_row(K, row, i, -k, b)
        for j, c in blocks:
            add_mat(K, i, j, at.penalty, outer(b, c))
    return g


@kernel
def _always(p, at):
    return 1.0


def in_phase(phase):
    """Return the side of ``scalar_constraint`` of a constraint that is active in this phase."""

    @kernel
    def side_of(p, at):
        return 1.0 if at.phase == phase else 0.0

    return side_of


def scalar_constraint(value, row, side_of=_always):
    """Return ``residual`` and ``constraints`` of side Phi = 0, whose multiplier has the local index ``row``.

    ``value(p, at)`` returns Phi and its gradient by blocks, ``side_of(p, at)`` the side: 1, -1, or 0 while the
    constraint is inactive.
    """

    @kernel
    def residual(p, at, f):
        side = side_of(p, at)
        if side == 0.0:
            f[row] -= at.q[row]
        else:
            Phi, gradient = value(p, at)
            add_reaction(f, at, row, Phi, gradient, side)

    @kernel
    def constraints(p, at, g):
        side = side_of(p, at)
        if side != 0.0:
            Phi, gradient = value(p, at)
            g[0, 0], g[0, 1] = side * Phi, side * rate_of(gradient, at.v)

    return named(residual, constraints)


def held_from_event(value, row, side_of, kept=0):
    """Return ``residual``, ``constraints`` and ``commit`` of a constraint that becomes active at an event.

    It holds a quantity at that of the last step before the event, the memory of the index ``kept``. ``value(p, at)``
    returns the quantity and its gradient by blocks; the other arguments are those of ``scalar_constraint``.
    """

    @kernel
    def change(p, at):
        c, gradient = value(p, at)
        return c - at.m[kept], gradient

    @kernel
    def commit(p, at, m_out):
        m_out[kept] = value(p, at)[0] if side_of(p, at) == 0.0 else at.m[kept]

    return {**scalar_constraint(change, row, side_of), **named(commit)}
