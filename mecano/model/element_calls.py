"""Calls of the functions of a kind for one gathered element, which are compiled for each kind.

There is one C function per kind and purpose, of the addresses of the batch record (BATCH) and of the system record
(SYSTEM); ``element`` of the batch is the index of the element. The loops of loops.py call it between gathering the
state of the element and scattering its results.

The functions here are templates: loop_code.py adds the ``function`` of the kind and its record of ``parameters`` to
their globals.
"""

from mecano.jit.kernel import kernel
from mecano.jit.memory import floats, items, lanes, lanes_items
from mecano.jit.null_matrix import NULL_MATRIX
from mecano.model.gather_scatter import event_values_of, lag_of, lanes_place, new_memory_of, observed, place
from mecano.model.loop_records import batch_at, system_at
from mecano.model.seeded_duals import dual_constraints, dual_forces, dual_place, moving_place


@kernel
def no_event_values(p, at, g):
    """Write no numbers: all events are by command."""


def tangent(batch, system):
    """Call ``force``."""
    b, s = batch_at(batch), system_at(system)
    n, p = b.n_local, items(b.p, b.n, parameters)[b.element]  # noqa: F821
    K, C, M = floats(b.K, (n, n)), floats(b.C, (n, n)), floats(b.M, (n, n))
    function(p, place(b, s, lag_of(b, s)), floats(b.f, n), K, C, M)  # noqa: F821


def force(batch, system):
    """Call ``force`` for the forces alone."""
    b, s = batch_at(batch), system_at(system)
    p, at = items(b.p, b.n, parameters)[b.element], place(b, s, lag_of(b, s))  # noqa: F821
    function(p, at, floats(b.f, b.n_local), NULL_MATRIX, NULL_MATRIX, NULL_MATRIX)  # noqa: F821


def lanes_tangent(batch, system):
    """Call ``force`` for a group of elements."""
    b, s = batch_at(batch), system_at(system)
    n, p = b.n_local, lanes_items(b.groups, b.n, parameters)[b.element]  # noqa: F821
    K, C, M = lanes(b.K, (n, n)), lanes(b.C, (n, n)), lanes(b.M, (n, n))
    function(p, lanes_place(b, s), lanes(b.f, n), K, C, M)  # noqa: F821


def lanes_force(batch, system):
    """Call ``force`` for the forces alone of a group of elements."""
    b, s = batch_at(batch), system_at(system)
    p, f = lanes_items(b.groups, b.n, parameters)[b.element], lanes(b.f, b.n_local)  # noqa: F821
    function(p, lanes_place(b, s), f, NULL_MATRIX, NULL_MATRIX, NULL_MATRIX)  # noqa: F821


def lanes_observe(batch, system):
    """Call ``observe`` for a group of elements."""
    b, s = batch_at(batch), system_at(system)
    p, F = lanes_items(b.groups, b.n, parameters)[b.element], lanes(b.F, b.n_forces)  # noqa: F821
    function(p, lanes_place(b, s), F, lanes(b.y, b.n_outputs), lanes(b.energies, 4))  # noqa: F821


def residual(batch, system):
    """Call ``residual``."""
    b, s = batch_at(batch), system_at(system)
    p, at = items(b.p, b.n, parameters)[b.element], place(b, s, lag_of(b, s))  # noqa: F821
    function(p, at, floats(b.f, b.n_local))  # noqa: F821


def dual_residual(batch, system):
    """Call ``residual`` with Duals."""
    b, s = batch_at(batch), system_at(system)
    p, at = items(b.p, b.n, parameters)[b.element], dual_place(b, s, lag_of(b, s))  # noqa: F821
    function(p, at, dual_forces(b))  # noqa: F821


def inertia(batch, system):
    """Call ``inertia``."""
    b, s = batch_at(batch), system_at(system)
    function(items(b.p, b.n, parameters)[b.element], place(b, s, 1.0), floats(b.f, b.n_local))  # noqa: F821


def constraints(batch, system):
    """Call ``constraints`` with Duals whose slopes are rates in time."""
    b, s = batch_at(batch), system_at(system)
    function(items(b.p, b.n, parameters)[b.element], moving_place(b, s), dual_constraints(b))  # noqa: F821


def observe(batch, system):
    """Call ``observe``."""
    b, s = batch_at(batch), system_at(system)
    y, energies = observed(b, s)
    function(items(b.p, b.n, parameters)[b.element], place(b, s, 1.0), floats(b.F, b.n_forces), y, energies)  # noqa: F821


def event_values(batch, system):
    """Call ``event_values``."""
    b, s = batch_at(batch), system_at(system)
    function(items(b.p, b.n, parameters)[b.element], place(b, s, 1.0), event_values_of(b, s))  # noqa: F821


def commit(batch, system):
    """Call ``commit``."""
    b, s = batch_at(batch), system_at(system)
    function(items(b.p, b.n, parameters)[b.element], place(b, s, 1.0), new_memory_of(b, s))  # noqa: F821
