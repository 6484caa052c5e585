r"""Generic joint: each of six axes between two nodes is held, free, driven or elastic.

In the axes :math:`\mu_i` of a and :math:`\xi_i` of b, which coincide initially, with :math:`d = R_a^T (x_b - x_a)`:
sliding ``along_1``, ``along_2``, ``along_axis`` is :math:`\mu_i \cdot d - c_i` with the initial values as constants;
tilt ``about_1`` is :math:`-\mu_2 \cdot \xi_3`, ``about_2`` is :math:`\mu_1 \cdot \xi_3`, the sines of the angles;
``about_axis`` is the twist, in :math:`(-\pi, \pi]`. :math:`\mu_1` is chosen as for the hinge.

An axis that is not mentioned is held rigidly by a multiplier. ``free`` lists the free axes, ``compliance`` has the law
of an elastic axis, ``driven`` the motion of a driven axis since the start, a law or a formula of time,
``driven_rates`` its rate, a law of time, which is integrated exactly from the time 0, or a formula of signals, which
prescribes velocities. Prefer the specific joints (hinge, prismatic, cylindrical, planar, spherical, universal, fixed)
where they suffice: they count turns, offer friction and stops, and need fewer equations. The assembly rejects
:math:`\xi_3 = -\mu_3` if both tilts are held.
"""

from dataclasses import replace

from mecano.constraints.along_coordinate.demand import is_formula
from mecano.constraints.along_coordinate.hold import motion_values
from mecano.constraints.along_coordinate.measure import REACTIONS, put_translation, translation
from mecano.constraints.coordinates.tilt import tilted
from mecano.constraints.coordinates.twist import turned
from mecano.constraints.joint_nodes import NODES, check_axis_1
from mecano.constraints.joint_samples import SPRUNG
from mecano.constraints.of_coordinates import BOTH, DRIVEN_SLIDE, RELATIVE_ANGLE, drive_part
from mecano.constraints.pair import (
    AXES,
    AXES_FIELDS,
    AXIS_1,
    FIRST_ROW,
    axis_place,
    compliance_field,
    coordinate_of,
    law_outputs,
    pair_parts,
    pair_record,
    put_reactions,
    rigid_axes,
)  # fmt: skip
from mecano.constraints.release import FIRST_ROW as FIRST_RELEASED
from mecano.constraints.release import RELEASE, SAMPLE, check_release, releasable
from mecano.constraints.triads import not_flipped
from mecano.element_interface import Display, Kind, Output, named, record
from mecano.jit.kernel import kernel
from mecano.laws.formula import evaluate_formula
from mecano.laws.law_table import evaluate_curve
from mecano.maths.dual import number, value
from mecano.maths.vector import mat
from mecano.schema import CONTINUOUS_DRIVE, DIRECTION, MOTION, Field, choice, list_of, mapping

RECORD = record(drive=6, row=6, law=6, **AXES_FIELDS)
RECORD_BY_FORMULA = record(rate=6, drive=6, row=6, law=6, **AXES_FIELDS)
DRIVABLE = ("along_1", "along_2", "along_axis", "about_axis")
WHAT = ("displacement", "displacement", "displacement", "twist")
AXES_DRIVEN = tuple(zip(DRIVABLE, ("m", "m", "m", "rad"), WHAT, strict=True))
DRIVEN = mapping(*(Field(axis, MOTION, unit, f"{what} since the start", None) for axis, unit, what in AXES_DRIVEN))
RATES = mapping(
    *(Field(axis, CONTINUOUS_DRIVE, f"{unit}/s", f"rate of the {what}", None) for axis, unit, what in AXES_DRIVEN)
)


@kernel
def _rate_of_law(p, at, i):
    return evaluate_curve(at.laws, int(p.drive[i]), at.t)[1]


@kernel
def _rate_of_any(p, at, i):
    """Return the rate of the drive of axis i, by a law or by a formula; the other one starts at 0, where it is zero."""
    return _rate_of_law(p, at, i) + value(evaluate_formula(at.laws, int(p.rate[i]), at.t, at.q, 0))


def _observed(rate_of):
    """Return ``observe`` for drives with the rates rate_of(p, at, index of the axis)."""

    @kernel
    def observe(p, at, F, y, e):
        """Write motion along and about the axes, reactions, power of the drives."""
        mu, xi = mat(p.mu), mat(p.xi)
        put_translation(p, at, F, y, 0)
        y[6], y[7] = -tilted(at, mu[1], xi[2])[0], tilted(at, mu[0], xi[2])[0]
        y[8], y[9] = turned(p, at)
        put_reactions(p, at, F, y, 10)
        for i in range(6):
            rate = rate_of(p, at, i)
            if rate != 0.0:
                e[3] += number(at.q[int(p.row[i])]) * rate

    return observe


def _driven(d, axis, field="driven"):
    return (d[field] or {}).get(axis)


def _by_formula(d):
    return any(is_formula(_driven(d, axis)) for axis in AXES)


def _bound(d):
    """Return the axes that are not free, in the order of their parts."""
    return [axis for axis in AXES if axis not in d["free"]]


