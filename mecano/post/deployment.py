"""Deployment margin: the torque reserve of the motors of a deploying structure.

Motors are hinges with a law and a latch, and with these other hinges whose laws give energy, such as synchronised ones.
Over the mean of their angles, from the start to the first lock:

    torque       work of their laws per angle, mean of all motors; without what these dissipate (dampers, dry friction)
    resisting    work against everything else per angle: energy stored (weight, springs, deformation), dissipated, also
                 in the motors, or transferred to prescribed motion and winders; the rest of the torque accelerates
    margin       torque over resisting torque

All are means over small intervals of the angle, between saved times, so that small oscillations do not matter. The
least margin is reported separately for the last part LATCHING of the way and for the rest. In the last part the members
of a flexible structure become taut and bend, driven by its momentum as well as by the motors. Together with the rest,
this would hide how close the motors came to stalling earlier. For a structure that does not become taut, the smaller
number counts.

Moments and forces that other actuators apply in joints are neither: if they give energy there is no margin. The motors
of reaction wheels turn bodies that nothing else holds: what they give accelerates these, and counts neither as torque
nor as resisting, if nothing else gives energy.
"""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from mecano.post.quantity import Quantity
from mecano.post.runs import Run
from mecano.post.sheet import Curve, Panel, Sheet

ANGLES = "angles of the motors"  # clock of the quantities
MARGINS = ("motors.margin", "motors.margin_at_latching")  # least before the last part LATCHING, and in it
INTERVALS = 40
LATCHING = 0.05  # of the way to the first lock
LEAST = 1e-3  # of the largest torque: less resistance is ignored; of the work of motors: so is that of actuators
ROUGHLY = 0.05  # of the energy given: less, besides that of reaction wheels, is an error of quadrature
LOCKED = 0.5  # value of the output 'latched' between 0 and 1
TURNS = 0.01  # of the largest angle: motors that turn less are still held


def deployment_sheet(runs: Sequence[Run]) -> Sheet:
    """Return the Sheet of the deployment margin, without panels if no motor turns."""
    torques, margins, reported = [], [], []
    for number, run in enumerate(runs):
        found = _torques(run, motors(run.deck))
        if found is not None:
            angle, torque, resisting, times = found
            curve = _Curves(number, times, angle)
            torques += [curve.of("torque", "N m", torque), curve.of("resisting", "N m", resisting)]
            margin = _margin(torque, resisting)
            if np.isfinite(margin).any():
                margins.append(curve.of("margin", "-", margin))
                reported.append(margin_text(angle, margin))
    panels = [Panel("mean torque", tuple(torques))] if torques else []
    panels += [Panel("deployment margin", tuple(margins), note="\n".join(reported))] if margins else []
    return Sheet("deployment", "Deployment: torque of motors and resistance, to the first lock", tuple(panels))


def least_margins(run: Run) -> dict[str, float]:
    """Return {name of MARGINS: least margin} of a run: 1/LEAST where nothing resists, nan if no motor turns."""
    found = _torques(run, motors(run.deck))
    if found is None:
        return dict.fromkeys(MARGINS, np.nan)
    margin = _margin(*found[1:3])
    return {name: 1.0 / LEAST if i is None else margin[i] for name, i in zip(MARGINS, _least(margin), strict=True)}


def margin_text(angle: np.ndarray, margin: np.ndarray) -> str:
    """Return a text on the least ``margin`` (n,) over ``angle`` (n,) [rad], in the last part LATCHING and before."""
    least = ["nothing resists" if i is None else f"{margin[i]:.3g} at {angle[i]:.3g} rad" for i in _least(margin)]
    return f"least {least[0]}; in the last {LATCHING:.0%} of the way {least[1]}"


def _margin(torque, resisting):
    """Return the torque (n,) over the resisting torque (n,), nan where next to nothing resists."""
    resists = resisting > LEAST * np.abs(torque).max()
    return np.where(resists, torque / np.where(resists, resisting, 1.0), np.nan)


def _least(margin):
    """Return the indices of the least ``margin`` (n,) before the last part LATCHING and in it; None without one."""
    last = np.arange(len(margin)) >= round((1.0 - LATCHING) * len(margin))
    known = [np.flatnonzero(rows & np.isfinite(margin)) for rows in (~last, last)]
    return [rows[np.argmin(margin[rows])] if len(rows) else None for rows in known]


def motors(deck: Mapping[str, Any]) -> dict[str, float]:
    """Return {name: sign of the latch angle} of the hinges with a law and a latch, of the values of a deck."""
    joints = deck.get("joints", {}).items()
    driven = ((name, d["latch"]) for name, d in joints if d.get("turning_law") and d.get("latch"))
    return {name: float(np.sign(latch["angle"])) for name, latch in driven if "angle" in latch}


class _Curves:
    """Curves of a run over the angle of its motors."""

    def __init__(self, number: int, times: np.ndarray, angle: np.ndarray):
        self.number, self.times = number, times
        self.x = Quantity("motors/mean_angle", "rad", "mean angle of the motors", ANGLES, times, angle)

    def of(self, name: str, unit: str, values: np.ndarray) -> Curve:
        """Return the Curve of one quantity."""
        return Curve(self.x, Quantity(f"motors/{name}", unit, name, ANGLES, self.times, values), self.number, "motors")


