"""Constraints that are redundant in some phases only: detect them after a change of phase, assign compliances."""

import numpy as np

from mecano.errors import AssemblyError
from mecano.solve.diagnostics.analysis import analyse, gradient
from mecano.solve.diagnostics.joint_redundancy import redundant_groups
from mecano.solve.events.compliance import compliance
from mecano.solve.time.consistent import Consistent


def consistent_in(system, linear, s, soft, length):
    """Return (Consistent, Compliance or None, redundant Groups) at ``s``, whose phases may have changed.

    ``soft`` is the previous Compliance. The pivots of the factorization show whether rigid constraints depend on
    others; only then, or if constraints are released, is the model analysed again. Raises AssemblyError.
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
