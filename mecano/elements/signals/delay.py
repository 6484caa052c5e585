r"""Delay: the input at an earlier time.

.. math::  y(t) = u(t - T)

Before the start, the input has its initial value; in an equilibrium it has no other. The values of accepted steps are
kept, and both values at events where the input jumps. They are interpolated by polynomials through up to six of them,
on one side of a jump or corner. In a step longer than the delay, values are interpolated linearly up to that at its
end. Time steps end where a jump of a 'switch', a 'sample_and_hold' or a law of time arrives, and at the start + T, ...,
5 T, where the derivatives of the value jump.

Adaptive steps are not longer than T/8, or 10 times 'step' (with Radau IIA 'step'). All steps are kept if T has up to
2000 of the length 'step'; otherwise those apart by T/2048. Of adaptive steps shorter than 'step', those apart by 'step'
are kept, or by T/256.
"""

import math
from dataclasses import replace
from functools import cache

from mecano.constraints.along_coordinate.signal import signal_of_input
from mecano.element_interface import named
from mecano.jit.kernel import kernel
from mecano.maths.dual import constant, number
from mecano.maths.neighbours import predecessor, successor
from mecano.schema import NUMBER, Field, positive

OWN, U = 0, 1  # local unknowns: the value; the input
FEWEST, MOST = 256, 2048  # spacings of the pairs that are kept, in the delay
SPARE = 1.05, 16  # spacings for each step, and more
PER_SPACING = 2  # pairs: those before and after a jump
INSTANT = 1e-9  # of the delay: values closer in time are those before and after a jump
SAME_TIME = 1e-12  # of the time: the same, as no step is made between times that are nearer
UNCHANGED = 1e-12  # relative change that is no jump
MOST_POINTS = 6  # of a polynomial
UNEVEN = 8.0  # times the length of the shortest interval of a polynomial: that in which it is evaluated
PREFERENCE = 3.0  # factor on the difference on the side that has more points
# In the memory: number of pairs (t, u); time at which the next jump of the input that is kept reaches the value; the
# newest pair, of a ring; the first place of the ring.
COUNT, ARRIVAL, NEWEST, FIRST = range(4)
NEVER = 1e300  # s


@kernel
def residual(p, at, f):
    """Add the equation of the value."""
    u, m, t = number(at.q[U]), at.m, at.t - p.time
    if m[COUNT] == 0.0:
        y = u
    elif t >= _time(m, 0):
        newest = _time(m, 0)
        w = (t - newest) / (at.t - newest) if at.t > newest else 1.0
        y = (1.0 - w) * _value(m, 0) + w * u
    else:
        y = constant(_kept(p, m, t), u)
    f[OWN] += number(at.q[OWN]) - y


@kernel
def _place(m, i):
    """Return the place in the memory of the pair i, newest first."""
    pairs = (m.shape[0] - FIRST) // 2
    j = int(m[NEWEST]) - i
    return FIRST + 2 * (j if j >= 0 else j + pairs)


@kernel
def _time(m, i):
    """Return the time of the pair i."""
    return m[_place(m, i)]


@kernel
def _value(m, i):
    """Return the value of the pair i."""
    return m[_place(m, i) + 1]


@kernel
def _kept(p, m, t):
    """Return the value at a time t before the last accepted step, or the oldest one."""
    newer, older = 0, int(m[COUNT]) - 1
    if t < _time(m, older):
        return _value(m, older)
    while older - newer > 1:  # t is between these pairs, or at the older one
        middle = (newer + older) // 2
        if t >= _time(m, middle):
            older = middle
        else:
            newer = middle
    return _between(p, m, newer, t)


@kernel
def _between(p, m, i, t):
    """Return the value at a time t between the pairs i and i + 1.

    The polynomial, in Newton's form, begins with these, and takes up the pair on that side on which its difference is
    smaller (ENO, Harten et al. 1987), preferably on that which has fewer (Shu 1990). It passes over no jumps, and ends
    where differences of higher order become larger.
    """
    last, newer, older, value = int(m[COUNT]) - 1, i, i + 1, _value(m, i + 1)
    length, instant = _time(m, i) - _time(m, older), _instant(p.time, t)
    if length <= instant:
        return _value(m, i)
    slope, least = _difference(m, i, older), max(instant, length / UNEVEN)
    value += (t - _time(m, older)) * slope
    product, scale, largest = (t - _time(m, i)) * (t - _time(m, older)), length, length * abs(slope)
    for order in range(2, MOST_POINTS):
        before = newer > 0 and _time(m, newer - 1) - _time(m, newer) > least
        behind = older < last and _time(m, older) - _time(m, older + 1) > least
        ahead = _difference(m, newer - 1, older) if before else math.inf
        back = _difference(m, newer, older + 1) if behind else math.inf
        forward = abs(ahead) * (PREFERENCE if i - newer > older - i - 1 else 1.0 / PREFERENCE) < abs(back)
        found = ahead if forward else back
        scale *= order * length
        if not (before or behind) or (order > 2 and scale * abs(found) > largest):
            return value
        largest = max(largest, scale * abs(found))
        newer, older = (newer - 1, older) if forward else (newer, older + 1)
        value, product = value + product * found, product * (t - _time(m, newer if forward else older))
    return value


