"""Warnings about redundant constraints that yielded to forces much larger than those at the start."""

from collections.abc import Iterator

import numpy as np

from mecano.model.extremes import Extremes
from mecano.model.sampler import Sampler
from mecano.model.system import System
from mecano.solve.events.compliance import SOFTNESS, Compliance

NOTICED = 1e-8  # of the length scale: displacement of a redundant constraint above which it is reported
UNITS = ("N", "N m")


def yielding_warnings(
    system: System,
    soft: Compliance | None,
    length: float,
    sampler: Sampler,
    extremes: Extremes,
    places: np.ndarray | None = None,
) -> Iterator[str]:
    """Yield a warning if the compliances ``soft`` of redundant constraints let them yield far beyond their tolerance.

    The displacement follows from the ``extremes`` of the forces of their joints; moments [N m] count over the
    ``length`` scale [m]. ``places`` as in ``limit_warnings``.
    """
    if soft is None:
        return
    largest, joint = max(_forces(system, soft, length, sampler, extremes, places), default=(0.0, ""))
    ratio = largest / soft.force
    if SOFTNESS * ratio <= NOTICED:
        return
    yield (
        f"redundant constraints yielded by up to some {SOFTNESS * ratio * length:.2g} m: the force of {joint} reached "
        f"{largest:.3g} N, {ratio:.2g} times the forces at the start, for which the compliances that share it are "
        "chosen (docs/theory.md, 3). If the mechanism hardly moves, constraints that are redundant at the start alone "
        "bind: are axes exactly parallel, or in one line, that should be? Loads by laws of time instead of formulas "
        "are taken into account; otherwise leave out redundant joints, give them their own 'compliance', or use "
        "'method: radau'"
    )


def _forces(system, soft, length, sampler, extremes, places):
    """Yield (largest force [N], joint) of each output of forces of the joints with redundant constraints."""
    of = system.numbering
    owners = {place.split("'")[1]: place for place in (of.name[of.n_q + i].place for i in soft.soft) if "'" in place}
    for column in sampler.columns:
        _, name, *_ = column.path.split("/")
        if name in owners and column.unit in UNITS:
            first = column.start if places is None else int(np.searchsorted(places, column.start))
            own = slice(first, first + column.size)
            size = max(extremes.high[own].max(), -extremes.low[own].min())
            yield float(size / (length if column.unit == "N m" else 1.0)), owners[name]
