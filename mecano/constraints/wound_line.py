r"""Wound line: a cable that is paid out by a winder, that is stopped with a shock at its full length, or both.

Its natural length L is the length paid out, at most the full one, :math:`L_f(t)`. It is

- slack: shorter than L;
- taut: elastic, :math:`N = EA (\varepsilon + \nu) > 0`, with the damping :math:`\nu` of a ``cable``;
- relaxing: without tension after it was taut, by damping, and still longer than L;
- paying out, once the tension has risen to that of the winder, :math:`N = T(\dot\ell)` for the rate of the distance,
  :math:`L = \ell/(1 + T(0)/EA)`, until the nodes stop moving apart or :math:`L = L_f`;
- held: inextensible, :math:`\Phi = L_f - \ell + c = 0`, until its tension, the multiplier, falls to zero. c is the
  excess (or deficit) of its length over :math:`L_f` at the end of the step in which it reached it. The energy of this
  strain, :math:`V = \tfrac12 EA\, c^2/L_f`, remains stored, also when the line goes slack; it is held again at the
  same length.

At the full length it becomes an elastic line without a shock (``stretch``), or exchanges momentum as if it were held
and is then elastic (``shock``) or held (``hold``). The winder dissipates :math:`T \dot\ell - \dot V`. With damping, the
line reaches the tension of the winder at a smaller strain than it has while it is paid out. It takes the larger strain
at once, and this energy is given with the event.
"""

from mecano.constraints import line_phases
from mecano.constraints.augmented_lagrangian import add_reaction
from mecano.constraints.elastic_line import (
    LINE_RECORD,
    add_line_inertia,
    add_strain_energy,
    line_inertia,
    put_line,
    put_line_energy,
    put_no_push,
    strained,
)
from mecano.constraints.line import add_line_force, line
from mecano.constraints.line_phases import is_damped, pulling, put_line_events
from mecano.constraints.stop_phases import FAR
from mecano.element_interface import CONTACT, Event, Kind, Part, Row, record
from mecano.jit.kernel import kernel
from mecano.laws.law_table import curve, evaluate_curve
from mecano.maths.dual import chain, number, select, value

RECORD = record(payout="i", wound=(), start=(), catch="i", **LINE_RECORD)
STRETCH, SHOCK, HOLD = 0, 1, 2
CATCHES = ("stretch", "shock", "hold")
SLACK, TAUT, RELAXING, PAYING, HELD = range(5)
PHASES = ("slack", "taut", "relaxing", "paying out", "held")
FULLY = "is fully uncoiled"
EVENTS = (
    *line_phases.EVENTS,
    Event("pays out", "taut", "paying out", "the tension rises to that of the winder", elastic=True,
          changes_energy=True),
    Event("stops paying out", "paying out", "taut", "the distance stops growing", elastic=True),
    Event(FULLY, "paying out", "taut", "the natural length rises to the full one"),
    Event(FULLY, "paying out", "taut", "the same, with a shock", CONTACT, through="held"),
    Event(FULLY, "paying out", "held", "the same, with a shock", CONTACT),
    Event("becomes taut at full length", "slack", "taut", "the distance rises to the full length; a shock", CONTACT,
          through="held", elastic=True, brief=True),
    Event("becomes taut at full length", "slack", "held", "the distance rises to the full length; a shock", CONTACT,
          brief=True),
    Event("goes slack", "held", "slack", "the tension falls to zero"),
)  # fmt: skip
# [m] natural length; distance minus full length at the last step in which it was not held, and when last held
MEMORY = ("paid_out", "excess", "held")
NEARLY = 1.0 - 1e-8  # of the full length: a smaller remainder is neglected
MORE = 1.0 + 1e-6  # on the tension of the winder, so that round-off does not draw out line after a stop
MULTIPLIER = 6


@kernel
def _full(p, laws, t):
    """Return the full length and its two rates."""
    return evaluate_curve(laws, p.law, t)


@kernel
def _paid_out(p, m, laws, t):
    """Return the natural length, its rate, and whether it is the full one; not valid while paying out."""
    full, rate, _ = _full(p, laws, t)
    if p.wound == 0.0 or m[0] >= NEARLY * full:
        return full, rate, True
    return max(m[0], p.start), 0.0, False


@kernel
def _tension(p, laws, rate):
    """Return the tension of the winder, and the strain of the line that leaves it."""
    return curve(laws, p.payout, rate), curve(laws, p.payout, 0.0) / p.EA


@kernel
def _follows(p, at):
    """Return whether the line has the tension of its strain and rate, slack or not: if no shock makes it taut."""
    return at.phase <= RELAXING and p.damping != 0.0 and p.catch == STRETCH


@kernel
def _strains(p, at, strain, strain_rate):
    return pulling(at.phase == TAUT, _follows(p, at), strain, strain_rate, p.damping)


@kernel
def elastic_residual(p, at, f):
    """Add the tension, except of a held line, inertia and weight."""
    add_line_inertia(p, at.a, f)
    length, rate, (_, u, _) = line(at.q, at.v)
    if at.phase == PAYING:
        add_line_force(f, _tension(p, at.laws, rate)[0], u)
    elif at.phase == TAUT or _follows(p, at):
        L, L_rate, _ = _paid_out(p, at.m, at.laws, at.t)
        add_line_force(f, p.EA * _strains(p, at, *strained(length, rate, L, L_rate))[1], u)


