r"""Local error of a step; that of oscillations is bounded by their amplitude.

The errors of a run of the duration T in such steps add up to :math:`\tau^2 \Delta a`, :math:`\tau^2` = Ce h T. Of a
mode of circular frequency omega this may be too much: it can be off by no more than its amplitude,
:math:`a/\omega^2`. Both are alike at :math:`\omega_c^3 = 1/(Ce h^2 T)`, and the error counted is

.. math:: \tau^2 |P^2 \Delta a| + |P (1 - P) a| / \omega_c^2, \qquad P = \omega_c^2 (K + \omega_c^2 M)^{-1} M

along the constraints (modal_filter.py); but all of :math:`\Delta a` where the motion is unstable (docs/theory.md, 2.2).
Where the constraints allow no part of it, as in a prescribed motion, the errors do not add up. Those of one step are
limited to the tolerance in any case: between the ends of steps the motion follows from velocities, which are as wrong.
"""

from typing import TYPE_CHECKING

import numpy as np

from mecano.jit.entry import Records, entry
from mecano.jit.kernel import kernel
from mecano.jit.memory import floats, integers
from mecano.model.loop_records import fields, record
from mecano.solve.time.increments import carried_history, compared, largest_change
from mecano.solve.time.modal_filter import (
    FLOATS,
    WORDS,
    factor_filter,
    filter_fields,
    keep_masses,
    negative_pivots,
    resolve,
)
from mecano.solve.time.step_control import FORGOTTEN, allowed, counted
from mecano.solve.time.workspace import STEP, TRIAL, history_of, state_of

if TYPE_CHECKING:
    from mecano.solve.time.generalized_alpha import GeneralizedAlpha

FREE = 1e6  # times the weight of the masses: beside it any stiffness is negligible
NOTHING = 1e-8  # of a change of the accelerations: a part along the constraints that may be rounding
BOUND = fields(floats=f"bounded {FLOATS}", words=f"vectors {WORDS}")
NONE, CHANGE, PART, TWICE = range(4)  # rows of ``vectors``, (4, n_all)


@entry
def bound_error(bound: Records(BOUND), work: Records(STEP)):
    """Write the error of the step in the workspace, ``bounded``."""
    b, w = bound[0], work[0]
    true, a0, _, _ = carried_history(w)
    change = row(w, b, CHANGE)
    began, ended = compared(w.am, true, state_of(w, TRIAL).a, a0, history_of(w, TRIAL)[0])
    for i in range(w.n_q):
        change[i] = ended[i] - began[i]
    all_of_it = size(w, b, change)
    plain = w.error * w.h * w.h * all_of_it
    b.bounded = plain
    summed = w.duration * w.error * w.h
    limit = (summed * w.h) ** (-2.0 / 3.0)
    keep_masses(w, b)
    if not factor_filter(w, b, FREE * limit):
        return
    stable, part, twice = negative_pivots(w, b), row(w, b, PART), row(w, b, TWICE)
    resolve(w, b, change, part)
    whole = size(w, b, part)
    if whole <= NOTHING * all_of_it:
        b.bounded = counted(plain, FORGOTTEN, w.duration, w.h)
        return
    if not whole < np.inf or not factor_filter(w, b, limit) or negative_pivots(w, b) != stable:
        return
    oscillation = max(filtered_twice(w, b, began), filtered_twice(w, b, ended))
    resolve(w, b, change, part)
    resolve(w, b, part, twice)
    share = min((size(w, b, twice) + oscillation / (limit * summed)) / whole, 1.0)
    b.bounded = max(plain * share, allowed(plain, w.duration, w.h))


@kernel
def row(w, b, which):
    """Return one of the vectors (n_all,)."""
    return floats(b.vectors + 8 * which * w.n_all, w.n_all)


@kernel
def size(w, b, a):
    """Return the largest of ``a``: of a node over the length scale, or of a scalar with inertia."""
    return largest_change(row(w, b, NONE), a, integers(w.kind, w.n_all), w.n_q, w.length)


@kernel
def filtered_twice(w, b, a):
    """Return the size of P (1 - P) ``a``."""
    part, twice = row(w, b, PART), row(w, b, TWICE)
    resolve(w, b, a, part)
    resolve(w, b, part, twice)
    for i in range(w.n_q):
        twice[i] = part[i] - twice[i]
    return size(w, b, twice)


class ErrorBound:
    """The record BOUND and the call with which compiled code bounds the error of a step of a GeneralizedAlpha."""

    def __init__(self, method: "GeneralizedAlpha"):
        values, owners = filter_fields(method.system, method.linear)
        vectors = np.zeros((4, method.system.numbering.n_all))
        self.record = record(BOUND, vectors=vectors.ctypes.data, **values)
        self._kept = owners, vectors  # their addresses stand in the record
        self.call = bound_error.call_from_compiled_code(self.record, method.workspace.record)
