"""Deployment margin: what the motors of a structure that unfolds have to spare.

Motors are joints with a law of their angle and a latch. Against the mean of their angles, from the start to the
first lock:

    torque       work of their laws per angle, the mean of all motors
    resisting    work done against everything else per angle: energy stored (weight, springs, deformation), dissipated,
                 taken by prescribed motion and winders; what is left of the torque accelerates
    margin       torque over resisting torque

All are means over small intervals of the angle, between saved times, so that small swings do not matter. The least
margin is told twice: on the way, and in its last LATCHING. There members of a flexible structure tighten and bend as it
comes to its shape, by its momentum as much as by its motors, and would hide how near these were to stopping before.
Of a structure that does not tighten, the smaller of both numbers counts.
"""

import numpy as np

from mecano.post.quantity import Quantity
from mecano.post.sheet import Curve, Panel, Sheet

ANGLES = "angles of the motors"  # to which quantities belong
INTERVALS = 40
LATCHING = 0.05  # of the way to the first lock
LEAST = 1e-3  # of the largest torque: resistance below that is none


def deployment_sheet(runs):
    """The sheet of the deployment margin; without panels where no motor turns."""
    torques, margins, reported = [], [], []
    for number, run in enumerate(runs):
        found = _torques(run, motors(run))
        if found is not None:
            angle, torque, resisting, times = found
            curve = _Curves(number, times, angle)
            torques += [curve.of("torque", "N m", torque), curve.of("resisting", "N m", resisting)]
            resists = resisting > LEAST * np.abs(torque).max()
            margin = np.where(resists, torque / np.where(resists, resisting, 1.0), np.nan)
            if resists.any():
                margins.append(curve.of("margin", "-", margin))
                reported.append(margin_told(angle, margin))
    panels = [Panel("torque of a motor", tuple(torques))] if torques else []
    panels += [Panel("deployment margin", tuple(margins), note="\n".join(reported))] if margins else []
    return Sheet("deployment", "Deployment: motors over what resists, to the first lock", tuple(panels))


def margin_told(angle, margin):
    """The least margin (n,) on the way over angles (n,) [rad], and that of its last LATCHING, in words."""
    last = np.arange(len(angle)) >= round((1.0 - LATCHING) * len(angle))
    least = []
    for rows in (~last, last):
        known = np.flatnonzero(rows & np.isfinite(margin))
        at = known[np.argmin(margin[known])] if len(known) else None
        least.append("nothing resists" if at is None else f"{margin[at]:.3g} at {angle[at]:.3g} rad")
    return f"least {least[0]}; in the last {LATCHING:.0%} of the way {least[1]}"


def motors(run):
    """Names of the joints with a law of their angle and a latch -> the sign of the way to the latch."""
    joints = run.deck.get("joints", {}).items()
    driven = ((name, d["latch"]) for name, d in joints if d.get("turning_law") and d.get("latch"))
    return {name: float(np.sign(latch["angle"])) for name, latch in driven if "angle" in latch}


class _Curves:
    """Curves of a run over the angle of its motors."""

    def __init__(self, number, times, angle):
        self.number, self.times = number, times
        self.x = Quantity("motors/angle", "rad", "mean angle of the motors", ANGLES, times, angle)

    def of(self, name, unit, values):
        """One quantity."""
        return Curve(self.x, Quantity(f"motors/{name}", unit, name, ANGLES, self.times, values), self.number, "motors")


def _torques(run, found):
    """Angle (n,), mean torque, mean resisting torque, times, in the middle of intervals; None where nothing turns."""
    results = run.results
    rows = results.time <= min((event.time for event in results.events if event.name == "locks"), default=np.inf)
    if not found or np.count_nonzero(rows) < 3:
        return None
    time = results.time[rows]
    angle = sum(sign * results.find(f"joints/{name}/angle").values[rows] for name, sign in found.items())
    power = sum(_power(results, name)[rows] for name in found)
    given = np.concatenate([[0.0], np.cumsum(0.5 * (power[1:] + power[:-1]) * np.diff(time))])
    energy = {name: results.find(f"energy/{name}").values[rows] for name in ("potential", "dissipated", "given")}
    spent = given + energy["potential"] + energy["dissipated"] - energy["given"]
    reached = np.maximum.accumulate(angle)
    grid = np.linspace(reached[0], reached[-1], INTERVALS + 1)
    if not grid[-1] > grid[0]:
        return None
    at = np.interp(grid, reached, time)
    torque, resisting = (np.diff(np.interp(at, time, work)) / np.diff(grid) for work in (given, spent))
    middle = 0.5 * (at[1:] + at[:-1])
    return 0.5 * (grid[1:] + grid[:-1]) / len(found), torque, resisting, middle


def _power(results, name):
    """Power [W] that a motor gives to the mechanism."""
    return -results.find(f"joints/{name}/law_moment").values * results.find(f"joints/{name}/rate").values
