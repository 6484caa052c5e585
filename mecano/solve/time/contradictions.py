"""Contradictions: redundant or deactivated constraints that the other constraints violate."""

import math
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from mecano.errors import AssemblyError, Failure
from mecano.model.numbering import LENGTH_CONSTRAINT, ROTATION, TRANSLATION
from mecano.solve.diagnostics.constraint_names import by_joint
from mecano.solve.diagnostics.joint_redundancy import redundant_groups
from mecano.solve.diagnostics.mobility import Group, analyse
from mecano.solve.diagnostics.scales import constraint_scale
from mecano.solve.events.compliance import NO_ROWS, Compliance, softness

if TYPE_CHECKING:
    from mecano.model.state import History, State
    from mecano.model.system import System
    from mecano.solve.time.radau import RadauHistory
    from mecano.solve.time.run_state import Method, RunState
    from mecano.solve.time.step_info import Trial

MOST_OTHERS, MOST_ALIKE = 12, 6  # lines on constraints that contradict one, and joints named in each
TEXT = "constraints contradict one another: the {} of {} to {}{}"
GAP = 1e-6  # of the length scale, or rad: of constraints that repeat one another, which give way by 1e-11 of it
YIELDING = 1e-8  # of the length scale, or rad: displacement by forces for which redundant constraints are made stiffer
AT_START = 1e-6  # of the speeds: the rate of a deactivated constraint while the others hold exactly
SLIPS = 0.02  # of the speeds: the same at the end of a step
NOTICED = 0.5  # of the admissible violation: from there on compiled code leaves a step to Python
CREEPING = 1e-3  # of the length scale per second: no speeds count for less


