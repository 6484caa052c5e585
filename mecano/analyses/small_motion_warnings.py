"""Warnings about small motions: no equilibrium, variable or inaccurate equations."""

from collections.abc import Iterator, Sequence

import numpy as np
import scipy.sparse as sp

from mecano.analyses.operating_point import OperatingPoint
from mecano.analyses.unsteady_bodies import unsteady_bodies
from mecano.errors import name_list
from mecano.model.numbering import TRANSLATION
from mecano.model.state import State
from mecano.model.system import System
from mecano.solve.linear.rounding import ROUNDING
from mecano.solve.modal.linearize import RESTING, Linearization
from mecano.solve.modal.modes import CONVERGED, unstable

CONSTANT = 1e-3  # change by a turn of one radian below which matrices count as constant
STEADY = 1e-8  # the same, below which a state is steady; rounding errors cause 1e-10
SLOW = 10.0  # times the rate of change of the matrices: slower motions are affected by this change
BALANCED = 1e-6  # of the largest force: inertia forces below which a state at rest counts as an equilibrium
NAMED = 3  # nodes of a body that a warning names
NOT_CONVERGED = "not converged"


def imbalance_warnings(base: OperatingPoint, w: np.ndarray, what: str = "the modes are those") -> Iterator[str]:
    """Yield a warning if a state at rest in axes with the angular velocity ``w`` (3,) is not an equilibrium there.

    The warning requires a body that accelerates relative to these axes by more than rounding errors. Bodies may turn in
    place, as the pylon of a rotor does relative to its blades. If a start moves there, it requires a body that moves
    and begins to deform. ``what``: description of the results.
    """
    system, s = base.prepared.system, base.state
    a = _relative_accelerations(system, s, w)
    if a is None and not base.is_start:
        return
    M, size = _matrix(system, s, 0.0, 1.0)
    K, _ = _matrix(system, s, 1.0, 0.0)
    if a is None:
        yield from (_unsteady(system, *body, what) for body in unsteady_bodies(system, s, M, K, size))
        return
    stiffness = np.abs(K.data).max(initial=0.0)
    rounding = ROUNDING * stiffness * np.abs(s.z[system.numbering.kind == TRANSLATION]).max(initial=0.0)
    if np.abs(M @ a).max(initial=0.0) > max(BALANCED * size, rounding):
        remedy = (
            "write 'initial: {steady: {angular_velocity: ..., about: ...}}'" if np.any(w) else
            "write 'initial: static'" if base.is_start else "add --at-rest (in Python at_rest=True)"
        )  # fmt: skip
        yield (
            f"the {'start' if base.is_start else 'state'} is not an equilibrium: {what} of this shape, without the "
            f"forces in the members that its loads cause; for those about the equilibrium {remedy}"
        )


def _unsteady(system, nodes, turns, what):
    """Return the warning about a body, given by its ``nodes``, that begins to deform; ``turns``: not only moves."""
    names = name_list([f"'{system.nodes[i].name}'" for i in nodes], NAMED)
    motion, remedy = ("turn", "angular_velocity: ..., about: ...") if turns else ("move", "velocity: ...")
    return (
        f"the start is not steady: the nodes {names} {motion} as one body, which begins to deform: {what} of "
        f"this shape, without the forces in its members that this motion and its loads cause; for those of a steady "
        f"motion write 'initial: {{steady: {{{remedy}}}}}'"
    )


