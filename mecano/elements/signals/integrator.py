r"""Integrator: the time integral of the input.

.. math::  \dot y = u
"""

from mecano.constraints.along_coordinate.signal import INITIAL, signal_of_input
from mecano.jit.kernel import kernel
from mecano.maths.dual import number

OWN, U = 0, 1  # local unknowns: the value; the input


@kernel
def residual(p, at, f):
    """Add the equation of the value."""
    f[OWN] += number(at.v[OWN]) - number(at.q[U])


INTEGRATOR = signal_of_input(
    "integrator", __doc__, INITIAL,
    smooths=lambda d: True,
    same_unit_as=lambda d: d["input"],
    power_of_seconds=lambda d: 1.0,
    states=("value",),
    start=lambda p: [p["initial"]],
    residual=residual,
)  # fmt: skip
