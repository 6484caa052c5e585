"""The table of the margins of a loop for a terminal: the margins, then all crossovers."""

from typing import TYPE_CHECKING

import numpy as np

from mecano.post.text_table import aligned

if TYPE_CHECKING:
    from mecano.analyses.margins import Margins

HEAD = ("margin", "value", "", "frequency [Hz]")
CROSSOVERS = (
    "crossover", "frequency [Hz]", "magnitude", "phase [deg]", "gain margin", "phase margin [deg]", "delay margin [s]"
)  # fmt: skip

POLES = "pole of the samples", "frequency [Hz]", "damping", "growth [1/s]"
SHOWN = 6  # poles that decay most slowly

NONE = "none"  # a margin without a crossover between the lowest and the highest frequency


def table(found: "Margins") -> list[str]:
    """Return the lines of the table."""
    low, high = found.frequency[[0, -1]]
    head = f"loop opened at {found.signal}, about: {found.about}; {len(found.frequency)} frequencies from {low:.6g} to "
    rows = [HEAD, *_margins(found)]
    crossovers = [CROSSOVERS, *(_crossover(one) for one in found.crossovers)]
    return [
        f"{head}{high:.6g} Hz", f"closed loop: {stability(found.growing)}", "", *aligned(rows, "<><>"), "",
        *(aligned(crossovers, "<>>>>>>") if found.crossovers else ["no crossovers in this range"]),
        *(["", *aligned([POLES, *_poles(found.sample_poles)], "<>>>")] if len(found.sample_poles) else []),
    ]  # fmt: skip


def stability(growing: int | None) -> str:
    """Return whether a closed loop with this number of growing poles is stable, as text."""
    if growing is None:
        return "stability not determined"
    return f"unstable, {growing} pole{'s' if growing > 1 else ''} in the right half-plane" if growing else "stable"


def _margins(found):
    for name, (factor, frequency) in (("gain", found.gain), ("gain reduction", found.gain_reduction)):
        if np.isfinite(factor):
            yield name, f"{factor:.6g}", f"{20.0 * np.log10(factor):.4g} dB", f"{frequency:.6g}"
        elif name == "gain":
            yield name, NONE, "", ""
    phase, frequency = found.phase
    yield "phase", _number(np.degrees(phase)), "deg" if np.isfinite(phase) else "", _number(frequency, "")
    delay, frequency = found.delay
    yield "delay", _number(delay), "s" if np.isfinite(delay) else "", _number(frequency, "")
    peak, frequency = found.sensitivity_peak
    where = "end of range" if frequency in found.frequency[[0, -1]] else ""
    yield "sensitivity peak", f"{peak:.6g}" if np.isfinite(peak) else "infinite", where, f"{frequency:.6g}"


def _poles(poles):
    """Yield the cells of the poles that decay most slowly."""
    for number, s in enumerate(sorted(poles.tolist(), key=lambda s: -s.real)[:SHOWN], 1):
        damping = f"{-s.real / abs(s):.5f}" if s else ""
        yield str(number), f"{s.imag / (2.0 * np.pi):.6g}", damping, f"{s.real:.4g}"


def _number(value, otherwise=NONE):
    return f"{value:.6g}" if np.isfinite(value) else otherwise


def _crossover(one):
    numbers = one.gain_margin, np.degrees(one.phase_margin), one.delay_margin
    phase = f"{np.degrees(np.angle(one.value)) if one.gain else -180.0:.4f}"
    value = f"{abs(one.value):.6g}"
    return "gain" if one.gain else "phase", f"{one.frequency:.6g}", value, phase, *(_number(x, "") for x in numbers)
