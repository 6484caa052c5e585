"""The arrays of a sweep as its file contains them."""

from typing import TYPE_CHECKING, Any

import numpy as np

from mecano.results.sweep_file import CRITICAL, RESONANCES
from mecano.solve.modal.modes import unstable

if TYPE_CHECKING:
    from mecano.analyses.sweep import Sweep


def contents(sweep: "Sweep") -> dict[str, Any]:
    """Return the arrays of a Sweep by group and name, as results/sweep_file.py writes them."""
    axes, loci = sweep.axes, sweep.loci
    other = axes[1].values if len(axes) == 2 else np.array([np.nan])
    values = loci[0].values
    size = np.abs(values)
    modes = {
        "real_part": values.real, "imaginary_part": values.imag, "frequency": values.imag / (2.0 * np.pi),
        "damping_ratio": -values.real / np.where(size > 0.0, size, np.nan), "converged": loci[0].converged,
    }  # fmt: skip
    if loci[0].whirl is not None:
        modes["whirl"] = loci[0].whirl
    over = {
        "growth": [locus.growth for locus in loci], "growing": [locus.count for locus in loci],
        "frequency": [np.abs(locus.fastest.imag) / (2.0 * np.pi) for locus in loci],
        "oscillation_growth": [_beyond_rounding(locus.swinging) for locus in loci],
    }  # fmt: skip
    rows = [
        (c.place, at, c.value.imag / (2 * np.pi), c.branch + 1, c.error, float(c.destabilizes), locus.of_instant(c))
        for at, locus in zip(other, loci, strict=True)
        for c in locus.critical
    ]
    alone = len(axes) == 1
    return {
        "names": tuple(axis.name for axis in axes), "units": tuple(axis.unit for axis in axes),
        "parameter": axes[0].values, "other": other,
        "modes": modes if alone else {}, "motions": loci[0].motions if alone else [],
        "families": loci[0].family_names if alone else [],
        "map": {name: np.array(table, float) for name, table in over.items()}, "critical": _columns(rows, CRITICAL),
        "about": sweep.about, **(_campbell(sweep) if sweep.rotor else {}),
    }  # fmt: skip


def _beyond_rounding(values):
    """Return the real parts of eigenvalues (n,), zero where they are rounding."""
    return np.where(unstable(values) | unstable(-values), values.real, np.where(np.isnan(values), np.nan, 0.0))


def _campbell(sweep):
    """Return the plain arrays of a Campbell diagram by group and name."""
    (locus,) = sweep.loci
    rows = [
        (one.place, one.order, one.speed, one.value.imag / (2 * np.pi), -one.value.real / abs(one.value),
         one.branch + 1, one.whirl)
        for one in locus.resonances
    ]  # fmt: skip
    found = _columns(rows, RESONANCES)
    return {"rotor": {"speed": locus.speed}, "resonances": found, "node": sweep.rotor, "orders": sweep.orders}


def _columns(rows, declared):
    """Return the columns of a table by name; ``declared``: (name, unit, meaning) of each."""
    columns = np.array(rows, float).reshape(len(rows), len(declared)).T
    return {name: column for (name, _, _), column in zip(declared, columns, strict=True)}
