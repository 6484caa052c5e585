r"""Nonlinear damper terms: polynomial and table of the rate, oil through orifices, dry friction.

Oil of density :math:`\rho` forced by a piston of area A through an orifice of area :math:`A_o` causes the pressure
:math:`p = \frac{\rho}{2} (A v / (C_d A_o))^2` (Bernoulli; Currey, Aircraft Landing Gear Design, 1988, chapter 5), hence
the force :math:`F = \frac{\rho A^3}{2 (C_d A_o)^2} v |v|`. A metering pin makes :math:`A_o` a function of the stroke.

Dry friction, regularized after Oden & Martins (1985), is :math:`F = F_f\,\phi(|v|)\,\mathrm{sign}(v)` with
:math:`\phi(s) = (s/\epsilon)(2 - s/\epsilon)` for :math:`s < \epsilon`, 1 beyond: C1 everywhere (Cardona, Geradin &
Doan 1991, eq. 34).
"""

import numpy as np

from mecano.jit.kernel import kernel
from mecano.laws.linear_forces import VISCOUS
from mecano.laws.polynomial import COEFFICIENTS, pack_polynomial
from mecano.laws.tabulated import (
    BEYOND,
    FILE_FIELDS,
    INTERPOLATION,
    POINTS_FIELD,
    pack_points,
    pack_table,
    some_points,
    table,
)  # fmt: skip
from mecano.laws.term import Term, of_rate
from mecano.schema import NUMBER, Field, not_negative, positive


@kernel
def oil_damper(a, i, s, v):
    """Evaluate the term; numbers: compression, rebound."""
    c = a[i] if v < 0.0 else a[i + 1]
    return c * v * abs(v), 0.0, 2.0 * c * abs(v)


@kernel
def metering_pin(a, i, s, v):
    """Evaluate the term; numbers: rho A^3/(2 Cd^2), then the table of the orifice area over the stroke -s."""
    area, slope, _ = table(a, i + 1, -s)
    c = a[i] / (area * area)
    F = c * v * abs(v)
    return F, 2.0 * F * slope / area, 2.0 * c * abs(v)


@kernel
def dry_friction(a, i, s, v):
    """Evaluate the term; numbers: force, regularization."""
    if v >= a[i + 1]:
        return a[i], 0.0, 0.0
    if v <= -a[i + 1]:
        return -a[i], 0.0, 0.0
    u = abs(v) / a[i + 1]
    return a[i] * v / a[i + 1] * (2.0 - u), 0.0, 2.0 * a[i] / a[i + 1] * (1.0 - u)


def pack_metering_pin(values):
    """Return the numbers of the term."""
    c = values["density"] * values["piston_area"] ** 3 / (2 * values["discharge_coefficient"] ** 2)
    return np.append(c, pack_points(values["points"], values["interpolation"], "hold"))


def opposes_motion(values):
    """Check that a damper table passes through [0, 0] and dissipates energy at all other points."""
    problems = some_points(values)
    if problems:
        return problems
    if not any(x == 0 and y == 0 for x, y in values["points"]):
        return ["'points' must hold the point [0, 0]: a damper gives no force at rest (see 'preload')"]
    wrong = [[float(x), float(y)] for x, y in values["points"] if x * y < 0]
    return [f"'points' must oppose the motion: force and rate have different signs at {wrong}"] if wrong else []


def open_orifice(values):
    """Check that the orifice never closes."""
    problems = some_points(values)
    if problems or all(y > 0 for _, y in values["points"]):
        return problems
    return ["'points' must have orifice areas greater than zero"]


DAMPER_POLYNOMIAL = Term(
    name="damper_polynomial", doc="F = c1 v + c2 v^2 + c3 v^3 + ..., a polynomial of the rate; c0 = 0.", role="force",
    fields=(COEFFICIENTS,),
    pack=pack_polynomial,
    evaluate=VISCOUS,
    check=lambda values: (
        ["'coefficients' must begin with 0: a damper gives no force at rest (see 'preload')"]
        if values["coefficients"][0] else []
    ),
)  # fmt: skip

DAMPER_TABLE = Term(
    name="damper_table",
    doc="F(v) through given points [rate, force], the point [0, 0] among them; corners as in 'table'.",
    role="force",
    fields=(POINTS_FIELD, *FILE_FIELDS, INTERPOLATION, BEYOND),
    pack=pack_table,
    evaluate=of_rate(table),
    check=opposes_motion,
)

OIL_DAMPER = Term(
    name="oil_damper", doc="F = c v |v|, with c of compression or of rebound; C1.", role="force",
    fields=(
        Field("compression", NUMBER, "N s2/m2", "coefficient while the length decreases", check=not_negative),
        Field("rebound", NUMBER, "N s2/m2", "coefficient while the length increases", check=not_negative),
    ),
    evaluate=oil_damper,
)  # fmt: skip

METERING_PIN = Term(
    name="metering_pin",
    doc="F = rho A^3/(2 (Cd Ao)^2) v |v|, the orifice area Ao a function of the stroke -s (held outside its points).",
    role="force",
    fields=(
        Field("density", NUMBER, "kg/m3", "density of the oil", check=positive),
        Field("piston_area", NUMBER, "m2", "area A of the piston", check=positive),
        Field("discharge_coefficient", NUMBER, "-", "discharge coefficient Cd of the orifice", check=positive),
        Field("points", POINTS_FIELD.type, "m, m2", "points [stroke, orifice area]", None, POINTS_FIELD.check),
        *FILE_FIELDS,
        INTERPOLATION,
    ),
    pack=pack_metering_pin,
    evaluate=metering_pin,
    check=open_orifice,
)

DRY_FRICTION = Term(
    name="dry_friction",
    doc="F = force phi(|v|) sign(v), phi = u (2 - u) with u = |v|/regularization up to u = 1, then 1; C1.",
    role="force",
    fields=(
        Field("force", NUMBER, "N or N m", "friction force in sliding", check=not_negative),
        Field("regularization", NUMBER, "m/s or rad/s", "rate at which the full force is reached", check=positive),
    ),
    evaluate=dry_friction,
)
