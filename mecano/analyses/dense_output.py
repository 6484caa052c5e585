"""Rows between the ends of a long step whose stages satisfy the equations."""

from typing import TYPE_CHECKING

import numpy as np

from mecano.solve.time.interpolate import between_smooth_states, interpolate

if TYPE_CHECKING:
    from mecano.model.sampler import Sampler
    from mecano.model.state import State
    from mecano.solve.time.time_integration import Accepted


class DenseOutput:
    """The rows within one accepted step that has stages.

    Positions, velocities and coordinates follow from the motion, interpolated to the order of the method. Forces,
    energies and all else follow the cubic through their values at the beginning, at the stages and at the end, within
    the span of the two neighbours: forces evaluated at an interpolated state would satisfy no equation of motion.

    Parameters
    ----------
    sampler : Sampler
    accepted : Accepted
        The step, whose StepInfo has stages.
    row0 : (n,) array
        The row at its beginning.
    """

    def __init__(self, sampler: "Sampler", accepted: "Accepted", row0: np.ndarray):
        self._sampler, self._before, self._after = sampler, accepted.before, accepted.run.motion
        self._run, work = accepted.run, accepted.info.work
        assert work is not None, "a step that has stages has the work at these"
        states = [*accepted.info.stages, self._after]
        self.times = np.array([self._before.t, *(s.t for s in states)])
        start = accepted.run.dissipated - work[-1][0], accepted.run.given - work[-1][1]
        self.rows = np.array([row0, *(self._row(s, np.add(start, w)) for s, w in zip(states, work, strict=True))])
        self._scaled = (self.times - self.times[0]) / (self.times[-1] - self.times[0])
        self._to_cubic = np.linalg.inv(np.vander(self._scaled, increasing=True))
        motion = np.zeros(len(row0), bool)
        motion[: sampler.node_size] = True
        motion[sampler.pairs.ravel()] = True
        motion[(sampler.rotations[:, None] + np.arange(4)).ravel()] = True
        self._motion = motion

    def _row(self, s, work):
        return self._sampler.take(Sample(s, *work), self._sampler.system.observe(s)).copy()

    def at(self, t: float) -> np.ndarray:
        """Return the row (n,) at the time ``t`` [s] in the step."""
        u = (t - self.times[0]) / (self.times[-1] - self.times[0])
        j = min(max(int(np.searchsorted(self._scaled, u)), 1), len(self.times) - 1)
        row = u ** np.arange(len(self.times)) @ self._to_cubic @ self.rows
        left, right = self.rows[j - 1], self.rows[j]
        row = np.clip(row, np.minimum(left, right), np.maximum(left, right))
        of = self._sampler.system.numbering
        s = interpolate(self._before, self._after, t, of, between_smooth_states)
        row[self._motion] = self._row(s, (0.0, 0.0))[self._motion]
        return row


class Sample:
    """A motion with the work since the start, as the sampler takes it."""

    def __init__(self, motion: "State", dissipated: float, given: float):
        self.motion, self.dissipated, self.given = motion, dissipated, given
