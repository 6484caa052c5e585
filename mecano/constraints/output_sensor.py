r"""Sensors of outputs and powers of elements: a signal y with y - c = 0, where c is a number that ``observe`` writes.

The local unknowns of a sensor are those of the ``observe`` of the element, the value y follows them: positions and
rotations, scalars and inputs, and the multipliers, of which reactions are linear functions. It has the record, the
phase and a copy of the memory of the element, so the same function computes output and signal, once for numbers and
once for Duals, from which the exact derivatives for the implicit step follow. The forces F are unknown to a sensor:
outputs that depend on them are ``Kind.hidden``.
"""

from functools import cache

from mecano.constraints.along_coordinate.signal import SIGNAL
from mecano.element_interface import Kind, Row, with_fields
from mecano.jit.kernel import kernel
from mecano.jit.memory import allocate_items, free
from mecano.maths.dual import number

ENERGIES = 4  # number of energies that ``observe`` writes


@cache
def output_sensor(kind, n_multipliers):
    """Return the Kind that senses an output of ``kind``, whose ``observe`` sees ``n_multipliers`` multipliers.

    Its record is that of ``kind`` with the index ``sensed`` of the output, components of vectors counted; the four
    energies follow the outputs.
    """
    row, observe = 3 * len(kind.layout) + len(kind.scalars) + len(kind.inputs) + n_multipliers, kind.observe
    n_outputs = outputs_of(kind)
    for phase, outputs in kind.idle.items():
        observe = _idle(observe, kind.phases.index(phase), outputs)
    n_forces = 3 * len(kind.layout)

    @kernel
    def residual(p, at, f):
        y = allocate_items((n_outputs + ENERGIES + n_forces,), f)
        observe(p, at, y[n_outputs + ENERGIES :], y, y[n_outputs:])
        f[row] += number(at.q[row]) - number(y[p.sensed])
        free(y)

    return Kind(
        name=f"sensor_of_{kind.name}", doc=f"Sensor of an output of {kind.name}.",
        dtype=with_fields(kind.dtype, sensed="i"), layout=kind.layout, inputs=(*kind.scalars, *kind.inputs),
        phases=kind.phases, memory=kind.memory, commit=kind.commit, kept=kind.kept, residual=residual, senses=kind,
        **SIGNAL,
        coupled_multipliers=tuple(Row(f"multiplier {i + 1}", "-", "-") for i in range(n_multipliers)),
    )  # fmt: skip


def outputs_of(kind):
    """Return the number of outputs of a kind, components of vectors counted."""
    return sum(output.size for output in kind.outputs)


@cache
def sum_of(n):
    """Return the Kind of the sum of n inputs: the powers of the parts of an element."""

    @kernel
    def residual(p, at, f):
        f[0] += number(at.q[0])
        for i in range(1, n + 1):
            f[0] -= number(at.q[i])

    inputs = tuple(f"input_{i}" for i in range(1, n + 1))
    return Kind(name="sum", doc="Sum of sensors.", inputs=inputs, residual=residual, **SIGNAL)


def _idle(observe, phase, outputs):
    """Return ``observe`` with the ``outputs`` and the energies zero in the phase of this index."""

    @kernel
    def observe_idle(p, at, F, y, e):
        observe(p, at, F, y, e)
        if at.phase == phase:
            for i in outputs:
                y[i] = 0.0
            for i in range(ENERGIES):
                e[i] = 0.0

    return observe_idle
