r"""Formula: a signal that is a function of outputs of elements, other signals, the time and parameters.

.. math::  y = c(u_1, ..., u_n, t)

It may contain numbers, parameters (``$gain``), ``time``, ``pi``, + - * / ** ( ), signals by name and their outputs
(``path.slope``), outputs of elements and joints (``elbow.angle``, ``strut.force``) and their powers
(``motor.given_power``, ``strut.dissipated_power``), the motion of nodes (``tip.position.z``, ``tip.velocity.x``,
``tip.angular_velocity.y``), and the functions sin, cos, tan, asin, acos, atan, atan2, sqrt, exp, log, tanh, hypot, abs,
sign, min, max, and step(x, a, b), which rises smoothly from 0 at x = a to 1 at x = b. All are in SI units and radians.
If a name occurs in two sections of the deck, prefix the section: ``joints.elbow.angle``. In the section ``signals`` the
formula alone suffices: ``torque: 40*error``.

y is an unknown of the model: the implicit step has the exact derivatives of forces that depend on it, and signals that
depend on one another are solved simultaneously.
"""

from dataclasses import replace
from functools import cache

from mecano.constraints.along_coordinate.signal import IN_DECK, UNIT_OF_VALUE
from mecano.element_interface import Kind, record
from mecano.jit.kernel import kernel
from mecano.laws.formula import evaluate_formula, read_formula
from mecano.maths.dual import number
from mecano.schema import FORMULA as FORMULA_TYPE
from mecano.schema import Field

OWN = 0  # local unknowns: the value; then the inputs


@kernel
def residual(p, at, f):
    """Add the equation of the value."""
    f[OWN] += number(at.q[OWN]) - evaluate_formula(at.laws, p.program, at.t, at.q, OWN)


@cache
def _of_size(n):
    return replace(FORMULA, inputs=tuple(f"input_{i}" for i in range(1, n + 1)), variant=None)


ALL_OPERATIONS = (
    "3*a.angle - b**2/(c + 4) + min(a.angle, b, 0.5) - max(c, 0.1)*time",
    "sin(a) + cos(b)*tan(c) - atan2(a, 1 + c) + hypot(a, b + 2) + abs(c) + sign(a)",
    "asin(a) + acos(b) + atan(c) + sqrt(4 + a) + exp(b)*log(2 + c) - tanh(-a) + (2 + a)**b",
    "step(a, -9, 9)*step(time, -1, b)",
    "time**2",
)  # in the samples
FORMULA = Kind(
    name="formula", doc=__doc__, dtype=record(program="i"),
    fields=(Field("value", FORMULA_TYPE, "-", "the formula"), UNIT_OF_VALUE),
    same_unit_as=lambda d: d["value"],
    reads=lambda d: read_formula(d["value"]).references,
    prepare=lambda d, nodes, context: {"program": context.laws.append(read_formula(d["value"]).numbers)},
    variant=lambda d: _of_size(len(read_formula(d["value"]).references)),
    cases=tuple({"value": text} for text in ALL_OPERATIONS),
    residual=residual,
    **IN_DECK,
)  # fmt: skip
