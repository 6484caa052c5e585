"""A law along a coordinate between two nodes (sliding, twist, tilt, angle of a pin): force, energies, record.

The coordinate c has gradients b_i by local unknowns of the element and a rate, whose gradients are r_i; the law gives
P(c - natural, dc/dt), which adds P b_i to the forces: P > 0 drives the coordinate back.
"""

from numba import njit

from mecano.constraints.stop_modes import law_record
from mecano.contract import Output
from mecano.laws.table import evaluate_force, potential
from mecano.maths.vec import add, add_mat, add_vec, outer, scale, tmul

LAW_RECORD = {"law": "i", "natural": (), "low": (), "high": ()}


@njit
def add_along(f, K, C, P, P_c, P_rate, blocks):
    """Add the force P [N, N m] along a coordinate, with its derivatives by coordinate and rate.

    ``blocks`` is a tuple of (local index, b (3,), r (3,)). The derivative of b itself is left to the caller.
    """
    for i, b, _ in blocks:
        add_vec(f, i, P, b)
        for j, c, r in blocks:
            add_mat(K, i, j, 1.0, outer(b, add(scale(P_c, c), scale(P_rate, r))))
            add_mat(C, i, j, P_rate, outer(b, c))


@njit
def turning_blocks(i, j, gradient, H, omega_0, omega_1):
    """Blocks for ``add_along`` of a coordinate of two rotations at i, j, given its gradients and their derivatives."""
    r_0 = add(tmul(H[0][0], omega_0), tmul(H[1][0], omega_1))
    r_1 = add(tmul(H[0][1], omega_0), tmul(H[1][1], omega_1))
    return (i, gradient[0], r_0), (j, gradient[1], r_1)


@njit
def report(p, laws, coordinate, rate, y, e):
    """Write the force of the law to y[0], potential energy and dissipated power to e."""
    P, _, _ = evaluate_force(laws, p.law, coordinate - p.natural, rate)
    elastic, _, _ = evaluate_force(laws, p.law, coordinate - p.natural, 0.0)
    y[0] = P
    e[1] = potential(laws, p.law, coordinate - p.natural)
    e[2] = (P - elastic) * rate


def axis_law_record(law, natural, context):
    """Values of ``LAW_RECORD``."""
    return {"natural": natural, **law_record(law, context)}


def law_output(name, unit):
    """The output of a law along an axis."""
    what = "force" if unit == "N" else "moment"
    return Output(name, unit, f"{what} of the law; > 0 drives the coordinate back")
