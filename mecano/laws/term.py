"""A term of a law: one summand with its deck fields, its numbers and its compiled functions."""

from collections.abc import Callable

from mecano.immutable import immutable
from mecano.jit.kernel import kernel

# A law may be a function of metres, seconds or radians: its units depend on where the deck uses it.
ARGUMENT = "unit of the argument"
VALUE = "unit of the value"
SLOPE = "unit of the value / unit of the argument"
OF_A_POWER = "unit of the value / unit of the argument^p"
DENSITY = "(unit of the value)^2 unit of the argument"

OF_A_WAVE = 32  # arguments per wave or edge that resolve its shape: second derivatives within 0.5 %
MOST_SHOWN = 100_000  # maximum number of arguments that resolve an unbounded term, starting from the lowest


def nothing(*_):
    """Return an empty list: no errors, corners or breakpoints."""
    return []


@kernel
def no_energy(a, i, s):
    """Return zero: the integral of a force term that gives no force at rest."""
    return 0.0


def of_extension(curve):
    """Return ``evaluate`` of a force term that is a curve of the extension."""

    @kernel
    def spring(a, i, s, v):
        y, d, _ = curve(a, i, s)
        return y, d, 0.0

    return spring


def of_rate(curve):
    """Return ``evaluate`` of a force term that is a curve of the rate."""

    @kernel
    def damper(a, i, s, v):
        y, d, _ = curve(a, i, v)
        return y, 0.0, d

    return damper


def along(places=(), lengths=(), rates=()):
    """Return ``along_line`` of a term some of whose fields are places, lengths or rates along its argument."""

    def along_line(values, slope, offset):
        return {
            **{name: (values[name] - offset) / slope for name in places},
            **{name: values[name] / slope for name in lengths},
            **{name: values[name] * slope for name in rates},
        }

    return along_line


@immutable
class Term:
    """One summand of a law.

    The compiled functions read the numbers of the term from the flat table ``a`` of all laws, from ``a[i]`` on:

    role "curve": ``evaluate(a, i, s)`` -> (y, dy/ds, d2y/ds2)
    role "force": ``evaluate(a, i, s, v)`` -> (F, dF/ds, dF/dv) for the extension s and its rate v; F > 0 pulls
    the two ends together. ARGUMENT in the units of its fields is the rate.

    ``integral(a, i, s)`` is a continuous antiderivative of y(s) or of F(s, 0); by default zero, as that of a damper.
    """

    name: str
    doc: str
    role: str
    fields: tuple  # schema.Field
    evaluate: Callable
    integral: Callable = no_energy
    pack: Callable | None = None
    """{field: value} -> the numbers of the term; by default the values of its fields, in their order"""
    check: Callable = nothing
    """{field: value} -> [text]: errors in the combination of the values"""
    stops: Callable = nothing
    """{field: value} -> [(extension, stiffness)]: corners of a force; a stiffness < 0 marks a lower stop"""
    breakpoints: Callable = nothing
    """{field: value} -> [argument]: jumps and corners of a curve"""
    landmarks: Callable = nothing
    """{field: value} -> [argument]: further places at which adaptive steps in time end, lest they pass over a pulse"""
    shape: Callable = nothing
    """{field: value}, low, high -> [argument], in any order, between which the second derivative of a curve changes
    little: from ``low`` to ``high`` for unbounded terms (a sine), everything for bounded ones (a table, an edge)"""
    frequency: Callable = lambda values: 0.0
    """{field: value} -> highest frequency [waves / unit of the argument] of a term made of waves"""
    along_line: Callable | None = None
    """{field: value}, slope > 0, offset -> the values, as far as they change, of the curve whose value at t is that of
    this one at slope t + offset; None if no values give it"""
    sample: Callable | None = None
    """() -> [{field: value}] for the generic tests of a term that is not one of mecano's"""

    @property
    def single(self):
        """The field whose value may stand for the whole term, the only required one, or None."""
        required = [field for field in self.fields if field.required]
        return required[0] if len(required) == 1 else None

    def numbers(self, values):
        """Return the numbers of a term with these values of its fields."""
        return self.pack(values) if self.pack else [values[field.name] for field in self.fields]
