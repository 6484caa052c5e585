"""Declarations shared by all signals: their first scalar is their value, which is also their first output."""

from mecano.element_interface import Kind, Output
from mecano.jit.kernel import kernel
from mecano.schema import FORMULA, NUMBER, UNIT, Field

OF_VALUE, OF_INPUT = "unit of the value", "unit of the input"  # units that the deck determines
OF_SLOPE = "unit of the value / unit of the input"
SIGNAL = {"scalars": ("value",), "of_signals": True}
VALUE = Output("value", "SI", "value of the signal, in SI units")
INPUT = Field("input", FORMULA, "-", "the input: a formula of signals, outputs of elements, motions of nodes, time")
INITIAL = Field("initial", NUMBER, OF_VALUE, "value at the start", 0.0)
UNIT_OF_VALUE = Field(
    "unit", UNIT, "-", "unit of the value in pictures, such as N m or deg; results are in SI units; when absent, it "
    "follows from the input, the formula or the use, where these determine it", None,
)  # fmt: skip


@kernel
def observe_value(p, at, F, y, e):
    """Write the value of a signal, its first local unknown."""
    y[0] = at.q[0]


IN_DECK = {**SIGNAL, "section": "signals", "outputs": (VALUE,), "observe": observe_value}
"""Declarations of a kind of the section ``signals``."""


def signal_of_input(name, doc, *fields, **declared):
    """Return the Kind of a signal whose first input is the field ``input``; ``fields`` are those of its own.

    ``declared`` are other fields of the Kind, which go before those of ``IN_DECK``.
    """
    given = {"fields": (INPUT, *fields, UNIT_OF_VALUE), "inputs": ("input",), **IN_DECK}
    return Kind(name=name, doc=doc, **{**given, **declared})
