r"""Twist law: a moment from a law of the angle between two nodes about an axis that both carry, and of its rate.

Node a carries the unit axes :math:`\mu_i`, node b the axes :math:`\xi_i`, equal to them at the start. With Q the
rotation of the second triad in the first, the angle is the twist of Q,

.. math::  \theta = \mathrm{atan2}(Q_{21} - Q_{12},\; Q_{11} + Q_{22}),

the rotation about :math:`\mu_3` where :math:`\xi_3 = \mu_3`, smooth and symmetric in both nodes off that alignment,
up to :math:`\xi_3 = -\mu_3`. It is followed over whole turns by the memory of the last accepted angle. Its gradient
(inertial) is :math:`g = (\mu_3 + \xi_3)/(1 + \mu_3 \cdot \xi_3)`:

.. math::  \dot\theta = g \cdot (\omega_b - \omega_a), \qquad f_a = -M R_a^T g, \qquad f_b = M R_b^T g,
   \qquad M = M(\theta - \theta_0, \dot\theta)

M > 0 turns the nodes back against a positive angle. Even where the axes are aligned the derivative of g does not
vanish.
"""

from mecano.compiled.kernel import kernel
from mecano.constraints.axis_law import LAW_RECORD, axis_law_record, law_kind
from mecano.constraints.carried import follow, relative_rotation, turned, twist, twist_gradient
from mecano.contract import Part, record
from mecano.maths.vector import mat, vec
from mecano.schema import LAW, NUMBER, Field

RECORD = record(mu=(3, 3), xi=(3, 3), **LAW_RECORD)


@kernel
def _angle(p, at):
    A = relative_rotation(mat(at.R[0]), mat(at.R[1]))
    return follow(at.m[0], twist(A, mat(p.mu), mat(p.xi)))


@kernel
def _gradient(p, at):
    A = relative_rotation(mat(at.R[0]), mat(at.R[1]))
    b_0, b_1 = twist_gradient(A, vec(p.mu[2], 0), vec(p.xi[2], 0))
    return (0, b_0), (3, b_1)


@kernel
def followed(p, m, q, v, R):
    """Angle [rad], by whole turns nearest to the memory, and its rate [rad/s]."""
    angle, rate = turned(mat(R[0]), vec(v, 0), mat(p.mu), mat(R[1]), vec(v, 3), mat(p.xi))
    return follow(m[0], angle), rate


def twist_law_record(mu, xi, law, natural, context):
    """Record: axes (3, 3), rows, in the axes of each node."""
    return {"mu": mu, "xi": xi, **axis_law_record(law, natural, context)}


TURNING_FIELDS = (
    Field("turning_law", LAW, "-", "moment [N m] from angle [rad] and rate [rad/s]; > 0 turns b back", None),
    Field("natural_angle", NUMBER, "rad", "angle at which the extension of the turning law is zero", 0.0),
)


def turning_parts(d, place, context):
    """[Part] of the fields ``TURNING_FIELDS`` of a joint at ``place`` (pair.py)."""
    if d["turning_law"] is None:
        return []
    values = twist_law_record(place["mu"], place["xi"], d["turning_law"], d["natural_angle"], context)
    return [Part(TWIST_LAW, (0, 1), values)]


TWIST_LAW = law_kind("twist_law", __doc__, RECORD, ("R0", "R1"), _angle, _gradient, ("angle",))
