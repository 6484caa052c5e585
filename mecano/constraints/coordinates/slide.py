r"""Sliding of a node along an axis mu fixed in another: :math:`s = \mu \cdot d` with :math:`d = R_0^T (x_1 - x_0)`.

Its rate is :math:`\mu \cdot R_0^T (v_1 - v_0) + (\Omega_0 \times \mu) \cdot d`. Local unknowns: x0 at 0, R0 at 3,
x1 at 6.
"""

from mecano.constraints.coordinates.coordinate import Coordinate
from mecano.jit.kernel import kernel
from mecano.maths.vector import add_mat, cross, dot, mat, skew, vec


@kernel
def slide(at, mu):
    """Return s [m] and its rate [m/s]."""
    A, v = mat(at.R[0]), at.v
    d, e = A.T @ (vec(at.q, 6) - vec(at.q, 0)), A.T @ (vec(v, 6) - vec(v, 0))
    return dot(mu, d), dot(mu, e) + dot(cross(vec(v, 3), mu), d)


@kernel
def slide_gradient(at, mu):
    """Return the gradient of s by blocks of the local unknowns."""
    A = mat(at.R[0])
    normal = A @ mu
    return (0, -normal), (3, cross(mu, A.T @ (vec(at.q, 6) - vec(at.q, 0)))), (6, normal)


@kernel
def add_slide_curvature(K, g, at, mu):
    """Add g times the derivative of the gradient of s to K."""
    A, hat_mu = mat(at.R[0]), skew(mu)
    turn, arm = A @ hat_mu, hat_mu @ A.T
    add_mat(K, 6, 3, -g, turn)
    add_mat(K, 0, 3, g, turn)
    add_mat(K, 3, 6, g, arm)
    add_mat(K, 3, 0, -g, arm)
    add_mat(K, 3, 3, g, hat_mu @ skew(A.T @ (vec(at.q, 6) - vec(at.q, 0))))


@kernel
def _value(p, at):
    return dot(vec(p.mu, 0), mat(at.R[0]).T @ (vec(at.q, 6) - vec(at.q, 0)))


@kernel
def _gradient(p, at):
    return slide_gradient(at, vec(p.mu, 0))


@kernel
def _add_curvature(p, at, g, K):
    add_slide_curvature(K, g, at, vec(p.mu, 0))


SLIDE = Coordinate(("x0", "R0", "x1"), "m", {"mu": 3}, _value, _gradient, _add_curvature)
