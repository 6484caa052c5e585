"""Steps of several sizes from one state, such as trials that locate an event; steps of similar size share factors.

A step of another size needs three matrices: two of the change of its size (step_change.py), the metric and the filter,
and the tangent of Newton's iteration. Where a step of similar size has been made, the gaps of the constraints are
closed in its metric, the solution of the filter is refined with its factor, and Newton's iteration begins where it
ended and with its tangent.
"""

from collections.abc import Callable
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from mecano.model.numbering import SIGNAL
from mecano.solve.linear.newton import CONVERGED
from mecano.solve.linear.refactorization import price
from mecano.solve.time.step_change import change_step
from mecano.solve.time.workspace import BEGIN

if TYPE_CHECKING:
    from mecano.model.state import History, State
    from mecano.solve.time.generalized_alpha import GeneralizedAlpha
    from mecano.solve.time.step_info import Trial

LARGER = 90  # unknowns from which steps share factors
SIMILAR = 0.05  # of a step size: matrices of steps that differ by less are similar


class RepeatedSteps:
    """Steps of a GeneralizedAlpha from one state; reproducible to the bit if repeated in the same order.

    They agree with ``GeneralizedAlpha.step`` to the tolerance of Newton's iteration.
    """

    def __init__(self, method: "GeneralizedAlpha"):
        system = method.system
        self.method, self.solvers = method, (method.linear.twin(), method.linear.twin())
        self.metric, self.filter = self.solvers
        self._latest = self.metric  # whose matrix is the latest one of a change of step size
        self._resolved = np.zeros(system.n)  # the last solution of the filter
        method.workspace.point_to(masses=np.zeros(system.nnz))

    def begin(self, s0: "State", history: "History", last: "State") -> "Callable[[float], Trial]":
        """Return a function of h that makes steps from ``s0`` with its ``history``.

        ``last`` is the State at the end of a step that has been made from ``s0``.
        """
        self.s0, self.history = s0, history
        self.last: State | None = last
        self.h = self.stiffness = 0.0  # size and mean stiffness of the step whose factors are kept [s, N/m]
        self.method.workspace.point_to(masses_kept=False)
        return self._step

    def _step(self, h):
        """Make a step of size h; return (state, history, StepInfo)."""
        if h == self.history.h:
            return self.method.step(self.s0, self.history, h)
        similar = self.last is not None and abs(h - self.h) <= SIMILAR * self.h
        history = self._changed(h, similar)
        if self.last is not None:
            history = self._from_the_last(self.last, history, h, similar)
        trial = self.method.step(self.s0, history, h)
        self.last = trial[0] if trial[2].ok and trial[0].t > self.s0.t else None  # h may be lost in the rounding of t
        return trial

    def _changed(self, h, similar):
        """Return the history for steps of size h."""
        w, m = self.method.workspace, self.method
        w.held = None
        w.put_state(BEGIN, self.s0)
        w.put_history(self.history)
        w.point_to(next_h=h, factored=0, delegated=True, similar=similar, similar_stiffness=self.stiffness)
        try:
            change_step(w.record)
            m.change_step_with(
                lambda stage: (self._resolve if stage else self._close_gaps)(similar),
                lambda: self._solve_again(similar),
            )
        finally:
            w.point_to(delegated=False, similar=False)
        if not similar:
            self.h, self.stiffness = h, float(w.record["stiffness"][0])
        if w.record["code"][0] == CONVERGED:
            return w.new_history(BEGIN, w.v_shift.copy(), None)
        self.h = 0.0
        return replace(self.history, h=h, tangent=None)

    def _close_gaps(self, similar):
        """Solve for the gap of the velocities in the metric; return whether it is regular."""
        m, self._latest = self.method, self.metric
        if similar:
            self.metric.solve_again(m.equations, m.increment)
        return similar or self.metric.solve(m.assembly.data, m.equations, m.increment).ok

    def _resolve(self, similar):
        """Solve for the part of the accelerations that steps resolve; return whether the tangent is regular."""
        m, self._latest = self.method, self.filter
        m.increment[:] = self._resolved
        regular = self._filtered(similar)
        self._resolved[:] = m.increment
        return regular

    def _filtered(self, similar):
        """Solve with the tangent of the filter, from the increment if ``similar``; return whether it is regular."""
        m = self.method
        regular = similar and self.filter.solve_similar(m.assembly.data, m.equations, m.increment)
        return regular or self.filter.solve(m.assembly.data, m.equations, m.increment).ok

    def _solve_again(self, similar):
        """Solve with the latest of both matrices for other equations."""
        m = self.method
        if similar and self._latest is self.filter:
            m.increment[:] = 0.0
            self._filtered(similar)
        else:
            self._latest.solve_again(m.equations, m.increment)

    def _in_axes_at_begin(self, s):
        """Return the accelerations (n_all,) of ``s``, those of free rotations in the axes at the beginning."""
        of, a = self.method.system.numbering, s.a.copy()
        free = of.rotation_dof < of.n_q
        places = of.rotation_dof[free, None] + np.arange(3)
        turns = self.s0.R[free].transpose(0, 2, 1) @ s.R[free]
        a[places] = (turns @ a[places][:, :, None])[:, :, 0]
        return a

    def _from_the_last(self, last, history, h, similar):
        """Return the ``history`` whose prediction ends on the line from the beginning to the last state."""
        s0, s1, n_q, of = self.s0, last, self.method.system.n_q, self.method.system.numbering
        slope = np.concatenate([(self._in_axes_at_begin(s1) - s0.a)[:n_q], (s1.z - s0.z)[n_q : of.n]])
        slope *= h / (s1.t - s0.t)
        signals = of.kind[: of.n] == SIGNAL  # whose rates follow from their own differences
        slope, bend = (np.where(signals, *both) for both in ((history.slope, slope), (history.bend, 0.0)))
        tangent = self.method.linear.label if similar else None
        spent = price(of.n) + 1.0
        return replace(history, slope=slope, bend=bend, tangent=tangent, age=1, drift=0.0, spent=spent)
