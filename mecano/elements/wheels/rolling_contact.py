"""Wheels with a slip law: kinematics of the contact, outputs, events and samples of all of them.

Their kinds have one variant for each slip law, in which the functions of that law are compiled.
"""

from dataclasses import replace
from functools import cache
from typing import NamedTuple

import numpy as np

from mecano.constraints.torus import torus_contact
from mecano.constraints.tread import flat, flat_on_ground, rounded, rounded_on_ground
from mecano.constraints.wheels import Wheel, slow
from mecano.element_interface import Kind, Output, named, record
from mecano.elements.wheels.enveloping import contact_with, rise_of_plane
from mecano.elements.wheels.ground_surface import Surface, surface_at
from mecano.elements.wheels.slip_law import Slip, default_values
from mecano.elements.wheels.start_warnings import start_warnings
from mecano.elements.wheels.tire_law import RADIAL_RECORD, radial_force, slip_law_of
from mecano.elements.wheels.tire_wheel import (
    EVENTS,
    FIELDS,
    PHASES,
    TYRE_DISPLAY,
    Grip,
    end_conditions,
    large_wheel,
    put_depths,
    put_tire,
    range_of_law,
)
from mecano.elements.wheels.tire_wheel import OUTPUTS as TIRE_OUTPUTS
from mecano.jit.kernel import kernel
from mecano.maths.dual import atan2, sqrt
from mecano.maths.surface import Contact, directions, disc_contact
from mecano.maths.vector import add_vec, cross, dot, mat, put, vec

OUTPUTS = (
    *TIRE_OUTPUTS,
    Output(
        "slip_moment", "N m", "moment of the slip law on the wheel: overturning about t, along l, aligning about n",
        (3,),
    ),
    Output("slip_ratio", "-", "minus slip velocity along t over the speed of the axle: -1 for a locked wheel"),
    Output("slip_angle", "rad", "arc tangent of slip velocity along l over the speed of the axle"),
)  # fmt: skip
FIRST = 18  # index of the first value of these outputs, after those of tire_wheel.py
SLOW = 0.1  # [m/s] speed of the axle below which slip ratio and angle are reduced; of small wheels less


class Rolling(NamedTuple):
    """Contact of a wheel; 3-vectors in the inertial frame."""

    g: Contact
    arm: tuple  # from the centre to the contact, or to the lowest point of the tread [m]
    height: float  # of the centre over the ground [m]
    surface: Surface
    axis: tuple
    w1: float  # dw/dt [m/s]
    F: float  # F_r [N]
    slip: Slip
    rise: float  # velocity of the surface along its normal at C [m/s]


def rolling_where(place):
    """Return the kernels that give the Rolling and the event values of a wheel.

    ``place(p, at)`` returns its axis, its Tread, and the velocity [m/s] of the surface along its normal.
    """

    @kernel
    def rolling(p, at, touching):
        """Return the Rolling of a wheel; if not ``touching``, with the velocity of the lowest point of the tread."""
        axis, k, rise = place(p, at)
        return rolling_on(p, at, touching, k, axis, surface_at(p, at, k.g.n, vec(at.q, 0) + k.g.arm), rise, 0.0)

    @kernel
    def event_values(p, at, g):
        put_depths(g, p, place(p, at)[1].g)

    return rolling, event_values


def on_ground(tread):
    """Return the kernels of ``rolling_where`` of a wheel with a ``tread`` on its ground."""

    @kernel
    def place(p, at):
        axis = mat(at.R[0]) @ vec(p.axis, 0)
        return axis, tread(p, at.laws, vec(at.q, 0), axis), 0.0

    return rolling_where(place)


ON_FLAT, ON_ROUND = on_ground(flat_on_ground), on_ground(rounded_on_ground)


@cache
def enveloping_on(plane, crowned):
    """Return the kernels of ``rolling_where`` of a wheel on the effective ``plane`` of cams, perhaps ``crowned``."""
    contact_of, tread = (contact_with(torus_contact), rounded) if crowned else (contact_with(disc_contact), flat)

    @kernel
    def place(p, at):
        axis = mat(at.R[0]) @ vec(p.axis, 0)
        found = plane(p, at.laws, vec(at.q, 0), axis, vec(at.v, 0), mat(at.R[0]) @ vec(at.v, 3))
        g = contact_of(p, found, axis)
        return axis, tread(p, g), rise_of_plane(found, g, vec(at.v, 0))

    return rolling_where(place)


def contact_of(law):
    """Return the kernels that give the Rolling and the event values of a wheel with a SlipLaw."""
    if law.plane:
        return enveloping_on(law.plane, law.crowned)
    return ON_ROUND if law.crowned else ON_FLAT


