"""Demanded value of a load: a function of time, or a formula of signals, which is then an input of its element."""

from dataclasses import replace

from mecano.jit.kernel import kernel
from mecano.laws.law_table import curve, evaluate_curve, terms_of
from mecano.maths.dual import number

LAW = (("linear", {"slope": 0.5, "offset": 3.0}),)  # of samples


@kernel
def of_law(p, at):
    """Return the value of the record's law at the current time, a Dual if that is one."""
    return curve(at.laws, p.law, at.t)


@kernel
def of_law_with_rate(p, at):
    """Return the value of the record's law at the current time, and its rate."""
    return evaluate_curve(at.laws, p.law, at.t)[:2]


def of_input(i):
    """Return the compiled function (p, at) -> value of the local unknown i, an input."""

    @kernel
    def read(p, at):
        return number(at.q[i])

    return read


def with_rate(i):
    """Return the compiled function (p, at) -> value and rate of the local unknown i, an input."""

    @kernel
    def read(p, at):
        return number(at.q[i]), number(at.v[i])

    return read


def is_formula(value):
    """Return whether a checked value of the type DRIVE is a formula, not a law."""
    return isinstance(value, str)


def reads_of(value):
    """Return ``Part.reads`` of a checked value of the type DRIVE: the formula, or nothing for a law."""
    return (value,) if is_formula(value) else ()


def law_of(value, context):
    """Return the start, in the table of laws, of a checked value of the type DRIVE; 0 for a formula."""
    return 0 if is_formula(value) else context.laws.add(value)


def as_formula(value):
    """Return a checked value of the type DRIVE, or None, as a formula; None for a law of time that varies."""
    if value is None or is_formula(value):
        return value or "0"
    terms = terms_of(value)
    return repr(terms[0][1]["value"]) if [name for name, _ in terms] == ["constant"] else None


def check_alike(name, values):
    """Return an error if some ``values`` of the mapping ``name`` are formulas and others laws of time."""
    if any(map(is_formula, values)) and None in map(as_formula, values):
        return [f"{name!r} has formulas and laws of time: a law can be a signal, a 'curve' of the time"]
    return []


def by_law_and_signal(kind, functions, field, of_law=of_law, of_input=of_input):
    """Return the ``kind`` for a demand that is a function of time, and for a formula, its input named ``field``.

    ``functions(demand)`` are fields of the Kind that depend on the demand, a compiled function (p, at) -> its value:
    {name: value}. ``of_law`` and ``of_input(i)`` are the demands of both, i the local index of the input.
    """
    by_signal = replace(kind, inputs=(field,))
    return replace(kind, **functions(of_law)), replace(by_signal, **functions(of_input(by_signal.place_of(field))))


def on_demand(kind, functions, field, *demands):
    """Return the ``kind`` for a function of time, whose variant reads a formula in the deck's ``field``.

    Samples that do not give the field are those of a law and of a formula. The arguments are those of
    ``by_law_and_signal``.
    """
    by_law, by_signal = by_law_and_signal(kind, functions, field, *demands)
    others = replace(kind, fields=tuple(one for one in kind.fields if one.name != field))

    def sample(rng):
        given = others.samples(rng)
        values = {True: [{}], False: [{field: LAW}, {field: "command"}]}
        return [({**d, **one}, nodes, phase) for d, nodes, phase in given for one in values[field in d]]

    return replace(by_law, sample=sample, variant=lambda d: by_signal if is_formula(d[field]) else by_law)
