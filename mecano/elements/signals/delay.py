r"""Delay: the input at an earlier time.

.. math::  y(t) = u(t - T)

Before the start, the input has its initial value; in an equilibrium it has no other. The values of accepted steps are
stored, at most one for each 1/256 of the delay, and both values at events where the input jumps; they are interpolated
by cubics that do not overshoot. In a step longer than the delay, values are interpolated linearly up to the value at
its end. Time steps end where a jump of a 'switch', a 'sample_and_hold' or a law of time arrives.
"""

from mecano.constraints.along_coordinate.signal import signal_of_input
from mecano.element_interface import named
from mecano.jit.kernel import kernel
from mecano.maths.dual import constant, number
from mecano.maths.neighbours import predecessor, successor
from mecano.schema import NUMBER, Field, positive

OWN, U = 0, 1  # local unknowns: the value; the input
KEPT = 256
MOST = 2 * KEPT  # pairs in the memory, with those of jumps
INSTANT = 1e-9  # of the delay: values closer in time are those before and after a jump
SAME_TIME = 1e-12  # of the time: the same, as no step is made between times that are nearer
UNCHANGED = 1e-12  # relative change that is no jump
STEEPEST = 3.0  # slope of a monotone cubic over the smallest adjacent mean slope (Fritsch & Carlson 1980)
COUNT, FIRST = 0, 1  # in the memory: number of pairs (t, u); first of the pairs, which are newest first
ARRIVAL = FIRST + 2 * MOST  # in the memory: time at which the next jump of the input that is kept reaches the value
NEVER = 1e300  # s


@kernel
def residual(p, at, f):
    """Add the equation of the value."""
    u, m, t = number(at.q[U]), at.m, at.t - p.time
    newest = m[FIRST]
    if m[COUNT] == 0.0:
        y = u
    elif t >= newest:
        w = (t - newest) / (at.t - newest) if at.t > newest else 1.0
        y = (1.0 - w) * m[FIRST + 1] + w * u
    else:
        y = constant(_kept(p, m, t), u)
    f[OWN] += number(at.q[OWN]) - y


@kernel
def _kept(p, m, t):
    """Return the value at a time t before the last accepted step, or the oldest one."""
    last = int(m[COUNT]) - 1
    for i in range(last):
        if t >= m[FIRST + 2 * i + 2]:
            return _between(p, m, i, last, t)
    return m[FIRST + 2 * last + 1]


@kernel
def _between(p, m, i, last, t):
    """Return the value at a time t between the pairs i and i + 1: a cubic with the slopes of parabolas at both."""
    length, mean = _chord(m, i)
    instant = _instant(p.time, t)
    if length <= instant:
        return m[FIRST + 2 * i + 1]
    has_later, has_earlier = False, False
    later, earlier = mean, mean
    if i > 0:
        has_later, later = _slope(instant, length, mean, _chord(m, i - 1))
    if i + 1 < last:
        has_earlier, earlier = _slope(instant, length, mean, _chord(m, i + 1))
    if has_earlier and not has_later:
        later = _limited(2.0 * mean - earlier, mean, mean)
    elif has_later and not has_earlier:
        earlier = _limited(2.0 * mean - later, mean, mean)
    w = (t - m[FIRST + 2 * i + 2]) / length
    line = (1.0 - w) * m[FIRST + 2 * i + 3] + w * m[FIRST + 2 * i + 1]
    return line + length * w * (1.0 - w) * ((1.0 - w) * (earlier - mean) - w * (later - mean))


@kernel
def _instant(late, t):
    """Return the distance in time near t below which two pairs are those before and after a jump."""
    return max(INSTANT * late, SAME_TIME * abs(t))


@kernel
def _chord(m, i):
    """Return length and mean slope between the pairs i and i + 1."""
    length = m[FIRST + 2 * i] - m[FIRST + 2 * i + 2]
    return length, (m[FIRST + 2 * i + 1] - m[FIRST + 2 * i + 3]) / length if length > 0.0 else 0.0


@kernel
def _slope(instant, length, mean, beside):
    """Return whether the values do not jump between two chords, and the slope of the parabola there, limited."""
    if beside[0] <= instant:
        return False, mean
    slope = (length * beside[1] + beside[0] * mean) / (length + beside[0])
    return True, _limited(slope, mean, beside[1])


@kernel
def _limited(slope, mean, beside):
    """Return the slope, limited to STEEPEST times the smaller of both adjacent mean slopes."""
    most = STEEPEST * min(abs(mean), abs(beside))
    return min(max(slope, -most), most)


@kernel
def commit(p, at, m_out):
    """Store the pair of this step, which replaces the last one if that is too close to the one before it."""
    count, u, instant = int(at.m[COUNT]), at.q[U], _instant(p.time, at.t)
    jumps = count > 0 and at.t - at.m[FIRST] <= instant
    if not (jumps and abs(u - at.m[FIRST + 1]) <= UNCHANGED * abs(u)):
        _keep(p, at, m_out, count, jumps, instant)
    m_out[ARRIVAL] = _next_arrival(p, m_out, at.t)


@kernel
def _keep(p, at, m_out, count, jumps, instant):
    """Store the pair of this step, newest first."""
    u, apart = at.q[U], at.m[FIRST] - at.m[FIRST + 2]
    if jumps or count < 2 or apart >= p.time / KEPT or apart <= instant:
        for i in range(min(count, MOST - 1)):
            m_out[FIRST + 2 * i + 2], m_out[FIRST + 2 * i + 3] = at.m[FIRST + 2 * i], at.m[FIRST + 2 * i + 1]
        m_out[COUNT] = min(count + 1, MOST)
    m_out[FIRST], m_out[FIRST + 1] = at.t, u


@kernel
def _next_arrival(p, m, now):
    """Return the first time behind ``now`` at which a jump of the input that is kept reaches the value, or NEVER."""
    for i in range(int(m[COUNT]) - 2, -1, -1):
        before = m[FIRST + 2 * i + 2]
        if m[FIRST + 2 * i] - before <= _instant(p.time, before):
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


DELAY = signal_of_input(
    "delay",
    __doc__,
    Field("time", NUMBER, "s", "T, by which the value is late", check=positive),
    same_unit_as=lambda d: d["input"],
    memory=("count", *(f"{name}_{i}" for i in range(MOST) for name in ("time", "value")), "arrival"),
    arrival="arrival",
    **named(residual, commit),
    follows_jumps=True,
    reads_past=True,
)
