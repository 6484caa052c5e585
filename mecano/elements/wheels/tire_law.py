r"""Tyre laws: the radial force and the friction in the contact, for every kind of wheel that deforms.

Radial force in the plane of the wheel, of the deformation w = radius - r and its rate ((32) of Cardona,
Geradin and Doan 1991; damping after Hunt and Crossley 1975, which never pulls):

    F_r = F(w) max(0, 1 + c dw/dt)

F is continued by its tangent to w < 0, so that a step which ends at the lift-off meets no corner.
Friction against the slip velocity v_C, with N the normal force, smooth at rest ((33)-(35); Oden and
Martins 1985):

    F_fr = mu(|v_C|) sigma(u) phi(|v_C|) N v_C/|v_C|,   phi(v) = (v/eps)(2 - v/eps) for v < eps, else 1

sigma is a factor, 1 unless given, of the speed u = |(I - n n^T) v| of the axle over the ground: the paper's mu_0
exp(-kappa u) is friction mu_0 and ``friction_by_speed: {exponential: {start: 1, rate: kappa}}``.
"""

import numpy as np

from mecano.compiled.kernel import kernel
from mecano.elements.wheels.lateral_law import LATERAL_TYPE
from mecano.laws.friction import sticking
from mecano.laws.probe import curve_at
from mecano.laws.table import curve, curve_and_slope, potential
from mecano.maths.dual import at_least, at_most
from mecano.maths.vector import dot, norm
from mecano.schema import CURVE, NUMBER, Field, not_negative, positive

TIRE_LAW_FIELDS = (
    Field("radius", NUMBER, "m", "undeformed radius", check=positive),
    Field("radial", CURVE, "N", "radial force, a curve of the radial deformation [m]; zero at zero"),
    Field(
        "radial_damping", NUMBER, "s/m", "c in the factor max(0, 1 + c dw/dt) on the radial force", 0.0,
        not_negative,
    ),
    Field("friction", CURVE, "-", "coefficient of friction, a curve of the slip speed; never below zero"),
    Field(
        "friction_by_speed", CURVE, "-", "factor on the friction, a curve of the speed of the axle [m/s]", 1.0,
    ),
    Field(
        "slip_regularization", NUMBER, "m/s", "slip speed eps below which friction falls to zero",
        check=positive,
    ),
    Field(
        "valid_deformation", NUMBER, "m", "deformation up to which the law holds; a warning beyond",
        None, positive,
    ),
    Field("lateral", LATERAL_TYPE, "-", "how the patch gives way sideways: flexible wheels", None),
)  # fmt: skip

PROBES = 201  # deformations at which the radial force is looked at
TIRE_RECORD = {
    "radius": (), "radial": "i", "radial_damping": (), "friction": "i", "friction_by_speed": "i",
    "slip_regularization": (),
}  # fmt: skip


def prepare_tire_law(law, context):
    """Values of TIRE_RECORD."""
    return {
        "radius": law["radius"],
        "radial": int(context.laws.add(law["radial"])),
        "radial_damping": law["radial_damping"],
        "friction": int(context.laws.add(law["friction"])),
        "friction_by_speed": int(context.laws.add(law["friction_by_speed"])),
        "slip_regularization": law["slip_regularization"],
    }


def check_tire_law(law):
    """Texts on what is wrong with a tyre law's values taken together."""
    texts = []
    at_zero, slope, _ = curve_at(law["radial"], 0.0)
    size = abs(curve_at(law["radial"], 0.1 * law["radius"])[0])
    if abs(at_zero) > 1e-6 * size:
        texts.append(f"'tire_law.radial' must be zero at zero deformation; it is {at_zero:g} N")
    if slope < 0.0:
        texts.append("'tire_law.radial' must not fall from zero deformation on")
    else:
        texts += _softening(law)
    if curve_at(law["friction"], 0.0)[0] < 0.0:
        texts.append("'tire_law.friction' must not be negative")
    return texts


def _softening(law):
    """Texts on a radial force that pulls at a deformation for which the law is meant."""
    valid = law.get("valid_deformation")
    for w in np.linspace(0.0, min(valid or law["radius"], law["radius"]), PROBES)[1:]:
        force = curve_at(law["radial"], w)[0]
        if force < 0.0:
            hint = "" if valid else " or 'valid_deformation' says how far the law holds"
            return [f"'tire_law.radial' falls to {force:.4g} N at a deformation of {w:.4g} m; it must not pull{hint}"]
    return []


@kernel
def elastic_force(p, laws, w):
    """F(w) [N] of the deformation w [m]; below zero its tangent at zero."""
    F, slope = curve_and_slope(laws, p.radial, at_least(w, 0.0))
    return F + slope * at_most(w, 0.0)


@kernel
def elastic_energy(p, laws, w):
    """Energy [J] stored at the deformation w [m] >= 0."""
    return potential(laws, p.radial, w) - potential(laws, p.radial, 0.0)


@kernel
def radial_force(p, laws, w, w1):
    """F_r [N] of the deformation w [m] and its rate w1 [m/s]."""
    return elastic_force(p, laws, w) * at_least(1.0 + p.radial_damping * w1, 0.0)


@kernel
def speed_over_ground(n, v):
    """Speed u [m/s] of the axle over the ground."""
    return norm(v - dot(n, v) * n)


@kernel
def gripping(p, laws, slip, speed, u):
    """b [s/m] of the friction N b v_C for the ``speed`` |v_C|, the speed u of the axle.

    mu is taken at the speed ``slip``: |v_C| but for a patch without mass, where it is that of the wheel.
    """
    mu = at_least(curve(laws, p.friction, slip), 0.0) * at_least(curve(laws, p.friction_by_speed, u), 0.0)
    return mu * sticking(p.slip_regularization, speed)
