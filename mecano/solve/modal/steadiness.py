"""Whether the state that a search for a steady motion found is steady, and the errors of one that is not."""

from typing import TYPE_CHECKING

import numpy as np

from mecano.errors import ConvergenceError
from mecano.solve.diagnostics.failure import worst_equations

if TYPE_CHECKING:
    from mecano.model.state import State
    from mecano.solve.modal.steady import Steady

STEADY = 1e-6  # of the speed: largest rate of a constraint, and event value [m, N or N m] over the length scale
OF_RATES = "; for a drive whose rate is a signal, an 'initial' value of its integrator near the rate in steady motion"


def require_steady(steady: "Steady", s: "State", arrived: bool) -> None:
    """Raise ConvergenceError if the state ``s`` of a Steady is not in the steady motion that it seeks.

    ``arrived``: Newton's method converged at ``s``. Then rates of constraints must be zero, and the forces constant.
    """
    system, motion, at = steady.system, steady.motion, steady.tangent(s)
    text, names = f"no {motion.title} was found", system.numbering.name
    if not arrived:
        worst = worst_equations(system, system.assemble(s, cK=1.0))
        raise ConvergenceError(
            f"{text}: forces remain out of balance or constraints violated; the worst equations:\n"
            f"{worst}{motion.cause_of_imbalance(steady, s, at)}\nwhat to try: {motion.remedy}"
            + (OF_RATES if any(batch.kind.inputs == ("rate",) for batch in system.batches) else "")
        )
    unsettled = steady.monitor.values(s) > STEADY * steady.length
    if unsettled.any():
        events = [f"{event.element} ({event.name})" for event in steady.monitor.apply(s, unsettled)[1]]
        raise ConvergenceError(
            f"{text}: stops or contacts do not settle: {', '.join(events)}\n"
            "what to try: initial positions in which they are open or closed as in the steady motion"
        )
    off = np.abs(at.rates) / steady.speed
    if off.max(initial=0.0) > STEADY:
        name = names[system.n_q + int(np.argmax(off))]
        raise ConvergenceError(
            f"{text}: the constraint '{name}' would be violated over time\nwhat to try: {motion.remedy_for_constraints}"
        )
    change, allowed = motion.change_of_forces(steady, s, at)
    if np.any(change > allowed):
        raise ConvergenceError(
            f"{text}: the forces change over time, in {names[int(np.argmax(change))]}\n"
            f"what to try: {motion.remedy_for_forces}"
        )
