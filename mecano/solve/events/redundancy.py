"""Constraints that are redundant in some phases only: detect them after a change of phase, assign compliances."""

import numpy as np

from mecano.errors import AssemblyError
from mecano.solve.diagnostics.analysis import analyse, gradient
from mecano.solve.diagnostics.joint_redundancy import redundant_groups
from mecano.solve.events.compliance import compliance
from mecano.solve.time.consistent import Consistent


def reanalyse_redundancy(system, linear, s, soft, length):
    """Analyse the redundancy of the constraints at ``s`` again, if its phases have changed it.

    Return (Consistent, Compliance or None, redundant Groups). ``soft`` is the previous Compliance. The model is
    analysed only if pivots of the factorization show that rigid constraints depend on others, or if constraints are
    released. Raises AssemblyError.
    """
    consistent, repeats = None, True
    try:
        consistent = Consistent(system, linear, s, soft)
        repeats = consistent.repeats()
    except AssemblyError:
        pass
    if not repeats and (soft is None or not len(soft.released)):
        return consistent, soft, ()
    analysis = analyse(system, s, length)
    if not repeats and not _missed(system, s, length, soft, analysis):
        return consistent, soft, ()
    soft = compliance(system, s, length, analysis)
    found = redundant_groups(system, s, length, analysis) if repeats else ()
    return Consistent(system, linear, s, soft), soft, found


def _missed(system, s, length, soft, analysis):
    """Return whether constraints that ``soft`` releases would be active at ``s`` and are no longer implied there."""
    would = np.intersect1d(soft.released, np.flatnonzero(gradient(system, s, length)[2]))
    return bool(np.setdiff1d(would, analysis.released).size)