def _relative_accelerations(system: System, s: State, w: np.ndarray) -> np.ndarray | None:
    """Return the accelerations (n_q,) relative to axes with the angular velocity ``w``, None if the state moves there.

    The axes turn about the origin or about any other point. Angular accelerations of nodes that turn in place are zero.
    """
    of, n_q = system.numbering, system.n_q
    v, a = s.v[:n_q].copy(), s.a[:n_q].copy()
    at = of.x[of.x < n_q][:, None] + np.arange(3)  # nodes may share a position
    a[at] -= np.cross(w, v[at])
    v[at] -= np.cross(w, s.z[at])
    if np.any(w):
        v[at] -= v[at[:1]]
    free = of.rotation_dof < n_q
    rotations = of.rotation_dof[free][:, None] + np.arange(3)
    v[rotations] -= w @ s.R[free]
    rounding = max(ROUNDING * np.abs(s.v[:n_q]).max(initial=0.0), RESTING)
    in_place = rotations[np.abs(v[rotations]).max(axis=1) > rounding]
    a[in_place], v[in_place] = 0.0, 0.0
    return None if np.any(np.abs(v[~system.signals]) > rounding) else a


def _matrix(system, s, cK, cM):
    """Return cK K + cM M (n_q, n_q) and the largest force or moment on a node."""
    assembly, n_q = system.assemble(s, cK=cK, cM=cM), system.n_q
    whole = sp.csr_matrix((assembly.data[: system.nnz], (system.rows, system.cols)), shape=(system.n, system.n))
    return whole[:n_q, :n_q], assembly.size.max(initial=0.0)


def accuracy_warnings(
    variation: float, residuals: np.ndarray | Sequence[float], what: str = "the modes hold"
) -> Iterator[str]:
    """Yield warnings about variable matrices, and about modes that do not satisfy the equations.

    ``what``: description of the results.
    """
    if variation > CONSTANT:
        yield (
            "the linearized equations are not constant in these axes: while the fastest body turns by 1 rad they "
            f"change by {variation:.2g} of their size, so {what} for this instant only; for a rotor take axes that "
            "turn with its hub, by --frame NODE (in Python frame=)"
        )
    worst = float(np.max(residuals, initial=0.0))
    if worst > CONVERGED:
        yield (
            f"modes marked '{NOT_CONVERGED}' do not satisfy the equations (residual up to {worst:.2g} of the terms): "
            "neither their eigenvalues nor their shapes are reliable; try the other solver, dense or sparse"
        )


def noticed(lin: Linearization, lowest: float) -> float:
    """Return the variation of a Linearization, or 0 if its matrices stay constant for motions at ``lowest`` [rad/s].

    They do in a mechanism that has all but come to rest: its bodies would turn by a radian in hours.
    """
    return lin.variation if lin.pace > CONSTANT * lowest else 0.0


def slowest(values: np.ndarray) -> float:
    """Return the least modulus [rad/s] of eigenvalues (m,) other than zero; 0 if all are."""
    return float(np.abs(values[values != 0.0]).min(initial=np.inf)) if values.any() else 0.0


def slow_mode_warnings(lin: Linearization, values: np.ndarray) -> Iterator[str]:
    """Yield a warning if modes with eigenvalues ``values`` (m,) swing or grow hardly faster than the matrices change.

    CONSTANT refers to a turn of the fastest body, such as the wheel of a car, whose motion in a curve is far slower.
    """
    slow = ((values.imag != 0.0) | unstable(values)) & (values != 0.0) & (np.abs(values) < SLOW * lin.pace)
    if STEADY < lin.variation <= CONSTANT and np.any(slow):
        yield (
            f"the linearized equations change at a rate of {lin.pace:.2g} 1/s in these axes: modes with eigenvalues "
            f"below {SLOW * lin.pace:.2g} 1/s hold for this instant only, and may grow for this reason alone; see "
            "--frame (in Python frame=)"
        )


def slow_response_warnings(lin: Linearization, lowest: float) -> Iterator[str]:
    """Yield a warning if the matrices change hardly more slowly than the ``lowest`` frequency [rad/s] of a response."""
    if STEADY < lin.variation <= CONSTANT and lowest < SLOW * lin.pace:
        yield (
            f"the linearized equations change at a rate of {lin.pace:.2g} 1/s in these axes: below "
            f"{SLOW * lin.pace / (2.0 * np.pi):.2g} Hz the response holds for this instant only; see --frame (in "
            "Python frame=)"
        )
