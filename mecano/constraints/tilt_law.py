r"""Tilt law: a moment from a law of :math:`c = \mu \cdot \xi`, for mu carried by the first node and xi by the second.

For unit vectors that are perpendicular at the start, c is the sine of the angle by which they lean to each other: what
the constraint ``orthogonal`` holds at zero. The moment on the second node is :math:`-P` about :math:`\xi \times \mu`.
"""

from mecano.compiled.kernel import kernel
from mecano.constraints.axis_law import LAW_RECORD, axis_law_record, law_kind
from mecano.constraints.carried import product_gradient, relative_rotation, turning_rate
from mecano.contract import record
from mecano.maths.vector import dot, mat, vec

RECORD = record(mu=3, xi=3, **LAW_RECORD)


@kernel
def tilted(mu, xi, A, omega_0, omega_1):
    """c and its rate [1/s]; A = R_0^T R_1, material angular velocities."""
    return dot(mu, A @ xi), turning_rate(product_gradient(A, mu, xi), omega_0, omega_1)


@kernel
def _tilt(p, at):
    return dot(mat(at.R[0]) @ vec(p.mu, 0), mat(at.R[1]) @ vec(p.xi, 0))


@kernel
def _gradient(p, at):
    b_0, b_1 = product_gradient(relative_rotation(mat(at.R[0]), mat(at.R[1])), vec(p.mu, 0), vec(p.xi, 0))
    return (0, b_0), (3, b_1)


def tilt_law_record(mu, xi, law, context):
    """Record: unit vectors (3,) in the axes of the nodes."""
    return {"mu": mu, "xi": xi, **axis_law_record(law, 0.0, context)}


TILT_LAW = law_kind("tilt_law", __doc__, RECORD, ("R0", "R1"), _tilt, _gradient)
