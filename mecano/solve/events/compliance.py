r"""Compliances that let redundant constraints share their forces: :math:`\Phi + c \Lambda = 0`.

Velocity constraints implied by position constraints are released: :math:`P \Lambda = 0` replaces them, with the
projector P on the reactions that the position constraints could balance. See docs/theory.md, section 3.
"""

from collections.abc import Mapping
from dataclasses import replace
from functools import cached_property
from typing import Any, Self

import numpy as np

from mecano.immutable import immutable
from mecano.jit.entry import Indices, Vector, entry
from mecano.maths.distinct import distinct
from mecano.maths.sparse_rows import SparseRows, sparse_rows
from mecano.model.assembly import Assembly
from mecano.model.numbering import LENGTH_CONSTRAINT, ROTATION, SIGNAL, TRANSLATION
from mecano.model.state import State
from mecano.model.system import System
from mecano.solve.diagnostics.mobility import Analysis
from mecano.solve.linear.rounding import TINY

SOFTNESS = 1e-11  # of the length scale, or rad: a tenth of the tolerance of the constraints
ROUNDED, SOFTEST = 1e3, 1e-9  # SOFTNESS is at least so many times the rounding of positions, but no more than this
SHARING = 1e-3  # of the acting forces: error of redundant reactions by the residuals of their constraints
SHARE_OF_PENALTY = 1e-7  # of the reactions, which the multipliers do not contain
RELEASED_COMPLIANCE = 1e3  # over the mean stiffness of the tangent: compliance of a released constraint
LEAST_ACCELERATION = 1.0  # [m/s2] of the mean mass, without steps
STIFFER = 1e3  # times as stiff as inertia: the vibration has a period of a fifth of a step, and is damped
ROOM = 10.0  # times the forces to which redundant constraints have yielded: those of stiffer compliances
EPSILON = 2.2e-16  # relative spacing of floating-point numbers
TIMES = 20  # at which loads are evaluated, from the start to the end


