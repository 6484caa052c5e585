r"""Steady rotation by continuation: from the start to an equilibrium at rest, then with growing speed.

At rest the forces r_0 and gaps of the start are removed gradually,

.. math:: r(q) = (1 - p)\, r_0, \qquad \Phi(q) = (1 - p)\, \Phi_0, \qquad 0 \le p \le 1,

so that a blade bends under a growing part of its weight; then the squared angular velocity, to which the centrifugal
forces are proportional, grows from zero to :math:`p\, w^2`, p = 1. Each step is solved by a few iterations of Newton's
method (steady.py) from the state before. Its length is halved if they do not converge or move far, and doubled
otherwise.
"""

from collections.abc import Callable
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from mecano.model.state import State
    from mecano.solve.modal.steady import Steady
    from mecano.solve.modal.steady_rotation import Rotation

FIRST, LEAST, MOST_STEPS = 0.1, 1e-4, 200  # step of p at the beginning, least step, number of trials
FAR = 0.3  # largest displacement of a node in a step, in length scales: a larger one may lead to another branch


def spin_up(steady: "Steady", motion: "Rotation", start: "State") -> "tuple[State, bool]":
    """Return (state, whether it is in steady ``motion``, that of ``steady``) by continuation from ``start``."""
    w = motion.w
    try:
        motion.turn(0.0 * w)
        s = steady.in_motion(start)
        at_start = steady.tangent(s)
        s, arrived = _follow(steady, s, lambda p: steady.release(at_start, 1.0 - p))
        if arrived and w.any():
            s, arrived = _follow(steady, s, lambda p: motion.turn(p**0.5 * w))
    finally:
        motion.turn(w)
        steady.release(None, 0.0)
    return s, arrived


def _follow(steady: "Steady", s: "State", go_to: Callable[[float], None]) -> "tuple[State, bool]":
    """Return (state at the last p, whether it is 1) on the path from ``s`` at p = 0; ``go_to(p)`` sets p."""
    p, step = 0.0, FIRST
    for _ in range(MOST_STEPS):
        go_to(min(p + step, 1.0))
        new, arrived = steady.correct(s)
        if arrived and steady.reshaped(s, new) <= FAR * steady.length:
            p, s, step = min(p + step, 1.0), new, 2.0 * step
        else:
            step *= 0.5
        if p == 1.0 or step < LEAST:
            break
    return s, p == 1.0