def _torques(run, found):
    """Return mean angle (n,), torque, resisting torque and times at midpoints of intervals; None if nothing turns."""
    results = run.results
    rows = _before_locks(results)
    if not found or np.count_nonzero(rows) < 3:
        return None
    time = results.time[rows]
    found = found | _synchronised(run, found, rows)
    angles = {name: sign * results.find(f"joints/{name}/angle").values[rows] for name, sign in found.items()}
    most = max(np.ptp(values) for values in angles.values())
    turning = [name for name, values in angles.items() if np.ptp(values) > TURNS * most]
    if not turning:
        return None
    angle = sum(angles[name] for name in turning)
    given = _work(time, sum(_power(results, name)[rows] for name in found))
    spinning, others = _actuators(run)
    if max((work.max() for work in _works(run, others, rows)), default=0.0) > LEAST * np.abs(given).max():
        return None
    energy = {name: results.find(f"energy/{name}").values[rows] for name in ("potential", "dissipated", "given")}
    transferred = energy["given"] - sum(_works(run, spinning, rows))
    if spinning and np.abs(energy["given"]).max() > LEAST * np.abs(given).max():
        if np.abs(transferred).max() > ROUGHLY * np.abs(energy["given"]).max():
            return None
        transferred = 0.0  # the rest is the error of the quadrature of a sampled torque
    spent = given + energy["potential"] + energy["dissipated"] - transferred
    reached = np.maximum.accumulate(angle)
    grid = np.linspace(reached[0], reached[-1], INTERVALS + 1)
    if not grid[-1] > grid[0]:
        return None
    at = np.interp(grid, reached, time)
    torque, resisting = (np.diff(np.interp(at, time, work)) / np.diff(grid) for work in (given, spent))
    middle = 0.5 * (at[1:] + at[:-1])
    return 0.5 * (grid[1:] + grid[:-1]) / len(turning), torque, resisting, middle


def _synchronised(run, found, rows):
    """Return {name: sign of its motion} of the hinges besides those ``found`` whose laws give energy."""
    others = {}
    for name, d in run.deck["joints"].items():
        if d.get("turning_law") and name not in found and f"joints/{name}/angle" in run.paths:
            angle = run.results.find(f"joints/{name}/angle").values[rows]
            if _work(run.results.time[rows], _power(run.results, name)[rows])[-1] > 0.0:
                others[name] = float(np.sign(angle[-1] - angle[0]))
    return others


def _before_locks(results):
    """Return (n,) bool: saved times up to the first lock, without one of that instant that holds the values after it.

    Such a time ends a run whose ``until`` becomes true by the lock.
    """
    rows = results.time <= min((event.time for event in results.events if event.name == "locks"), default=np.inf)
    for path in results.series:
        if path.endswith("/latched"):
            rows &= results.find(path).values < LOCKED
    return rows


def _actuators(run):
    """Return the names of the loads in joints: (those that only spin a wheel, the others)."""
    loads = [
        (name, d["joint"])
        for name, d in run.deck.get("loads", {}).items()
        if d.get("joint") and f"loads/{name}/power" in run.paths
    ]
    wheels = {joint for _, joint in loads if f"joints/{joint}/angle" in run.paths and _spins_a_wheel(run.deck, joint)}
    return [name for name, joint in loads if joint in wheels], [name for name, joint in loads if joint not in wheels]


def _spins_a_wheel(deck, joint):
    """Return whether a joint without options is all that holds one of its bodies, as the axle of a reaction wheel."""
    d = deck["joints"][joint]
    if any(d.get(option) for option in ("turning_law", "latch", "lock", "stops")):
        return False
    things = [one for section in ("elements", "joints") for one in deck.get(section, {}).values() if one is not d]
    held = [node for one in things for node in (*one.get("nodes", ()), *one.get("attached", ()))]
    bodies = {one["node"] for one in things if one.get("inertia") and not one.get("attached")}
    return any(node in bodies and node not in held for node in d["nodes"])


def _works(run, loads, rows):
    """Return the energies (n,) [J] that each of some loads has given until the saved times ``rows``."""
    time = run.results.time[rows]
    return [_work(time, run.results.find(f"loads/{name}/power").values[rows]) for name in loads]


def _work(time, power):
    """Return the integral (n,) [J] of a power (n,) [W] over the time, of fourth order."""
    from scipy.interpolate import CubicSpline  # slow to import, and rarely needed

    return CubicSpline(time, power).antiderivative()(time) if len(time) > 1 else np.zeros(len(time))


def _power(results, name):
    """Return the power [W] of a motor, > 0 into the mechanism, including the power that it dissipates."""
    power = -results.find(f"joints/{name}/law_moment").values * results.find(f"joints/{name}/rate").values
    dissipation = f"joints/{name}/law_moment_dissipation"
    return power + results.find(dissipation).values if dissipation in results.series else power