@kernel
def _difference(m, newer, older):
    """Return the divided difference of the pairs ``newer`` ... ``older``."""
    total = 0.0
    for i in range(newer, older + 1):
        product, t = 1.0, _time(m, i)
        for j in range(newer, older + 1):
            if j != i:
                product *= t - _time(m, j)
        total += (_value(m, i) - _value(m, older)) / product
    return total


@kernel
def _instant(late, t):
    """Return the distance in time near t below which two pairs are those before and after a jump."""
    return max(INSTANT * late, SAME_TIME * abs(t))


@kernel
def commit(p, at, m_out):
    """Store the pair of this step, which replaces the last one if that is too close to the one before it."""
    count, u, instant = int(at.m[COUNT]), at.q[U], _instant(p.time, at.t)
    jumps = count > 0 and at.t - _time(at.m, 0) <= instant
    arrival = at.m[ARRIVAL] if count > 0 else NEVER
    if not (jumps and abs(u - _value(at.m, 0)) <= UNCHANGED * abs(u)):
        _keep(p, at, m_out, count, jumps, instant)
        if jumps and arrival == NEVER:
            arrival = _arrival(_time(at.m, 0), p.time)
    m_out[ARRIVAL] = arrival if arrival > at.t else _next_arrival(p, m_out, at.t)


@kernel
def _keep(p, at, m_out, count, jumps, instant):
    """Store the pair of this step."""
    pairs = (m_out.shape[0] - FIRST) // 2
    apart = _time(at.m, 0) - _time(at.m, 1)
    if jumps or count < 2 or apart >= p.time / (pairs // PER_SPACING) or apart <= instant:
        m_out[NEWEST] = at.m[NEWEST] + 1.0 if at.m[NEWEST] < pairs - 1 else 0.0
        m_out[COUNT] = min(count + 1, pairs)
    place = _place(m_out, 0)
    m_out[place], m_out[place + 1] = at.t, at.q[U]


@kernel
def _next_arrival(p, m, now):
    """Return the first time behind ``now`` at which a jump of the input that is kept reaches the value, or NEVER."""
    for i in range(int(m[COUNT]) - 2, -1, -1):
        before = _time(m, i + 1)
        if _time(m, i) - before <= _instant(p.time, before):
            arrival = _arrival(before, p.time)
            if arrival > now:
                return arrival
    return NEVER


@kernel
def _arrival(t, late):
    """Return the first time that is ``late`` by no less than rounding behind t: the value jumps there, not before."""
    found = t + late
    while found - late < t:
        found = successor(found)
    while predecessor(found) - late >= t:
        found = predecessor(found)
    return found


@cache
def _memory(spacings):
    """Return the names of the values of the memory."""
    pairs = range(PER_SPACING * spacings)
    return "count", "arrival", "newest", *(f"{name}_{i}" for i in pairs for name in ("time", "value"))


@cache
def _with_memory(spacings):
    """Return the Kind that keeps so many steps."""
    return replace(DELAY, memory=_memory(spacings))


def kept_steps(d, time):
    """Return how many steps of a run with this section 'time' are kept."""
    own, more = SPARE
    steps = int(min(own * d["time"] / time["step"] + more, MOST))
    return steps if time["adaptive"] is None else max(steps, FEWEST)


def in_run(d, time):
    """Return the Kind whose memory suffices for the steps of a run."""
    return _with_memory(kept_steps(d, time))


def sampling_times(d, start, end):
    """Return the times at which derivatives of the value jump, as it begins to change at the start + T."""
    return [t for n in range(1, 6) if (t := start + n * d["time"]) < end]


DELAY = signal_of_input(
    "delay", __doc__, Field("time", NUMBER, "s", "T, by which the value is late", check=positive),
    same_unit_as=lambda d: d["input"],
    memory=_memory(FEWEST),
    arrival="arrival",
    **named(residual, commit, in_run, sampling_times),
    follows_jumps=True,
    reads_past=True,
)  # fmt: skip
