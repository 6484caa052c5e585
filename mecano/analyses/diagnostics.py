"""Diagnostics of a completed or failed run: warnings and remedies, one text each."""

import re
from bisect import bisect_right
from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager
from typing import TYPE_CHECKING

import numpy as np

from mecano.analyses.recorder import FORCES
from mecano.element_interface import SECTIONS, WAITS
from mecano.elements import KINDS
from mecano.elements.signals.formula import FORMULA
from mecano.errors import MecanoError, NonFiniteError, name_list
from mecano.maths.so3 import exp
from mecano.maths.vector import Vec3
from mecano.model.model import title_of
from mecano.model.output_limits import watched_outputs
from mecano.results.energy_balance import EXCHANGED, scale_of_balance

if TYPE_CHECKING:
    from mecano.deck.deck import Deck
    from mecano.model.extremes import Extremes
    from mecano.model.sampler import Sampler
    from mecano.model.system import System
    from mecano.schema import Values
    from mecano.solve.events.capture import EventCapture
    from mecano.solve.time.generalized_alpha import GeneralizedAlpha
    from mecano.solve.time.radau import Radau
    from mecano.solve.time.run_state import RunState
    from mecano.solve.time.unresolved_oscillation import Oscillation, OscillationMonitor

MOST_LATCHES = 8  # named in a warning
MOST_FORCES = 4
MOST_NAMED = 4  # elements named with the same remedies
LEAST_SWING = 0.01  # of the largest force or moment of the model; smaller oscillations are noise
ROUNDED = 1e-9  # of the kinetic energy over the length scale: smaller forces are rounding
NOTED = 0.01  # failed trials per step above which a fixed step is reported as too large
UNBALANCED = 0.01  # of the largest change of an energy, above which an error of the balance is reported
OFF = 0.007  # error of the force of a mass that circles, above which it is reported: 0.2 rad in a step at rho_inf = 0.8
ALIKE = 0.2  # relative difference of changes of an acceleration below which they turn as the node does
SIMILAR = 2.0  # ratio of a speed over a radius to the angular velocity, and of two radii, below which a node circles
WRAPPED = 6.2  # rad: an angle known within one turn only whose values range so far has jumped
NOISE = 1e-5  # of the largest energy, below which an error of the balance is never reported


def step_cut_warnings(values: "Values", cuts: Sequence[tuple[float, float]], final: "RunState") -> Iterator[str]:
    """Yield a warning if a fixed step was too large, judged by the ``cuts`` of the step and the final RunState."""
    if values["adaptive"] or len(cuts) <= NOTED * final.steps:
        return
    since, smallest = cuts[0][0], min(h for _, h in cuts)
    yield (
        f"the fixed step of {values['step']:g} s is too large: Newton's method failed in {len(cuts)} trials, first at "
        f"t = {since:.4g} s, and steps were cut to as little as {smallest:.3g} s ({final.steps} steps in all); without "
        "error control the result may be far off: use a smaller 'time.step', or 'time.adaptive'"
    )


def capture_warnings(values: "Values", capture: "EventCapture") -> Iterator[str]:
    """Yield a warning if events were captured at the ends of steps, by an EventCapture, instead of located."""
    if not capture.steps:
        return
    names = [name for name, _ in sorted(capture.by_element.items(), key=lambda item: (-item[1], item[0]))]
    smaller = "'time.adaptive.tolerance'" if values["adaptive"] else "'time.step'"
    yield (
        f"{sum(capture.by_element.values())} events of {name_list(names, MOST_NAMED, '; ')} were taken at the ends of "
        f"{capture.steps} steps instead of located, first after t = {capture.first:.4g} s: they happened at more than "
        f"time.located_events = {capture.most} instants beyond one in each step, or again and again at one instant. "
        f"Motions from one such event to the next are not resolved: compare with a run with a smaller {smaller}"
    )


