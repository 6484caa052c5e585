r"""Coulomb friction that is smooth at rest (Oden & Martins 1985).

A normal force N and a sliding velocity of size u give the friction :math:`\mu(u)\,\phi(u)\,N` against the sliding, with
:math:`\phi(u) = (u/\epsilon)(2 - u/\epsilon)` for :math:`u < \epsilon`, 1 beyond: C1 in the velocity vector.
"""

from mecano.compiled.kernel import kernel
from mecano.laws.table import curve, evaluate_curve
from mecano.maths.dual import at_least, select


@kernel
def sticking(eps, u):
    """Return phi/u [s/m] and u d(phi/u)/du of the sliding speed u >= 0 [m/s]; finite at u = 0."""
    if u >= eps:
        return 1.0 / u, -1.0 / u
    return (2.0 - u / eps) / eps, -u / (eps * eps)


@kernel
def friction_factor(laws, law, eps, u):
    """mu phi [-], b = mu phi/u [s/m] and u db/du of the sliding speed u >= 0 [m/s]; finite at u = 0."""
    mu, d_mu, _ = evaluate_curve(laws, law, u)
    if mu <= 0.0:
        return 0.0, 0.0, 0.0
    ramp, ramp_1 = sticking(eps, u)
    return mu * ramp * u, mu * ramp, u * d_mu * ramp + mu * ramp_1


@kernel
def friction(laws, law, eps, u):
    """Return mu phi/u [s/m] of the sliding speed u >= 0 [m/s], finite at u = 0: the force is this times N times v."""
    mu = at_least(curve(laws, law, u), 0.0)
    return mu * select(u < eps, (2.0 - u / eps) / eps, 1.0 / at_least(u, eps))
