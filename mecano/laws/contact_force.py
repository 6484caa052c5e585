r"""Force between two bodies in contact, from the depth w by which they overlap and its rate (Hunt & Crossley 1975).

.. math::  N = F(w)\,\max(0, 1 + c\,\dot w)

with an elastic law F, zero at w = 0, and a damping c [s/m], which never pulls. F is continued by its tangent to w < 0,
so that there is no corner in a step that ends where the contact opens. The stored energy is the integral of F; the
damping dissipates :math:`(N - F)\,\dot w \ge 0`.
"""

from mecano.jit.kernel import kernel
from mecano.laws.law_table import curve_and_slope, potential
from mecano.maths.dual import at_least, at_most


@kernel
def elastic_force(laws, law, w):
    """Return F(w) [N] of the depth w [m]; below zero, its tangent at zero."""
    F, slope = curve_and_slope(laws, law, at_least(w, 0.0))
    return F + slope * at_most(w, 0.0)


@kernel
def elastic_energy(laws, law, w):
    """Return the energy [J] stored at the depth w [m] >= 0."""
    return potential(laws, law, w) - potential(laws, law, 0.0)


@kernel
def contact_force(laws, law, damping, w, w1):
    """Return N [N] of the depth w [m] and its rate w1 [m/s]."""
    return elastic_force(laws, law, w) * at_least(1.0 + damping * w1, 0.0)
