r"""Integrator: the time integral of the input.

.. math::  \dot y = u
"""

from mecano.constraints.along_coordinate.signal import INITIAL, INPUT, SIGNAL, VALUE, observe_value
from mecano.element_interface import Kind, record
from mecano.jit.kernel import kernel
from mecano.maths.dual import number

OWN, U = 0, 1  # local unknowns: the value; the input


@kernel
def residual(p, at, f):
    """Add the equation of the value."""
    f[OWN] += number(at.v[OWN]) - number(at.q[U])


INTEGRATOR = Kind(
    name="integrator",
    section="signals",
    doc=__doc__,
    dtype=record(initial=()),
    fields=(INPUT, INITIAL),
    outputs=(VALUE,),
    states=("value",),
    inputs=("input",),
    prepare=lambda d, nodes, context: {"initial": d["initial"]},
    start=lambda p: [p["initial"]],
    residual=residual,
    observe=observe_value,
    sample=lambda rng: [({"input": "a"}, 1, "")],
    **SIGNAL,
)
