"""The sheet of a drop test: a gear with a shock absorber from touch-down to lift-off.

The efficiency of an absorber is the work of compression up to the largest stroke over the product of largest force and
largest stroke: 1 for a constant force. Spin-up is the largest drag of the wheel on the gear, against the motion;
spring-back is the largest forward force after it, when the gear springs back.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from mecano.constraints.triads import triad
from mecano.post.curve_values import terms_of
from mecano.post.ground import plane_of
from mecano.post.panels import with_peaks
from mecano.post.quantity import SAVED, Quantity, find, time_of
from mecano.post.runs import Run
from mecano.post.shapes import Motion
from mecano.post.sheet import Curve, Panel, Sheet
from mecano.results.energy_balance import EXCHANGED

PICTURE = "drop_test"  # to which wheels that deform and absorbers belong
ABSORBING = ("gas_spring", "oil_damper", "metering_pin")  # terms of the law of a shock absorber


@dataclass(frozen=True)
class Impact:
    """The first ground contact of a wheel in run number ``number``; ``during`` selects its saved times."""

    run: Run
    number: int
    wheel: str
    absorbers: tuple[str, ...]
    during: np.ndarray

    def curve(self, name: str, x: str | None = None, *, sign: float = 1.0) -> Curve:
        """Return the Curve of a quantity over time, or over another quantity ``x``."""
        y = self._cut(find(self.run.results, name)[0])
        y = replace(y, values=sign * y.values)
        return Curve(time_of(y) if x is None else self._cut(find(self.run.results, x)[0]), y, self.number, y.subject)

    def of(self, path: str, unit: str, doc: str, values: np.ndarray) -> Curve:
        """Return the Curve over time of ``values`` given at all saved times."""
        y = self._cut(Quantity(path, unit, doc, SAVED, self.run.results.time, values))
        return Curve(time_of(y), y, self.number, y.subject)

    def _cut(self, quantity):
        return replace(quantity, time=quantity.time[self.during], values=quantity.values[self.during])


def drop_sheet(runs: Sequence[Run]) -> Sheet:
    """Return the Sheet of the first impacts of the runs, without panels if no gear with an absorber touches down."""
    impacts = [impact for number, run in enumerate(runs) for impact in _impacts(run, number)]
    panels = [_load_stroke(impacts), _ground(impacts), _tyre(impacts), _axle(impacts), _travel(impacts)]
    panels = [_within(with_peaks(panel, runs)) for panel in panels if panel.curves]
    energies = _energies(impacts)
    return Sheet("drop_test", "Drop test: the first impact", (*panels, *[energies] * bool(energies.curves)), lead=0)


def _impacts(run, number):
    """Yield the Impact of each wheel that touches down."""
    absorbers = tuple(name for name, d in run.deck.get("elements", {}).items() if _absorbs(run, d))
    for name, d in run.deck.get("elements", {}).items():
        if absorbers and d.get("ground") and PICTURE in run.display(d).pictures:
            start, end = _contact(run, name)
            time = run.results.time
            during = (time >= start) & (time <= end)
            if np.count_nonzero(during) > 2:
                yield Impact(run, number, name, absorbers, during)


def _absorbs(run, d):
    law = d.get("law") if PICTURE in run.display(d).pictures else None
    return any(term in ABSORBING for term, _ in terms_of(run.deck, law))


def _contact(run, wheel):
    """Return the times [s] of the first touch-down of a wheel and of the lift-off after it; inf if there is none."""
    happened = [event for event in run.results.events if run.results.subject(event)[1] == wheel]
    downs = [event.time for event in happened if event.name == "touch_down"]
    start = downs[0] if downs else np.inf
    return start, min((e.time for e in happened if e.name == "lift_off" and e.time > start), default=np.inf)


def _load_stroke(impacts):
    curves = [
        one.curve(f"{name}.compression_force", f"{name}.stroke") for one in impacts for name in one.absorbers
    ]  # fmt: skip
    reported = ", ".join(f"{efficiency(c.x.values, c.y.values):.2f}" for c in curves)
    return Panel("load on the absorber", tuple(curves), note=f"efficiency {reported}")


def efficiency(stroke: np.ndarray, force: np.ndarray) -> float:
    """Return the work of compression to the largest stroke over largest force times stroke; both (n,), over time."""
    last = int(np.argmax(stroke)) + 1
    stroke, force = stroke[:last], force[:last]
    most = np.ptp(stroke) * force.max(initial=0.0)
    return float(0.5 * (force[1:] + force[:-1]) @ np.diff(stroke) / most) if most > 0.0 else 0.0


def _tyre(impacts):
    curves = [one.curve(f"{one.wheel}.normal_force", f"{one.wheel}.deformation") for one in impacts]
    return Panel("load on the tyre", tuple(curves))


def _ground(impacts):
    pairs = [
        (one.curve(f"{one.wheel}.normal_force"), one.curve(f"{one.wheel}.drag_force")) for one in impacts
    ]  # fmt: skip
    return Panel("force of the ground", tuple(curve for pair in pairs for curve in pair))


def _axle(impacts):
    """Return the Panel of the drag on the gear at the axle, with a note on spin-up and spring-back."""
    curves = [curve for one in impacts if (curve := _axle_drag(one)) is not None]
    found = [spin_up_and_spring_back(curve.y.values) for curve in curves]
    reported = [_peaks_text(curves, [rows[i] for rows in found]) for i in range(2)]
    note = f"spin-up {reported[0]}, spring-back {reported[1]}, of the saved times"
    return Panel("drag on the axle", tuple(curves), note=note)


def _peaks_text(curves, rows):
    """Return a text with the magnitudes of the curves at ``rows``; with the time if there is a single curve."""
    sizes = ", ".join(f"{abs(c.y.values[row]) / 1e3:.3g}" for c, row in zip(curves, rows, strict=True))
    return f"{sizes} kN at {curves[0].y.time[rows[0]]:.3g} s" if len(curves) == 1 else f"{sizes} kN"


def spin_up_and_spring_back(drag: np.ndarray) -> tuple[int, int]:
    """Return the rows of the largest drag and of the largest forward force after it."""
    up = int(np.argmax(drag))
    return up, up + int(np.argmin(drag[up:]))


def _axle_drag(one):
    """Return the Curve of the drag on the gear in the hinge that carries the wheel; None without such a hinge."""
    node = one.run.deck["elements"][one.wheel]["node"]
    for name, d in one.run.deck.get("joints", {}).items():
        if one.run.display(d).along_axes and d["nodes"][1] == node and d["nodes"][0] != "ground":
            force = one.run.results.find(f"joints/{name}/force").values
            gear = Motion(one.run, slice(None))
            axes = (gear.turned(d["nodes"][0], mu) for mu in triad(d["axis"], d.get("axis_1")))
            on_gear = -sum(f[:, None] * axis for f, axis in zip(force.T, axes, strict=True))
            drag = -np.einsum("ij,ij->i", on_gear, _heading(one))
            return one.of(f"joints/{name}/drag", "N", "force on the gear against the motion", drag)
    return None


def _heading(one):
    """Return the unit directions (n, 3) of motion of the wheel along the ground."""
    d = one.run.deck["elements"][one.wheel]
    _, normal = plane_of(one.run.deck["grounds"][d["ground"]])
    velocity = one.run.results.find(f"nodes/{d['node']}/velocity").values
    along = velocity - np.outer(velocity @ normal, normal)
    return along / np.maximum(np.linalg.norm(along, axis=1, keepdims=True), 1e-300)


def _travel(impacts):
    strokes = [one.curve(f"{name}.stroke") for one in impacts for name in one.absorbers]
    return Panel("travel", (*strokes, *(one.curve(f"{one.wheel}.deformation") for one in impacts)))


def _energies(impacts):
    """Return the Panel of the changes of energies since touch-down, with a note on the energy balance."""
    curves = []
    for one in {impact.number: impact for impact in impacts}.values():
        for name in EXCHANGED:
            curve = one.curve(f"energy/{name}")
            y = replace(curve.y, values=curve.y.values - curve.y.values[:1])
            curves.append(replace(curve, y=y, subject="energy"))
    gaps = [np.ptp(one.curve("energy/balance").y.values) for one in impacts]
    return Panel("change of energy", tuple(curves), note=f"balanced within {max(gaps, default=0.0):.2g} J")


def _within(panel):
    """Return the panel without peaks outside its times."""
    curves = [
        replace(curve, peak=curve.peak if curve.peak and curve.x.time[0] <= curve.peak[1] <= curve.x.time[-1] else ())
        for curve in panel.curves
    ]
    own = curves[0].peak if len(curves) == 1 and not panel.note else ()
    return replace(panel, curves=tuple(curves), peak=own)
