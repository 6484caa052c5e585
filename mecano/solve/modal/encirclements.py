"""Encirclements of zero by a function along the border of the right half-plane, or of a strip of it (Nyquist)."""

from collections.abc import Callable

import numpy as np

TILT = 1e-4  # damping ratio below zero of the contour: lightly damped poles are not on it
ARC, RAY = 10, 40  # points of the arc around zero and of the ray, at least
TURN = 0.7  # rad: largest turn between two points
DEEPEST = 24  # bisections of an interval


def encirclements(F: Callable[[complex], complex], first: float, last: float) -> int | None:
    """Return the zeros less the poles of F inside the contour, by its turns around zero; None where it has no angle.

    The contour goes from the real axis along the arc of the radius ``first`` [rad/s] to the imaginary axis, and along
    that to ``last`` [rad/s]; its mirror image is added. F is real on the real axis and at the end.
    """
    angle = 0.5 * np.pi - TILT

    def point(t):  # from 0 to 1 on the arc, to 2 on the ray
        return first * np.exp(1j * angle * t) if t < 1.0 else first * (last / first) ** (t - 1.0) * np.exp(1j * angle)

    places = np.concatenate([np.linspace(0.0, 1.0, ARC, endpoint=False), np.linspace(1.0, 2.0, RAY)]).tolist()
    values = [F(point(t)) for t in places]
    if not all(np.isfinite(values)) or not all(values):
        return None
    total = sum(
        _turn(lambda t: F(point(t)), places[i : i + 2], values[i : i + 2], DEEPEST) for i in range(len(places) - 1)
    )
    return -round(total / np.pi)


def _turn(F, places, values, depth):
    """Return the change of the angle [rad] of F between two places, in steps of less than TURN."""
    turn = float(np.angle(values[1] / values[0]))
    if abs(turn) < TURN or not depth:
        return turn
    middle = 0.5 * (places[0] + places[1])
    value = F(middle)
    if not np.isfinite(value) or not value:
        return turn
    return _turn(F, [places[0], middle], [values[0], value], depth - 1) + _turn(
        F, [middle, places[1]], [value, values[1]], depth - 1
    )
