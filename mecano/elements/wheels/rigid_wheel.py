r"""Rigid wheel that rolls without slip, exact at any inclination and on any smooth ground.

With the axis a = R a0, the contact C = x + r c, its normal n and q = |n - (n.a) a|, and the velocity
u = v + omega x r c of the wheel at C:

    r - radius = 0                   it touches the ground; on a plane (18), (x - P).n - radius q = 0
    u.t = 0, u.l = 0                 it does not slip (22), along t = a x n/q and l = n x t
    a.n = 0                          with ``axle: level`` (19): the axle stays parallel to the plane of the ground

Equation numbers are those of Cardona, Geradin and Doan, CMAME 89 (1991), who describe this wheel for small
inclinations; here the contact moves over the rim as the wheel leans (``cardona_wheel`` is theirs to the letter). The
reactions are the radial force, N = F_r/q, the driving and the lateral force at C (24), and the moment that keeps the
axle level.

With ``unilateral`` the wheel starts in the air if its rim is more than a thousandth of the radius above the ground. It
leaves the ground when N falls to zero and lands again without rebound: at touch-down the velocities jump to the nearest
ones, in the norm of the kinetic energy, that roll. The energy of this shock is lost (docs/shocks.md).

With a ``crown_radius`` e the tread is rounded, as that of a motorcycle: the wheel is a torus, whose middle circle has
the radius ``radius`` - e. Its contact, C = x + (``radius`` - e) c - e n, moves across the tread as it leans; the way
from that circle to the ground, along n, has the length e, and the first reaction is N.

Where the curvature of the ground's profile jumps, at the ends of bumps, the accelerations jump too: the passage of the
wheel over such a point is an event, so that no step extends across it, if there are no more than eight such points.

The node is that of the wheel body: its rotation spins with the wheel. The wheel must not lie flat (q > 0).
"""

import math
from dataclasses import replace

from mecano.constraints.ground import (
    GROUND_RECORD,
    MOST_BENDS,
    STANDING,
    along_profile,
    bends,
    check_axle,
    check_crown,
    check_ground,
    end_conditions,
    on_the_slope,
    slope_below,
    too_low,
)
from mecano.constraints.of_coordinates import LEVEL_AXIS
from mecano.constraints.rolling import ROLLING, ROUND_ROLLING
from mecano.constraints.rolling_radius import ROLLING_RADIUS, ROUND_RADIUS
from mecano.constraints.tread import flat_on_ground, rounded_on_ground, tread_above
from mecano.constraints.wheels import FIELDS, OUTPUTS, WHEEL_DISPLAY, Wheel, check_touching, disc_record, put_outputs
from mecano.element_interface import CONTACT as SHOCK
from mecano.element_interface import Event, Kind, Part, named, record
from mecano.jit.kernel import kernel
from mecano.maths.dual import number, select
from mecano.maths.vector import dot, mat, vec
from mecano.schema import BOOLEAN, NUMBER, Field, choice, not_negative

RECORD = record(axis=3, radius=(), restitution=(), in_air="i", bends=MOST_BENDS, **GROUND_RECORD)
BILATERAL = -1.0  # in place of a restitution
CONTACT, AIR = 0, 1
BEHIND = 1e-7  # of the radius: distance of the event beyond a bend, larger than the round-off of a step that ends on it
COUNTED = 0.99  # of that: beyond this distance the bend counts as passed, even if round-off has moved the event
RADIAL, DRIVING, LATERAL = 6, 7, 8  # multipliers of the parts, after its own unknowns

OPTIONS = (
    Field("axle", choice("free", "level"), "-", "free to lean, or kept parallel to the plane of the ground", "free"),
    Field("unilateral", BOOLEAN, "-", "whether it may leave the ground", False),
    Field(
        "crown_radius", NUMBER, "m", "radius of a rounded tread, seen along the wheel; part of 'radius'", 0.0,
        not_negative,
    ),
)  # fmt: skip


def compiled(tread_on_ground):
    """Return ``observe``, ``event_values`` and ``commit`` of a wheel with a tread of tread.py."""

    @kernel
    def observe(p, at, F, y, e):
        """Write the reactions from the multipliers of the parts; the wheel neither stores nor dissipates energy."""
        Rn = mat(at.R[0])
        axis = Rn @ vec(p.axis, 0)
        k = tread_on_ground(p, at.laws, vec(at.q, 0), axis)
        radius = select(at.phase == AIR, p.radius, k.g.r)
        push = number(at.q[RADIAL]) / k.tilt, number(at.q[DRIVING]), number(at.q[LATERAL])
        arm = select(at.phase == AIR, k.lowest, k.g.arm)
        put_outputs(y, at.q, push, radius, Wheel(k.g, axis, arm, dot(Rn @ vec(at.v, 3), axis), k.height))

    @kernel
    def place(p, laws, q, R):
        """Return the distance [m] of the contact along the profile."""
        x = vec(q, 0)
        return along_profile(p, x + tread_on_ground(p, laws, x, mat(R[0]) @ vec(p.axis, 0)).g.arm)

    @kernel
    def event_values(p, at, g):
        """Write depth of the rim below the ground [m], -F_r [N], distance of the contact beyond adjacent bends [m]."""
        g[:] = -1.0
        if at.phase == AIR:
            g[0] = p.radius - tread_on_ground(p, at.laws, vec(at.q, 0), mat(at.R[0]) @ vec(p.axis, 0)).g.r
            return
        if p.restitution >= 0.0:
            g[1] = -at.q[RADIAL]
        if p.bends[0] < math.inf:
            there, passed = place(p, at.laws, at.q, at.R), int(at.m[0])
            g[2] = there - p.bends[passed] if passed < MOST_BENDS else -1.0
            if passed > 0:
                g[2] = max(g[2], p.bends[passed - 1] - there)
            g[2] -= BEHIND * p.radius

    @kernel
    def commit(p, at, m_out):
        """Write the number of bends of the profile that the contact has passed."""
        passed = int(at.m[0])
        if p.bends[0] < math.inf:
            there, margin = place(p, at.laws, at.q, at.R), COUNTED * BEHIND * p.radius
            while passed < MOST_BENDS and there > p.bends[passed] + margin:
                passed += 1
            while passed > 0 and there < p.bends[passed - 1] - margin:
                passed -= 1
        m_out[0] = passed

    return named(observe, event_values, commit)


