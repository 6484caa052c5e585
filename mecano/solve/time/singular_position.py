r"""Singular positions, in which constraints become dependent: the bars of a parallelogram in one line.

At a distance :math:`\varepsilon` [rad] from such a position, a violation u of the constraints, such as its rounding,
corresponds to a displacement :math:`u/\varepsilon` across the motion, velocities :math:`u/\varepsilon^2`, and reactions
:math:`u/\varepsilon^4`: positions projected on the constraints yield useless reactions. The stages of Radau IIA are
computed with a tangent in the middle of the step, which is regular: they pass with their full accuracy. If a step ends
so near that the reactions of a projection would have less than four digits, it therefore ends with the last stage. A
step that begins and ends where less than two digits are left is too short to pass.

:math:`1/\varepsilon` is found as the *amplification*, a displacement for a violation of the constraints, relative to
its least value since the start of the run or the last event, which depends on the mechanism alone.
"""

from collections.abc import Sequence

import numpy as np

from mecano.errors import AssemblyError, ConvergenceError, name_list
from mecano.model.model import title_of
from mecano.model.state import State
from mecano.model.system import System
from mecano.solve.diagnostics.scales import constraint_scale
from mecano.solve.time.consistent import Consistent
from mecano.solve.time.increments import largest, moved
from mecano.solve.time.run_state import Method

ROUNDED, LOST = (float((share / np.finfo(float).eps) ** 0.25) for share in (1e-4, 1e-2))  # errors of reactions
TOO_NEAR = 300.0  # amplification above which a step that fails is explained by the position
BACK = 1e-4  # length scales, or rad, from a singular position: near enough, and regular
TAKE_PART = 0.1  # of the largest share of a constraint in the dependence
DRIVES = 1e-6  # of the same: share of a prescribed motion that may lead to it
MOST_NAMES = 8  # constraints in the message


class Amplification:
    """Displacements, relative to the size of the mechanism, that unit violations of its constraints cause."""

    def __init__(self, system: System, length: float):
        self.system, self.length = system, length
        signs = np.cos(np.arange(system.n_l) ** 2)  # of both signs, in no order: no dependence is without a part of it
        self.violation = signs * constraint_scale(system, length)

    def at(self, consistent: Consistent) -> float:
        """Return the amplification, 1 to 50 at usual positions and at least 1, for a factored ``Consistent``."""
        of = self.system.numbering
        return max(largest(consistent.change(self.violation), of.kind, of.n_q, self.length), 1.0)

    def places(self, consistent: Consistent, least: float) -> list[str]:
        """Return the owners of constraints that become dependent at a factored ``Consistent``, in order of share.

        Their shares are at least ``least`` times the largest one.
        """
        share, of = np.abs(consistent.impose(self.violation)[1]), self.system.numbering
        order = [i for i in np.argsort(-share, kind="stable") if share[i] >= least * share.max(initial=0.0)]
        return list(dict.fromkeys(of.name[of.n_q + i].place for i in order))

    def drives(self, consistent: Consistent) -> list[str]:
        """Return the prescribed motions that may lead to a singular position, at a factored ``Consistent``."""
        joints = self.system.model.elements
        drives = {title_of(joint.kind.name, joint.name) for joint in joints if joint.kind.drives(joint.values)}
        return [place for place in self.places(consistent, DRIVES) if place in drives]


def refuse_singular(method: "Method", s: State) -> None:
    """Raise ConvergenceError if the constraints are almost dependent at ``s``, from which no step could be taken."""
    if not method.system.n_l:
        return
    amplification = Amplification(method.system, method.length)
    # exactly there, the factors may be regular by rounding, and show nothing
    near = [found for state in (s, _before(method, s)) if (found := _factored(method, state)) is not None]
    consistent = max(near, key=amplification.at, default=None)
    if consistent is not None and amplification.at(consistent) > TOO_NEAR:
        raise cannot_go_on(amplification.places(consistent, TAKE_PART), amplification.drives(consistent), s.t)


def _factored(method, s):
    """Return the Consistent at ``s``, or None where it cannot be factored."""
    try:
        return Consistent(method.system, method.linear.twin(), s, method.length, method.compliance)
    except AssemblyError:
        return None


def _before(method, s):
    """Return the state ``s`` moved back along its velocities by BACK, as a share of the length scale or in rad."""
    of = method.system.numbering
    fastest = largest(s.v, of.kind, of.n_q, method.length)
    return moved(s.unaccelerated(), -BACK / fastest if fastest > 0.0 else 0.0, of)


def cannot_go_on(places: Sequence[str], drives: Sequence[str], t: float) -> ConvergenceError:
    """Return the error of steps that fail at a singular position at ``t`` [s], to which the ``drives`` may lead."""
    reach, within = _of_drives(drives)
    return _error(
        places,
        f"{_at(t)}{reach}what to try: {within}if it passes this position, a fixed step, or time.method: radau; "
        "elasticity of a joint or member of this loop",
    )


def cannot_pass(places: Sequence[str], drives: Sequence[str], t: float, h: float) -> ConvergenceError:
    """Return the error of a step of size h [s] up to ``t`` [s] that begins and ends near a singular position.

    The ``drives`` may lead to it.
    """
    reach, within = _of_drives(drives)
    return _error(
        places,
        f"{_at(t)}steps of {h:.3g} s are too short to pass it: the rounding of positions dominates the reactions\n"
        f"{reach}what to try: {within}a larger time.step or time.adaptive.tolerance, so that bodies turn by more than "
        "2e-3 rad in a step; time.method: generalized_alpha with fixed steps; elasticity of a joint or member of this "
        "loop, if the mechanism stops or turns back here",
    )


def _at(t):
    return f"at t = {t:.9g} s the mechanism is at a singular position, where constraints become dependent: {{}}\n"


def _of_drives(drives):
    """Return a line on prescribed motions that may lead to a singular position, and an advice on them."""
    if not drives:
        return "", ""
    return (
        f"it cannot go on if {name_list(drives, MOST_NAMES)} drives it beyond its reach\n",
        "a prescribed motion within the reach of the mechanism; ",
    )


def _error(places, text):
    """Return the error with the ``places`` of constraints entered into the ``text``."""
    return ConvergenceError(text.replace("{}", name_list(places, MOST_NAMES), 1)).about(places)