@kernel
def rolling_on(p, at, touching, tread, axis, surface, rise, curvature):
    """Return the Rolling of a Tread on a Surface that moves along its normal with ``rise`` [m/s].

    ``curvature`` is that of the surface along the driving direction [1/m].
    """
    g = tread.g
    v, omega = vec(at.v, 0), mat(at.R[0]) @ vec(at.v, 3)
    arm = g.arm if touching else tread.lowest
    point = v + cross(omega, arm)
    lift = dot(g.n, point)
    v_C, w1 = point - lift * g.n, (rise - lift) / tread.tilt
    F = radial_force(p, at.laws, p.radius - g.r, w1)
    t, l = directions(axis, g)
    v_C, turning = v_C - surface.v, omega - surface.omega
    u = _passing(v - dot(g.n, v) * g.n - surface.v, surface.omega, g, t, curvature)
    spin = dot(turning, axis)
    slip = Slip(F / tread.tilt, p.radius - g.r, surface.grip, v_C, v_C, u, turning, spin, g.s, t, l, g.n, curvature)
    return Rolling(g, arm, tread.height, surface, axis, w1, F, slip, rise)


@kernel
def _passing(u, omega, g, t, curvature):
    """Return the velocity at which the contact passes over its surface [m/s].

    That is the velocity of the axle in axes that turn with the surface, where ``u`` is its velocity less that of the
    surface at the contact and ``omega`` the rate of the surface [rad/s]; over a curved one the contact moves as fast
    as the axle times its own distance from the centre of curvature over that of the axle.
    """
    across = cross(omega, g.arm)
    u = u + (across - dot(g.n, across) * g.n)
    bend = -curvature * dot(g.n, g.arm)
    return u - bend / (1.0 + bend) * dot(t, u) * t


@kernel
def with_slip(k, slip):
    """Return the Rolling with another Slip."""
    return Rolling(k.g, k.arm, k.height, k.surface, k.axis, k.w1, k.F, slip, k.rise)


@kernel
def add_ground(f, at, k, ground):
    """Subtract force and material moment of the ground from ``f``: SlipForces ``ground`` and the normal force."""
    push = ground.F + k.slip.N * k.slip.n
    add_vec(f, 0, -1.0, push)
    add_vec(f, 3, -1.0, mat(at.R[0]).T @ (cross(k.g.arm, push) + ground.M))


@kernel
def put_rolling(p, at, k, ground, y, e):
    """Write outputs and energies of a Rolling under the SlipForces ``ground``; return True if the ground pushes."""
    grip = Grip(k.F, ground.F, k.slip.N, k.slip.v_0, ground.lost, k.w1)
    spin = dot(k.axis, k.slip.omega + k.surface.omega)
    pushes = put_tire(p, at, Wheel(k.g, k.axis, k.arm, spin, k.height), grip, y, e)
    if pushes:
        t, l, M = k.slip.t, k.slip.l, ground.M
        put(y, FIRST, (dot(t, M), dot(l, M), dot(k.slip.n, M)))
        e[3] = ground.given + dot(ground.F, k.surface.v) + dot(M, k.surface.omega) + k.slip.N * k.rise
        forward = dot(t, k.slip.u)
        least = slow(p.radius, SLOW)
        V = sqrt(forward * forward + least * least)
        y[FIRST + 3] = -dot(t, k.slip.v_0) / V
        y[FIRST + 4] = atan2(dot(l, k.slip.v_0), V)
    return pushes


def limits(d):
    """Return the limits of the radial law and of the slip law."""
    return range_of_law(d) + slip_law_of(d["tire_law"]).limits(d["tire_law"])


def law_samples(rng, law):
    """Return samples of a wheel with a slip law: all samples of the law in contact, the last one also in the air."""
    found = []
    for values in law.sample(rng) if law.sample else ():
        wheel = large_wheel(rng, True, None, None, 1.0, None)
        wheel["tire_law"][law.name] = default_values(law.type.options, values)
        found.append((wheel, [(np.zeros(3), np.eye(3))], "contact"))
    return [*found, *((wheel, nodes, "air") for wheel, nodes, _ in found[-1:])]


def wheel_with(law, compiled, own_record, prepare, **fields):
    """Return the Kind of a wheel with a SlipLaw.

    ``compiled(law)``: its ``residual`` and ``observe``; ``own_record``: fields of its record besides the axis, the
    radial force and those of the law, all but the last from ``prepare``; ``fields``: of the Kind.
    """
    return Kind(
        section="elements", dtype=record(axis=3, **own_record, **RADIAL_RECORD, **law.record),
        phases=PHASES, events=EVENTS,
        prepare=lambda d, nodes, context: {**prepare(d, nodes, context), **law.prepare(d["tire_law"], context)},
        **named(limits, end_conditions),
        **compiled(law),
        **fields,
    )  # fmt: skip


def wheel_on_ground(law, compiled, **fields):
    """Return the Kind of a wheel of ``wheel_with`` on a ground."""
    return wheel_with(
        law, compiled,
        display=TYRE_DISPLAY, layout=("x0", "R0"),
        fields=FIELDS,
        start_warnings=start_warnings,
        event_values=contact_of(law)[1],
        **fields,
    )  # fmt: skip


def by_slip_law(make, first):
    """Return the Kind ``make(first)`` of a wheel with the SlipLaw ``first``, and ``make(law)`` as its variants."""

    @cache
    def named(law):
        kind = make(law)
        return replace(kind, name=f"{kind.name}_{law.name}")

    def variant(d):
        law = slip_law_of(d["tire_law"])
        return wheel if law is first else named(law)

    wheel = replace(make(first), variant=variant)
    return wheel
