r"""Delay: the input at an earlier time.

.. math::  y(t) = u(t - T)

Before the start, the input has its initial value. The values of accepted steps are stored, at most one for each 1/256
of the delay, and interpolated linearly. In a step longer than the delay, the value at its end is part of the
interpolation.
"""

from mecano.constraints.along_coordinate.signal import signal_of_input
from mecano.jit.kernel import kernel
from mecano.maths.dual import constant, number
from mecano.schema import NUMBER, Field, positive

OWN, U = 0, 1  # local unknowns: the value; the input
KEPT = 256
COUNT, FIRST = 0, 1  # in the memory: number of pairs (t, u); first of the pairs, which are newest first


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
        y = constant(_kept(m, t), u)
    f[OWN] += number(at.q[OWN]) - y


@kernel
def _kept(m, t):
    """Return the value at a time t before the last accepted step, or the oldest one."""
    last = int(m[COUNT]) - 1
    for i in range(last):
        later, earlier = FIRST + 2 * i, FIRST + 2 * i + 2
        if t >= m[earlier]:
            length = m[later] - m[earlier]
            w = (t - m[earlier]) / length if length > 0.0 else 1.0
            return (1.0 - w) * m[earlier + 1] + w * m[later + 1]
    return m[FIRST + 2 * last + 1]


@kernel
def commit(p, at, m_out):
    """Store the pair of this step; it replaces the last one if that is too close to the one before it."""
    count = int(at.m[COUNT])
    if count < 2 or at.m[FIRST] - at.m[FIRST + 2] >= p.time / KEPT:
        for i in range(min(count, KEPT + 1)):
            m_out[FIRST + 2 * i + 2], m_out[FIRST + 2 * i + 3] = at.m[FIRST + 2 * i], at.m[FIRST + 2 * i + 1]
        m_out[COUNT] = min(count + 1, KEPT + 2)
    m_out[FIRST], m_out[FIRST + 1] = at.t, at.q[U]


DELAY = signal_of_input(
    "delay",
    __doc__,
    Field("time", NUMBER, "s", "T, by which the value is late", check=positive),
    like=lambda d: d["input"],
    memory=("count", *(f"{name}_{i}" for i in range(KEPT + 2) for name in ("time", "value"))),
    residual=residual,
    commit=commit,
)
