"""The table of a response for a terminal: static gain, bandwidth and peaks of each transfer function."""

from typing import TYPE_CHECKING

import numpy as np

from mecano.post.text_table import aligned
from mecano.results.response_file import ratio_unit

if TYPE_CHECKING:
    from mecano.analyses.response import Response

HEAD = ("input", "output", "unit", "static gain", "bandwidth [Hz]", "peak [Hz]", "magnitude", "phase [deg]")
MOST = 5  # peaks of a transfer function, the highest ones


def table(found: "Response") -> list[str]:
    """Return the lines of the table."""
    rows = [HEAD]
    for j, source in enumerate(found.inputs):
        for i, output in enumerate(found.outputs):
            unit = ratio_unit(found.output_units[i], found.input_units[j])
            peaks = _highest([peak for peak in found.peaks if (peak.output, peak.input) == (output, source)])
            static = found.static_gain[i, j]
            first = (source, output, unit, "-" if np.isnan(static) else f"{static + 0.0:.6g}", _bandwidth(found, i, j))
            for k, peak in enumerate(peaks or [None]):
                rows.append((*(first if k == 0 else ("",) * 5), *_peak(peak)))

    low, high = found.frequency[[0, -1]]
    head = f"response about: {found.about}; {len(found.frequency)} frequencies from {low:.6g} to {high:.6g} Hz"
    return [head, *aligned(rows, "<<<>>>>>")]


def _highest(peaks):
    """Return the highest Peaks, by ascending frequency."""
    return sorted(sorted(peaks, key=lambda peak: -abs(peak.value))[:MOST], key=lambda peak: peak.frequency)


def _peak(peak):
    if peak is None:
        return "-", "", ""
    if not np.isfinite(peak.value):
        return f"{peak.frequency:.6g}", "undamped", ""
    return f"{peak.frequency:.6g}", f"{abs(peak.value):.6g}", f"{np.degrees(np.angle(peak.value)):.1f}"


def _bandwidth(found, i, j):
    """Return the frequency [Hz], as text, at which the magnitude has fallen by 3 dB below the static gain; or "-"."""
    static, size = abs(found.static_gain[i, j]), np.abs(found.values[:, i, j])
    limit = static / np.sqrt(2.0)
    below = np.flatnonzero(size < limit)
    if not static > 0.0 or not len(below) or below[0] == 0 or not size[below[0]] > 0.0:
        return "-"
    k = below[0]
    x, y = np.log(found.frequency[k - 1 : k + 1]), np.log(size[k - 1 : k + 1])
    return f"{np.exp(x[0] + (np.log(limit) - y[0]) / (y[1] - y[0]) * (x[1] - x[0])):.4g}"
