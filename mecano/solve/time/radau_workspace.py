"""The arrays of one step of Radau IIA, in addition to the workspace, in the memory that compiled code works on."""

from collections.abc import Sequence
from typing import Any

import numpy as np

from mecano.jit.kernel import kernel
from mecano.jit.memory import floats
from mecano.model.assembly import Observation
from mecano.model.loop_records import Pointers, fields
from mecano.model.loops import observe
from mecano.model.numbering import ROTATION
from mecano.model.state import Instant, RadauHistory, State
from mecano.model.system import System
from mecano.solve.linear.factors import Factors
from mecano.solve.linear.symbolic_analysis import Pattern
from mecano.solve.time.constrained_mass import ConstrainedMass
from mecano.solve.time.radau_tableau import (
    COMPLEX,
    ERROR,
    FROM_BOTH,
    NODES,
    REAL,
    TO_BOTH,
    TO_CUBIC,
    TO_PARABOLA,
    TO_REAL,
    A,
    D,
)
from mecano.solve.time.workspace import BEGIN, state_of

# Numbers and addresses of a step; the lengths of the arrays are those of the workspace. ``last_...``: of the last step.
RADAU = fields(
    floats="last_h tolerance constraint_tolerance goal size moved reach error drift unbalanced "
    "amplified last_amplified least_amplified real complex_real complex_imaginary",
    words="known iterations has_rates projects projected "
    "nodes A D to_error to_cubic to_parabola to_real to_both from_both "
    "velocities reactions last_velocities last_reactions increments rates scratch kept_increments kept_reactions "
    "t z v a R F sizes turn parts entry_kinds turned real_values complex_values "
    "n_soft soft_entries soft_places n_sums sums n_right_sums right_sums "
    "real_scale complex_scale real_right complex_right correction "
    "factor_real factor_real_words real_outcome solve_real solve_real_words "
    "factor_complex factor_complex_words complex_outcome solve_complex solve_complex_words "
    "n_outputs observation outputs energies work mass violation",
    loops="observe",
)


@kernel
def stage_of(w, r, i):
    """Return the Instant of stage i; phases and memory are those at the beginning of the step."""
    n, m, s0 = w.n_all, w.n_rotations, state_of(w, BEGIN)
    z, v, a = floats(r.z + 8 * i * n, n), floats(r.v + 8 * i * n, n), floats(r.a + 8 * i * n, n)
    return Instant(floats(r.t, 3)[i], z, v, a, floats(r.R + 72 * i * m, (m, 3, 3)), s0.phases, s0.memory)


@kernel
def row_of(address, i, n):
    """Return row i of a matrix with n columns."""
    return floats(address + 8 * i * n, n)


@kernel
def copy_numbers(source, target, n):
    """Copy n numbers from one address to another."""
    read, written = floats(source, n), floats(target, n)
    for i in range(n):
        written[i] = read[i]


@kernel
def weight(to_coefficients, x, j):
    """Return the weight of value j, at x, in the polynomial whose ascending coefficients a matrix gives."""
    total = 0.0
    for power in range(to_coefficients.shape[0] - 1, -1, -1):
        total = total * x + to_coefficients[power, j]
    return total


