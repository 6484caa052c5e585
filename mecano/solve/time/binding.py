r"""Binding: friction that depends on reactions and grows faster with them than the motion relieves them.

Reactions that change by :math:`\Lambda` change the friction by :math:`f'\Lambda`, to which the constraints respond with
reactions :math:`-W \Lambda`. Where I + W has a real eigenvalue that is not positive, the accelerations of rigid bodies
do not exist, or are not unique (Painleve, Comptes rendus 121 (1895) 112-115).
"""

import numpy as np

from mecano.errors import AssemblyError
from mecano.model.state import State
from mecano.solve.diagnostics.failure import friction_binds
from mecano.solve.time.consistent import Consistent
from mecano.solve.time.run_state import Method

REAL = 1e-9  # of an eigenvalue: a smaller imaginary part is rounding


def refuse_binding(method: "Method", s: State) -> None:
    """Raise ConvergenceError if the friction of a joint or contact binds at the state ``s``."""
    system = method.system
    if not len(system.coupled_multipliers):
        return
    try:
        consistent = Consistent(system, method.linear.twin(), s, method.length, method.compliance)
    except AssemblyError:
        return
    values, vectors = np.linalg.eig(np.eye(len(system.coupled_multipliers)) + consistent.friction_on_itself(s))
    binding = np.flatnonzero((values.real <= 0.0) & (np.abs(values.imag) <= REAL * np.abs(values)))
    if len(binding):
        worst = np.argmax(np.abs(vectors[:, binding[np.argmin(values[binding].real)]]))
        raise friction_binds(system, system.n_q + system.coupled_multipliers[worst], s.t)
