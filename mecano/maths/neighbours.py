"""The numbers next to a number."""

from mecano.jit.kernel import kernel

HALF_SPACING = 2.0**-53 * (1.0 + 2.0**-52)  # of a number, above half the distance of the next one
SMALLEST = 5e-324


@kernel
def successor(x):
    """Return the next larger number, of x = 0 or beyond 1e-290 in magnitude (Rump et al. 2009, BIT 49, 419-431)."""
    return x + (abs(x) * HALF_SPACING + SMALLEST)


@kernel
def predecessor(x):
    """Return the next smaller number, as ``successor``."""
    return x - (abs(x) * HALF_SPACING + SMALLEST)