def prepare(d, nodes, context):
    """Return axes of both nodes, the constraint or law of each axis, the motions of the driven ones."""
    motions = [motion_values(_driven(d, axis), 0.0, context) for axis in AXES]
    drives = {"drive": [motion.get("law", 0) for motion in motions]}
    if _by_formula(d):
        drives["rate"] = [motion.get("rate", 0) for motion in motions]
    first = FIRST_RELEASED if d["release"] else FIRST_ROW
    return {**drives, **pair_record(axis_place(d, nodes, context), _bound(d), d["compliance"], context, first)}


def parts(d, nodes, context):
    """Return a constraint or a law for each axis that is not free."""
    p, found = axis_place(d, nodes, context), []
    for axis in _bound(d):
        given, rate = (_driven(d, axis, field) for field in ("driven", "driven_rates"))
        if given is rate is None:
            found += pair_parts(p, (axis,), d["compliance"], context)
        else:
            axes, start = coordinate_of(axis, p)
            kind = RELATIVE_ANGLE if axis == "about_axis" else DRIVEN_SLIDE
            driven = (given, start, context) if rate is None else (rate, start, context, True)
            found.append(drive_part(kind, BOTH, axes, *driven))
    return found


def check(d, nodes):
    """Check that no axis is given twice, and that at least one is not free."""
    texts = check_axis_1(d, nodes) + check_release(d, ("compliance",))
    laws = {
        name: {axis for axis, law in (d[name] or {}).items() if law is not None}
        for name in ("compliance", "driven", "driven_rates")
    }
    given = {"free": set(d["free"]), **laws}
    for axis in AXES:
        twice = [name for name, axes in given.items() if axis in axes]
        if len(twice) > 1:
            texts.append(f"{axis!r} is given in {' and '.join(map(repr, twice))}; only one of them is allowed")
    texts += [f"{axis!r} is given twice in 'free'" for axis in AXES if d["free"].count(axis) > 1]
    if set(AXES) <= given["free"]:
        texts.append("'free' has all six axes: nothing would join the nodes")
    return texts


def admissible(p, q, R):
    """Return an error for a flipped joint, if both tilts are held."""
    return not_flipped(p, q, R) if p["row"][0] >= 0.0 and p["row"][1] >= 0.0 else ""


FIRST = {"axis_1": (0.3, -1.0, 0.5)}  # of samples, as the others
WAVE = (("sine", {"amplitude": 0.3, "frequency": 0.2, "phase": 0.4, "offset": 0.1}),)
LEAN = {"about_2": SPRUNG, "about_1": SPRUNG, "along_axis": SPRUNG}
GENERIC = Kind(
    name="generic", section="joints", doc=__doc__, display=Display(force="force", along_axes=True), dtype=RECORD,
    layout=("x0", "R0", "x1", "R1"),
    fields=(
        NODES,
        Field("axis", DIRECTION, "-", "third axis at the start, inertial; fixed in both nodes"),
        AXIS_1,
        Field("free", list_of(choice(*AXES)), "-", "axes along or about which b moves freely", ()),
        Field("driven", DRIVEN, "-", "motions along axes; 1, 2: of mu_1, mu_2", None),
        Field("driven_rates", RATES, "-", "rates along axes, laws of time or formulas of signals", None),
        compliance_field(AXES),
        RELEASE,
    ),
    outputs=(
        *translation("mu_1, mu_2 and the axis").declared,
        Output("tilt", "-", "sines of the angles by which the axis of b leans about mu_1 and mu_2", (2,)),
        Output("angle", "rad", "twist of b relative to a about the axis, in one turn", wraps=True),
        Output("rate", "rad/s", "rate of the angle"),
        *REACTIONS,
    ),
    optional=law_outputs("compliance", AXES),
    observe=_observed(_rate_of_law),
    variant=lambda d: (RELEASED if d["release"] else KINDS)[_by_formula(d)],
    holds=lambda d: () if d["driven"] or d["driven_rates"] or d["release"] else rigid_axes(_bound(d), d["compliance"]),
    cases=(
        {},
        {**FIRST, "free": ("about_1",), "driven": {"about_axis": WAVE, "along_2": WAVE}},
        {**FIRST, **SAMPLE, "driven": {"along_1": WAVE}, "driven_rates": {"along_2": WAVE, "about_axis": "command"}},
        {**FIRST, **SAMPLE, "free": ("about_1", "about_2"), "driven": {"along_2": "sin(time)"}},
        {**FIRST, "driven": {"along_1": "sin(time)", "about_axis": "time**2/2", "along_2": WAVE}},
        {**FIRST, "driven_rates": {"along_2": WAVE, "along_axis": "command", "about_axis": "command"}},
        {**FIRST, "free": ("along_1", "about_axis"), "compliance": LEAN},
    ),
    **named(prepare, parts, check, admissible),
)  # fmt: skip
KINDS = GENERIC, replace(GENERIC, dtype=RECORD_BY_FORMULA, observe=_observed(_rate_of_any))
RELEASED = tuple(releasable(kind, admissible=None) for kind in KINDS)
"""The joints whose axes laws drive, or also formulas of time; and those with a release."""
