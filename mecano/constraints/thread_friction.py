r"""Friction of a thread, proportional to its force: the efficiency of a screw that turns its nut, or is turned by it.

With the force N of the thread along the axis, :math:`h = P/2\pi` and the mean travel :math:`w = (s + h\theta)/2`,

.. math::  F_r = \mu\,|N|\,\phi(|\dot w|)\,\mathrm{sign}\,\dot w, \qquad \mu = 2\,\frac{1 - \eta}{1 + \eta}

half of which acts against the sliding s, and :math:`h F_r/2` against the rotation: the ratio of the power received to
the power given is :math:`\eta`, or :math:`\eta_b` if the thrust drives. :math:`\phi(u) = (u/\epsilon)(2 - u/\epsilon)`
below the speed :math:`\epsilon` of the ``regularization``, 1 beyond. With the lead angle :math:`\gamma` and the
friction angle :math:`\rho` of the thread,

.. math::  \eta = \frac{\tan\gamma}{\tan(\gamma + \rho)}, \qquad \eta_b = \frac{\tan(\gamma - \rho)}{\tan\gamma}

if the moment drives the thrust, and the reverse.
"""

from dataclasses import replace

from mecano.constraints.along_coordinate.friction import FRICTION_FORCE, FRICTION_MOMENT, POWER
from mecano.constraints.coordinates.coordinate import rate_of
from mecano.constraints.gear_teeth import Mesh
from mecano.constraints.geared_slide import GEARED_SLIDE, MULTIPLIER, slide_travel
from mecano.constraints.of_coordinates import BOTH
from mecano.constraints.tooth_friction import friction_values, tooth_friction, tooth_friction_kind
from mecano.element_interface import Part, with_fields
from mecano.jit.kernel import kernel

THREAD = Mesh(GEARED_SLIDE, slide_travel, driver=1)


@kernel
def observe(p, at, F, y, e):
    """Write friction and its power."""
    _, (_, along) = slide_travel(p, at)
    rate = rate_of(along, at.v)
    drag = tooth_friction(p, -at.q[MULTIPLIER], rate)
    y[0], y[1], y[2] = 0.5 * drag, 0.5 * p.travel * drag, drag * rate
    e[2] = y[2]


THREAD_FRICTION = replace(
    tooth_friction_kind(THREAD, with_fields(GEARED_SLIDE.dtype, loss=2, regularization=())),
    name="thread_friction", doc=__doc__, outputs=(FRICTION_FORCE, FRICTION_MOMENT, POWER), observe=observe,
)  # fmt: skip


def thread_friction_parts(friction, thread, row):
    """Return [Part] for the deck's ``friction``, or []; ``thread`` are the values of the thread, the part ``row``."""
    if friction is None:
        return []
    values = {**thread, **friction_values(friction, THREAD.driver)}
    return [Part(THREAD_FRICTION, BOTH, values, coupled_to=(row,))]
