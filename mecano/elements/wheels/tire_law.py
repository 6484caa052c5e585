r"""Tyre laws: deck fields, and the radial force in the plane of the wheel.

The radial force depends on the deformation w = radius - r and its rate ((32) of Cardona, Geradin and Doan 1991; damping
after Hunt and Crossley 1975, which never pulls):

    F_r = F(w) max(0, 1 + c dw/dt)

F is continued by its tangent to w < 0, so that there is no corner in a step that ends at the lift-off. The stored
energy is the integral of F(w); the damping dissipates (F_r - F) dw/dt >= 0.

The forces in the plane of the ground are those of a slip law (slip_law.py). A tyre law contains exactly one: friction,
whose fields are listed here, or one under its own name, such as ``fiala``.
"""

import numpy as np

from mecano.element_interface import recorded_values
from mecano.elements.wheels.crown import CROWN, crowned_law
from mecano.elements.wheels.enveloping import ENVELOPING, enveloping_law
from mecano.elements.wheels.lateral_law import LATERAL_TYPE, check_forms
from mecano.elements.wheels.rolling_tyre import FIELDS as ROLLING_FIELDS
from mecano.elements.wheels.rolling_tyre import check_rolling, is_given, rolling_law
from mecano.elements.wheels.sliding_friction import FIELDS as FRICTION_FIELDS
from mecano.elements.wheels.slip_laws import SLIP_LAWS, given_law
from mecano.elements.wheels.smiley_horne import SMILEY_HORNE
from mecano.elements.wheels.turn_slip import turning_law, twisting_law
from mecano.jit.kernel import kernel
from mecano.laws.contact_force import contact_force
from mecano.laws.probe import curve_at, curve_values
from mecano.maths.vector import dot, norm
from mecano.schema import CURVE, NUMBER, Field, not_negative, positive

LAW_FIELDS = (
    Field(
        "radius", NUMBER, "m", "undeformed radius; required unless smiley_horne or a .tir file gives it", None,
        positive,
    ),
    Field(
        "radial", CURVE, "N",
        "radial force, a curve of the deformation w [m], zero at w = 0; required unless smiley_horne or a .tir file "
        "gives it", None, argument="m"
    ),
    Field(
        "radial_damping", NUMBER, "s/m", "c in the factor max(0, 1 + c dw/dt) on the radial force", 0.0,
        not_negative,
    ),
    *FRICTION_FIELDS,
    Field(
        "valid_deformation", NUMBER, "m", "deformation up to which the law is valid; a warning beyond",
        None, positive,
    ),
    *ROLLING_FIELDS,
    ENVELOPING,
    CROWN,
    Field("lateral", LATERAL_TYPE, "-", "lateral law of the patch; for flexible wheels", None, check=check_forms),
    SMILEY_HORNE,
)  # fmt: skip


def slip_field(law):
    """Return the deck field of a SlipLaw."""
    return Field(law.name, law.type, "-", law.summary, None)


TIRE_LAW_FIELDS = [*LAW_FIELDS, *(slip_field(law) for name, law in SLIP_LAWS.items() if name != "friction")]
"""Deck fields of a tyre law; ``register`` adds those of further slip laws."""

PROBES = 201  # number of deformations at which the radial force is checked
RADIAL_RECORD = {"radius": (), "radial": "i", "radial_damping": ()}


def register(law):
    """Add a SlipLaw to those that a tyre law may contain."""
    SLIP_LAWS[law.name] = law
    TIRE_LAW_FIELDS.append(slip_field(law))


def slip_law_of(values):
    """Return the SlipLaw of the values of a tyre law, with crown, turn slip, rolling radius, resistance, cams."""
    law = given_law(values)
    field, own = law.name, values[law.name] if law.turning else {}
    law = crowned_law(law) if values.get("crown_radius") else law
    if own.get("contact_width") or own.get("turn_slip"):
        law = twisting_law(law, field) if own.get("torsional_stiffness") else turning_law(law)
    law = rolling_law(law) if is_given(values) else law
    cams = values.get("enveloping")
    return law if cams is None else enveloping_law(law, cams["contact_width"] > 0.0)


def prepare_radial(law, context):
    """Return the values of RADIAL_RECORD."""
    return recorded_values(RADIAL_RECORD, LAW_FIELDS, law, context)


def check_tire_law(law):
    """Return errors in the combination of the values of a tyre law."""
    texts = slip_law_of(law).check(law) + check_rolling(law)
    at_zero, slope, _ = curve_at(law["radial"], 0.0)
    size = abs(curve_at(law["radial"], 0.1 * law["radius"])[0])
    if abs(at_zero) > 1e-6 * size:
        texts.append(f"'tire_law.radial' must be zero at zero deformation; it is {at_zero:g} N")
    if slope < 0.0:
        texts.append("'tire_law.radial' must not decrease at zero deformation")
    else:
        texts += _softening(law)
    return texts


def _softening(law):
    """Return errors for a radial force that is negative (pulls) within the range of validity of the law."""
    valid = law.get("valid_deformation")
    w = np.linspace(0.0, min(valid or law["radius"], law["radius"]), PROBES)[1:]
    force = curve_values(law["radial"], w)[:, 0]
    if not (force < 0.0).any():
        return []
    first, hint = np.argmax(force < 0.0), "" if valid else " unless 'valid_deformation' limits the range of the law"
    fall = f"falls to {force[first]:.4g} N at a deformation of {w[first]:.4g} m"
    return [f"'tire_law.radial' {fall}; it must not pull{hint}"]


@kernel
def radial_force(p, laws, w, w1):
    """Return F_r [N] of the deformation w [m] and its rate w1 [m/s]."""
    return contact_force(laws, p.radial, p.radial_damping, w, w1)


@kernel
def speed_over_ground(n, v):
    """Return the speed u [m/s] of the axle over the ground, from its velocity v and the normal n."""
    return norm(v - dot(n, v) * n)
