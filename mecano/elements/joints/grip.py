r"""Grip: holds node b in node a on command, in their relative position at that instant: a gripper, a docking port.

It closes at a time or by a condition with a shock (docs/shocks.md): momentum is exchanged, and the kinetic energy of
the relative motion is lost. From then on the relative position :math:`d = R_a^T (x_b - x_a)` and the relative rotation
:math:`R_a^T R_b` are held at those of that instant, :math:`d_0` and :math:`Q_0 = \exp\hat\psi_0`:

.. math::  d - d_0 = 0, \qquad \tfrac12 \operatorname{axial}(S - S^T) = 0, \quad S = Q_0^T R_a^T R_b

until it opens, without a shock. With ``close``, and perhaps ``release``, it closes once, and opens at most once; it
does not close while the command of its release holds. With ``while`` it closes whenever the condition becomes true and
opens whenever it becomes false. With ``rotation: false`` it holds the position alone, as a hook does; then node b needs
no orientation.
"""

from dataclasses import replace

from mecano.constraints.along_coordinate.trigger import TRIGGER, check_trigger, trigger_of
from mecano.constraints.augmented_lagrangian import add_reaction, times_penalty
from mecano.constraints.coordinates.coordinate import rate_of
from mecano.element_interface import LOCK, RELEASES, Display, Event, Kind, Output, Row, named, record
from mecano.jit.kernel import kernel
from mecano.laws.formula import difference_of
from mecano.maths.so3 import exp, log
from mecano.maths.vector import Vec3, cross, mat, put, vec
from mecano.schema import BOOLEAN, CONDITION, NODE_PAIR, Field

OPEN, CLOSED = 0, 1
PHASES = ("open", "closed", "released")
LAYOUT = ("x0", "R0", "x1", "R1")
FOR_EVER, UNTIL_RELEASED, WHILE = 0.0, 1.0, 2.0  # how long it is closed
NEVER = -1.0  # value of an event that does not occur
UNIT = (Vec3(1.0, 0.0, 0.0), Vec3(0.0, 1.0, 0.0), Vec3(0.0, 0.0, 1.0))


@kernel
def _position(at):
    """Return the position of b relative to a, in the axes of a."""
    return mat(at.R[0]).T @ (vec(at.q, 6) - vec(at.q, 0))


@kernel
def _gradient_of_position(at, i):
    """Return the gradient of component i of the relative position, by blocks of the local unknowns."""
    along = mat(at.R[0]) @ UNIT[i]
    return (0, -along), (3, cross(UNIT[i], _position(at))), (6, along)


@kernel
def _turned(at):
    """Return S, the rotation of b relative to a since the grip closed, in axes of b."""
    return exp(vec(at.m, 3)).T @ (mat(at.R[0]).T @ mat(at.R[1]))


@kernel
def _turn(S):
    """Return half of the axial vector of S - S^T."""
    return Vec3(0.5 * (S[2][1] - S[1][2]), 0.5 * (S[0][2] - S[2][0]), 0.5 * (S[1][0] - S[0][1]))


@kernel
def _moment_on_b(S, moment):
    """Return the material moment on b of the multipliers ``moment`` of the turn: (tr S - S) moment / 2."""
    return 0.5 * ((S[0][0] + S[1][1] + S[2][2]) * moment - S @ moment)


@kernel
def _gradient_of_turn(at, S, i):
    """Return the gradient of component i of the turn, by blocks of the local unknowns."""
    on_b = _moment_on_b(S, UNIT[i])
    return (3, -(mat(at.R[0]).T @ (mat(at.R[1]) @ on_b))), (9, on_b)


def _holding(force, moment, turns):
    """Return ``residual`` and ``constraints`` of a grip whose multipliers have these local indices.

    It holds the rotation, too, if it ``turns``.
    """
    end = moment + 3 if turns else moment

    @kernel
    def residual(p, at, f):
        """Add the reactions of a closed grip; of an open one, the multipliers are zero."""
        if at.phase != CLOSED:
            for row in range(force, end):
                f[row] -= at.q[row]
            return
        Phi = _position(at) - vec(at.m, 0)
        for i in range(3):
            add_reaction(f, at, force + i, Phi[i], _gradient_of_position(at, i))
        if turns:
            S = _turned(at)
            Phi, stiffer = _turn(S), times_penalty(at, p.lever * p.lever)
            for i in range(3):
                add_reaction(f, stiffer, moment + i, Phi[i], _gradient_of_turn(at, S, i))

    @kernel
    def constraints(p, at, g):
        """Write the constraints of a closed grip and their rates."""
        if at.phase != CLOSED:
            return
        Phi = _position(at) - vec(at.m, 0)
        for i in range(3):
            g[i, 0], g[i, 1] = Phi[i], rate_of(_gradient_of_position(at, i), at.v)
        if turns:
            S = _turned(at)
            Phi = _turn(S)
            for i in range(3):
                g[3 + i, 0], g[3 + i, 1] = Phi[i], rate_of(_gradient_of_turn(at, S, i), at.v)

    return residual, constraints


