"""A law along a coordinate between two nodes (sliding, twist, tilt, angle of a pin): force, energies, record.

A coordinate c is given by two compiled functions: its value, ``value(p, at)``, and its gradient, ``gradient(p, at)``, a
tuple of (local index, b (3,)). Its rate is the sum of the b . v. The law gives P(c - natural, dc/dt), which adds P b to
the forces: P > 0 drives the coordinate back.
"""

from mecano.compiled.kernel import kernel
from mecano.constraints.stop_modes import EVENTS, MODES, law_record, put_stop_events
from mecano.contract import Kind, Output
from mecano.laws.table import evaluate_force, law_force, potential
from mecano.maths.vector import add_vec, dot, vec

LAW_RECORD = {"law": "i", "natural": (), "low": (), "high": ()}


@kernel
def rate_of(gradient, v):
    """Rate of a coordinate, from its gradient and the velocities (n_local,)."""
    first, b = gradient[0]
    rate = dot(b, vec(v, first))
    for i, b in gradient[1:]:
        rate = rate + dot(b, vec(v, i))
    return rate


@kernel
def add_along(f, P, gradient):
    """Add the force P [N, N m] along a coordinate."""
    for i, b in gradient:
        add_vec(f, i, P, b)


@kernel
def report(p, laws, coordinate, rate, y, e):
    """Write the force of the law to y[0], potential energy and dissipated power to e."""
    P, _, _ = evaluate_force(laws, p.law, coordinate - p.natural, rate)
    elastic, _, _ = evaluate_force(laws, p.law, coordinate - p.natural, 0.0)
    y[0] = P
    e[1] = potential(laws, p.law, coordinate - p.natural)
    e[2] = (P - elastic) * rate


def law_kind(name, doc, dtype, layout, value, gradient, memory=()):
    """The Kind of a law along a coordinate.

    Its unit is that of a force when the layout has positions; with ``memory`` the value is followed.
    """

    @kernel
    def residual(p, at, f):
        along = gradient(p, at)
        add_along(f, law_force(at.laws, p.law, value(p, at) - p.natural, rate_of(along, at.v)), along)

    @kernel
    def observe(p, at, F, y, e):
        report(p, at.laws, value(p, at), rate_of(gradient(p, at), at.v), y, e)

    @kernel
    def event_values(p, at, g):
        put_stop_events(g, p.low, p.high, value(p, at) - p.natural)

    @kernel
    def commit(p, at, m_out):
        m_out[0] = value(p, at)

    what, unit = ("force", "N") if layout[0][0] == "x" else ("moment", "N m")
    return Kind(
        name=name, section="", doc=doc, dtype=dtype, layout=layout,
        outputs=(Output(f"law_{what}", unit, f"{what} of the law; > 0 drives the coordinate back"),),
        modes=MODES, events=EVENTS, memory=memory,
        residual=residual, observe=observe, event_values=event_values, commit=commit if memory else None,
    )  # fmt: skip


def axis_law_record(law, natural, context):
    """Values of ``LAW_RECORD``."""
    return {"natural": natural, **law_record(law, context)}
