"""Outputs of a response that formulas cannot read: of beams and superelements, and of nodes inside members.

Section forces and strains of a member depend on its own unknowns alone: their derivatives are differences of fourth
order of the outputs as the results contain them. The rotation of a node is its small rotation about an axis.
"""

import re
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
import scipy.sparse as sp

from mecano.errors import UsageError
from mecano.model.measured_outputs import AXES, index_of
from mecano.model.numbering import ROTATION, TRANSLATION
from mecano.solve.modal.linearize import by_motions
from mecano.solve.time.increments import displaced

if TYPE_CHECKING:
    from mecano.model.batch import Batch
    from mecano.model.state import State
    from mecano.model.system import System

    Change = Callable[[System, State, int, float], State]

NODE = re.compile(r"(?:nodes\.)?(\w+(?:\.\d+)?)\.(position|rotation|velocity)\.([xyz])")
MEMBER = re.compile(r"(?:elements\.)?(\w+(?:\.\d+)?)\.(\w+(?:\.[xyz])?)")
UNITS = {"position": "m", "rotation": "rad", "velocity": "m/s"}
STEP = 1e-4  # [rad], and of the length of the member: of differences, with errors of about 1e-7 of stiffer forces
SMOOTH = 1e-3  # of a derivative: difference between both sides of the state
CURVED = 1.5  # ratio of that difference for twice the step: 1 at a corner, 2 of a curve


@dataclass(frozen=True)
class NodeOutput:
    """A component of the small motion of a node: "position", "rotation" about an axis, "velocity"."""

    name: str
    unit: str
    node: str
    what: str
    axis: int

    def rows(self, system: "System", s: "State", w: np.ndarray) -> list[sp.csr_matrix]:
        """Return R0, R1, R2, each (1, n), in axes that turn with ``w`` (3,)."""
        of = system.numbering
        i = next(i for i, node in enumerate(system.nodes) if node.name == self.node)
        first, R = int((of.r if self.what == "rotation" else of.x)[i]), np.zeros((3, system.n))
        if first < of.n_q and self.what != "velocity":
            R[0, first + self.axis] = 1.0
        elif first < of.n_q:
            R[1, first + self.axis] = 1.0
            R[0, first : first + 3] = np.cross(np.eye(3)[self.axis], w)
        return [sp.csr_matrix(row[None]) for row in R]


@dataclass(frozen=True)
class MemberOutput:
    """An output of a beam or superelement, a component of a vector or a number."""

    name: str
    unit: str
    path: str
    what: str

    def rows(self, system: "System", s: "State", w: np.ndarray) -> list[sp.csr_matrix]:
        """Return R0, R1, R2, each (1, n), in axes that turn with ``w`` (3,). Raises UsageError at a corner."""
        b, e, index = _locate(system, self.path, self.what)
        place, own = b.first_output + e * b.n_outputs + index, np.unique(b.dofs[e][b.dofs[e] < system.n_q])
        base, steps = displaced(s, np.zeros(system.n_q), system.numbering), STEP * _sizes(system, s, b.dofs[e], own)

        def values(change: "Change", steps: np.ndarray) -> np.ndarray:
            """Return the outputs (n, 2) on both sides of the state, at ``steps`` of the n unknowns."""
            sides = [
                [system.observe(change(system, base, i, sign * step)).outputs[place] for sign in (1.0, -1.0)]
                for i, step in zip(own.tolist(), steps.tolist(), strict=True)
            ]
            return np.array(sides, float).reshape(-1, 2)

        middle = float(system.observe(base).outputs[place])
        q = self._slopes(values, middle, _moved, steps)
        reach = np.abs(q * steps).max(initial=0.0)
        v, a = (
            self._slopes(values, middle, change, _lengthened(steps, reach, values(change, steps)))
            for change in (_faster, _accelerated)
        )
        q, v, a = (_row(system, own, slopes) for slopes in (q, v, a))
        P, V, A0, A1 = by_motions(system, base, w)
        return [sp.csr_matrix(row) for row in (q @ P + v @ V + a @ A0, v @ P + a @ A1, a @ P)]

    def _slopes(self, values, middle, change, steps):
        """Return the derivatives (n,) by n unknowns, each changed by ``change``; ``middle``: the value at the state."""

        def slopes(factor: float) -> tuple[np.ndarray, np.ndarray]:
            """Return the mean of the slopes on both sides, and their difference."""
            above, below = values(change, factor * steps).T
            return (above - below) / (2.0 * factor * steps), (above - 2.0 * middle + below) / (factor * steps)

        (near, bend), (far, further) = slopes(1.0), slopes(2.0)
        found = (4.0 * near - far) / 3.0
        # in changes of the output, which have one unit for all unknowns
        largest = np.abs(bend * steps).max(initial=0.0)
        if (
            largest > SMOOTH * np.abs(found * steps).max(initial=0.0)
            and np.abs(further * steps).max(initial=0.0) < CURVED * largest
        ):
            raise UsageError(f"output {self.name}: it has a corner at this state, like a magnitude that is zero")
        return found


