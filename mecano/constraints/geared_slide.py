r"""Geared slide: couples the sliding of the second node along an axis of the first to its rotation, as in a screw.

With :math:`\sigma` fixed in the first node, the angle :math:`\theta` of the second about :math:`\mu_3` (twist.py)
and the travel h in metres per radian:

.. math::  \Phi = \sigma \cdot (x_1 - x_0) - c - h\,\theta = 0

The difference between :math:`\theta` and the angle that corresponds to the sliding is reduced to :math:`(-\pi, \pi]`,
so that any number of turns needs no memory. The multiplier is the force on the second node along :math:`\sigma`; it is
accompanied by the moment :math:`-h` times that force about :math:`\mu_3`.
"""

from mecano.constraints.augmented_lagrangian import scalar_constraint
from mecano.constraints.body_fixed import relative_rotation, wrap
from mecano.constraints.coordinates.slide import slide, slide_gradient
from mecano.constraints.coordinates.twist import twist, twist_gradient
from mecano.element_interface import Kind, Row, record
from mecano.jit.kernel import kernel
from mecano.maths.vector import mat, vec

RECORD = record(mu=(3, 3), xi=(3, 3), sigma=3, offset=(), travel=())
MULTIPLIER = 12


@kernel
def _coupling(p, at):
    """Return the constraint [m] and its gradient."""
    sigma, mu, xi, h = vec(p.sigma, 0), mat(p.mu), mat(p.xi), p.travel
    Q, s = relative_rotation(at), slide(at, sigma)[0] - p.offset
    back, (_, b_R), along = slide_gradient(at, sigma)
    turn_0, turn_1 = twist_gradient(Q, mu[2], xi[2])
    return -h * wrap(twist(Q, mu, xi) - s / h), (back, (3, b_R - h * turn_0), along, (9, -h * turn_1))


@kernel
def slide_travel(p, at):
    """Return the constraint [m] with its gradient, and the mean travel of sliding and rolling [m] with its gradient."""
    sigma = vec(p.sigma, 0)
    (Phi, gradient), along = _coupling(p, at), slide(at, sigma)[0] - p.offset
    (_, b_0), (_, b_R), (_, b_1) = slide_gradient(at, sigma)
    turn_0, turn_1 = 0.5 * (b_R - gradient[1][1]), -0.5 * gradient[3][1]
    mean = ((0, 0.5 * b_0), (3, 0.5 * b_R + turn_0), (6, 0.5 * b_1), (9, turn_1))
    return (Phi, gradient), (along - 0.5 * Phi, mean)


GEARED_SLIDE = Kind(
    name="geared_slide", doc=__doc__, dtype=RECORD, layout=("x0", "R0", "x1", "R1"),
    multipliers=(Row("force of the thread or teeth", "N", "m"),),
    cases=({}, {"travel": -0.7}),
    **scalar_constraint(_coupling, MULTIPLIER),
)  # fmt: skip
