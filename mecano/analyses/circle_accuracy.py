"""Warnings about fixed steps that are too long, or unstable, for masses that move on circles."""

from collections.abc import Iterator
from typing import TYPE_CHECKING

import numpy as np

from mecano.maths.so3 import exp
from mecano.maths.vector import Vec3
from mecano.results.energy_balance import energy_ranges, scale_of_balance

if TYPE_CHECKING:
    from mecano.model.extremes import Extremes
    from mecano.model.sampler import Sampler
    from mecano.schema import Values
    from mecano.solve.time.generalized_alpha import GeneralizedAlpha
    from mecano.solve.time.radau import Radau
    from mecano.solve.time.run_state import RunState

OFF = 0.007  # error of the force of a circling mass above which it is reported: 0.2 rad in a step at rho_inf = 0.8
ALIKE = 0.2  # relative difference of changes of an acceleration below which they turn with the node
STABLE = 1.36  # rad in a step, times (1 - rho)/(1 + rho): more is unstable for a mass on a rigid arm
GROWN = 0.5  # error of the energy balance over its scale above which a motion may be unstable
SIMILAR = 2.0  # ratio of a speed over a radius to the angular velocity, and of two radii, below which a node circles


def circle_warnings(
    values: "Values", method: "GeneralizedAlpha | Radau", run: "RunState", sampler: "Sampler", extremes: "Extremes"
) -> Iterator[str]:
    """Yield a warning if a mass attached off the axis of a body moves far along its circle in each fixed step.

    Positions are integrated separately from rotations, so the acceleration on a circle is wrong by a factor
    (``Coefficients.acceleration``), and so is the centrifugal force. The mass is taken from the tangent at the end of
    ``run``, a RunState. Circles about a fixed centre are recognized by the ranges of position and velocity during the
    run, others by the accelerations in the last two steps. A ``method`` without coefficients has no such error.
    """
    if values["adaptive"] or method.order != 2:
        return
    system, h, spins, s = method.system, values["step"], _spins(sampler), run.motion
    if not np.any(_off(method, _rates(spins, extremes) * h) > OFF):
        return
    mass = system.assemble(s, cM=1.0).data[system.diagonal[: system.n_q]]
    circles = []
    for i, (column, x) in enumerate(zip(spins, np.asarray(sampler.nodes.x).tolist(), strict=True)):
        if 0 <= x < system.n_q and mass[x] > 0.0:
            about = _circle(column, sampler.starts, extremes), _turning_circle(run, i, x, sampler.nodes)
            circles += [(*circle, mass[x], column.path) for circle in about]
    rate, radius, m, path = max(circles, key=lambda circle: circle[0] ** 2 * circle[1] * circle[2], default=(0,) * 4)
    [off] = _off(method, np.array([rate * h]))
    if off <= OFF:
        return
    yield (
        f"node '{path.split('/')[1]}' moves on a circle of {radius:.3g} m by {rate * h:.2g} rad in a step of {h:g} s: "
        f"the centrifugal force of {m * rate**2 * radius:.3g} N of its mass is wrong by some {100 * off:.2g} %, "
        "more if the mass is large compared with its rotor; use a smaller 'time.step', 'time.adaptive', 'method: "
        "radau', or the 'center_of_mass' of the rotor instead of an attached mass"
    )


def unstable_turning_warnings(values: "Values", sampler: "Sampler", extremes: "Extremes") -> Iterator[str]:
    """Yield a warning if energy has grown in fixed steps that turn bodies farther than ``rho_inf`` allows.

    ``values`` are the section ``time`` of the deck. With rho_inf = 1 no such steps are stable, which the documentation
    says of constraints in general.
    """
    rho, h = values["rho_inf"], values["step"]
    spins = _spins(sampler)
    if values["adaptive"] or values["method"] != "generalized_alpha" or rho == 1.0 or not spins:
        return
    limit = STABLE * (1.0 - rho) / (1.0 + rho)
    if _rates(spins, extremes).max() * h > limit and _has_grown(sampler, extremes):
        yield (
            f"energy grows, and bodies turn by more than {limit:.2g} rad in a step of {h:g} s: with rho_inf = {rho:g} "
            "the motion of masses that stiff members or constraints lead around a centre is unstable then; use a "
            "smaller 'time.step', 'time.adaptive' or 'method: radau' (a smaller 'time.rho_inf' allows longer steps, "
            "but brakes the motion)"
        )


def _has_grown(sampler, extremes):
    """Return whether the sum of the energies has grown by much of what was exchanged."""
    balance = sampler.starts["energy/balance"]
    grows = extremes.high_time[balance] > extremes.low_time[balance]
    ranges = energy_ranges(sampler, extremes)
    return grows and np.ptp(ranges["balance"]) > GROWN * scale_of_balance(ranges)[1]


def _off(method, phases):
    """Return the errors (n,) of the accelerations on circles that turn by these ``phases`` (n,) [rad] in each step."""
    off, turning = np.zeros(len(phases)), (phases > 0.0) & np.isfinite(phases)
    off[turning] = np.abs(method.coefficients.acceleration(phases[turning]) - 1.0)
    return off


def _rates(spins, extremes):
    """Return the largest components (n,) of the angular velocities in these n columns [rad/s]."""
    places = np.array([column.start for column in spins], int)[:, None] + np.arange(3)
    return np.maximum(np.abs(extremes.low[places]), np.abs(extremes.high[places])).max(axis=1)


def _circle(column, starts, extremes):
    """Return the angular velocity [rad/s] of a node and the radius [m] of its circle, or zeros if it does not circle.

    Along at least two of the axes a circle extends over more than half of its largest range. ``column`` is that of the
    angular velocity, ``starts`` maps the paths of columns to their indices in a row.
    """
    node = column.path.rpartition("/")[0]
    places = [starts[f"{node}/{name}"] for name in ("position", "velocity")]
    ranges = [0.5 * np.sort(extremes.high[at : at + 3] - extremes.low[at : at + 3]) for at in places]
    rate = float(_rates([column], extremes)[0])
    (radius, speed), second = (float(r[-1]) for r in ranges), [float(r[-2]) for r in ranges]
    circles = second[0] > 0.5 * radius and second[1] > 0.5 * speed
    if circles and rate * radius < SIMILAR * speed and speed < SIMILAR * rate * radius:
        return rate, radius
    return 0.0, 0.0


def _turning_circle(run, i, x, nodes):
    """Return angular velocity [rad/s] and radius [m] of the circle of node i about any centre, or zeros if none.

    On a circle whose centre has a constant acceleration, the changes of the node's acceleration over the last two steps
    turn with the node. ``x`` is the index of its position.
    """
    s, history, place = run.motion, run.history, slice(x, x + 3)
    omega = s.R[nodes.rotation[i]] @ s.v[nodes.r[i] : nodes.r[i] + 3]
    change, bend = history.slope[place], history.bend[place]
    rate, size = float(np.linalg.norm(omega)), float(np.linalg.norm(change))
    phase = rate * history.h
    if not (0.0 < phase < np.pi and size > 0.0):
        return 0.0, 0.0
    expected = change - np.array(exp(Vec3(*(-history.h * omega)))) @ change
    if np.linalg.norm(bend - expected) > ALIKE * phase * size or abs(omega @ change) > ALIKE * rate * size:
        return 0.0, 0.0
    return rate, size / (2.0 * np.sin(0.5 * phase)) / rate**2


def _spins(sampler):
    """Return the columns of the angular velocities of nodes."""
    return [c for c in sampler.columns if c.path.startswith("nodes/") and c.path.endswith("/angular_velocity")]
