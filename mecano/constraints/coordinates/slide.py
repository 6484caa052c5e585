r"""Sliding of a node along an axis mu fixed in another: :math:`s = \mu \cdot d` with :math:`d = R_0^T (x_1 - x_0)`.

Its rate is :math:`\mu \cdot R_0^T (v_1 - v_0) + (\Omega_0 \times \mu) \cdot d`. Local unknowns: x0 at 0, R0 at 3,
x1 at 6.
"""

from mecano.constraints.body_fixed import carried, product_rates
from mecano.constraints.coordinates.coordinate import Coordinate
from mecano.jit.kernel import kernel
from mecano.maths.vector import add_mat, cross, dot, mat, skew, vec


@kernel
def slide(q, v, A, mu):
    """Return s [m] and its rate [m/s]."""
    d, e = A.T @ (vec(q, 6) - vec(q, 0)), A.T @ (vec(v, 6) - vec(v, 0))
    return dot(mu, d), dot(mu, e) + dot(cross(vec(v, 3), mu), d)


@kernel
def slide_rates(q, v, a, R_0, mu):
    """Return s [m] and its first two rates, from velocities and accelerations; R_0: rotation of the first node."""
    d, d_rate, d_second = vec(q, 6) - vec(q, 0), vec(v, 6) - vec(v, 0), vec(a, 6) - vec(a, 0)
    return product_rates(carried(R_0, vec(v, 3), vec(a, 3), mu), (d, d_rate, d_second))


@kernel
def slide_gradient(q, A, mu):
    """Return the gradients of s (and of its rate by the velocities) at the local indices 0, 3, 6."""
    normal = A @ mu
    return -normal, cross(mu, A.T @ (vec(q, 6) - vec(q, 0))), normal


@kernel
def add_slide_curvature(K, g, q, A, mu):
    """Add g times the derivative of the gradients of s to K."""
    hat_mu = skew(mu)
    turn, arm = A @ hat_mu, hat_mu @ A.T
    add_mat(K, 6, 3, -g, turn)
    add_mat(K, 0, 3, g, turn)
    add_mat(K, 3, 6, g, arm)
    add_mat(K, 3, 0, -g, arm)
    add_mat(K, 3, 3, g, hat_mu @ skew(A.T @ (vec(q, 6) - vec(q, 0))))


@kernel
def _value(p, at):
    return dot(vec(p.mu, 0), mat(at.R[0]).T @ (vec(at.q, 6) - vec(at.q, 0)))


@kernel
def _gradient(p, at):
    b_0, b_R, b_1 = slide_gradient(at.q, mat(at.R[0]), vec(p.mu, 0))
    return (0, b_0), (3, b_R), (6, b_1)


@kernel
def _add_curvature(p, at, g, K):
    add_slide_curvature(K, g, at.q, mat(at.R[0]), vec(p.mu, 0))


@kernel
def _rates(p, at):
    _, rate, second = slide_rates(at.q, at.v, at.a, mat(at.R[0]), vec(p.mu, 0))
    return rate, second


SLIDE = Coordinate(
    ("x0", "R0", "x1"), "m", {"mu": 3}, lambda rng: {"mu": rng.normal(size=3)},
    _value, _gradient, _add_curvature, _rates,
)  # fmt: skip
