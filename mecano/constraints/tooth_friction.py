r"""Friction of meshing teeth, proportional to the force that they transmit: the efficiency of a gear stage.

With the force N of the teeth and the mean travel w of both pitch circles relative to the carrier:

.. math::  F_r = \mu\,|N|\,\phi(|\dot w|)\,\mathrm{sign}\,\dot w, \qquad \mu = 2\,\frac{1 - \eta}{1 + \eta}, \qquad
           P_{dissipated} = F_r\,\dot w

with :math:`\phi(u) = (u/\epsilon)(2 - u/\epsilon)` below the speed :math:`\epsilon` of the ``regularization``, 1
beyond. Half of :math:`F_r` acts against each of the gears, so that the driving one pushes with :math:`N(1 + \mu/2)`
and the driven one receives :math:`N(1 - \mu/2)`: their ratio is the efficiency :math:`\eta`, whichever of them drives.
"""

from mecano.constraints.coordinates.coordinate import add_along, rate_of
from mecano.element_interface import Kind
from mecano.jit.kernel import kernel
from mecano.laws.friction import regularization, sticking
from mecano.maths.dual import number
from mecano.schema import NUMBER, Field, mapping


@kernel
def tooth_friction(p, N, rate):
    """Return F_r [N] for the force N of the teeth [N] and the rate of the mean travel [m/s]."""
    return p.loss * abs(N) * sticking(p.regularization, abs(rate)) * rate


def tooth_friction_kind(mesh, dtype):
    """Return the Kind of the friction of rigid teeth, to whose force it is coupled; ``mesh`` as in gear_teeth.py."""
    travel, row = mesh.travel, 3 * len(mesh.held.layout)

    @kernel
    def residual(p, at, f):
        _, (_, along) = travel(p, at)
        add_along(f, tooth_friction(p, number(at.q[row]), rate_of(along, at.v)), along)

    @kernel
    def observe(p, at, F, y, e):
        _, (_, along) = travel(p, at)
        rate = rate_of(along, at.v)
        e[2] = tooth_friction(p, at.q[row], rate) * rate

    return Kind(
        name=f"{mesh.held.name}_friction", doc=__doc__, dtype=dtype, layout=mesh.held.layout,
        coupled_multipliers=mesh.held.multipliers, memory=mesh.held.memory, commit=mesh.held.commit,
        residual=residual, observe=observe,
    )  # fmt: skip


def _efficiency(value):
    return None if 0.0 < value <= 1.0 else "must be greater than 0 and at most 1"


FRICTION = Field(
    "friction",
    mapping(
        Field("efficiency", NUMBER, "-", "power that the driven part receives over that of the driving one, in either "
              "direction", check=_efficiency),
        regularization("speed of the pitch circle"),
    ),
    "-", "friction of the teeth, proportional to the force that they transmit; none when absent", None,
)  # fmt: skip


def friction_values(friction):
    """Return the values loss (mu) and regularization of a record from the deck's ``friction``, or None."""
    if friction is None:
        return {"loss": 0.0, "regularization": 1.0}
    eta = friction["efficiency"]
    return {"loss": 2.0 * (1.0 - eta) / (1.0 + eta), "regularization": friction["regularization"]}