def _sizes(system, s, dofs, own):
    """Return the size (n,) of each unknown ``own`` of a member: 1 rad of rotations, its length of all others."""
    kind = system.numbering.kind
    x = s.z[dofs[kind[dofs] == TRANSLATION]].reshape(-1, 3)
    length = float(np.linalg.norm(np.ptp(x, axis=0))) if len(x) else 0.0
    return np.where(kind[own] == ROTATION, 1.0, length or 1.0)


def _lengthened(steps, reach, sides):
    """Return steps of rates which change an output by ``reach``, as motions do, if ``steps`` give the values ``sides``.

    It is of the first degree in accelerations and of the second in velocities, of which differences are exact; small
    steps would drown in the rounding of the forces of stiff members.
    """
    change = np.abs(sides[:, 0] - sides[:, 1]).max(initial=0.0) / 2.0
    return steps * max(reach / change, 1.0) if change > 0.0 else steps


def _row(system, own, slopes):
    """Return derivatives by the unknowns ``own`` as a sparse row (1, n)."""
    found = np.zeros((1, system.n))
    found[0, own] = slopes
    return sp.csr_matrix(found)


def _moved(system, s, i, step):
    dq = np.zeros(system.n_q)
    dq[i] = step
    return displaced(s, dq, system.numbering)


def _faster(system, s, i, step):
    out = s.copy()
    out.v[i] += step
    return out


def _accelerated(system, s, i, step):
    out = s.copy()
    out.a[i] += step
    return out


def _locate(system: "System", path: str, what: str) -> "tuple[Batch, int, int]":
    """Return the Batch of an element, its index there, and the index of its output."""
    for b in system.batches:
        for e, (own, label) in enumerate(b.paths):
            if own == path and (index := index_of(what, b.kind, label)) is not None:
                return b, e, index
    raise AssertionError(f"{what} is not an output of {path}")


def node_output(name: str, known: Callable[[str], bool], measured: Callable[[str], bool]) -> NodeOutput | None:
    """Return the NodeOutput of a name, or None for another name.

    ``known(node)``: whether the node exists; ``measured(node)``: whether formulas read its position and velocity.
    """
    found = NODE.fullmatch(name)
    if not found or not known(found[1]) or (found[2] != "rotation" and measured(found[1])):
        return None
    return NodeOutput(name, UNITS[found[2]], found[1], found[2], AXES.index(found[3]))


def member_output(name: str, outputs: "Callable[[str], Iterator[tuple[str, str]]]") -> MemberOutput | None:
    """Return the MemberOutput of a name, or None; ``outputs(element)`` yields (name, unit) of each output."""
    if not (found := MEMBER.fullmatch(name)):
        return None
    own = (MemberOutput(name, unit, f"elements/{found[1]}", what) for what, unit in outputs(found[1]))
    return next((one for one in own if one.what == found[2]), None)
