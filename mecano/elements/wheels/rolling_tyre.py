r"""Effective rolling radius and rolling resistance of a tyre, for any slip law except that of a .tir file.

Without ``rolling_radius_coefficient`` a tyre without slip rolls on its loaded radius r_l = radius - w, w being the
radial deformation. With the coefficient c the effective rolling radius is

    r_e = radius - c w

For a belt that keeps its length while its arc of contact is pressed flat, r_e = radius sin(phi)/phi with
radius (1 - cos phi) = w, and c = 1/3 for small w. The slip velocity is that of a rim of this radius, with t the driving
direction, of a twisted patch the one in which it rolls, and W = a.omega the spin relative to the ground:

    v' = v_C - (r_e - r_l) W t,      free rolling: u.t = r_e W

The force F of the slip law at v' still acts at the contact; with the moment -(r_e - r_l) (F.t) a its moment about the
axle is r_e F.t, and no power is lost except by the slip: F.v_C + M.omega = F.v'.

On a drum of the curvature k along t the normal at the contact turns, too: relative to it, a wheel that rolls without
slip has the spin W/(1 + k r_e). This takes the place of W, and the moments are those above over 1 + k r_e, for the same
power. A free wheel on a fixed axle then spins at R/r_e times the rate of a drum of the radius R, and the rolling
resistance brakes the drum by the force f g N.

``rolling_resistance`` f(N) g(u), a coefficient times a factor of the speed u of the axle, adds the moment

    M = -f g N r_e phi(|W| r_e/v_0) sign(W) a,      phi(x) = x (2 - x) for x < 1, else 1

A wheel that rolls freely at a constant speed is braked by the force f g N. The moment dissipates -M.omega >= 0.
"""

from dataclasses import replace
from functools import cache

from mecano.elements.wheels.slip_law import SlipForces, slipping
from mecano.jit.kernel import kernel
from mecano.laws.friction import sticking
from mecano.laws.law_table import curve
from mecano.laws.probe import negative_curves
from mecano.maths.dual import at_least, sqrt
from mecano.maths.vector import dot, norm
from mecano.schema import CURVE, NUMBER, Field, mapping, positive, share

RESISTANCE = mapping(
    Field("coefficient", CURVE, "-", "coefficient f, a curve of the normal force [N]", argument="N"),
    Field("by_speed", CURVE, "-", "factor g, a curve of the speed of the axle [m/s]", 1.0, argument="m/s"),
    Field("least_speed", NUMBER, "m/s", "v_0, speed of the rim below which the moment falls to zero", 0.1, positive),
)
FIELDS = (
    Field(
        "rolling_radius_coefficient", NUMBER, "-",
        "c in the effective rolling radius r_e = radius - c w, about 1/3 for tyres; the loaded radius (c = 1) when "
        "absent", None, share,
    ),
    Field("rolling_resistance", RESISTANCE, "-", "moment against the rolling", None),
)  # fmt: skip
RECORD = {"undeflected": (), "resistance": "i", "resistance_by_speed": "i", "resistance_speed": ()}


def is_given(law):
    """Return True if the values of a tyre law contain a rolling radius or a rolling resistance."""
    return any(law.get(field.name) is not None for field in FIELDS)


@cache
def rolling_law(law):
    """Return the SlipLaw with the forces of ``law`` at the effective rolling radius, and rolling resistance."""
    forces, radius = law.forces, _radius_of_crown if law.crowned else _radius

    @kernel
    def rolled_forces(p, laws, k):
        """Return the SlipForces at the contact ``k`` (a Slip) with the moment about the axle."""
        ground = forces(p, laws, k)
        a, (extra, r_e, share) = _axis(k), radius(p, k)
        spin = dot(a, k.omega)
        load, rim = at_least(k.N, 0.0), r_e * share * spin
        f, g = curve(laws, p.resistance, load), curve(laws, p.resistance_by_speed, norm(k.u))
        full = load * at_least(f, 0.0) * at_least(g, 0.0) * r_e * sticking(p.resistance_speed, abs(rim)) * rim
        moment = -share * full
        M = ground.M + (moment - share * extra * dot(ground.F, k.t)) * a
        return SlipForces(ground.F, M, ground.lost - moment * spin, ground.given)

    def prepare(d, context):
        coefficient = d.get("rolling_radius_coefficient")
        resistance = d.get("rolling_resistance") or {"coefficient": None, "by_speed": None, "least_speed": 1.0}
        return {
            **law.prepare(d, context), "undeflected": 0.0 if coefficient is None else 1.0 - coefficient,
            "resistance": context.laws.add(resistance["coefficient"]),
            "resistance_by_speed": context.laws.add(resistance["by_speed"]),
            "resistance_speed": resistance["least_speed"],
        }  # fmt: skip

    return replace(
        law, name=f"{law.name}_rolling", forces=rolled_forces, slip=at_effective_radius,
        record={**law.record, **RECORD}, prepare=prepare,
    )  # fmt: skip


@kernel
def _axis(k):
    """Return the axis of the wheel of a Slip."""
    return k.lean * k.n + sqrt(1.0 - k.lean * k.lean) * k.l


@kernel
def _radius(p, k):
    """Return r_e - r_l [m], r_e [m] and 1/(1 + k r_e) of a Slip."""
    extra = p.undeflected * at_least(k.w, 0.0)
    r_e = p.radius - k.w + extra
    return extra, r_e, 1.0 / (1.0 + k.curvature * r_e)


@kernel
def _radius_of_crown(p, k):
    """Return the same for a rounded tread, whose contact is nearer to the axle as the wheel leans."""
    extra, r_e, share = _radius(p, k)
    return extra, r_e - (p.crown - k.w) * (1.0 - sqrt(1.0 - k.lean * k.lean)), share


@kernel
def at_effective_radius(p, k):
    """Return the Slip of a rim of the effective rolling radius."""
    extra, _, share = _radius(p, k)
    back = extra * share * dot(_axis(k), k.omega) * k.t
    return slipping(k, k.v - back, k.v_0 - back)


def with_rolling(sample):
    """Return a sample (values, nodes, phase) of a wheel of 12 m with a rolling radius and a rolling resistance."""
    values, nodes, phase = sample
    falling = (("exponential", {"start": 0.3, "limit": 0.1, "rate": 1e-4, "origin": 0.0}),)
    rising = (("linear", {"slope": 0.1, "offset": 1.0}),)
    own = {
        "rolling_radius_coefficient": 0.3,
        "rolling_resistance": {"coefficient": falling, "by_speed": rising, "least_speed": 5.0},
    }
    return {**values, "tire_law": {**values["tire_law"], **own}}, nodes, phase


def check_rolling(law):
    """Return errors for a negative resistance, and for values that a .tir file contains."""
    given = [field.name for field in FIELDS if law.get(field.name) is not None]
    if law.get("magic_formula") is not None:
        text = "is not available with 'magic_formula', whose file contains it"
        return [f"'tire_law.{name}' {text}" for name in given]
    if law.get("rolling_resistance") is None:
        return []
    curves = {name: law["rolling_resistance"][name] for name in ("coefficient", "by_speed")}
    return negative_curves("tire_law.rolling_resistance", curves)
