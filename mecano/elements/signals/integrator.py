r"""Integrator: the time integral of the input.

.. math::  \dot y = u
"""

from mecano.constraints.along_coordinate.signal import IN_DECK, INITIAL, INPUT, UNIT_OF_VALUE
from mecano.element_interface import Kind
from mecano.jit.kernel import kernel
from mecano.maths.dual import number

OWN, U = 0, 1  # local unknowns: the value; the input


@kernel
def residual(p, at, f):
    """Add the equation of the value."""
    f[OWN] += number(at.v[OWN]) - number(at.q[U])


INTEGRATOR = Kind(
    name="integrator",
    doc=__doc__,
    smooths=lambda d: True,
    fields=(INPUT, INITIAL, UNIT_OF_VALUE),
    states=("value",),
    inputs=("input",),
    start=lambda p: [p["initial"]],
    residual=residual,
    **IN_DECK,
)
