r"""Tyre laws: deck fields, and the radial force in the plane of the wheel.

The radial force depends on the deformation w = radius - r and its rate ((32) of Cardona, Geradin and Doan 1991; damping
after Hunt and Crossley 1975, which never pulls):

    F_r = F(w) max(0, 1 + c dw/dt)

F is continued by its tangent to w < 0, so that a step which ends at the lift-off meets no corner. It stores the
integral of F(w); what damping dissipates is (F_r - F) dw/dt >= 0.

What happens in the ground is a slip law (slip_law.py), exactly one of which a tyre law has: friction with its fields
here, or one that stands under its name, such as ``fiala``.
"""

import numpy as np

from mecano.elements.wheels.lateral_law import LATERAL_TYPE
from mecano.elements.wheels.sliding_friction import FIELDS as FRICTION_FIELDS
from mecano.elements.wheels.slip_law import given_law
from mecano.elements.wheels.slip_laws import SLIP_LAWS
from mecano.jit.kernel import kernel
from mecano.laws.probe import curve_at
from mecano.laws.table import curve_and_slope, potential
from mecano.maths.dual import at_least, at_most
from mecano.maths.vector import dot, norm
from mecano.schema import CURVE, NUMBER, Field, not_negative, positive

LAW_FIELDS = (
    Field("radius", NUMBER, "m", "undeformed radius; required unless a file gives it", None, positive),
    Field(
        "radial", CURVE, "N", "radial force, a curve of the deformation w [m]; zero at zero; required as the radius",
        None,
    ),
    Field(
        "radial_damping", NUMBER, "s/m", "c in the factor max(0, 1 + c dw/dt) on the radial force", 0.0,
        not_negative,
    ),
    *FRICTION_FIELDS,
    Field(
        "valid_deformation", NUMBER, "m", "deformation up to which the law holds; a warning beyond",
        None, positive,
    ),
    Field("lateral", LATERAL_TYPE, "-", "how the patch gives way sideways: flexible wheels", None),
)  # fmt: skip


def slip_field(law):
    """The deck field of a SlipLaw."""
    return Field(law.name, law.type, "-", law.summary, None)


TIRE_LAW_FIELDS = [*LAW_FIELDS, *(slip_field(law) for name, law in SLIP_LAWS.items() if name != "friction")]
"""What a tyre law may have in a deck; it grows with the slip laws (``register``)."""

PROBES = 201  # deformations at which the radial force is looked at
RADIAL_RECORD = {"radius": (), "radial": "i", "radial_damping": ()}


def register(law):
    """Add a SlipLaw to those that a tyre law may have."""
    SLIP_LAWS[law.name] = law
    TIRE_LAW_FIELDS.append(slip_field(law))


def slip_law_of(values):
    """The SlipLaw of the values of a tyre law."""
    return given_law(values, SLIP_LAWS)


def prepare_radial(law, context):
    """Values of RADIAL_RECORD."""
    return {
        "radius": law["radius"],
        "radial": int(context.laws.add(law["radial"])),
        "radial_damping": law["radial_damping"],
    }


def check_tire_law(law):
    """Texts on what is wrong with a tyre law's values taken together."""
    texts = slip_law_of(law).check(law)
    at_zero, slope, _ = curve_at(law["radial"], 0.0)
    size = abs(curve_at(law["radial"], 0.1 * law["radius"])[0])
    if abs(at_zero) > 1e-6 * size:
        texts.append(f"'tire_law.radial' must be zero at zero deformation; it is {at_zero:g} N")
    if slope < 0.0:
        texts.append("'tire_law.radial' must not fall from zero deformation on")
    else:
        texts += _softening(law)
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
