"""Constraints that repeat others only in some modes: found when these are entered, and given compliances."""

import numpy as np

from mecano.errors import AssemblyError
from mecano.solve.diagnostics.analysis import analyse, gradient
from mecano.solve.diagnostics.joint_redundancy import redundant_groups
from mecano.solve.events.compliance import compliance
from mecano.solve.time.consistent import Consistent


def consistent_in(system, linear, s, soft, length):
    """(Consistent, Compliance or None, redundant Groups) at ``s``, whose modes may be new; ``soft`` that of the last.

    The pivots of the factorization tell whether constraints that are rigid depend on others; only then, or where
    constraints are let go because of others, is the model analysed again. Raises AssemblyError.
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
    """True when constraints that ``soft`` lets go would hold at ``s``, and no others imply them there any more."""
    would = np.intersect1d(soft.released, np.flatnonzero(gradient(system, s, length)[2]))
    return bool(np.setdiff1d(would, analysis.released).size)