class RadauWorkspace(Pointers):
    """The arrays of steps of Radau IIA of one system, and the record RADAU that holds their addresses.

    Parameters
    ----------
    system : System
    length : float
        Length scale [m].
    fixed : dict
        Fields of RADAU that never change: numbers, and arrays in the place of their addresses.
    """

    def __init__(self, system: System, length: float, **fixed: Any):
        super().__init__(RADAU)
        of, n, n_q, n_l = system.numbering, system.n, system.n_q, system.n_l
        pattern = Pattern(n, system.rows, system.cols, of.group)
        self.factors = [Factors(pattern, kind) for kind in (float, complex)]
        self.mass, self.observation = system.kept(ConstrainedMass), Observation(system)
        self.velocities, self.reactions = np.zeros((4, n_q)), np.zeros((3, n_l))
        self.last_velocities, self.last_reactions = np.zeros((4, n_q)), np.zeros((3, n_l))
        self.t, self.R = np.zeros(3), np.zeros((3, len(of.rotation_dof), 3, 3))
        self.z, self.v, self.a = np.zeros((3, 3, of.n_all))
        self.work, self.energies = np.zeros((3, 2)), np.zeros((3, 4))
        own = "velocities reactions last_velocities last_reactions t R z v a work energies"
        self.point_to_loops(observe=system.loops(observe))
        self.point_to(
            has_rates=of.of_rates.any(), real=REAL, complex_real=COMPLEX.real,
            complex_imaginary=COMPLEX.imag,
            **{name: getattr(self, name) for name in own.split()},
            nodes=NODES, A=A, D=D, to_error=ERROR, to_cubic=TO_CUBIC, to_parabola=TO_PARABOLA, to_real=TO_REAL,
            to_both=TO_BOTH, from_both=FROM_BOTH, increments=np.zeros((3, n_q)), rates=np.zeros((3, n_q)),
            scratch=np.zeros(max(3 * n_q, n)), kept_increments=np.zeros((3, n_q)), kept_reactions=np.zeros((3, n_l)),
            F=np.zeros((3, n)), sizes=np.where(of.kind[:n_q] == ROTATION, 1.0, float(length)),
            turn=np.zeros(of.n_all), parts=np.zeros((7, system.nnz)), correction=np.zeros((3, n)),
            real_scale=np.ones(n), complex_scale=np.ones((n, 2)) * [1.0, 0.0], n_outputs=system.n_outputs,
            outputs=np.zeros((3, system.n_outputs)),
            observation=self.observation.record, mass=self.mass.record, **fixed,
        )  # fmt: skip
        for name, matrix in zip(("real", "complex"), self.factors, strict=True):
            self.point_to(**{
                f"{name}_values": matrix.values, f"{name}_right": matrix.right, f"{name}_outcome": matrix.outcome,
                f"factor_{name}": matrix.factor.function, f"factor_{name}_words": matrix.factor.words,
                f"solve_{name}": matrix.solve.function, f"solve_{name}_words": matrix.solve.words,
            })  # fmt: skip

    def put_history(self, history: RadauHistory) -> None:
        """Enter the history with which a step begins."""
        self.last_velocities[:], self.last_reactions[:] = history.v, history.reactions
        r = self.record
        r["known"], r["last_h"] = history.known, history.h
        r["last_amplified"], r["least_amplified"] = history.amplified, history.least_amplified

    def raise_error(self) -> None:
        """Raise the error of the last factorization or solution in Python, if it had one."""
        for matrix in self.factors:
            if matrix.error is not None:
                raise matrix.error

    def history(self, a: np.ndarray, k: float) -> RadauHistory:
        """Return the history with which a step begins, with accelerations ``a`` (n_all,) and the mean stiffness k."""
        r = self.record[0]
        return RadauHistory(
            a, float(r["last_h"]), self.last_velocities.copy(), self.last_reactions.copy(), int(r["known"]), k,
            float(r["last_amplified"]), float(r["least_amplified"]),
        )  # fmt: skip

    def stage(self, i: int, s0: State) -> State:
        """Return stage i of a step from ``s0``."""
        z, v, a, R = (values[i].copy() for values in (self.z, self.v, self.a, self.R))
        return State(float(self.t[i]), z, v, a, R, s0.phases, s0.memory)

    def put(self, stages: Sequence[State], observed: Sequence[Observation], work: np.ndarray) -> None:
        """Enter the stages of a step before its end, with their Observations, and its work (3, 2)."""
        for i, (s, observation) in enumerate(zip(stages, observed, strict=True)):
            self.t[i], self.z[i], self.v[i], self.a[i], self.R[i] = s.t, s.z, s.v, s.a, s.R
            self.array("outputs")[i], self.energies[i] = observation.outputs, observation.energy
        self.work[:] = work