def _functions(layout, turns):
    """Return the functions of a grip of nodes with this layout, which holds the rotation, too, if it ``turns``."""
    command = 3 * len(layout)
    force, moment = command + 2, command + 5
    residual, constraints = _holding(force, moment, turns)

    @kernel
    def observe(p, at, F, y, e):
        """Write force and moment on b, and the state."""
        put(y, 0, mat(at.R[0]) @ vec(at.q, force))
        if turns and at.phase == CLOSED:
            put(y, 3, mat(at.R[1]) @ _moment_on_b(_turned(at), vec(at.q, moment)))
        y[6] = 1.0 if at.phase == CLOSED else 0.0

    @kernel
    def event_values(p, at, g):
        """Write the numbers of the events, from the commands to close and to open."""
        closing, opening = at.q[command], at.q[command + 1]
        g[0] = min(closing, -opening) if p.duration == UNTIL_RELEASED else closing
        g[1] = opening if p.duration == UNTIL_RELEASED else NEVER
        g[2] = -closing if p.duration == WHILE else NEVER

    @kernel
    def commit(p, at, m_out):
        """Keep the relative position, and rotation, of the last step before it closed."""
        put(m_out, 0, vec(at.m, 0) if at.phase == CLOSED else _position(at))
        if turns:
            put(m_out, 3, vec(at.m, 3) if at.phase == CLOSED else log(mat(at.R[0]).T @ mat(at.R[1])))

    return named(residual, constraints, observe, event_values, commit)


def prepare(d, nodes, context):
    """Return the record of one grip."""
    duration = WHILE if d["while"] is not None else FOR_EVER if d["release"] is None else UNTIL_RELEASED
    return {"duration": duration, "lever": context.length}


def reads(d):
    """Return the formulas that rise through zero when the grip closes and when it is released."""
    if d["while"] is not None:
        return [difference_of(d["while"])] * 2
    return [trigger_of(d["close"]), trigger_of(d["release"] or d["close"])]


def check(d, nodes):
    """Return errors for a grip that has no command, two of them, or one with neither or both of time and condition."""
    texts = [] if (d["close"] is None) != (d["while"] is None) else ["give either 'close' or 'while'"]
    if d["release"] is not None and d["while"] is not None:
        texts.append("'release' and 'while' exclude one another: it opens when the condition of 'while' is false")
    closes, opens = ((d[name] or {}).get("time") for name in ("close", "release"))
    if closes is not None and opens is not None and opens <= closes:
        texts.append(f"'release.time' must be later than 'close.time', {closes:g} s")
    return texts + [text for name in ("close", "release") for text in check_trigger(name, d[name])]


CLOSING, OPENING = ({"time": time, "when": None} for time in (0.3, 0.5))  # of samples
GRIP = Kind(
    name="grip", section="joints", doc=__doc__, display=Display(support=False, force="force"),
    dtype=record(duration=(), lever=()), layout=LAYOUT,
    fields=(
        Field("nodes", NODE_PAIR, "-", "node a, which grips, and node b, which is held"),
        Field("close", TRIGGER, "-", "when it closes: {time: ...} or {when: ...}", None),
        Field("release", TRIGGER, "-", "when it opens for good: {time: ...} or {when: ...}; never when absent", None),
        Field("while", CONDITION, "-", "condition on signals, outputs and motions: closed while it is true", None),
        Field("rotation", BOOLEAN, "-", "whether it also holds the rotation of b", True),
    ),
    outputs=(
        Output("force", "N", "force of a on b, inertial axes", (3,)),
        Output("moment", "N m", "moment of a on b, inertial axes", (3,)),
        Output("closed", "-", "1 while it holds b, otherwise 0"),
    ),
    multipliers=(
        *(Row(f"force of the grip along axis {i} of a", "N", "m") for i in (1, 2, 3)),
        *(Row(f"moment of the grip about axis {i} of b", "N m", "rad") for i in (1, 2, 3)),
    ),
    inputs=("closing", "opening"),
    phases=PHASES,
    events=(
        Event("closes", "open", "closed", "the command to close; a shock", LOCK, condition=True),
        Event(RELEASES, "closed", "released", "the command to release", condition=True),
        Event("opens", "closed", "open", "the condition becomes false", condition=True),
    ),
    memory=tuple(f"held_{i}" for i in range(1, 7)),
    variant=lambda d: GRIP if d["rotation"] else POSITION_GRIP,
    cases=(
        {"close": CLOSING, "release": OPENING},
        {"close": CLOSING, "release": OPENING, "rotation": False},
        {"close": CLOSING},
        {"while": "time > 0.3"},
    ),
    **named(reads, prepare, check),
    **_functions(LAYOUT, True),
)  # fmt: skip
POSITION_GRIP = replace(
    GRIP, name="position_grip", layout=LAYOUT[:3], multipliers=GRIP.multipliers[:3], memory=GRIP.memory[:3],
    **_functions(LAYOUT[:3], False),
)  # fmt: skip
