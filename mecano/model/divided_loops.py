"""Loops over the elements of a model in halves (halves.py), by two threads.

One C function replaces the loops of all kinds: it calls them for the elements of each half, then for all other
elements. Elements of different halves add to different forces and entries of the tangent.
"""

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING

import numpy as np

from mecano.jit import thread_pool
from mecano.jit.digest import digest
from mecano.jit.machine_code import Code, address
from mecano.jit.memory import call, floats, integers, items
from mecano.jit.thread_pool import PARTS, run_parts
from mecano.model.batch import calling
from mecano.model.halves import BETWEEN, ONE, OTHER
from mecano.model.loop_records import BATCH, SYSTEM, batch_at, fields, record

if TYPE_CHECKING:
    from mecano.model.batch import Batch
    from mecano.model.loop_code import Calls
    from mecano.model.system import System

WORDS = SYSTEM.itemsize // 8
SIZE = BATCH.itemsize
APART = 16  # words between arrays that two threads write: two lines of the cache

# Loops and batches of one part; its record SYSTEM, a copy of the one ``given`` to the loops; its energies.
PART = fields(words="n loops batches given system energy")
STRIDE = PART.itemsize
# All parts, those of the halves first; it is the record of the only element of the batch of a divided loop.
DIVIDED = fields(words="pool call_part parts")


def divided(batch, system):
    """Call the loops of all parts."""
    d = items(batch_at(batch).p, 1, DIVIDED)[0]
    parts = items(d.parts, PARTS + 1, PART)
    for i in range(PARTS + 1):
        parts[i].given = system
    run_parts(d.pool, d.call_part, d.parts, STRIDE)
    call(d.call_part, d.parts + PARTS * STRIDE, 0)
    s = items(system, 1, SYSTEM)[0]
    if s.energy == 0:  # not of an Observation
        return
    total = floats(s.energy, 4)
    for i in range(PARTS + 1):
        energy = floats(parts[i].energy, 4)
        for j in range(4):
            total[j] += energy[j]


def call_part(part, _):
    """Call the loops of one part."""
    m = items(part, 1, PART)[0]
    given, own = integers(m.given, WORDS), integers(m.system, WORDS)
    for i in range(WORDS):
        own[i] = given[i]
    items(m.system, 1, SYSTEM)[0].energy = m.energy
    floats(m.energy, 4)[:] = 0.0
    loops = integers(m.loops, m.n)
    for i in range(m.n):
        call(loops[i], m.batches + i * SIZE, m.system)


FUNCTIONS = divided, call_part


def code_of(function: Callable[..., None]) -> Code:
    """Return the Code of one of these functions."""
    return Code(function.__name__, digest(function), lambda compiler: compiler.loop_code(function))


class DividedLoops:
    """The loops of one purpose over the elements of a system in halves.

    Parameters
    ----------
    system : System
        Its ``halves`` are not None.
    loops : list of (Batch, Calls)
        Batches, and the addresses of their loops and of the callees of these.

    Attributes
    ----------
    loops : (1,) int
        Address of the function that takes the place of the loops.
    batches : (1,) BATCH
        The record for it.
    found : list
        Of each part: addresses of loops (n,), records of batches (n,), work arrays.
    """

    def __init__(self, system: "System", loops: "Sequence[tuple[Batch, Calls]]"):
        of_unknown = np.full(system.numbering.n_all, BETWEEN)
        of_unknown[: system.n] = system.halves
        self.found = [_part(i, loops, of_unknown) for i in range(PARTS + 1)]
        energies, systems = np.zeros((PARTS + 1, APART)), np.zeros((PARTS + 1, WORDS + APART), np.int64)
        parts = np.zeros(PARTS + 1, PART)
        for i, (addresses, records, _) in enumerate(self.found):
            arrays = addresses, records, systems[i], energies[i]
            loops, batches, own, energy = (array.ctypes.data for array in arrays)
            parts[i] = len(addresses), loops, batches, 0, own, energy
        whole = record(DIVIDED, pool=thread_pool.pool(), call_part=address(code_of(call_part)), parts=parts.ctypes.data)
        self._kept = energies, systems, parts, whole
        self.loops = np.array([address(code_of(divided))], np.int64)
        self.batches = record(BATCH, n=1, p=whole.ctypes.data)


def _part(which, loops, of_unknown):
    """Return addresses of loops (n,), records of batches (n,), and their work arrays for one half or the rest."""
    addresses, records, kept = [np.zeros(0, np.int64)], [np.zeros(0, BATCH)], []
    for batch, calls in loops:
        own = np.concatenate([[False], _part_of(of_unknown[batch.dofs]) == which, [False]])
        begins, ends = np.flatnonzero(~own[:-1] & own[1:]), np.flatnonzero(own[:-1] & ~own[1:])
        records.append(calling(batch.records_of(begins, ends), calls))
        addresses.append(np.full(len(begins), calls.loop, np.int64))
        kept.append(batch.give_work(records[-1]))
    return np.concatenate(addresses), np.concatenate(records), kept


def _part_of(of_unknowns):
    """Return the half (n,) to which all unknowns (n, n_local) of an element belong, or BETWEEN; ONE without any."""
    one, other = ((of_unknowns == half).all(axis=1) for half in (ONE, OTHER))
    return np.where(one, ONE, np.where(other, OTHER, BETWEEN))
