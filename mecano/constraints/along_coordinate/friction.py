"""Coulomb friction driven by the reactions of a joint: code shared by all kinds of friction."""

from mecano.constraints.coordinates.coordinate import add_along, rate_of
from mecano.element_interface import Kind, Output, Row, record
from mecano.jit.kernel import kernel
from mecano.laws.friction import friction, regularization
from mecano.laws.probe import negative_curves
from mecano.maths.dual import sqrt
from mecano.schema import CURVE, NUMBER, REQUIRED, Field, mapping, not_negative, positive

FRICTION_RECORD = {"coefficient": "i", "regularization": (), "inverse_length": ()}
PADS = r"""
Two pads are at the ends of the bearing or guide, of length :math:`\ell`, around node b. With the force F across the
axis and the couple that the joint transmits, written as the vector m of the multipliers that hold the axis
(:math:`m_i` acts along :math:`\mu_i \cdot \xi_3`), the sum of their normal forces is

.. math::  N = |F/2 + m/\ell| + |F/2 - m/\ell|

which is :math:`|F|` if no length is given.
"""
REGULARIZED = r"""
The friction is regularized at rest after Oden & Martins 1985: :math:`\phi(u) = (u/\epsilon)(2 - u/\epsilon)` for
sliding speeds :math:`u < \epsilon`, 1 beyond. A sticking joint creeps at the speed at which friction
balances the load. :math:`\mu` may depend on the speed. The magnitudes of forces are exact, with a corner where they
vanish; the derivative is taken as zero there.
"""
AXIS_ROWS = (
    Row("moment that keeps the axes together, of mu_1", "N m", "rad"),
    Row("moment that keeps the axes together, of mu_2", "N m", "rad"),
)
FORCE_ROWS = tuple(Row(f"force along mu_{i}", "N", "m") for i in (1, 2, 3))
FRICTION_MOMENT = Output("friction_moment", "N m", "friction moment; > 0 against a positive rate of the angle")
FRICTION_FORCE = Output("friction_force", "N", "friction force along the axis; > 0 against a positive velocity")
NORMAL_FORCE = Output(
    "normal_force", "N", "sum of the forces of both ends of the bearing or guide across its axis, and of a key"
)
POWER = Output("dissipated_power", "W", "power dissipated by friction")


@kernel
def pads(F_1, F_2, m_1, m_2, inverse_length):
    """Return N [N] of both pads."""
    a_1, a_2 = 0.5 * F_1 + inverse_length * m_1, 0.5 * F_2 + inverse_length * m_2
    b_1, b_2 = 0.5 * F_1 - inverse_length * m_1, 0.5 * F_2 - inverse_length * m_2
    return sqrt(a_1 * a_1 + a_2 * a_2) + sqrt(b_1 * b_1 + b_2 * b_2)


@kernel
def drag(p, laws, velocity):
    """Return friction over normal force, odd in the sliding velocity [m/s]."""
    return friction(laws, p.coefficient, p.regularization, abs(velocity)) * velocity


def friction_kind(name, doc, coordinate, values, coupled_multipliers, output, load):
    """Return the Kind of friction along one coordinate.

    ``load(p, at, rate)`` returns the force against a rate of the coordinate and the normal force that causes it [N, N
    m]. It reads the ``coupled_multipliers`` from ``at.q``, after the unknowns of the coordinate's layout: from q[9] on
    for a slide (x0, R0, x1), from q[12] on with both rotations. ``values`` are the fields of the record other than the
    axes and FRICTION_RECORD, ``output`` is the Output of the force.
    """
    gradient = coordinate.gradient

    @kernel
    def residual(p, at, f):
        along = gradient(p, at)
        add_along(f, load(p, at, rate_of(along, at.v))[0], along)

    @kernel
    def observe(p, at, F, y, e):
        rate = rate_of(gradient(p, at), at.v)
        force, normal = load(p, at, rate)
        y[0], y[1], y[2] = force, normal, force * rate
        e[2] = force * rate

    return Kind(
        name=name, doc=doc, dtype=record(**coordinate.axes, **values, **FRICTION_RECORD),
        layout=coordinate.layout, coupled_multipliers=coupled_multipliers, outputs=(output, NORMAL_FORCE, POWER),
        residual=residual, observe=observe,
    )  # fmt: skip


def friction_fields(*geometry):
    """Return the field ``friction`` of a joint; ``geometry`` are the fields that the joint adds."""
    given = (
        Field("coefficient", CURVE, "-", "coefficient of friction, a number or a curve of the sliding speed [m/s]",
              argument="m/s"),
        regularization(),
        *geometry,
    )  # fmt: skip
    doc = "Coulomb friction, from the normal forces; none when absent"
    return Field("friction", mapping(*given), "-", doc, None)


def radius(name, doc, default=REQUIRED):
    """Return the field of a radius at which friction acts."""
    return Field(name, NUMBER, "m", doc, default, not_negative if default == 0.0 else positive)


LENGTH = Field(
    "length", NUMBER, "m",
    "length of the bearing or guide, centred at node b, whose ends carry the couple; when absent the couple causes no "
    "friction", None, positive,
)  # fmt: skip


def friction_record(friction, context, names):
    """Return the values of the fields ``names`` of a record that follow from the deck's friction.

    Of the lengths that the deck may omit the record has the inverses, which are then zero.
    """
    lengths = {name: friction.get(name) for name in ("length", "key_radius")}
    inverses = {f"inverse_{name}": 0.0 if length is None else 1.0 / length for name, length in lengths.items()}
    values = {**friction, **inverses, "coefficient": context.laws.add(friction["coefficient"])}
    return {name: values[name] for name in names if name in values}


def check_friction(d):
    """Return errors in a joint with the fields ``friction`` and ``compliance``."""
    if d["friction"] is None:
        return []
    texts = negative_curves("friction", {"coefficient": d["friction"]["coefficient"]})
    if d.get("compliance"):
        texts.append(
            "'friction' is driven by the reactions of rigid directions: it cannot be combined with 'compliance'; put "
            "the compliance in a second joint, with a node in between"
        )
    return texts
