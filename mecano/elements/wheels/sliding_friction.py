r"""Regularized isotropic friction opposing the slip velocity.

With N the normal force and v_C the slip velocity, smooth at rest ((33)-(35) of Cardona, Geradin and Doan 1991; Oden and
Martins 1985):

    F_fr = mu(|v_0|) sigma(u) phi(|v_C|) N v_C/|v_C|,   phi(v) = (v/eps)(2 - v/eps) for v < eps, else 1

opposes the slip; v_0 is v_C without the rates of a patch (docs/tyre-equations.md). sigma is a factor that depends on
the speed u of the axle over the ground, 1 by default: the paper's mu_0 exp(-kappa u) is friction mu_0 with
``friction_by_speed: {exponential: {start: 1, rate: kappa}}``.
"""

from mecano.element_interface import recorded_values
from mecano.elements.wheels.slip_law import SlipForces, SlipLaw
from mecano.jit.kernel import kernel
from mecano.laws.friction import sticking
from mecano.laws.law_table import curve
from mecano.laws.probe import negative_curves
from mecano.maths.dual import at_least
from mecano.maths.vector import ZERO, dot, norm
from mecano.schema import CURVE, NUMBER, Field, positive

FIELDS = (
    Field("friction", CURVE, "-", "coefficient of friction, a curve of the slip speed [m/s]", None, argument="m/s"),
    Field("friction_by_speed", CURVE, "-", "factor on the friction, a curve of the speed of the axle [m/s]", 1.0,
          argument="m/s"),
    Field(
        "slip_regularization", NUMBER, "m/s", "slip speed eps below which friction falls to zero; with 'friction'",
        None, positive,
    ),
)  # fmt: skip
RECORD = {"friction": "i", "friction_by_speed": "i", "slip_regularization": ()}


def prepare(law, context):
    """Return the values of RECORD."""
    return recorded_values(RECORD, FIELDS, law, context)


def check(law):
    """Return errors for negative friction and for a missing regularization."""
    if law["slip_regularization"] is None:
        return ["'tire_law.slip_regularization' is missing: the slip speed below which friction falls to zero"]
    return negative_curves("tire_law", {"friction": law["friction"]})


@kernel
def forces(p, laws, k):
    """Return the SlipForces of the Slip ``k``."""
    speed = norm(k.v)
    mu = at_least(curve(laws, p.friction, norm(k.v_0)), 0.0)
    mu = mu * at_least(curve(laws, p.friction_by_speed, norm(k.u)), 0.0)
    b = k.N * (k.grip * mu * sticking(p.slip_regularization, speed))
    return SlipForces(-b * k.v, ZERO, b * dot(k.v, k.v), 0.0)


SLIDING_FRICTION = SlipLaw("friction", __doc__, CURVE, forces, RECORD, prepare, check)
