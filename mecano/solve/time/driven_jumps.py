r"""Work of the impulses of prescribed motions whose velocities jump, as at a corner of a table of angles.

With the rates :math:`w_0, w_1` of the prescribed coordinates before and after it, the impulses :math:`p` do the work

.. math:: p^T (w_0 + w_1) / 2,

the change of the kinetic energy: :math:`M (v_1 - v_0) = B^T p` and :math:`B v = w`.
"""

from dataclasses import replace

import numpy as np

from mecano.model.state import State
from mecano.model.system import System
from mecano.solve.time.run_state import Method

LEAST = 1e-6  # of the larger rate: a smaller change between two adjacent times is not a jump


def work_of_jumps(system: System, method: "Method", s: State, behind: State, h: float) -> float:
    """Return the work [J] of prescribed motions whose velocities jump between ``s`` and ``behind``, just after it."""
    if not system.n_l:
        return 0.0
    before, after = _prescribed(system, replace(s, t=np.nextafter(s.t, -np.inf))), _prescribed(system, behind)
    jump = after - before
    jump[np.abs(jump) <= LEAST * np.maximum(np.abs(before), np.abs(after))] = 0.0
    if not jump.any():
        return 0.0
    _, consistent = method.consistent(behind, h)
    _, reactions = consistent.impose(jump)
    return 0.5 * float((reactions - consistent.penalty * jump) @ (before + after))


def _prescribed(system, s):
    """Return the rates (n_l,) of the constrained coordinates at ``s`` that are prescribed."""
    return -system.constraint_derivatives(replace(s, v=np.zeros_like(s.v)))[:, 1]
