r"""Geared slide: couples the sliding of the second node along an axis of the first to its rotation, as in a screw.

With :math:`\sigma` fixed in the first node, the angle :math:`\theta` of the second about :math:`\mu_3` (twist.py)
and the travel h in metres per radian:

.. math::  \Phi = \sigma \cdot (x_1 - x_0) - c - h\,\theta = 0

The difference between :math:`\theta` and the angle that corresponds to the sliding is reduced to :math:`(-\pi, \pi]`,
so that any number of turns needs no memory. The multiplier is the force on the second node along :math:`\sigma`; it is
accompanied by the moment :math:`-h` times that force about :math:`\mu_3`. The tangent consists of gradients and
curvatures of the coordinates, which other joints need as well; with dual numbers compiling took half as long again (5.2
instead of 3.4 s of processor time), for five lines less.
"""

from mecano.constraints.augmented_lagrangian import add_constraint, put_derivatives
from mecano.constraints.body_fixed import add_blocks, relative_rotation, wrap
from mecano.constraints.coordinates.slide import add_slide_curvature, slide_gradient, slide_rates
from mecano.constraints.coordinates.twist import turning_rates, twist, twist_curvature, twist_gradient
from mecano.constraints.joint_frame import triad
from mecano.element_interface import Kind, Row, record
from mecano.jit.kernel import kernel
from mecano.maths.vector import dot, mat, vec

RECORD = record(mu=(3, 3), xi=(3, 3), sigma=3, offset=(), travel=())
MULTIPLIER = 12


@kernel
def force(p, at, f, K, C, M):
    """Add forces and moments to both nodes."""
    A, sigma, mu, xi, h = mat(at.R[0]), vec(p.sigma, 0), mat(p.mu), mat(p.xi), p.travel
    Q = relative_rotation(A, mat(at.R[1]))
    s = dot(sigma, A.T @ (vec(at.q, 6) - vec(at.q, 0))) - p.offset
    Phi = -h * wrap(twist(Q, mu, xi) - s / h)
    b_0, b_R, b_1 = slide_gradient(at.q, A, sigma)
    turn_0, turn_1 = twist_gradient(Q, mu[2], xi[2])
    blocks = ((0, b_0), (3, b_R - h * turn_0), (6, b_1), (9, -h * turn_1))
    g = add_constraint(f, K, MULTIPLIER, at.k, at.penalty, Phi, at.q[MULTIPLIER], blocks)
    add_slide_curvature(K, g, at.q, A, sigma)
    add_blocks(K, 3, 9, -h * g, twist_curvature(Q, mu[2], xi[2]))


@kernel
def constraint_derivatives(p, at, g):
    """Write value and rates."""
    first, second = (mat(at.R[0]), vec(at.v, 3), vec(at.a, 3)), (mat(at.R[1]), vec(at.v, 9), vec(at.a, 9))
    angle = twist(relative_rotation(first[0], second[0]), mat(p.mu), mat(p.xi))
    rate, second_rate = turning_rates(vec(p.mu[2], 0), vec(p.xi[2], 0), first, second)
    s, s_rate, s_second = slide_rates(at.q, at.v, at.a, first[0], vec(p.sigma, 0))
    Phi = -p.travel * wrap(angle - (s - p.offset) / p.travel)
    put_derivatives(g, 0, Phi, s_rate - p.travel * rate, s_second - p.travel * second_rate)


def sample(rng):
    """Return a screw of either hand, and a rack."""
    mu, xi = triad(rng.normal(size=3)), triad(rng.normal(size=3))
    d = {"mu": mu, "xi": xi, "offset": rng.normal()}
    return [({**d, "sigma": mu[2], "travel": -0.7}, 2, ""), ({**d, "sigma": mu[0], "travel": 0.9}, 2, "")]


GEARED_SLIDE = Kind(
    name="geared_slide",
    section="",
    doc=__doc__,
    dtype=RECORD,
    layout=("x0", "R0", "x1", "R1"),
    multipliers=(Row("force of the thread or teeth", "N", "m"),),
    force=force,
    constraint_derivatives=constraint_derivatives,
    sample=sample,
)
