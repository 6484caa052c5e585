"""What a load is asked to give: a law of the time, or a formula of signals, which is then an input of its element."""

from dataclasses import replace

from mecano.jit.kernel import kernel
from mecano.laws.table import evaluate_curve
from mecano.maths.dual import number


@kernel
def of_time(p, at):
    """Return the law of the record at the time."""
    return evaluate_curve(at.laws, p.law, at.t)[0]


def of_input(i):
    """Return the compiled function (p, at) -> value of the local unknown number i."""

    @kernel
    def read(p, at):
        return number(at.q[i])

    return read


def is_formula(value):
    """Return True for a checked value of the type DRIVE that is a formula, not a law."""
    return isinstance(value, str)


def law_of(value, context):
    """Return where the law of a checked value of the type DRIVE starts in the table; 0 for a formula."""
    return 0 if is_formula(value) else int(context.laws.add(value))


def on_demand(make, field, i):
    """Return the Kind ``make(demand)`` for a law of the time, whose variant reads a formula in the deck's ``field``.

    ``i`` is the local index of the input: behind the slots and the scalars.
    """
    by_law, by_signal = make(of_time), replace(make(of_input(i)), inputs=(field,))
    return replace(by_law, variant=lambda d: by_signal if is_formula(d[field]) else by_law)