@immutable
class Compliance:
    """The symmetric matrix c, which couples rows of one element only, rows P, and their entries in the tangent.

    Constraints on velocities have the compliance c per second: ``lag`` times c in a step, whose rows are displacements.
    The rows P are multiplied by ``RELEASED_COMPLIANCE`` over the stiffness of the step. They may couple elements, for
    which the tangent has no entries. There the identity replaces them, with which Newton's iteration converges as well:
    P projects on exactly those reactions that change with the multipliers of released constraints.
    """

    matrix: SparseRows  # (n_l, n_l): c [m/N, rad/(N m)], per second for constraints on velocities; P [-]
    places: np.ndarray  # (nnz,) indices into the values of the tangent; the last one if there is none
    of_rates: np.ndarray  # (nnz,) bool
    released_entries: np.ndarray  # (nnz,) bool: P
    active: np.ndarray  # (n_l,) bool: constraints whose redundancies the compliances account for
    force: float  # [N] that displaces a length constraint by SOFTNESS of the length scale
    yielded: tuple[float, float, float]  # when it was made stiffer [s], for which displacement, by which factor
    stiffens: bool  # whether forces displace the constraints, instead of geometry
    values: np.ndarray  # (nnz,) in a step
    penalty_factors: np.ndarray  # (n_l,) of the System
    penalty_share: float  # of the System

    @cached_property
    def released(self) -> np.ndarray:
        """Indices (n,) of the released constraints."""
        return distinct(self.matrix.rows[self.released_entries])

    @cached_property
    def soft(self) -> np.ndarray:
        """Indices (n,) of the redundant constraints, which are compliant."""
        return distinct(self.matrix.rows[~self.released_entries])

    def stiffer(self, t: float, displacement: float, softness: float) -> Self:
        """Return compliances for the forces that displace the constraints at the time t [s].

        ``displacement``, and the ``softness`` at ROOM times these forces, are relative to the length scale, or in rad.
        If the last such change, at the same time, has not reduced the displacement, the constraints do not fit one
        another: then the compliances are those before it, for good.
        """
        before, last, factor = self.yielded
        if t == before and displacement > 0.5 * last:
            return self._for_forces(1.0 / factor).final()
        factor = ROOM * displacement / softness
        return replace(self._for_forces(factor), yielded=(t, displacement, factor))

    def final(self) -> Self:
        """Return these compliances, which no forces make stiffer."""
        return replace(self, stiffens=False)

    def _for_forces(self, factor):
        """Return the compliances for forces that are larger by a factor."""
        c = self.matrix
        values = np.where(self.released_entries, c.values, c.values / factor)
        matrix = SparseRows(c.starts, c.columns, values)
        return replace(self, matrix=matrix, force=self.force * factor, values=values.copy())

    def deflection(self, reactions: np.ndarray) -> np.ndarray:
        """Return c Lambda (n_l,) for the reactions Lambda (n_l,), zero for released constraints."""
        out = self.matrix @ reactions
        out[self.released] = 0.0
        return out

    @cached_property
    def in_tangent_share(self) -> np.ndarray:
        """Factors (nnz,) of ``values`` in the tangent, where the identity replaces P."""
        c = self.matrix
        return np.where(self.released_entries, (c.rows == c.columns) / c.values, 1.0)

    @property
    def largest_penalty_share(self) -> float:
        """The largest penalty over the mean stiffness of the tangent, infinite without released constraints."""
        return 1.0 / RELEASED_COMPLIANCE if len(self.released) else np.inf

    def largest_penalty(self, stiffness: float) -> float:
        """Return the largest penalty [N/m] with a negligible share of the reactions of compliant constraints.

        ``stiffness`` [N/m] is the mean stiffness of the tangent.
        """
        return min(SHARE_OF_PENALTY / self._softest, stiffness * self.largest_penalty_share)

    @cached_property
    def _softest(self) -> float:
        """The largest compliance [m/N], those of angles times the factors of their penalty."""
        by_length = self.matrix.values * self.penalty_factors[self.matrix.rows]
        return by_length[~self.released_entries].max(initial=TINY)

    @property
    def rows(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """The matrices c and P in CSR form for ``soften``: (row starts, columns, values)."""
        return self.matrix.starts, self.matrix.columns, self.values

    def set_step(self, lag: float, stiffness: float) -> None:
        """Set the values for steps of mean ``stiffness`` [N/m] in which rates count ``lag`` [s] times."""
        share = np.where(self.released_entries, RELEASED_COMPLIANCE / stiffness, np.where(self.of_rates, lag, 1.0))
        self.values[:] = share * self.matrix.values

    def soften_tangent(self, k: float, data: np.ndarray) -> None:
        """Add ``in_tangent`` to the values ``data`` (n_data,) of the tangent."""
        np.add.at(data, self.places, self.in_tangent(k))

    def in_tangent(self, k: float) -> np.ndarray:
        """Return the contribution -k^2 c (nnz,) to the tangent, whose rows of constraints are times k."""
        return -k * k * self.values * self.in_tangent_share

    def sharing(self, k: float, bottom: np.ndarray, x: np.ndarray) -> np.ndarray:
        r"""Return the right-hand sides (n_l,) of the constraints with which released constraints carry their share.

        ``x`` (n_l,) is the solution of the system of consistent.py for ``bottom``. A reaction there is
        :math:`k x - p B a`, the share of the penalty p included.
        """
        rows, out, factors = self.released, bottom.copy(), self.penalty_share * self.penalty_factors
        forces = k * x + factors * bottom
        reached = -k * RELEASED_COMPLIANCE * x[rows] - bottom[rows]  # k B a
        forces[rows] = k * x[rows] - factors[rows] * reached
        share = forces[rows] - (self.matrix @ forces)[rows]
        out[rows] = -reached - RELEASED_COMPLIANCE * (share + factors[rows] * reached)
        return out

    def to_plain(self) -> dict[str, np.ndarray]:
        """Return a dict of arrays from which ``from_plain`` restores the compliances."""
        c = self.matrix
        of = {"data": c.values, "indices": c.columns, "indptr": c.starts}
        own = {"places": self.places, "of_rates": self.of_rates, "active": self.active, "force": self.force,
               "values": self.values, "penalty_factors": self.penalty_factors,
               "penalty_share": np.array(self.penalty_share), "yielded": np.array(self.yielded),
               "stiffens": np.array(self.stiffens)}  # fmt: skip
        return {**of, **own, "let_go": self.released_entries}

    @classmethod
    def from_plain(cls, plain: Mapping[str, np.ndarray]) -> Self:
        """Restore the compliances from the dict of ``to_plain``."""
        matrix = SparseRows(plain["indptr"].astype(np.int64), plain["indices"].astype(np.int64), plain["data"])
        own = [plain[name] for name in ("places", "of_rates", "let_go", "active")]
        own += [float(plain["force"]), tuple(plain["yielded"].tolist()), bool(plain["stiffens"])]
        return cls(matrix, *own, plain["values"].copy(), plain["penalty_factors"], float(plain["penalty_share"]))


OF_POSITIONS, OF_RATES, OF_RELEASED = range(3)  # kinds of the entries of compliances
NO_ROWS = np.zeros(1, np.int64), np.zeros(0, np.int64), np.zeros(0)


def compliance_fields(compliance: Compliance | None) -> dict[str, Any]:
    """Return a Compliance, or none, as a dict of the fields that compiled code reads."""
    if compliance is None:
        starts, columns, values = NO_ROWS
        none = {"entry_places": columns, "soft_base": values, "soft_kinds": columns, "soft_in_tangent": values}
        return none | {"n_entries": 0, "soft_starts": starts, "soft_columns": columns}
    kinds = np.where(compliance.released_entries, OF_RELEASED, np.where(compliance.of_rates, OF_RATES, OF_POSITIONS))
    starts, columns, _ = compliance.rows
    return {
        "n_entries": len(compliance.places), "entry_places": compliance.places, "soft_starts": starts,
        "soft_columns": columns, "soft_base": compliance.matrix.values, "soft_kinds": kinds,
        "soft_in_tangent": compliance.in_tangent_share,
    }  # fmt: skip


def compliances_of_a_step(compliance: Compliance | None) -> dict[str, Any]:
    """Return ``compliance_fields``, and those with which compiled code sets the compliances for a step size."""
    found = compliance_fields(compliance)
    found["entry_values"] = np.zeros(found["n_entries"])
    if compliance is None:
        return found | {"soft_values": NO_ROWS[2], "largest_penalty": np.inf, "largest_penalty_share": np.inf}
    return found | {
        "soft_values": compliance.values, "largest_penalty": compliance.largest_penalty(np.inf),
        "largest_penalty_share": compliance.largest_penalty_share,
    }  # fmt: skip


@entry
def soften(k: float, starts: Indices, columns: Indices, values: Vector, multipliers: Vector, rows_out: Vector):
    """Add -k c Lambda to the rows of the constraints (n_l,); c by rows."""
    for i in range(starts.shape[0] - 1):
        for j in range(starts[i], starts[i + 1]):
            rows_out[i] -= k * values[j] * multipliers[columns[j]]


def compliance(
    system: System,
    s: State,
    length: float,
    analysis: Analysis,
    end: float | None = None,
    step: float | None = None,
    before: Compliance | None = None,
) -> Compliance | None:
    """Return the Compliance of a model from the ``analysis`` of its constraints; None if none is redundant.

    Reactions in the directions that the projector ``analysis.dependent`` (n_l, n_l) holds have a compliance: the forces
    acting in ``s``, with the loads until ``end`` [s], displace the constraints by SOFTNESS of the length scale, or rad;
    so do those of the compliance ``before``. In a run with steps of ``step`` [s] they are at least STIFFER times as
    stiff as the inertia of the mean mass in a step, which would otherwise vibrate on them. All other directions are
    exact. Signals are ignored, as they may not be known yet.
    """
    if analysis.dependent is None and analysis.release_matrix is None:
        return None
    of, force = system.numbering, _largest_force(system, s, length, end)
    acceleration = LEAST_ACCELERATION if not step else STIFFER * SOFTNESS * length / step**2
    force = max(force, before.force if before else acceleration * _mean_mass(system, s, length), TINY)
    force *= SOFTNESS / softness(system, s, length)
    angular = of.kind[system.n_q : system.n] != LENGTH_CONSTRAINT
    root = np.sqrt(SOFTNESS * np.where(angular, 1.0 / (force * length), length / force))
    parts = []
    if (dependent := analysis.dependent) is not None:
        rows = dependent.rows
        parts.append((rows, dependent.columns, root[rows] * dependent.values * root[dependent.columns]))
    if (release := analysis.release_matrix) is not None:
        parts.append((release.rows, release.columns, release.values))
    matrix = sparse_rows(*map(np.concatenate, zip(*parts, strict=True)), system.n_l)
    rows, is_released = matrix.rows, np.zeros(system.n_l, bool)
    is_released[analysis.released] = True
    places, released = _places(system, rows, matrix.columns), is_released[rows]
    own = matrix.values.copy(), system.penalty_factors, system.penalty_share
    none = -np.inf, np.inf, 1.0  # yielded
    return Compliance(matrix, places, of.of_rates[rows], released, analysis.active, force, none, True, *own)


def softness(system: System, s: State, length: float) -> float:
    """Return SOFTNESS, or, far from the origin, ROUNDED times the rounding of positions over the length scale."""
    reach = np.abs(s.z[system.numbering.kind == TRANSLATION]).max(initial=0.0) / length
    return min(max(SOFTNESS, ROUNDED * EPSILON * float(reach)), SOFTEST)


def _largest_force(system, s, length, end):
    """Return the largest force [N] in ``s``, with loads at times until ``end``."""
    of = system.numbering
    loads = [_loads(system, replace(s, t=t)) for t in np.linspace(s.t, end, TIMES)] if end is not None else []
    sizes = np.max([system.assemble(s).size, *loads], axis=0)
    return float(np.where(of.kind == ROTATION, sizes / length, sizes)[of.kind < SIGNAL].max())


def _mean_mass(system, s, length):
    """Return the mean of the masses [kg] of unknowns that have some, inertias divided by the squared length scale."""
    inertias, kind = system.assemble(s, cM=1.0).data[system.diagonal[: system.n_q]], system.numbering.kind
    kind = kind[: system.n_q]
    masses = np.where(kind == ROTATION, inertias / length**2, inertias)[kind < SIGNAL]
    return masses.sum() / max(np.count_nonzero(masses), 1)


def _loads(system, s):
    """Return the sizes (n_all,) of the loads at ``s``, except those by signals."""
    alone = Assembly(system)
    system.scale_loads(alone, s, 2.0)
    return np.abs(alone.residual)


def _places(system, rows, cols):
    """Return the indices of multiplier entries in the values of the tangent; nnz for entries not in the pattern."""
    codes = (system.n_q + rows) * system.n + system.n_q + cols
    pattern = system.rows * system.n + system.cols
    places = np.minimum(np.searchsorted(pattern, codes), system.nnz - 1)
    return np.where(pattern[places] == codes, places, system.nnz)
