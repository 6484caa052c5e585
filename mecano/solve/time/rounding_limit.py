r"""Tolerances that no step size can meet, because of the rounding of the positions.

Positions are known to :math:`u L r`, with u = 2.2e-16, the length scale L and the largest coordinate r over it (at
least 1), and the accelerations of a step of size h to :math:`u L r/(\beta h^2)`. The estimate of the local error,
:math:`C_e h^2 |\Delta a|`, is therefore at least about u r at any step size, while the share of the tolerance of a step
falls with h. If that share is less, trials are rejected or accepted by chance, and the step size falls without bound.

The error of a smooth motion, such as that of a spinning top, may be far below u r. A tolerance is therefore too tight
only if many trials are rejected, too, or if the motion has grown out of all bounds, as in an unstable control loop:
with constant errors its steps would become ever shorter.
"""

import numpy as np

from mecano.errors import ConvergenceError
from mecano.model.state import State
from mecano.solve.time.increments import reach_of
from mecano.solve.time.run_state import Method, RunState
from mecano.solve.time.step_control import StepControl

NEAR = 4.0 * np.finfo(float).eps  # of the reach: share of a step that its rounding may exceed
FAR = 1e6  # a reach that no model has
TRIALS = 2000  # judged together
REJECTED = 0.2  # of them


class RoundingLimit:
    """Monitor of the rejected trials of a run; ``refuse`` is called repeatedly with its RunState."""

    def __init__(self, control: StepControl, method: "Method"):
        self.control, self.method = control, method
        self._begun: tuple[int, int] | None = None  # accepted and rejected steps when rounding began to matter
        # reach of a motion that grows without bound
        self._most = FAR * max([1.0, *(np.abs(node.x).max() / method.length for node in method.system.nodes)])

    def refuse(self, run: RunState, cuts: int) -> None:
        """Raise ConvergenceError if the last trials were rejected because of rounding, or the motion left all bounds.

        ``cuts`` is the number of trials in the run that were rejected for other reasons.
        """
        here = run.steps, run.rejected - cuts
        if not below_rounding(self.control.allowed(run.h), run.motion, self.method):
            self._begun = None
            return
        reach = reach_of(run.motion.z, self.method.system.numbering, self.method.length)
        if reach > self._most:
            raise self._runaway(run, reach)
        begun = self._begun = self._begun or here
        steps, rejected = here[0] - begun[0], here[1] - begun[1]
        if steps + rejected < TRIALS:
            return
        if rejected >= REJECTED * (steps + rejected):
            raise self._too_tight(run, rejected, steps + rejected)
        self._begun = here

    def _runaway(self, run, reach):
        """Return the error of a motion that grows without bound."""
        return ConvergenceError(
            f"at t = {run.motion.t:.9g} s the motion has grown to {reach:.2g} length scales, and still grows: steps "
            f"for a tolerance of {self.control.tolerance:.3g} length scales have become as short as {run.h:.3g} s\n"
            "what to try: look at the motion so far (`mecano post`); is a gain, a stiffness or a sign wrong?"
        )

    def _too_tight(self, run, rejected, trials):
        """Return the error of a tolerance for which ``rejected`` of the last ``trials`` were rejected."""
        other = "time.method: radau, whose steps are much longer; " if self.method.order == 2 else ""
        allowed = f"an error of {self.control.allowed(run.h):.2g} of the length scale in a step of {run.h:.3g} s"
        return ConvergenceError(
            f"at t = {run.motion.t:.9g} s the tolerance of {self.control.tolerance:.3g} cannot be met: it allows "
            f"{allowed}, less than the rounding of positions, for which {rejected} of the last {trials} trials were "
            "rejected\n"
            f"what to try: a larger time.adaptive.tolerance; {other}a shorter run, whose fewer steps share it"
        )


def below_rounding(error: float, s: State, method: "Method") -> bool:
    """Return whether an ``error``, relative to the length scale, is below the rounding error of ``s``."""
    return bool(error < NEAR * FAR and error < NEAR * reach_of(s.z, method.system.numbering, method.length))
