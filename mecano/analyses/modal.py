"""Modes of a deck about its start, a static equilibrium or a saved state: computation, table, file, warnings."""

import os

import numpy as np

from mecano.analyses.friction_and_play import friction_and_play_warnings
from mecano.analyses.modes_contents import contents, inner_motions
from mecano.analyses.operating_point import OperatingPoint, angular_velocity_of, operating_point
from mecano.analyses.small_motion_warnings import (
    NOT_CONVERGED,
    accuracy_warnings,
    imbalance_warnings,
    noticed,
    slow_mode_warnings,
    slowest,
)
from mecano.analyses.source import source_of
from mecano.deck.deck import Deck
from mecano.model.state import State
from mecano.model.system import System
from mecano.post.text_table import aligned
from mecano.process.interrupt import call_interruptibly
from mecano.results.file_names import to_be_written
from mecano.results.modes_file import write_modes
from mecano.solve.modal.linearize import Linearization, linearize
from mecano.solve.modal.modes import Modes, solve
from mecano.solve.modal.small_motions import signals_follow
from mecano.solve.statics.stability import motion_text

HEAD = ("mode", "damped [Hz]", "natural [Hz]", "damping", "growth [1/s]", "residual", "kind", "largest motions")


def modes(
    deck: Deck,
    path: str | os.PathLike[str] | None,
    *,
    at: str | None = None,
    at_rest: bool = False,
    number: int = 10,
    frame: str = "inertial",
    method: str = "automatic",
    force: bool = False,
) -> tuple[str, Modes, OperatingPoint]:
    """Compute modes, write them to ``path`` unless it is None, and return (text of the table, Modes, OperatingPoint).

    ``at``, ``at_rest`` as in ``operating_point``; ``frame``: "inertial", the name of a node with which the axes turn,
    or "wx,wy,wz" [rad/s]. Raises UsageError, the errors of ``mecano run``, and, before anything is computed,
    ResultsError if ``path`` exists.
    """
    with to_be_written(path, force, "the command prints the table of modes"):
        base = operating_point(deck, at, at_rest)
        prepared, system = base.prepared, base.prepared.system
        turning = angular_velocity_of(system, base.state, frame)
        lin = linearize(system, base.state, prepared.length, turning, base.assemble, prepared.stiff_compliance)
        found = call_interruptibly(solve, lin, number, method)
        reported = [
            *base.warnings,
            *imbalance_warnings(base, turning),
            *friction_and_play_warnings(deck, system, base.state),
            *accuracy_warnings(noticed(lin, slowest(found.values)), found.residuals),
            *slow_mode_warnings(lin, found.values),
        ]
        if path is not None:
            inner = inner_motions(deck, system, base.state, found.shapes)
            plain = contents(system, base.state, found, base.words, turning, inner)
            write_modes(path, plain, source_of(deck, warnings=reported), force=force)
    shown = len(found.values)
    part = f", {shown} of them shown (--number, in Python number=)" if shown < found.found else ""
    head = f"modes about: {base.words}; {found.method}; {found.found} computed{part}"
    lines = [head, *table(system, base.state, found, lin)]
    return "\n".join([*lines, *(f"mecano: {text}" for text in reported)]), found, base


def table(system: System, s: State, found: Modes, lin: Linearization) -> list[str]:
    """Return the lines of the table for a terminal."""
    rows = [HEAD]
    columns = zip(found.values, found.frequency, found.natural_frequency, found.damping_ratio, found.residuals,
                  found.kinds, found.converged, found.shapes, strict=True)  # fmt: skip
    for i, (value, damped, natural, ratio, residual, kind, converged, shape) in enumerate(columns, start=1):
        what = largest_motions(system, s, lin, value, shape)
        ratio_text = "" if value == 0.0 else f"{round(float(ratio), 5) + 0.0:.5f}"
        numbers = (str(i), f"{damped:.6g}", f"{natural:.6g}", ratio_text, f"{value.real + 0.0:.4g}", f"{residual:.1e}")
        rows.append((*numbers, kind if converged else f"{kind}, {NOT_CONVERGED}", what))
    return aligned(rows, ">>>>>>><")


def largest_motions(system: System, s: State, lin: Linearization, value: complex, shape: np.ndarray) -> str:
    """Return the nodes with the largest motions of a mode as text, those of an oscillation by their kinetic energies.

    Compared as displacements, the rotations of members with waves shorter than the length scale would dominate. A decay
    or a divergence may involve no inertia: its motions are compared as displacements. Signals that follow from the
    motions are left out: in their units, which are arbitrary, the motions may look like rounding.
    """
    M = lin.M if value.imag or value == 0.0 else None
    shape = np.where(lin.signals, 0.0, shape) if signals_follow(lin, value) else shape
    return motion_text(system, s, shape.real, float(lin.root.max(initial=1.0)), inertial=True, most=2, M=M)