@kernel
def catch_residual(p, at, f):
    """Add the constraint Phi = L_f + c - length; its gradient by the second node opposes the line."""
    if at.phase != HELD:
        f[MULTIPLIER] -= at.q[MULTIPLIER]
        return
    length, _, (_, u, _) = line(at.q, at.v)
    Phi = _full(p, at.laws, at.t)[0] + at.m[1] - length
    add_reaction(f, at, MULTIPLIER, Phi, ((0, u), (3, -u)))


@kernel
def catch_constraints(p, at, g):
    """Write value and rate, including that of the full length."""
    if at.phase == HELD:
        length, rate, _ = line(at.q, at.v)
        full, full_rate, full_second = _full(p, at.laws, value(at.t))
        g[0, 0], g[0, 1] = full + at.m[1] - length, chain(at.t, full_rate, full_second) - rate


@kernel
def observe(p, at, F, y, e):
    """Write length, natural length, strain, tension, stress, state; energies."""
    length, rate, _ = line(at.q, at.v)
    put_line_energy(p, at.q, at.v, e)
    paid, paid_rate, _ = _paid_out(p, at.m, at.laws, at.t)
    paying, leaving = at.phase == PAYING, evaluate_curve(at.laws, p.payout, 0.0)[0] / p.EA
    L = select(paying, length / (1.0 + leaving), paid)
    L_rate = select(paying, rate / (1.0 + leaving), paid_rate)
    strain, strain_rate = strained(length, rate, paid, paid_rate)
    strain, strain_rate = select(paying, leaving, strain), select(paying, 0.0, strain_rate)
    N = p.EA * _strains(p, at, strain, strain_rate)[1]
    elastic = select(at.phase == TAUT or strain > 0.0, p.EA * strain, 0.0)
    N = select(paying, curve(at.laws, p.payout, rate), select(at.phase == HELD, number(at.q[MULTIPLIER]), N))
    stored, kept = 0.5 * p.EA * strain * strain, max(at.m[1], 0.0) / paid
    if paying:
        e[1] += stored * L
        e[2] = N * rate - stored * L_rate
    elif at.phase == HELD:
        e[1] += 0.5 * p.EA * kept * kept * L
        e[3] = -(N + 0.5 * p.EA * kept * kept) * L_rate
    else:
        add_strain_energy(elastic, N - elastic, strain, strain_rate, L, L_rate, e)
    put_line(p, y, length, L, strain, strain_rate, N)
    put_no_push(y)
    y[6] = 2.0 if at.phase == PAYING else 1.0 if at.phase in (TAUT, HELD) else 0.0


@kernel
def event_values(p, at, g):
    """Write strains, tensions over EA, rates and lengths, each in the phase that monitors it."""
    g[:] = -FAR
    length, rate, _ = line(at.q, at.v)
    L, L_rate, full = _paid_out(p, at.m, at.laws, at.t)
    strain, strain_rate = strained(length, rate, L, L_rate)
    if at.phase <= RELAXING:
        put_line_events(g, at.phase == TAUT, strain, strain_rate, p.damping)
    if at.phase == SLACK and full and p.catch != STRETCH:
        g[0], g[10 if p.catch == SHOCK else 11] = -FAR, length - L - at.m[2]
    elif at.phase == TAUT and not full:
        g[5] = _strains(p, at, strain, strain_rate)[1] - MORE * _tension(p, at.laws, 0.0)[1]
    elif at.phase == PAYING:
        g[6] = -rate
        g[7 + p.catch] = length / (1.0 + _tension(p, at.laws, 0.0)[1]) - _full(p, at.laws, at.t)[0]
    elif at.phase == HELD:
        g[12] = -at.q[MULTIPLIER]


@kernel
def commit(p, at, m_out):
    """Write the length paid out, the excess over the full length, and the excess when last held."""
    length = line(at.q, at.v)[0]
    full = _full(p, at.laws, at.t)[0]
    paid = max(at.m[0], p.start)
    m_out[0] = min(length / (1.0 + _tension(p, at.laws, 0.0)[1]), full) if at.phase == PAYING else paid
    m_out[1] = at.m[1] if at.phase == HELD else length - full
    m_out[2] = at.m[1] if at.phase == HELD else at.m[2]


def wound_parts(values):
    """Return the Parts of a wound line: elastic line and constraint at full length; ``values`` of ``RECORD``."""
    return [Part(ELASTIC, (0, 1), values), Part(CATCH, (0, 1), values)]


CATCH = Kind(
    name="line_catch", doc=__doc__, dtype=RECORD, layout=("x0", "x1"),
    multipliers=(Row("tension of the cable at its full length", "N", "m", unilateral=True),),
    phases=PHASES,
    memory=MEMORY,
    residual=catch_residual,
    constraints=catch_constraints,
    commit=commit,
    cases=({"catch": HOLD},),
)  # fmt: skip
ELASTIC = Kind(
    name="wound_line", doc=__doc__, dtype=RECORD, layout=("x0", "x1"), phases=PHASES, memory=MEMORY,
    residual=elastic_residual, inertia=line_inertia, commit=commit, cornered=is_damped,
)  # fmt: skip
