"""Consistent velocities and accelerations where constraints on velocities follow signals that depend on velocities.

Such a signal changes with the velocities, or accelerations, that it prescribes. Both are found by Newton's method: of a
linear feedback in one iteration.
"""

from collections.abc import Callable

import numpy as np

from mecano.errors import AssemblyError, Failure
from mecano.model.state import State
from mecano.solve.time.consistent import Consistent
from mecano.solve.time.massless_scalars import DIFFERENCE
from mecano.solve.time.signals import rates_along, settle_signals

ITERATIONS = 20
AGREED = 1e-9  # of the values
ROUNDING = 1e-14  # of the values, whose differences are the rates
UNBOUNDED = 1e9  # gain of the feedback


def settle_driving_signals(consistent: Consistent, s: State, h: float, renewed: Callable[[], Consistent]) -> Consistent:
    """Set velocities, accelerations and multipliers of ``s`` in place, consistent with the signals that drive rates.

    ``s`` is consistent but for the dependence of these signals on velocities; h [s] is the size of the steps. Returns
    the Consistent of ``s``: the gradients of the constraints may depend on the signals, so that it is ``renewed``.
    Raises AssemblyError where they do not determine the velocities.
    """
    system, dt, given = consistent.system, DIFFERENCE * h, s.v.copy()
    own = system.driving_signals

    def values(u):
        s.v[:] = given
        s.z[own] = u
        consistent.project_velocity(s)
        settle_signals(system, s, dt)
        return s.z[own].copy()

    def rates(r):
        s.v[own] = r
        consistent.accelerate(s)
        found, second = rates_along(system, s, dt)
        s.a[own] = second[own]
        return found[own]

    for _ in range(ITERATIONS):
        before = s.z[own].copy()
        _agree(values, before, AGREED, s.t)
        if np.allclose(s.z[own], before, rtol=AGREED, atol=AGREED):
            break
        consistent = renewed()
    consistent.settle(s, h)
    rounding = ROUNDING * (1.0 + float(np.abs(s.z[own]).max())) / dt
    _agree(rates, s.v[own].copy(), AGREED + rounding, s.t)
    return consistent


def _agree(feedback: Callable[[np.ndarray], np.ndarray], x: np.ndarray, tolerance: float, t: float) -> None:
    """Find x (n,) with feedback(x) = x, and call ``feedback`` with it last; ``tolerance``: relative to 1 and to x."""
    for _ in range(ITERATIONS):
        found = feedback(x)
        size = 1.0 + np.abs(found).max()
        if np.abs(found - x).max() <= tolerance * size:
            return
        J = np.column_stack([(feedback(x + size * e) - found) / size for e in np.eye(len(x))])
        gain = np.linalg.pinv(np.eye(len(x)) - J, rcond=0.0)
        if np.abs(gain).max() > UNBOUNDED:
            break
        x = x + gain @ (found - x)
    raise AssemblyError(
        f"at t = {t:.9g} s the signals that prescribe rates depend on velocities such that no velocities satisfy them",
        Failure.SINGULAR, timed=True,
    )  # fmt: skip
