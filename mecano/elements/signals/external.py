r"""External: a value that a Python program sets during a run, constant in between (docs/python.md).

.. math::  y(t) = u_k, \qquad t_k < t \le t_{k+1}

In a ``mecano.Simulation`` named s, ``s["torque"] = 2.5`` sets the signal 'torque' from the present time on. It keeps
its ``initial`` value until then, and in all other analyses.
"""

from collections.abc import Mapping
from typing import TYPE_CHECKING

import numpy as np

from mecano.constraints.along_coordinate.signal import IN_DECK, INITIAL, UNIT_OF_VALUE
from mecano.element_interface import Kind, named
from mecano.jit.kernel import kernel
from mecano.maths.dual import number

if TYPE_CHECKING:
    from mecano.model.state import State
    from mecano.model.system import System

VALUE, STARTED = range(2)  # in the memory


@kernel
def residual(p, at, f):
    """Add the equation of the value."""
    f[0] += number(at.q[0]) - (at.m[VALUE] if at.m[STARTED] != 0.0 else p.initial)


@kernel
def commit(p, at, m_out):
    """Write the initial value, at the start."""
    if at.m[STARTED] == 0.0:
        m_out[VALUE], m_out[STARTED] = p.initial, 1.0


EXTERNAL = Kind(
    name="external", doc=__doc__,
    **IN_DECK,
    fields=(INITIAL, UNIT_OF_VALUE),
    jumps=lambda d: True,
    memory=("value", "started"), is_set=True,
    **named(residual, commit),
)  # fmt: skip


def with_external_values(system: "System", s: "State", given: Mapping[str, float]) -> np.ndarray:
    """Return the memory (n_memory,) of a state with new values of external signals, by their titles."""
    memory, width = s.memory.copy(), len(EXTERNAL.memory)
    for batch in system.batches:
        if batch.kind is EXTERNAL:
            own = memory[batch.first_memory :][: width * len(batch.p)].reshape(-1, width)
            for i, name in enumerate(batch.names):
                if name in given:
                    own[i, VALUE], own[i, STARTED] = given[name], 1.0
    return memory
