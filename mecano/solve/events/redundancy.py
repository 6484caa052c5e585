"""Constraints that are redundant in some phases only: detect them after a change of phase, assign compliances."""

import numpy as np

from mecano.errors import AssemblyError
from mecano.model.state import State
from mecano.model.system import System
from mecano.solve.diagnostics.joint_redundancy import by_same_joints, redundant_groups
from mecano.solve.diagnostics.mobility import Group, analyse, gradient
from mecano.solve.events.compliance import Compliance, compliance
from mecano.solve.linear.sparse import LinearSolver
from mecano.solve.time.consistent import Consistent


def reanalyse_redundancy(
    system: System, linear: LinearSolver, s: State, soft: Compliance | None, length: float, h: float
) -> tuple[Consistent, Compliance | None, tuple[Group, ...]]:
    """Analyse the redundancy of the constraints at ``s`` again, if its phases have changed it.

    Return (Consistent, Compliance or None, redundant Groups, one for the same joints). ``soft`` is the previous
    Compliance. The model is analysed only if pivots of the factorization show that rigid constraints depend on others,
    if constraints have become active of which ``soft`` does not account for, or if constraints are released.
    ``h`` is the ``step`` [s] of ``compliance``. Raises AssemblyError.

    The pivots do not show a rigid constraint that depends on compliant ones, in which case the compliant ones would
    carry nothing. A subset of the constraints that ``soft`` accounts for has no further redundancies.
    """
    added = np.zeros(0, np.int64) if soft is None else np.flatnonzero(gradient(system, s, length)[2] & ~soft.active)
    consistent: Consistent | None = None
    repeats = True
    try:
        consistent = Consistent(system, linear, s, length, soft)
        repeats = consistent.repeats()
    except AssemblyError:
        pass
    if consistent is not None and not repeats and not len(added) and (soft is None or not len(soft.released)):
        return consistent, soft, ()
    analysis = analyse(system, s, length)
    if consistent is not None and not repeats and not len(added) and not _missed(soft, analysis):
        return consistent, soft, ()
    new = compliance(system, s, length, analysis, step=h, before=soft)
    found = redundant_groups(system, s, length, analysis) if repeats or len(added) else ()
    if len(added):
        found = _with_any(found, system, added)
    return Consistent(system, linear, s, length, new), new, by_same_joints(found)


def _missed(soft, analysis):
    """Return whether constraints that ``soft`` releases are active in ``analysis`` and no longer implied there."""
    would = np.intersect1d(soft.released, np.flatnonzero(analysis.active))
    return bool(np.setdiff1d(would, analysis.released).size)


def _with_any(found, system, constraints):
    """Return the Groups of ``found`` with any of the ``constraints`` (n,)."""
    of = system.numbering
    names = {of.name[of.n_q + i] for i in constraints}
    return tuple(group for group in found if names.intersection(group.names))
