"""Hermite interpolation within a step, from the values and rates at its ends."""

from mecano.jit.kernel import kernel

SMOOTH = 0.125  # bound of |change - change at the mean rate| / change at the greater rate


@kernel
def hermite(u, h, x0, x1, v0, v1):
    """Return the cubic Hermite value and rate at the fraction u of an interval of length h."""
    d = x1 - x0
    c2, c3 = 3.0 * d - h * (2.0 * v0 + v1), h * (v0 + v1) - 2.0 * d
    return x0 + u * (h * v0 + u * (c2 + u * c3)), v0 + (2.0 * u * c2 + 3.0 * u * u * c3) / h


@kernel
def quintic(u, h, x0, x1, v0, v1, a0, a1):
    """Return the quintic Hermite value and rate at the fraction u of an interval of length h."""
    v0, v1, a0, a1 = h * v0, h * v1, 0.5 * h * h * a0, 0.5 * h * h * a1
    d = x1 - x0 - v0 - a0
    e, f = v1 - v0 - 2.0 * a0, a1 - a0
    c3, c4, c5 = 10.0 * d - 4.0 * e + f, 7.0 * e - 15.0 * d - 2.0 * f, 6.0 * d - 3.0 * e + f
    value = x0 + u * (v0 + u * (a0 + u * (c3 + u * (c4 + u * c5))))
    return value, (v0 + u * (2.0 * a0 + u * (3.0 * c3 + u * (4.0 * c4 + u * 5.0 * c5)))) / h


@kernel
def between(u, x0, x1):
    """Return the linear interpolant at the fraction u; it stays within [x0, x1] in spite of round-off."""
    x = x0 + u * (x1 - x0)
    return min(max(x, min(x0, x1)), max(x0, x1))


@kernel
def is_smooth(h, x0, x1, v0, v1):
    """Return whether a change over h agrees with its rates well enough for a cubic.

    By Taylor's series x1 - x0 - h (v0 + v1)/2 = -h^3 x'''/12: for an oscillation of circular frequency omega this is
    (omega h)^2/12 of the change at the greater rate, so five steps per period are enough. If the steps do not resolve
    an oscillation, its rates contain no information.
    """
    return abs(x1 - x0 - 0.5 * h * (v0 + v1)) <= SMOOTH * h * max(abs(v0), abs(v1))
