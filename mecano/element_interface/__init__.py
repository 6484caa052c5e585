"""The interface that every kind of element, joint, load and basic constraint implements.

A ``Kind`` (kind.py) consists of a name, its entry in a deck, its mechanics, its events and its display, with one class
for each of these groups; declarations.py has their values, records.py the records of parameters. This page describes
the functions of a kind, in the order in which an element needs them.

The local unknowns of one element are ordered as follows: the slots of ``layout`` (3 unknowns each; "x0" is the position
of its first node, "R0" its rotation), its ``scalars``, its ``multipliers``, and the multipliers of other parts to which
it is coupled (``coupled_multipliers``). All compiled functions work on ONE element; their first arguments are

    p       record of parameters (``dtype``); a field ``mass`` is the mass of the element [kg]
    at      Place: time, state and memory of the element, all read-only

``residual(p, at, f)`` adds the residual of the equations of motion (internal minus external forces, including inertia)
to ``f`` (n_local,), for numbers and for Duals (maths/dual.py), from which its tangents are derived. Branches on varying
quantities are written with ``select``, roots of equations with ``implicit``. Rotations are varied in the material
frame, dR = R hat(dTheta); the rotation rows of ``f`` are material moments. A constraint Phi with the gradient B adds
B^T (penalty Phi - k lambda) and the row -k Phi. The penalty of a kind whose constraints are all on angles is in N m. A
kind with multipliers has no other stiffness or damping: that of a joint is a separate part.

``inertia(p, at, m)``, if the kind has inertia, writes the diagonal of the mass matrix M to ``m`` (n_local,), zero on
entry: times the accelerations, it is part of the scale against which residuals are judged.

``constraints(p, at, g)`` writes Phi and dPhi/dt = B v to ``g`` (n_multipliers, 2), zero on entry; of a constraint on
velocities, Phi(q, v), it writes Phi in place of dPhi/dt. All constraints of one kind are on positions, or all on
velocities (``Row.constraint_unit`` per second), whose B = dPhi/dv; the loops scale rows and penalty to those of a
displacement. A constraint that is inactive in a phase writes nothing, and adds -k lambda to its row of the residual:
its reaction is zero. Second rates are computed with dual numbers; so that they include the rates of functions of time,
the time is a Dual there, too: ``chain(at.t, rate, second_rate)``.

``observe(p, at, F, y, e)`` writes the outputs to ``y`` (n_outputs,) and the energies to ``e`` (4,), both zero on entry:
kinetic energy [J], potential energy [J], dissipated power [W] (>= 0), power supplied by the surroundings [W].
``F`` (n_local,) are the forces and moments that the rest of the model exerts on the nodes of the element's slots (the
forces that a joint transmits); if all residuals are those of its ``parts``, their multipliers follow its own unknowns
in ``q``, in their order. Signals read outputs by calling it with Duals, with all ``F`` zero; outputs that do not follow
from these are ``hidden``. The energies of an element are those of its own ``observe`` plus those of its parts, whose
outputs are written next to its own.

``event_values(p, at, g)`` writes one number per event; an event that is monitored in the current phase occurs when its
number rises through zero. If all residuals are those of parts, ``q`` is that of ``observe``. The number of an event by
command (``Event.command``) is the value of an input, which the loops write.

An event may involve a *shock* (``Event.shock``): constraints of the element, or of the parts that share its phase,
become active, and momentum is exchanged at fixed positions (docs/shocks.md). The number of such an event is -Phi, or
increases with it; a contact, which can only push, is a ``Row.unilateral``, with Phi >= 0 while it is open and a
reaction >= 0 while it is closed. A contact also has an event for its opening, at which its reaction falls to zero. A
grip holds in both directions until another event releases it, whose number may depend on anything. As positions do not
change during a shock, a constraint may use the memory that its ``commit`` has just written.

``commit(p, at, m_out)`` writes the new memory after an accepted step. If the kind ``follows_jumps`` of its inputs, it
is also called after every event, at the same time or the next number after it. A kind that ``reads_past`` inputs from
its memory takes the current one while the memory is zero, as it is in statics. ``sampling_times`` are those at which
the new memory makes the value jump.

Where a benchmark shows that derivatives by hand pay, ``force(p, at, f, K, C, M)`` replaces ``residual``: it also adds
the exact derivatives K = df/dq, C = df/dv, M = df/da to (n_local, n_local) arrays that are zero on entry. The columns
of multipliers in K are -k B^T; for constraints on velocities, B is in C and -k dPhi/dq in K.

A kind with ``by_lanes`` has ``force`` and ``observe`` compiled for LANES elements at once (jit/lanes.py), which makes
large models faster: each number of ``p``, ``at.q``, ``at.v``, ``at.a``, ``at.R`` and of what is written stands for
those of all these elements; an integer of ``p`` is the largest of theirs. Conditions then differ from element to
element: ``select`` chooses for each of them; ``everywhere`` and ``anywhere`` return whether a condition holds for all
or for any of them, so that a branch may skip what none of them needs. It runs for all where one needs it: what it
writes for the others must still be chosen by ``select``. Such a kind has one phase, no multipliers and no memory.

A part of a joint may depend on the multipliers of other parts of the same joint (friction driven by reactions). These
*coupled multipliers* are at the end of q, in the order of ``Part.coupled_to``. The part adds nothing to their rows;
their columns in K are derivatives with respect to lambda, like those of all multipliers: k times the derivative with
respect to the reaction k*lambda in q. Only a kind with coupled multipliers may let its forces depend on reactions, and
such a kind has no multipliers and no inertia of its own.
"""

from typing import NamedTuple

import numpy as np

from mecano.element_interface.declarations import (
    CONTACT,
    GRIP,
    LOCK,
    POWERS,
    RELEASES,
    WAITS,
    Display,
    Event,
    Measured,
    Output,
    Row,
)
from mecano.element_interface.kind import (
    BY_COMMAND,
    FREELY,
    SECTIONS,
    Context,
    Kind,
    NodeAtStart,
    OwnOutput,
    Part,
    named,
    nothing,
)
from mecano.element_interface.records import UNUSED, record, recorded, recorded_values, with_fields

__all__ = [
    "BY_COMMAND", "CONTACT", "FREELY", "GRIP", "LOCK", "POWERS", "RELEASES", "SECTIONS", "UNUSED", "WAITS", "Context",
    "Display", "Event", "Kind", "Measured", "NodeAtStart", "Output", "OwnOutput", "Part", "Place", "Row", "named",
    "nothing", "record", "recorded", "recorded_values", "with_fields",
]  # fmt: skip


class Place(NamedTuple):
    """Time, state and memory at which a function of an element is evaluated."""

    t: float  # time [s]
    phase: int  # index into ``phases``
    k: float  # scale of the multipliers
    penalty: float  # of the constraints
    laws: np.ndarray  # flat table of all laws of the model (see mecano.laws), and of the matrices of superelements
    m: np.ndarray  # (n_memory,) values written by ``commit`` at the last accepted step
    q: np.ndarray  # (n_local,) positions [m], 0 for rotations, scalars, multipliers k*lambda [N, N m], coupled ones
    v: np.ndarray  # (n_local,) velocities [m/s], material angular velocities [rad/s], rates of scalars, else 0
    a: np.ndarray  # (n_local,) accelerations, in the same frames
    R: np.ndarray  # (n_rotations, 3, 3) rotations, material to inertial, in the order of the "R" slots
