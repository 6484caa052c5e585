"""Pin law: a moment from a law of the angle of a pin about an axis, followed over whole turns."""

from mecano.compiled.kernel import kernel
from mecano.constraints.axis_law import LAW_RECORD, add_turning, axis_law_record, law_kind
from mecano.constraints.carried import follow, relative_rotation, turning_rate
from mecano.constraints.pin_angle import pin_angle, pin_curvature, pin_gradient
from mecano.contract import record
from mecano.laws.table import evaluate_force
from mecano.maths.vector import mat, vec

RECORD = record(mu=(3, 3), xi=3, **LAW_RECORD)


@kernel
def force(p, at, f, K, C, M):
    """Opposite moments on both nodes."""
    mu, xi = mat(p.mu), vec(p.xi, 0)
    A = relative_rotation(mat(at.R[0]), mat(at.R[1]))
    gradient, H = pin_gradient(A, mu, xi), pin_curvature(A, mu, xi)
    omega_0, omega_1 = vec(at.v, 0), vec(at.v, 3)
    angle = follow(at.m[0], pin_angle(A, mu, xi)) - p.natural
    P, P_angle, P_rate = evaluate_force(at.laws, p.law, angle, turning_rate(gradient, omega_0, omega_1))
    add_turning(f, K, C, P, P_angle, P_rate, gradient, H, omega_0, omega_1)


@kernel
def _followed(p, m, q, v, R):
    mu, xi = mat(p.mu), vec(p.xi, 0)
    A = relative_rotation(mat(R[0]), mat(R[1]))
    return follow(m[0], pin_angle(A, mu, xi)), turning_rate(pin_gradient(A, mu, xi), vec(v, 0), vec(v, 3))


def pin_law_record(mu, xi, law, natural, context):
    """Record: axes (3, 3) of the first node, rows, the pin (3,) of the second."""
    return {"mu": mu, "xi": xi, **axis_law_record(law, natural, context)}


PIN_LAW = law_kind("pin_law", __doc__, RECORD, ("R0", "R1"), force, _followed, ("angle",))
