r"""Backlash of rigid teeth: the flanks do not touch within a play, and meet at its ends with a shock.

With the transmission error s, by which the pitch circle of the first gear is ahead of that of the second one, and the
play j, half of it on each side at the start:

.. math::  -j/2 \le s \le j/2

On a flank, the constraint holds the s at the end of the last step before the event, the memory of the part. It pushes,
rebounds with the coefficient of ``restitution``, and opens where the force of the teeth falls to zero.
"""

from mecano.constraints.along_coordinate.stops import STOP_PHASES, put_end_events, side_of, stop_events
from mecano.constraints.augmented_lagrangian import held_from_event
from mecano.element_interface import Kind, Row
from mecano.jit.kernel import kernel

EVENTS = stop_events("flank", "force of the teeth")


def backlash_kind(mesh):
    """Return the Kind of the flanks of rigid teeth; ``mesh`` as in gear_teeth.py."""
    travel, row, kept = mesh.travel, 3 * len(mesh.held.layout), len(mesh.held.memory)
    commit_angles = mesh.held.commit or _keep_nothing

    @kernel
    def side(p, at):
        return side_of(at.phase)

    @kernel
    def error(p, at):
        return travel(p, at)[0]

    held = held_from_event(error, row, side, kept)
    commit_error = held["commit"]

    @kernel
    def commit(p, at, m_out):
        commit_angles(p, at, m_out)
        commit_error(p, at, m_out)

    return Kind(
        name=f"{mesh.held.name}_backlash", doc=__doc__, dtype=mesh.held.dtype, layout=mesh.held.layout,
        multipliers=(Row(mesh.held.multipliers[0].name, "N", "m", unilateral=True),), phases=STOP_PHASES,
        memory=(*mesh.held.memory, "held"), **held | {"commit": commit},
    )  # fmt: skip


@kernel
def _keep_nothing(p, at, m_out):
    pass


def backlash_events(mesh):
    """Return ``event_values`` of ``EVENTS`` for the joint that owns the flanks."""
    travel, row = mesh.travel, 3 * len(mesh.held.layout)

    @kernel
    def event_values(p, at, g):
        put_end_events(g, -p.half_play, p.half_play, travel(p, at)[0][0], at.q[row])

    return event_values