class Contradictions:
    """Checks of the redundant and deactivated constraints of a system; ``compliance`` is None if it has none.

    Attributes
    ----------
    released : (m,) int
        Indices of the deactivated constraints.
    along : (m,) int
        1 of those along a direction, whose rates are in m/s; 0 of those about one, rad/s.
    fields : tuple
        Names and values of the fields of the record STRIDE by which compiled code checks the constraints.
    soft : ((n,) int, (n,) int)
        Indices of the redundant constraints, which are compliant, and whether they are along a direction.
    share_of_gap : (n_l,) float
        Reciprocal of the violation of each constraint that Python examines; 0 if it is not checked.
    """

    def __init__(self, system: "System", length: float, compliance: Compliance | None):
        self.system, self.length, self.compliance = system, length, compliance
        self._redundant: tuple[Group, ...] | None = None  # found when a contradiction is described
        self.released = NO_ROWS[1] if compliance is None else compliance.released.astype(np.int64)
        self._soft = NO_ROWS[1] if compliance is None else compliance.soft
        self._examined = YIELDING if compliance is None or compliance.stiffens else GAP
        of, allowed = system.numbering, self._examined * constraint_scale(system, length)
        self.along, along = (
            (of.kind[of.n_q + rows] == LENGTH_CONSTRAINT).astype(np.int64) for rows in (self.released, self._soft)
        )
        self.soft = self._soft.astype(np.int64), along
        self.share_of_gap = np.where(np.isin(np.arange(of.n_l), self._soft) & ~of.of_rates, 1.0 / allowed, 0.0)
        arrays = {name: getattr(self, name) for name in ("share_of_gap", "released", "along")}
        numbers = ("checks_gaps", self.possible), ("n_released", len(self.released))
        self.fields = *numbers, *((name, array.ctypes.data) for name, array in arrays.items())

    @property
    def possible(self) -> bool:
        """True if redundant constraints have compliances."""
        return len(self._soft) > 0

    def refuse(self, s: "State", h: float) -> None:
        """Raise AssemblyError if the exact constraints violate others at the consistent state ``s``."""
        for rows, others in (
            (self.released, "constraints on positions leave a slip"),
            (self._soft, "other constraints leave a rate"),
        ):
            if len(rows) and (text := self._rate(s, h, rows, self.system.constraint_derivatives(s)[:, 1], AT_START)):
                text = f"at t = {s.t:.9g} s {TEXT.format(others, *text)}"
                raise AssemblyError(text, Failure.CONTRADICTION, timed=True)

    def yielding(self, trial: "Trial") -> float:
        """Return ``displaced`` at the end of a ``trial`` step, 0 if Newton's iteration did not converge."""
        s, _, info = trial
        return self.displaced(s) if info.ok or info.failure is Failure.CONTRADICTION else 0.0

    def displaced(self, s: "State") -> float:
        """Return the displacement of redundant constraints by reactions at ``s`` for which they need be stiffer, or 0.

        It is relative to the length scale, or in rad.
        """
        soft = self.compliance
        if soft is None or not self.possible or not soft.stiffens:
            return 0.0
        size = soft.deflection(s.z[self.system.n_q : self.system.n]) * self.share_of_gap
        return YIELDING * math.sqrt(size @ size) if size @ size > NOTICED**2 else 0.0

    def at_the_end(self, s: "State", h: float, slips: np.ndarray) -> str:
        """Return the text of a contradiction after a step of size h to ``s``, or "".

        ``slips`` (n_l,) are the rates of the deactivated constraints.
        """
        if len(self.released) and (text := self._rate(s, h, self.released, slips, SLIPS)):
            return TEXT.format("constraints on positions leave a slip", *text)
        if len(self._soft) and (text := self._gap(s)):
            return TEXT.format("other constraints leave a gap", *text)
        return ""

    def _rate(self, s, h, rows, rates, share):
        """Return rate, name and others of a row whose rate, of ``rates`` (n_l,), exceeds a ``share`` of speeds."""
        of = self.system.numbering
        kind, along = of.kind[: of.n_q], of.kind[of.n_q + rows] == LENGTH_CONSTRAINT
        speeds = np.abs(s.v[: of.n_q]) + h * np.abs(s.a[: of.n_q])
        linear = speeds[kind == TRANSLATION].max(initial=CREEPING * self.length)
        slip = np.abs(rates[rows]) / np.where(along, linear, speeds[kind == ROTATION].max(initial=CREEPING))
        worst = int(np.argmax(slip))
        if slip[worst] <= share:
            return ()
        name = of.name[of.n_q + rows[worst]]
        return f"{rates[rows[worst]]:.3g} {'m/s' if along[worst] else 'rad/s'}", name, self._others(s, name)

    def _gap(self, s):
        """Return size, name and others of a redundant constraint violated at ``s`` by more than GAP, or ()."""
        off = self.system.constraint_derivatives(s)[:, 0]
        size = off * self.share_of_gap * (self._examined / GAP)
        if size @ size <= 1.0:
            return ()
        worst, of = int(np.abs(size).argmax()), self.system.numbering
        unit = "m" if of.kind[of.n_q + worst] == LENGTH_CONSTRAINT else "rad"
        name = of.name[of.n_q + worst]
        return f"{off[worst]:.3g} {unit}", name, self._others(s, name)

    def _others(self, s, name):
        """Return a text that names the constraints which are redundant together with the one of this ``name``."""
        if self._redundant is None:
            self._redundant = redundant_groups(self.system, s, self.length, analyse(self.system, s, self.length))
        lines = []
        for group in self._redundant:
            if name in group.names:
                others = [other for other in group.names if other != name]
                lines += by_joint(others, group.totals, MOST_ALIKE)
        more = [f"and {len(lines) - MOST_OTHERS} more kinds of joints and directions"] * (len(lines) > MOST_OTHERS)
        return "".join(["; the others are:", *(f"\n  {line}" for line in lines[:MOST_OTHERS] + more)]) if lines else ""


def start_stiff(method: "Method", s: "State", h: float) -> "tuple[State, History | RadauHistory]":
    """Return a consistent state and history, with compliances of redundant constraints for the forces there."""
    while True:
        (begun, history), soft = method.start(s, h), method.compliance
        if soft is None or not (displacement := method.contradictions.displaced(begun)):
            return begun, history
        method.use(soft.stiffer(s.t, displacement, softness(method.system, s, method.length)))


def stiffened(method: "Method", run: "RunState", displacement: float) -> "RunState":
    """Return the run with stiffer compliances if forces displace redundant constraints in its next step.

    If its motion is another one, ``powers`` are still those of the old one.
    """
    s, soft = run.motion, run.compliance
    assert soft is not None, "only compliances are displaced"
    stiffer = soft.stiffer(s.t, displacement, softness(method.system, s, method.length))
    method.use(stiffer)
    try:
        s, history = method.start(s, run.h)
    except AssemblyError:  # constraints contradict one another, which the next step refuses if it is too much
        method.use(soft.final())
        return replace(run, compliance=method.compliance)
    return replace(run, motion=s, history=history, compliance=stiffer)
