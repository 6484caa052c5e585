"""Floating-point numbers next to another one, for compiled code (Rump, Zimmermann, Boldo & Melquiond 2009)."""

from mecano.jit.kernel import kernel

HALF_SPACING = 2.0**-53 * (1.0 + 2.0**-52)  # of a number, above half the distance of the next one
SMALLEST = 5e-324


@kernel
def successor(x):
    """Return the next larger number, for x = 0 or above 1e-290 in magnitude."""
    return x + (abs(x) * HALF_SPACING + SMALLEST)


@kernel
def predecessor(x):
    """Return the next smaller number, as ``successor``."""
    return x - (abs(x) * HALF_SPACING + SMALLEST)
