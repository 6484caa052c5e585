r"""Span of a belt that creeps on its pulleys: an elastic line, as of a belt without creep, with the creep c as a state.

A belt runs onto a pulley at the speed u of its surface and sticks to it. Where it leaves the pulley it has the tension
and strain of the next span, so that the same mass per time leaves at another speed. With the tension T of the span,
:math:`T_i` of the other span at pulley i, and the speed :math:`u_i` of the surface of pulley i in the sense from pulley
0 to pulley 1, the span is fed at each pulley that the belt leaves for it,

.. math::
   \dot c = - \max(u_0, 0)\, \frac{T - T_0}{EA + T_0} - \max(-u_1, 0)\, \frac{T - T_1}{EA + T_1}, \qquad
   u_i = -\rho_i \dot\psi_i,

and its stretch is :math:`\Delta + c`. In a steady drive the driven pulley turns at (EA + T_slack)/(EA + T_tight) of the
speed that the radii give. The belt that leaves pulley i at the speed u dissipates
:math:`u\,(T - T_i)^2/(2 (EA + T_i))` on it; the elastic energy that it carries from one span to the next is counted as
given to the latter, and taken from the former: in a steady drive these powers cancel. A pulley at an end of the belt is
a drum, from which it leaves with its own tension.
"""

from dataclasses import replace

from mecano.constraints.belt_span import BELT_END, BELT_SPAN, between_pulleys, observed, tangent_direction, to_a_point
from mecano.constraints.coordinates.coordinate import add_along, rate_of
from mecano.constraints.line_phases import pulled
from mecano.element_interface import Output, named, with_fields
from mecano.jit.kernel import kernel
from mecano.maths.dual import number, select
from mecano.maths.vector import cross, dot, mat, vec

CREEP = Output("creep", "m", "length by which creep has stretched the span since the start")


@kernel
def _surface_speed(at, radius, axes, delta, R, omega):
    """Return the speed u of the surface of a pulley, from the first node to the second [m/s].

    ``axes`` are those of the pulley, R (3, 3) its rotation, ``omega`` the index of its angular velocity in at.v.
    """
    d = R.T @ (vec(at.q, 6) - vec(at.q, 0))
    _, g = tangent_direction(axes, d, delta)
    turning = dot(R @ g, vec(at.v, 6) - vec(at.v, 0)) - dot(cross(d, g), vec(at.v, omega))
    return -radius * turning


@kernel
def _fed(u, T, before, EA):
    """Return the rate [m/s] at which a belt that leaves a pulley at the speed u feeds its span, and the loss [W]."""
    rate = -select(u > 0.0, u, 0.0 * u) * (T - before) / (EA + before)
    return rate, 0.5 * rate * (before - T)


def _creep(first, pulleys):
    """Return the compiled function (p, at, T) -> rate of the creep [m/s] and the power lost [W] at the tension T.

    ``first`` is the local index of the tension of the other span at pulley 0, ``pulleys`` their number.
    """

    @kernel
    def creep(p, at, T):
        u = _surface_speed(at, p.radius_0, mat(p.axes_0), p.radius_1 - p.radius_0, mat(at.R[0]), 3)
        rate, loss = _fed(u, T, number(at.q[first]), p.EA)
        if pulleys > 1:
            u = _surface_speed(at, p.radius_1, mat(p.axes_1), p.radius_1 - p.radius_0, mat(at.R[1]), 9)
            rate_1, loss_1 = _fed(-u, T, number(at.q[first + 1]), p.EA)
            rate, loss = rate + rate_1, loss + loss_1
        return rate, loss

    return creep


def _functions(geometry, own, creep):
    """Return the functions of a span with this ``geometry``, whose creep is the local unknown ``own``."""

    @kernel
    def stretch_of(p, at):
        stretch, along, L, _, _ = geometry(p, at)
        return stretch + number(at.q[own]), rate_of(along, at.v) + number(at.v[own]), along, L

    without_creep = observed(stretch_of)
    put = without_creep["observe"]

    @kernel
    def residual(p, at, f):
        stretch, rate, along, _ = stretch_of(p, at)
        T = p.stiffness * pulled(p, at, stretch, rate)[1]
        add_along(f, T, along)
        f[own] += number(at.v[own]) - creep(p, at, T)[0]

    @kernel
    def observe(p, at, F, y, e):
        """Write tension, stretch, length, closeness, creep, energy, dissipated and given power."""
        put(p, at, F, y, e)
        T = number(y[0])
        loss = creep(p, at, T)[1]
        y[4] = number(at.q[own])
        e[2] += loss
        e[3] = loss + T * number(at.v[own])

    return without_creep | named(residual, observe)


def _creeping(name, doc, span, geometry):
    """Return the Kind of a ``span`` with this ``geometry`` on which the belt creeps."""
    own, pulleys = 3 * len(span.layout), len(span.memory)
    return replace(
        span, name=name, doc=doc, dtype=with_fields(span.dtype, EA=()), outputs=(*span.outputs, CREEP),
        scalars=("creep",), states=("creep",), inputs=("tension_before", "tension_behind")[:pulleys],
        sample=lambda rng: [({**values, "EA": 40.0}, nodes, phase) for values, nodes, phase in span.sample(rng)],
        **_functions(geometry, own, _creep(own + 1, pulleys)),
    )  # fmt: skip


CREEPING_SPAN = _creeping("creeping_span", __doc__, BELT_SPAN, between_pulleys)
CREEPING_END = _creeping(
    "creeping_end", "Span of a belt that creeps between a pulley and a point, see the span.", BELT_END, to_a_point
)