def untouched_ground_warnings(deck: "Deck", sampler: "Sampler", extremes: "Extremes") -> Iterator[str]:
    """Yield a warning if the model has wheels and none of them touched its ground, as their loads were always zero."""
    at = {column.path: column.start for column in sampler.columns}
    wheels = [n for n, d in deck.values["elements"].items() if "wheels" in KINDS[d["type"]].display.pictures]
    loads = [at.get(f"elements/{name}/radial_force", at.get(f"elements/{name}/normal_force")) for name in wheels]
    if wheels and not any(i is None or extremes.high[i] or extremes.low[i] for i in loads):
        yield "no wheel touched its ground: does the run end too early, or do the wheels start too high?"


def wrap_warnings(deck: "Deck", sampler: "Sampler", extremes: "Extremes") -> Iterator[str]:
    """Yield warnings on angles in formulas that jumped by a turn, as they are known within one turn only."""
    at = {column.path: column.start for column in sampler.columns}
    for section, name, kind, output in _wrapping(deck) if deck.formulas else ():
        i, read = at[f"{section}/{name}/{output}"], re.compile(rf"(?<![\w.]){re.escape(name)}\.{output}\b")
        formulas = [f"'{text}'" for text in deck.formulas if read.search(text)]
        if formulas and extremes.high[i] - extremes.low[i] > WRAPPED:
            yield (
                f"{kind} '{name}': its {output}, read by {name_list(formulas, MOST_NAMED)}, is known within one turn "
                "only and jumped by 2 pi; read the angle of a joint that counts turns, such as a hinge, or sine and "
                "cosine of this one"
            )


def _wrapping(deck):
    """Yield (section, name, kind, output) of all outputs that wrap."""
    for section in SECTIONS:
        for name, d in deck.values[section].items():
            yield from ((section, name, d["type"], one.name) for one in KINDS[d["type"]].outputs if one.wraps)


def energy_warnings(values: "Values", sampler: "Sampler", extremes: "Extremes") -> Iterator[str]:
    """Yield a warning if the integration lost or created energy; ``values`` are the section ``time`` of the deck."""
    at = {column.path: column.start for column in sampler.columns}
    high, low, balance = extremes.high, extremes.low, at["energy/balance"]
    energies, off = [at[f"energy/{name}"] for name in EXCHANGED], high[balance] - low[balance]
    ranges = {name: (low[at[f"energy/{name}"]], high[at[f"energy/{name}"]]) for name in (*EXCHANGED, "balance")}
    compared, scale = scale_of_balance(ranges)
    if not off > max(UNBALANCED * scale, NOISE * max(max(high[i], -low[i]) for i in energies)):
        return
    first, last = extremes.high_time[balance], extremes.low_time[balance]
    what = "Integration error creates energy"
    if last > first:
        rho = values["rho_inf"]
        damping = f"numerical damping of motions too fast for the steps (time.rho_inf = {rho:g}) or by "
        what = f"Energy is lost by {damping if rho < 1.0 else ''}integration error"
    yield (
        f"the energy balance varies by {off:.3g} J, {100 * off / scale:.3g} % of {compared}: "
        f"it is highest at t = {first:.4g} s and lowest at t = {last:.4g} s. {what}: compare with a run with a smaller "
        f"'time.{'adaptive.tolerance' if values['adaptive'] else 'step'}'"
    )


