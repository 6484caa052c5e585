"""Residual and tangent of each element alone, to find the one at fault."""

from collections.abc import Iterator

import numpy as np

from mecano.model import assembly_driver, loops
from mecano.model.assembly import Assembly
from mecano.model.assembly_driver import Loops
from mecano.model.batch import calling
from mecano.model.loop_code import calls_of
from mecano.model.state import State
from mecano.model.system import System


def each_alone(system: System, s: State) -> Iterator[tuple[str, Assembly]]:
    """Yield (name, Assembly at ``s``, all weights one) of each element; the next one overwrites the Assembly.

    Basic constraints and parts are included, with the name of the element to which they belong.
    """
    alone, no_turn = Assembly(system), np.tile(np.eye(3), (3 * len(system.numbering.rotation_dof), 1, 1))
    for b in system.batches:
        if (calls := calls_of(b.kind, loops.tangent)) is None:
            continue
        for e in range(len(b.p)):
            alone_in_loop = Loops(np.array([calls.loop], np.int64), calling(b.record_of(e), calls))
            assemble = assembly_driver.assemble.bind(alone_in_loop)
            assemble(alone.record, s, no_turn, 1.0, 0.0, 1.0, 1.0, 1.0)
            yield b.names[e], alone


def elements_not_finite(system: System, s: State) -> list[str]:
    """Return the names of the elements whose own forces or tangents at ``s`` are not finite."""
    found = [
        name
        for name, alone in each_alone(system, s)
        if not (np.isfinite(alone.forces).all() and np.isfinite(alone.data).all())
    ]
    return list(dict.fromkeys(found))
