"""Pin law: a moment from a law of the angle of a pin about an axis, followed over whole turns."""

from mecano.compiled.kernel import kernel
from mecano.constraints.axis_law import LAW_RECORD, axis_law_record, law_kind
from mecano.constraints.carried import follow, relative_rotation
from mecano.constraints.pin_angle import pin_angle, pin_gradient
from mecano.contract import record
from mecano.maths.vector import mat, vec

RECORD = record(mu=(3, 3), xi=3, **LAW_RECORD)


@kernel
def _angle(p, at):
    A = relative_rotation(mat(at.R[0]), mat(at.R[1]))
    return follow(at.m[0], pin_angle(A, mat(p.mu), vec(p.xi, 0)))


@kernel
def pin_along(p, at):
    """Gradient of the angle of an element whose record has the axes ``mu`` (3, 3) and the pin ``xi`` (3,)."""
    b_0, b_1 = pin_gradient(relative_rotation(mat(at.R[0]), mat(at.R[1])), mat(p.mu), vec(p.xi, 0))
    return (0, b_0), (3, b_1)


def pin_law_record(mu, xi, law, natural, context):
    """Record: axes (3, 3) of the first node, rows, the pin (3,) of the second."""
    return {"mu": mu, "xi": xi, **axis_law_record(law, natural, context)}


PIN_LAW = law_kind("pin_law", __doc__, RECORD, ("R0", "R1"), _angle, pin_along, ("angle",))