def circle_warnings(
    values: "Values", method: "GeneralizedAlpha | Radau", run: "RunState", sampler: "Sampler", extremes: "Extremes"
) -> Iterator[str]:
    """Yield a warning if a mass that is attached off the axis of a body circles far in each fixed step.

    Positions are integrated apart from rotations, so that the acceleration on a circle is wrong by a factor
    (``Coefficients.acceleration``), and with it the force of the mass, found in the tangent at the end, in the RunState
    ``run``. Circles about a fixed centre are recognized by the ranges of position and velocity during the run, others
    by the accelerations in the last two steps. A ``method`` without coefficients has no such error.
    """
    if values["adaptive"] or method.order != 2:
        return
    system, h, spins, s = method.system, values["step"], _spins(sampler), run.motion
    if not np.any(_off(method, _rates(spins, extremes) * h) > OFF):
        return
    starts = {column.path: column.start for column in sampler.columns}
    mass = system.assemble(s, 1.0, 0.0, 0.0, 0.0, 1.0).data[system.diagonal[: system.n_q]]
    circles = []
    for i, (column, x) in enumerate(zip(spins, np.asarray(sampler.nodes.x).tolist(), strict=True)):
        if 0 <= x < system.n_q and mass[x] > 0.0:
            about = _circle(column, starts, extremes), _turning_circle(run, i, x, sampler.nodes)
            circles += [(*circle, mass[x], column.path) for circle in about]
    rate, radius, m, path = max(circles, key=lambda circle: circle[0] ** 2 * circle[1] * circle[2], default=(0,) * 4)
    [off] = _off(method, np.array([rate * h]))
    if off <= OFF:
        return
    yield (
        f"node '{path.split('/')[1]}' moves on a circle of {radius:.3g} m by {rate * h:.2g} rad in a step of {h:g} s: "
        f"the centrifugal force of {m * rate**2 * radius:.3g} N of its mass is wrong by some {100 * off:.2g} %, by "
        "more if the mass is large beside its rotor; use a smaller 'time.step', 'time.adaptive', 'method: radau', or "
        "the 'center_of_mass' of the rotor instead of an attached mass"
    )


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

    Along at least two of the axes a circle has more than half of its largest range. ``column`` is that of the angular
    velocity, ``starts`` maps the paths of all columns to their places in a row.
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
    """Return angular velocity [rad/s] and radius [m] of the circle of node i about any centre, or zeros without one.

    The changes of its acceleration over the last two steps turn as the node does: so they do on a circle whose centre
    has a constant acceleration. ``x`` is the place of its position.
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


def oscillation_warnings(
    values: "Values", sampler: "Sampler", ringing: "OscillationMonitor", extremes: "Extremes", length: float
) -> Iterator[str]:
    """Yield a warning if forces oscillate from step to step, as found by the OscillationMonitor of the run.

    Moments are compared with those of the forces of the model at its ``length`` [m], too. Forces that are rounding
    beside the kinetic energy over this length, as in a free motion, do not count.
    """
    columns = sorted((c for c in sampler.columns if c.unit in FORCES), key=lambda column: column.start)
    starts = [column.start for column in columns]
    of = [columns[bisect_right(starts, place) - 1] for place in ringing.columns]
    largest = {unit: max((x for c, x in zip(of, ringing.largest, strict=True) if c.unit == unit), default=0.0)
               for unit in FORCES}  # fmt: skip
    largest["N m"] = max(largest["N m"], length * largest["N"])
    moving = next(extremes.high[c.start] for c in sampler.columns if c.path == "energy/kinetic")
    rounding = {"N": ROUNDED * moving / length, "N m": ROUNDED * moving, "Pa": 0.0}
    found = ringing.found(np.array([max(LEAST_SWING * largest[c.unit], rounding[c.unit]) for c in of]))
    if not found:
        return
    names: dict[str, tuple[Oscillation, str]] = {}
    for one in found:
        column = columns[bisect_right(starts, one.column) - 1]
        names.setdefault(column.path.replace("/", "."), (one, column.unit))
    worst = [
        f"{name} by {one.swing:.3g} of {one.largest:.3g} {unit} at t = {one.time:.4g} s"
        for name, (one, unit) in names.items()
    ]
    yield (
        f"the steps do not resolve {len(worst)} force(s), which oscillate from step to step: "
        f"{name_list(worst, MOST_FORCES, '; ')}. Their values are not reliable; {_remedy(values)}"
    )


def _remedy(values):
    """Return what to do about forces that oscillate."""
    smaller = "'time.adaptive.tolerance' or 'time.adaptive.maximum_step'" if values["adaptive"] else "'time.step'"
    text = f"use a smaller {smaller}, or add damping to the oscillating parts"
    if values["method"] == "radau" or values["rho_inf"] < 1.0:
        return text
    return (
        f"{text}. With 'rho_inf: 1' the reactions of prescribed motions oscillate more and more after each kink of the "
        "acceleration, at any step size: use a smaller 'rho_inf', such as 0.8"
    )


def limit_warnings(
    deck: "Deck",
    sampler: "Sampler",
    extremes: "Extremes",
    places: np.ndarray | None = None,
    where: str = "t = {:.4g} s",
) -> list[str]:
    """Return a warning for each output whose magnitude exceeded the limit of validity of its element.

    ``places`` are the indices of the outputs of the ``extremes`` in a row of the ``sampler``, ascending; default: all.
    ``where`` is the text of a time, or of a load factor.
    """
    below = -extremes.low > extremes.high
    worst = np.where(below, extremes.low, extremes.high)
    when = np.where(below, extremes.low_time, extremes.high_time)
    found = []
    for name, d, output, column, limit, text in watched_outputs(deck.values, sampler, "limits"):
        i = column if places is None else np.searchsorted(places, column)
        if abs(worst[i]) > limit:
            at = where.format(when[i])
            found.append(f"{d['type']} '{name}': {output} reached {worst[i]:.4g} at {at}, but {text}")
    return found


@contextmanager
def locating_formulas(deck: "Deck") -> Iterator[None]:
    """Add the places of the formulas that failed to a NonFiniteError."""
    try:
        yield
    except NonFiniteError as error:
        raise NonFiniteError(failure_text(error, deck, ())) from error


def failure_text(error: MecanoError, deck: "Deck", warnings: Iterable[str]) -> str:
    """Return the text of an ``error`` with remedies for the elements that failed, and the places of their formulas.

    The ``warnings`` about these elements and about the places of the equations that failed follow.
    """
    remedies: dict[str, list[str]] = {}
    affected = [*error.elements, *(f"{place}: " for place in error.places)]
    for section in SECTIONS:
        for name, d in deck.values[section].items():
            title = title_of(d["type"], name)
            if title in error.elements and (found := KINDS[d["type"]].remedies(d)):
                remedies.setdefault("; ".join(found), []).append(title)
    tries = [f"in {name_list(titles, MOST_NAMED, '; ')}: {found}" for found, titles in remedies.items()]
    known = [f"warning: {one}" for one in dict.fromkeys(warnings) if any(text in one for text in affected)]
    return "\n".join([str(error), *_formulas(error, deck), *tries, *known])


def _formulas(error, deck):
    """Yield where the formulas among the elements that failed are in the deck."""
    marks = {title_of(FORMULA.name, text): mark for text, mark in deck.formulas.items()}
    named = {title_of(FORMULA.name, name): deck.mark("signals", name) for name in deck.values["signals"]}
    for title in error.elements:
        if mark := named.get(title) or marks.get(title):
            yield f"{title} is at {mark}"


def waiting_warnings(system: "System", phases: np.ndarray) -> Iterator[str]:
    """Yield a text that names the elements that are due, by the ``phases`` at the end, but did not act yet."""
    found = [
        name
        for batch in system.batches
        for after in {event.after for event in batch.kind.events if event.name == WAITS}
        for name, phase in zip(batch.names, phases[batch.phases], strict=True)
        if phase == batch.kind.phases.index(after)
    ]
    if found:
        waiting = name_list(found, MOST_LATCHES, "; ")
        yield f"activated without effect, as the bodies overlapped until the end: {waiting}"


def open_latch_warnings(deck: "Deck", row: np.ndarray, sampler: "Sampler") -> Iterator[str]:
    """Yield a text that names open latches, with the coordinates and rates of their joints from a row of outputs.

    Latches with a release may have been closed before.
    """
    columns, found = {column.path: column.start for column in sampler.columns}, []
    joints = deck.values["joints"].items()
    latched = {name: d for name, d in joints if d.get("latch") and not d["latch"]["release"]}
    for name, d in latched.items():
        if not row[columns[f"joints/{name}/latched"]]:
            quantity, wanted = next(iter(d["latch"].items()))
            rate, unit = ("rate", "rad") if quantity == "angle" else ("velocity", "m")
            at, moving = (row[columns[f"joints/{name}/{output}"]] for output in (quantity, rate))
            found.append(f"{d['type']} '{name}' at {at:.4g} of {wanted:.4g} {unit}, moving at {moving:.3g} {unit}/s")
    if found:
        yield f"{len(found)} of {len(latched)} latches never closed: {name_list(found, MOST_LATCHES, '; ')}"
