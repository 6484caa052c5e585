r"""Switch: one of two formulas, by whether a quantity is high or low; with hysteresis where both levels differ.

It goes to ``high`` when the input rises through ``upper``, to ``low`` when it falls through ``lower``, which is the
same level where the deck gives none. Both are located as events, at which steps of time end. A quantity that is driven
back by what it switches needs two levels, or it would switch again and again in no time. Its value is that of the
formula ``high`` or ``low``: with the numbers 1 and 0 it is a condition, for other formulas and for the record of
events.
"""

from mecano.constraints.along_coordinate.signal import INPUT, SIGNAL, VALUE, observe_value
from mecano.element_interface import Event, Kind, record
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
    """How far the input is above the upper level, below the lower one."""
    g[0], g[1] = at.q[U] - p.upper, p.lower - at.q[U]


def prepare(d, nodes, context):
    """Record: both levels."""
    return {"upper": d["upper"], "lower": d["upper"] if d["lower"] is None else d["lower"]}


def check(d, nodes):
    """Texts on levels in the wrong order."""
    wrong = d["lower"] is not None and d["lower"] > d["upper"]
    return ["'lower' must not be greater than 'upper'"] if wrong else []


def sample(rng):
    """High and low."""
    return [
        ({"input": "a", "upper": 0.5, "lower": -0.5, "high": "b", "low": "c"}, 1, phase) for phase in ("low", "high")
    ]


SWITCH = Kind(
    name="switch",
    section="signals",
    doc=__doc__,
    dtype=record(upper=(), lower=()),
    fields=(
        INPUT,
        Field("upper", NUMBER, "-", "level of the input from which on the switch is high", 0.0),
        Field("lower", NUMBER, "-", "level below which it is low again; 'upper' when absent", None),
        Field("high", FORMULA, "-", "value when it is high", "1"),
        Field("low", FORMULA, "-", "value when it is low", "0"),
    ),
    outputs=(VALUE,),
    inputs=("input", "high", "low"),
    phases=("low", "high"),
    events=(
        Event("switches on", "low", "high", "the input rises through the upper level"),
        Event("switches off", "high", "low", "the input falls through the lower level"),
    ),
    prepare=prepare,
    check=check,
    residual=residual,
    observe=observe_value,
    event_values=event_values,
    sample=sample,
    **SIGNAL,
)
