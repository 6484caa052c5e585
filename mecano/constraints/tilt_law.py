r"""Tilt law: a moment from a law of :math:`c = \mu \cdot \xi`, for mu carried by the first node and xi by the second.

For unit vectors that are perpendicular at the start, c is the sine of the angle by which they lean to each other: what
the constraint ``orthogonal`` holds at zero. The moment on the second node is :math:`-P` about :math:`\xi \times \mu`.
"""

from mecano.compiled.kernel import kernel
from mecano.constraints.axis_law import LAW_RECORD, add_turning, axis_law_record, law_kind
from mecano.constraints.carried import product_curvature, product_gradient, relative_rotation, turning_rate
from mecano.contract import record
from mecano.laws.table import evaluate_force
from mecano.maths.vector import dot, mat, vec

RECORD = record(mu=3, xi=3, **LAW_RECORD)


@kernel
def force(p, at, f, K, C, M):
    """Opposite moments on both nodes."""
    mu, xi = vec(p.mu, 0), vec(p.xi, 0)
    A = relative_rotation(mat(at.R[0]), mat(at.R[1]))
    gradient, H = product_gradient(A, mu, xi), product_curvature(A, mu, xi)
    omega_0, omega_1 = vec(at.v, 0), vec(at.v, 3)
    tilt, rate = tilted(mu, xi, A, omega_0, omega_1)
    P, P_tilt, P_rate = evaluate_force(at.laws, p.law, tilt - p.natural, rate)
    add_turning(f, K, C, P, P_tilt, P_rate, gradient, H, omega_0, omega_1)


@kernel
def tilted(mu, xi, A, omega_0, omega_1):
    """c and its rate [1/s]; A = R_0^T R_1, material angular velocities."""
    return dot(mu, A @ xi), turning_rate(product_gradient(A, mu, xi), omega_0, omega_1)


@kernel
def _tilted(p, m, q, v, R):
    A = relative_rotation(mat(R[0]), mat(R[1]))
    return tilted(vec(p.mu, 0), vec(p.xi, 0), A, vec(v, 0), vec(v, 3))


def tilt_law_record(mu, xi, law, context):
    """Record: unit vectors (3,) in the axes of the nodes."""
    return {"mu": mu, "xi": xi, **axis_law_record(law, 0.0, context)}


TILT_LAW = law_kind("tilt_law", __doc__, RECORD, ("R0", "R1"), force, _tilted)
