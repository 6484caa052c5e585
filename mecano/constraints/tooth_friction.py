r"""Friction of meshing teeth or of a thread, proportional to the force that it transmits: its efficiency.

With the force N of the teeth and the mean travel w of both pitch circles relative to the carrier:

.. math::  F_r = \mu\,|N|\,\phi(|\dot w|)\,\mathrm{sign}\,\dot w, \qquad \mu = 2\,\frac{1 - \eta}{1 + \eta}, \qquad
           P_{dissipated} = F_r\,\dot w

with :math:`\phi(u) = (u/\epsilon)(2 - u/\epsilon)` below the speed :math:`\epsilon` of the ``regularization``, 1
beyond. Half of :math:`F_r` acts against each of the gears, so that the driving one pushes with :math:`N(1 + \mu/2)`
and the driven one receives :math:`N(1 - \mu/2)`: their ratio is the efficiency :math:`\eta` of the direction in which
power passes, forward if :math:`N\dot w > 0`. The force is continuous where the direction changes, as N or
:math:`\dot w` is zero there. With a backdriving efficiency :math:`\eta_b \le 0` the mesh locks itself: driven backward,
it creeps at the speed at which :math:`\mu\phi = 2`, without a force on the forward driver.
"""

from mecano.constraints.along_coordinate.stops import UPPER
from mecano.constraints.coordinates.coordinate import add_along, rate_of
from mecano.element_interface import Kind
from mecano.jit.kernel import kernel
from mecano.laws.friction import regularization, sticking
from mecano.maths.dual import number, value
from mecano.schema import NUMBER, Field, mapping, requirement


@kernel
def tooth_friction(p, N, rate):
    """Return F_r [N] for the force N with which part 0 pushes part 1 [N] and the rate of the mean travel [m/s]."""
    loss = p.loss[0] if value(N) * value(rate) > 0.0 else p.loss[1]
    return loss * abs(N) * sticking(p.regularization, abs(rate)) * rate


@kernel
def push(phase, reaction):
    """Return the force with which part 0 pushes part 1 [N], of teeth without play or of flanks (backlash.py)."""
    return reaction if phase == UPPER else -reaction


def tooth_friction_kind(mesh, dtype):
    """Return the Kind of the friction of rigid teeth, to whose force it is coupled; ``mesh`` as in gear_teeth.py.

    For teeth with backlash, replace its phases by those of the flanks.
    """
    travel, row = mesh.travel, 3 * len(mesh.held.layout)

    @kernel
    def residual(p, at, f):
        _, (_, along) = travel(p, at)
        add_along(f, tooth_friction(p, push(at.phase, number(at.q[row])), rate_of(along, at.v)), along)

    @kernel
    def observe(p, at, F, y, e):
        _, (_, along) = travel(p, at)
        rate = rate_of(along, at.v)
        e[2] = tooth_friction(p, push(at.phase, at.q[row]), rate) * rate

    return Kind(
        name=f"{mesh.held.name}_friction", doc=__doc__, dtype=dtype, layout=mesh.held.layout,
        coupled_multipliers=mesh.held.multipliers, memory=mesh.held.memory, commit=mesh.held.commit,
        residual=residual, observe=observe,
    )  # fmt: skip


EFFICIENT = requirement(lambda eta: 0.0 < eta <= 1.0, "must be greater than 0 and at most 1")
BACKDRIVING = requirement(
    lambda eta: -1.0 < eta <= 1.0, "must be greater than -1 and at most 1; 0 or less is self-locking"
)


def friction_field(backward, speed, doc):
    """Return the field ``friction``; ``backward`` and ``speed`` describe backward power and the regularization."""
    return Field(
        "friction",
        mapping(
            Field("efficiency", NUMBER, "-", "power received by the driven part over the power of the driving part",
                  check=EFFICIENT),
            Field("backdriving_efficiency", NUMBER, "-", f"the same if power passes {backward}; 0 or less: "
                  "self-locking; 'efficiency' when absent", None, BACKDRIVING),
            speed,
        ),
        "-", f"{doc}; none when absent", None,
    )  # fmt: skip


FRICTION = friction_field(
    "from gear b to a, from the rack to the pinion, or from the thrust to the turning of a screw",
    regularization("speed of the pitch circle, or along the axis of a screw, the mean of both parts,"),
    "friction proportional to the force of the teeth or the thread",
)


def friction_values(friction, driver):
    """Return the values loss (mu if part 0 drives, if part 1 does) and regularization of a record from the deck.

    ``friction`` is that of the deck or None, ``driver`` the part (0, 1) that drives if power passes forward.
    """
    if friction is None:
        return {"loss": (0.0, 0.0), "regularization": 1.0}
    eta, back = friction["efficiency"], friction["backdriving_efficiency"]
    mu = [2.0 * (1.0 - e) / (1.0 + e) for e in (eta, eta if back is None else back)]
    return {"loss": mu[::-1] if driver else mu, "regularization": friction["regularization"]}
