"""Judgement of redundant and deactivated constraints at the end of a step, in compiled code (contradictions.py)."""

from mecano.jit.kernel import kernel
from mecano.jit.memory import floats, integers
from mecano.model.numbering import ROTATION, TRANSLATION
from mecano.solve.events.compliance import soften
from mecano.solve.time.contradictions import CREEPING, SLIPS
from mecano.solve.time.workspace import TRIAL, state_of


@kernel
def contradict(m, w):
    """Return whether redundant constraints contradict one another at TRIAL by more than half the admissible gap.

    Their values are those to which their compliances give way under the reactions.
    """
    if not m.checks_gaps:
        return False
    gap = floats(w.gap, w.n_l)
    deflections(w, 1.0, gap)
    return exceeds_gap(m, gap)


@kernel
def exceeds_gap(m, violations):
    """Return whether the ``violations`` (n_l,) of redundant constraints exceed half the admissible gap."""
    weight, largest = floats(m.share_of_gap, violations.size), 0.0
    for i in range(violations.size):
        largest += (violations[i] * weight[i]) * (violations[i] * weight[i])
    return largest > 0.25


@kernel
def deflections(w, factor, out):
    """Write -c Lambda (n_l,) times a ``factor`` at TRIAL, with the compliances c of redundant constraints."""
    out[:] = 0.0
    starts, columns = integers(w.soft_starts, w.n_l + 1), integers(w.soft_columns, w.n_entries)
    multipliers = state_of(w, TRIAL).z[w.n_q : w.n]
    soften(factor, starts, columns, floats(w.soft_values, w.n_entries), multipliers, out)


@kernel
def slips(m, w):
    """Return whether a deactivated constraint slips at TRIAL, by more than half of what is allowed of the speeds."""
    if m.n_released == 0:
        return False
    s, kind, rates = state_of(w, TRIAL), integers(w.kind, w.n_all), floats(w.gap, w.n_l)
    linear, angular = CREEPING * w.length, CREEPING
    for i in range(w.n_q):
        speed = abs(s.v[i]) + w.h * abs(s.a[i])
        if kind[i] == TRANSLATION:
            linear = max(linear, speed)
        elif kind[i] == ROTATION:
            angular = max(angular, speed)
    deflections(w, w.cC, rates)
    released, along = integers(m.released, m.n_released), integers(m.along, m.n_released)
    for i in range(m.n_released):
        if abs(rates[released[i]]) > 0.5 * SLIPS * (linear if along[i] else angular):
            return True
    return False
