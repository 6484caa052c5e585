r"""Lower a vehicle onto its wheels: a start from which Newton's method finds steady running.

A wheel in the air, or one that just touches its ground, has no stiffness, so that the tangent does not show what will
carry the vehicle; Newton's method may lift it off one of its wheels instead. The vehicle is therefore displaced along
the direction :math:`\hat g` of gravity, without a change of shape, until its forces, with f of steady.py, balance along
this direction,

.. math::
   \hat g \cdot \sum_i f_i(q + d\, \hat g) = 0 .
"""

from typing import TYPE_CHECKING

import numpy as np

from mecano.maths.root import root

if TYPE_CHECKING:
    from mecano.model.state import State
    from mecano.solve.modal.steady import Steady

STRIDE, FARTHEST = 0.01, 1.0  # of the length scale: interval of the search for the balance, largest displacement
HELD = 1e-6  # of the displacement: a larger change of a constraint holds the vehicle at its height


def lowered(steady: "Steady", start: "State") -> "State | None":
    """Return ``start`` displaced along gravity until the forces along it balance, with velocities of steady motion.

    None without gravity, if constraints hold the vehicle at its height, or if nothing carries it.
    """
    system, of = steady.system, steady.system.numbering
    gravity = system.context.gravity
    if not gravity.any():
        return None
    down = gravity / np.linalg.norm(gravity)
    free = np.unique(of.x[of.x < steady.n_q])[:, None] + np.arange(3)

    def at(d):
        s = start.copy()
        s.z[free] += d * down
        return steady.monitor.settle(steady.begun(s))

    def weight(d):
        return float(system.assemble(at(d)).residual[free].sum(axis=0) @ down)

    stride = STRIDE * steady.length
    of_positions = ~steady.of_rates
    gaps = [system.constraint_derivatives(at(d))[of_positions, 0] for d in (0.0, stride)]
    if np.abs(gaps[1] - gaps[0]).max(initial=0.0) > HELD * stride:
        return None
    high, sign = 0.0, np.sign(weight(0.0))
    for high in stride * np.arange(1, round(FARTHEST / STRIDE) + 1):
        if np.sign(weight(high)) != sign:
            return at(root(weight, high - stride, high))
    return None
