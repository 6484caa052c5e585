"""The value that a constraint is held at: a constant and, where there is a law, a function of time."""

from mecano.compiled.kernel import kernel
from mecano.laws.table import evaluate_curve

TARGET = {"offset": (), "law": "i"}


@kernel
def target(p, laws, t):
    """Value, rate and second rate of offset + law(t) of a record with the fields of ``TARGET``; law 0 is zero."""
    y, y1, y2 = evaluate_curve(laws, p.law, t)
    return p.offset + y, y1, y2
