"""The tread of a wheel over its ground: flat, a disc, or rounded, a torus."""

from types import SimpleNamespace
from typing import NamedTuple

import numpy as np

from mecano.constraints.ground import prepare_ground, touch
from mecano.constraints.torus import touch_torus
from mecano.constraints.triads import unit
from mecano.element_interface import Context
from mecano.jit.kernel import kernel
from mecano.laws.law_table import LawTable
from mecano.maths.dual import constant
from mecano.maths.surface import Contact
from mecano.maths.vector import Vec3, dot


class Tread(NamedTuple):
    """The tread of a wheel and the ground; 3-vectors in the inertial frame."""

    g: Contact
    lowest: tuple  # from the centre to the lowest point of the undeformed tread [m]
    height: float  # of the centre over the ground, along the normal at C [m]
    tilt: float  # F_r/N: q for a radial force in the plane of the wheel, 1 for one along the normal


@kernel
def flat(p, g):
    """Return the Tread of a disc at the Contact ``g``."""
    return Tread(g, p.radius * g.c, g.r * g.q, g.q)


@kernel
def rounded(p, g):
    """Return the Tread of a torus at the Contact ``g`` of ``torus_contact``."""
    return Tread(g, (p.radius - p.crown) * g.c - p.crown * g.n, -dot(g.n, g.arm), constant(1.0, g.q))


@kernel
def flat_on_ground(p, laws, x, a):
    """Return the Tread of a disc of centre ``x`` and axis ``a`` on the ground with record ``p``."""
    return flat(p, touch(p, laws, x, a))


@kernel
def rounded_on_ground(p, laws, x, a):
    """Return the same of a torus."""
    return rounded(p, touch_torus(p, laws, x, a))


def tread_above(ground, radius, crown, x, axis):
    """Return the height [m] of a tread above the ``ground``, as its deformation is counted, and along the normal.

    They are negative below the ground. ``radius`` [m] includes the ``crown`` radius [m], 0 for a disc; centre ``x``
    (3,) [m] and ``axis`` (3,) must have passed ``check_axle``.
    """
    laws, tread_on_ground = LawTable(), rounded_on_ground if crown else flat_on_ground
    p = SimpleNamespace(radius=radius, **prepare_ground(ground, Context(laws, np.zeros(3)), crown))
    tread = tread_on_ground(p, laws.array(), Vec3(*np.array(x, float)), Vec3(*unit(axis)))
    gap = tread.g.r - radius
    return gap, gap * tread.tilt
