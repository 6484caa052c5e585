r"""First-order lag: a low-pass filter, or an actuator or sensor with a time constant.

.. math::  T \dot y + y = g u
"""

from mecano.constraints.along_coordinate.signal import INITIAL, signal_of_input
from mecano.jit.kernel import kernel
from mecano.maths.dual import number
from mecano.schema import NUMBER, Field, positive

OWN, U = 0, 1  # local unknowns: the value; the input


@kernel
def residual(p, at, f):
    """Add the equation of the value."""
    f[OWN] += number(at.v[OWN]) + (number(at.q[OWN]) - p.gain * number(at.q[U])) / p.time_constant


LAG = signal_of_input(
    "lag", __doc__, Field("time_constant", NUMBER, "s", "time constant T", check=positive),
    Field("gain", NUMBER, "-", "g, ratio of the value to a constant input", 1.0), INITIAL,
    smooths=lambda d: True,
    same_unit_as=lambda d: d["input"] if d["gain"] == 1.0 else "",
    states=("value",),
    start=lambda p: [p["initial"]],
    residual=residual,
)  # fmt: skip