def prepare(d, nodes, context):
    """Return the record: that of the parts, whether the wheel may lift off or starts in the air, the bends."""
    may_leave = d["unilateral"]
    in_air = may_leave and _rim(d, nodes)[0] > STANDING * d["radius"]
    return {
        **disc_record(d, nodes, context), "restitution": 0.0 if may_leave else BILATERAL,
        "in_air": AIR if in_air else CONTACT, "bends": bends(d["ground"]),
    }  # fmt: skip


def _rim(d, nodes):
    """Return the height of the rim as ``tread_above``."""
    return tread_above(d["ground"], d["radius"], d["crown_radius"], nodes[0][0], d["axis"])


def parts(d, nodes, context):
    """Return the Parts: contact, no slip, and a level axle if requested."""
    disc = disc_record(d, nodes, context)
    radius, rolling = (ROUND_RADIUS, ROUND_ROLLING) if d["crown_radius"] else (ROLLING_RADIUS, ROLLING)
    found = [Part(radius, (0,), disc), Part(rolling, (0,), disc)]
    if d["axle"] == "level":
        found.append(Part(LEVEL_AXIS, (0,), {"axis": disc["axis"], "normal": disc["normal"]}))
    return found


def check(d, nodes):
    """Return errors for an unusable ground, a wheel that lies flat or starts below the ground."""
    texts = check_ground(d["ground"]) + check_axle(d["ground"], nodes[0][0], d["axis"])
    texts += check_crown(d["radius"], d["crown_radius"])
    if not texts:
        texts = _check_rim(d, *_rim(d, nodes))
    if d["axle"] == "level" and d["unilateral"]:
        texts.append("'axle' must not be level in a wheel that may leave the ground")
    return texts


def _check_rim(d, gap, along_normal):
    """Return errors for a rim that starts too far from the ground; ``gap`` [m] from ``tread_above``."""
    if not d["unilateral"]:
        return check_touching(gap, along_normal, d["radius"], ", or let it leave the ground ('unilateral: true')")
    return [too_low(-gap, -along_normal)] if gap < -STANDING * d["radius"] else []


def sample(rng):
    """Return wheels that lean on a slope and on waves, one level, one in the air."""
    wave = (("sine", {"amplitude": 0.2, "frequency": 0.03, "phase": 1.0, "offset": 0.0}),)
    waves = (*wave, ("bump", {"start": -2.0, "length": 9.0, "height": 0.1}))
    found = []
    for height, axle, unilateral, phase, crown in (
        (None, "free", False, "contact", 1.5), (waves, "free", True, "contact", 0.0),
        (None, "level", False, "contact", 0.0), (wave, "free", True, "air", 0.0), (waves, "free", True, "contact", 1.5),
        (wave, "free", True, "air", 1.5),
    ):  # fmt: skip
        ground, normal, level = slope_below(rng, height)
        values = {
            "radius": 8.0, "axis": level + 0.3 * normal, "ground": ground, "axle": axle,
            "unilateral": unilateral, "crown_radius": crown,
        }  # fmt: skip
        found.append((values, on_the_slope(rng, normal), phase))
    return found


RIGID_WHEEL = Kind(
    name="rigid_wheel", section="elements", doc=__doc__, display=WHEEL_DISPLAY, dtype=RECORD, layout=("x0", "R0"),
    fields=(*FIELDS, *OPTIONS),
    outputs=OUTPUTS,
    phases=("contact", "air"),
    events=(
        Event("touch_down", "air", "contact", "the rim reaches the ground; a shock", SHOCK, "restitution", brief=True),
        Event("lift_off", "contact", "air", "the normal force falls to zero"),
        Event("bend", "contact", "contact", "it rolls over a point where the curvature of the ground jumps"),
    ),
    memory=("bends_passed",),
    at_start=lambda p: p["in_air"],
    variant=lambda d: ROUND if d["crown_radius"] else RIGID_WHEEL,
    **compiled(flat_on_ground),
    **named(prepare, parts, check, end_conditions, sample),
)  # fmt: skip
ROUND = replace(RIGID_WHEEL, name="rigid_wheel_crowned", variant=None, **compiled(rounded_on_ground))
