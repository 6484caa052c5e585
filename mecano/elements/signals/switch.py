r"""Switch: selects one of two formulas by the level of its input; with hysteresis if the two levels differ.

It becomes ``high`` when the input rises through ``upper`` and ``low`` when it falls through ``lower`` (``upper`` by
default). Both are located as events, at which time steps end. If the switch acts back on its input, two different
levels are needed: with a single one it would switch indefinitely without time advancing. Its value is that of the
formula ``high`` or ``low``; with the numbers 1 and 0 it is a condition, for use in other formulas and in the record of
events.
"""

from mecano.constraints.along_coordinate.signal import OF_INPUT, signal_of_input
from mecano.element_interface import Event, named, record
from mecano.jit.kernel import kernel
from mecano.maths.dual import number, select
from mecano.schema import FORMULA, NUMBER, Field

LOW, HIGH = range(2)
OWN, U, OF_HIGH, OF_LOW = range(4)  # local unknowns: the value; the inputs


@kernel
def residual(p, at, f):
    """Add the equation of the value."""
    f[OWN] += number(at.q[OWN]) - select(at.phase == HIGH, number(at.q[OF_HIGH]), number(at.q[OF_LOW]))


@kernel
def event_values(p, at, g):
    """Write the distances of the input above the upper level and below the lower one."""
    g[0], g[1] = at.q[U] - p.upper, p.lower - at.q[U]


def check(d, nodes):
    """Return errors for levels in the wrong order."""
    wrong = d["lower"] is not None and d["lower"] > d["upper"]
    return ["'lower' must not be greater than 'upper'"] if wrong else []


SWITCH = signal_of_input(
    "switch", __doc__,
    Field("upper", NUMBER, OF_INPUT, "level of the input above which the switch becomes high", 0.0),
    Field("lower", NUMBER, OF_INPUT, "level below which it becomes low again; 'upper' when absent", None),
    Field("high", FORMULA, "-", "value when it is high", "1"), Field("low", FORMULA, "-", "value when it is low", "0"),
    jumps=lambda d: True,
    dtype=record(upper=(), lower=()),
    inputs=("input", "high", "low"),
    phases=("low", "high"),
    events=(
        Event("switches on", "low", "high", "the input rises through the upper level", condition=True),
        Event("switches off", "high", "low", "the input falls through the lower level", condition=True),
    ),
    prepare=lambda d, nodes, context: {"upper": d["upper"], "lower": d["upper"] if d["lower"] is None else d["lower"]},
    **named(check, residual, event_values),
)  # fmt: skip
