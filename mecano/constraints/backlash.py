r"""Backlash of rigid teeth: the flanks do not touch within a play, and meet at its ends with a shock.

With the transmission error s, by which the pitch circle of the first gear is ahead of that of the second one, and the
play j, half of it on each side at the start:

.. math::  -j/2 \le s \le j/2

On a flank, the constraint holds the s at the end of the last step before the event, the memory of the part. It pushes,
rebounds with the coefficient of ``restitution``, and opens where the force of the teeth falls to zero.
"""

from mecano.constraints.along_coordinate.stops import BETWEEN, LOWER, STOP_PHASES
from mecano.constraints.augmented_lagrangian import scalar_constraint
from mecano.element_interface import CONTACT, Event, Kind, Row
from mecano.jit.kernel import kernel

EVENTS = tuple(
    event
    for side in ("lower", "upper")
    for event in (
        Event(f"meets {side} flank", "between", f"{side} stop", "it rests on the flank or rebounds; a shock", CONTACT,
              "restitution"),
        Event(f"leaves {side} flank", f"{side} stop", "between", "the force of the teeth falls to zero"),
    )
)  # fmt: skip


@kernel
def side_of(phase):
    """Return 1 at the lower flank, -1 at the upper one, the sense in which it pushes s; 0 between."""
    return 0.0 if phase == BETWEEN else 1.0 if phase == LOWER else -1.0


def backlash_kind(mesh):
    """Return the Kind of the flanks of rigid teeth; ``mesh`` as in gear_teeth.py."""
    travel, row, kept = mesh.travel, 3 * len(mesh.held.layout), len(mesh.held.memory)
    commit_angles = mesh.held.commit or _keep_nothing

    @kernel
    def side(p, at):
        return side_of(at.phase)

    @kernel
    def beyond(p, at):
        s, along = travel(p, at)[0]
        return s - at.m[kept], along

    @kernel
    def commit(p, at, m_out):
        commit_angles(p, at, m_out)
        m_out[kept] = travel(p, at)[0][0] if at.phase == BETWEEN else at.m[kept]

    return Kind(
        name=f"{mesh.held.name}_backlash", doc=__doc__, dtype=mesh.held.dtype, layout=mesh.held.layout,
        multipliers=(Row(mesh.held.multipliers[0].name, "N", "m", unilateral=True),), phases=STOP_PHASES,
        memory=(*mesh.held.memory, "held"), commit=commit, **scalar_constraint(beyond, row, side),
    )  # fmt: skip


@kernel
def _keep_nothing(p, at, m_out):
    pass


def backlash_events(mesh):
    """Return ``event_values`` of ``EVENTS`` for the joint that owns the flanks."""
    travel, row = mesh.travel, 3 * len(mesh.held.layout)

    @kernel
    def event_values(p, at, g):
        s = travel(p, at)[0][0]
        g[0], g[1] = -p.half_play - s, -at.q[row]
        g[2], g[3] = s - p.half_play, -at.q[row]

    return event_values
