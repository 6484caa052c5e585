"""Zero of a function in an interval, by Chandrupatla's method (Adv. Eng. Software 28, 1997, 145-149)."""

import math
from collections.abc import Callable
from typing import Any, TypeVar

P = TypeVar("P", bound=tuple[Any, ...])  # a point: x, the value there, and what else belongs to it
NEAR = 0.01  # of the interval: the first point tried is no nearer to its ends
MOST = 100  # evaluations, more than bisection to the last digit needs
ROUNDING = 4e-16  # of x: digits to which a zero is known at best


def root(f: Callable[[float], float], low: float, high: float, tolerance: float = 0.0) -> float:
    """Return the zero of ``f`` between low and high, where f has opposite signs, to a ``tolerance`` or to rounding."""
    last = float(f(high))
    sign = 1.0 if last >= 0.0 else -1.0
    early, late = (float(low), sign * float(f(low))), (float(high), sign * last)
    near = max(tolerance, ROUNDING * max(abs(low), abs(high)))

    def at(x):
        return x, sign * float(f(x))

    def is_over(a, b):
        return b[0] - a[0] <= near or a[1] == 0.0 or b[1] == 0.0

    early, late = chandrupatla(at, early, late, is_over, near, MOST) or (early, late)
    return late[0] if late[1] <= -early[1] else early[0]


def chandrupatla(
    at: Callable[[float], P | None], early: P, late: P, is_over: Callable[[P, P], bool], tolerance: float, most: int
) -> tuple[P, P] | None:
    """Return the ends of the interval around a zero, of which ``is_over`` is true, or None if ``at`` fails.

    Points are tuples that begin with x and the value there; at(x) -> point, or None. Chandrupatla (Adv. Eng. Software
    28, 1997, 145-149); at most ``most`` points.
    """
    newest, opposite, drop = late, early, late[1] - early[1]
    share = late[1] / drop if 0.0 < drop < math.inf else 0.5
    share = min(max(share, NEAR), 1.0 - NEAR)  # contacts that have just separated may close again
    for _ in range(most):
        if is_over(early, late):
            break
        least = 0.5 * tolerance / (late[0] - early[0])
        point = at(newest[0] + min(max(share, least), 1.0 - least) * (opposite[0] - newest[0]))
        if point is None:
            return None
        older, opposite = (newest, opposite) if (point[1] >= 0) == (newest[1] >= 0) else (opposite, newest)
        newest = point
        early, late = (early, point) if point[1] >= 0 else (point, late)
        share = _share(newest, opposite, older)
    return early, late


def _share(newest, opposite, older):
    """Return the fraction of the way from the ``newest`` point to the ``opposite`` one at which the value vanishes.

    By inverse quadratic interpolation where it is monotonic, else by bisection.
    """
    (a, f_a), (b, f_b), (c, f_c) = newest[:2], opposite[:2], older[:2]
    if not all(map(math.isfinite, (f_a, f_b, f_c))) or f_c == f_b:
        return 0.5
    x, f = (a - b) / (c - b), (f_a - f_b) / (f_c - f_b)
    if f * f >= x or (1.0 - f) ** 2 >= 1.0 - x:
        return 0.5
    return f_a / (f_b - f_a) * f_c / (f_b - f_c) + (c - a) / (b - a) * f_a / (f_c - f_a) * f_b / (f_c - f_b)
