r"""Contribution of a scalar constraint to residual and tangent: augmented Lagrangian, bordered.

With :math:`g = p\,\Phi - k\lambda` and B the gradient of Phi by blocks of three unknowns (theory.md section 1,
equations (12)-(14) of Cardona, Geradin & Doan 1991):

.. math::  f = B^T g, \quad f_\lambda = -k \Phi, \quad K = p B^T B + g\, \partial B^T/\partial q, \quad
           K_{q\lambda} = -k B^T, \quad K_{\lambda q} = -k B
"""

from mecano.constraints.coordinates.coordinate import add_along
from mecano.jit.kernel import kernel
from mecano.maths.vector import add_col, add_mat, add_row, add_vec, outer


@kernel
def add_constraint(f, K, row, k, penalty, Phi, multiplier, blocks):
    """Add one constraint without its curvature; return g = penalty Phi - k lambda [N, N m].

    ``blocks`` is a tuple of (local index, gradient (3,)), ``row`` the local index of the multiplier, whose value
    ``multiplier`` is k lambda.
    """
    g = penalty * Phi - multiplier
    f[row] -= k * Phi
    for i, b in blocks:
        add_vec(f, i, g, b)
        add_col(K, i, row, -k, b)
        add_row(K, row, i, -k, b)
        for j, c in blocks:
            add_mat(K, i, j, penalty, outer(b, c))
    return g


@kernel
def add_reaction(f, row, k, penalty, Phi, multiplier, blocks):
    """Add one constraint to a residual whose tangent is computed with dual numbers; see ``add_constraint``."""
    g = penalty * Phi - multiplier
    f[row] -= k * Phi
    add_along(f, g, blocks)
    return g


@kernel
def deactivate(f, K, row, k, multiplier):
    """Deactivate a constraint in the current phase: its reaction is zero. Its derivatives are not written."""
    f[row] -= multiplier
    K[row, row] -= k
