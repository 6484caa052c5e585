"""Constraints that repeat others only in some mode: found when it is entered, and given compliances."""

from mecano.errors import AssemblyError
from mecano.solve.analysis import analyse
from mecano.solve.compliance import compliance
from mecano.solve.consistent import Consistent


def consistent_in(system, linear, s, soft, length):
    """(Consistent, Compliance or None, redundant Groups) at ``s``, whose modes may be new; ``soft`` that of the last.

    The pivots of the factorization tell whether constraints that are rigid depend on others; only then is the model
    analysed again. Raises AssemblyError.
    """
    try:
        consistent = Consistent(system, linear, s, soft)
        if not consistent.repeats():
            return consistent, soft, ()
    except AssemblyError:
        pass
    analysis = analyse(system, s, length)
    soft = compliance(system, s, length, analysis.dependent)
    return Consistent(system, linear, s, soft), soft, analysis.redundant
