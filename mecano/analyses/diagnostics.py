"""Warnings about a completed run, one text each: steps, events, energies, oscillations, limits, latches."""

import re
from bisect import bisect_right
from collections.abc import Iterator, Sequence

import numpy as np

from mecano.analyses.recorder import FORCES
from mecano.deck.deck import Deck
from mecano.element_interface import SECTIONS, WAITS
from mecano.elements import KINDS
from mecano.errors import name_list
from mecano.model.extremes import Extremes
from mecano.model.model import title_of
from mecano.model.output_limits import watched_outputs
from mecano.model.sampler import Sampler
from mecano.model.system import System
from mecano.results.energy_balance import EXCHANGED, energy_ranges, scale_of_balance
from mecano.schema import Values
from mecano.solve.events.capture import EventCapture
from mecano.solve.time.run_state import RunState
from mecano.solve.time.unresolved_oscillation import Oscillation, OscillationMonitor

MOST_LATCHES = 8  # named in a warning
MOST_FORCES = 4
MOST_NAMES = 4  # elements or formulas
AMPLIFIED = 10.0  # tolerances of forces: what residuals of several steps may cause in a reaction
LEAST_SWING = 0.01  # of the largest force or moment of the model; smaller oscillations are noise
ROUNDED = 1e-9  # of the kinetic energy over the length scale: smaller forces are rounding errors
ROUNDED_POSITIONS = 1e-15  # of the length scale, some times the rounding of numbers

FAR_MOVED = 0.1  # rad, or length scales of the model: motions that are no creep
LAWS = {  # fields of laws that may have dry friction: outputs of the coordinate
    "law": ("extension", "angle"), "turning_law": ("angle",), "sliding_law": ("displacement",),
}  # fmt: skip
RATES = {"extension": "rate", "angle": "rate", "displacement": "velocity"}
NOTED = 0.01  # failed trials per step above which a fixed step is reported as too large
UNBALANCED = 0.01  # of the largest change of an energy, above which an error of the balance is reported
LEVEL = 1e-3  # m: range of the height of a wheel in the air that is neither lowered nor retracted
WRAPPED = 6.2  # rad: range of values above which an angle known within one turn only has jumped
NOISE = 1e-5  # of the largest energy, below which an error of the balance is never reported


def step_cut_warnings(values: Values, cuts: Sequence[tuple[float, float]], final: RunState) -> Iterator[str]:
    """Yield a warning if a fixed step was too large, judged by the ``cuts`` of the step and the final RunState."""
    if values["adaptive"] or len(cuts) <= NOTED * final.steps:
        return
    since, smallest = cuts[0][0], min(h for _, h in cuts)
    yield (
        f"the fixed step of {values['step']:g} s is too large: Newton's method failed in {len(cuts)} trials, first at "
        f"t = {since:.4g} s, and steps were cut to as little as {smallest:.3g} s ({final.steps} steps in all); without "
        "error control the result may be far off: use a smaller 'time.step', or 'time.adaptive'"
    )


def capture_warnings(values: Values, capture: EventCapture) -> Iterator[str]:
    """Yield a warning if events were captured at the ends of steps, instead of being located."""
    if not capture.steps:
        return
    names = [name for name, _ in sorted(capture.by_element.items(), key=lambda item: (-item[1], item[0]))]
    smaller = "'time.adaptive.tolerance'" if values["adaptive"] else "'time.step'"
    yield (
        f"{sum(capture.by_element.values())} events of {name_list(names, MOST_NAMES, '; ')} were taken at the ends of "
        f"{capture.steps} steps instead of located, first after t = {capture.first:.4g} s: they happened at more than "
        f"time.located_events = {capture.most} instants beyond one in each step, or again and again at one instant. "
        f"Motions from one such event to the next are not resolved: compare with a run with a smaller {smaller}"
    )


def untouched_ground_warnings(deck: Deck, sampler: Sampler, extremes: Extremes, end: float) -> Iterator[str]:
    """Yield a warning if no wheel touched its ground, though one was sinking at the ``end`` [s] or kept its height."""
    at, elements = sampler.starts, deck.values["elements"].items()
    wheels = [f"elements/{name}" for name, d in elements if "wheels" in KINDS[d["type"]].display.pictures]
    loads = [at.get(f"{wheel}/radial_force", at.get(f"{wheel}/normal_force")) for wheel in wheels]
    if not wheels or any(i is None or extremes.high[i] or extremes.low[i] for i in loads):
        return
    heights = [at[name] for name in (f"{wheel}/height" for wheel in wheels) if name in at]
    if any(extremes.low_time[i] >= end or extremes.high[i] - extremes.low[i] < LEVEL for i in heights):
        yield "no wheel touched its ground: does the run end too early, or do the wheels start too high?"


def wrap_warnings(deck: Deck, sampler: Sampler, extremes: Extremes) -> Iterator[str]:
    """Yield warnings on angles in formulas that jumped by a turn, because they are known within one turn only."""
    for section, name, kind, output in _wrapping(deck) if deck.formulas else ():
        i, read = sampler.starts[f"{section}/{name}/{output}"], re.compile(rf"(?<![\w.]){re.escape(name)}\.{output}\b")
        formulas = [f"'{text}'" for text in deck.formulas if read.search(text)]
        if formulas and extremes.high[i] - extremes.low[i] > WRAPPED:
            yield (
                f"{kind} '{name}': its {output}, read by {name_list(formulas, MOST_NAMES)}, is known within one turn "
                "only and jumped by 2 pi; read the angle of a joint that counts turns, such as a hinge, or sine and "
                "cosine of this one"
            )


def _wrapping(deck):
    """Yield (section, name, kind, output) of all outputs that wrap."""
    for section in SECTIONS:
        for name, d in deck.values[section].items():
            yield from ((section, name, d["type"], one.name) for one in KINDS[d["type"]].outputs if one.wraps)


def energy_warnings(values: Values, sampler: Sampler, extremes: Extremes, length: float, mass: float) -> Iterator[str]:
    """Yield a warning if the integration lost or created energy; ``values`` are the section ``time`` of the deck.

    The energy of the ``mass`` [kg] of the model that moves by the rounding of its ``length`` [m] in a step does not
    count, as that of a mechanism at rest.
    """
    rounding = mass * (ROUNDED_POSITIONS * length / values["step"]) ** 2
    ranges, balance = energy_ranges(sampler, extremes), sampler.starts["energy/balance"]
    off, (compared, scale) = np.ptp(ranges["balance"]), scale_of_balance(ranges)
    if not off > max(UNBALANCED * scale, NOISE * np.abs([ranges[name] for name in EXCHANGED]).max(), rounding):
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


def oscillation_warnings(
    values: Values, sampler: Sampler, ringing: OscillationMonitor, extremes: Extremes, length: float, mass: float
) -> Iterator[str]:
    """Yield a warning if forces oscillate from step to step, as found by the OscillationMonitor of the run.

    Moments are also compared with the forces of the model times its ``length`` [m]. Forces at the rounding level of the
    kinetic energy over this length, as in a free motion, do not count, nor those that accelerate its ``mass`` [kg] by
    the rounding of positions over the square of the step, nor what Newton's iteration may leave beside large moments.
    """
    columns = sorted((c for c in sampler.columns if c.unit in FORCES), key=lambda column: column.start)
    starts = [column.start for column in columns]
    of = [columns[bisect_right(starts, place) - 1] for place in ringing.columns]
    largest = {unit: max((x for c, x in zip(of, ringing.largest, strict=True) if c.unit == unit), default=0.0)
               for unit in FORCES}  # fmt: skip
    largest["N m"] = max(largest["N m"], length * largest["N"])
    work = max(
        ROUNDED * extremes.high[sampler.starts["energy/kinetic"]],
        mass * (length / values["step"]) ** 2 * ROUNDED_POSITIONS,
    )
    left = AMPLIFIED * values["newton"]["force_tolerance"] * largest["N m"]
    rounding = {"N": max(work, left) / length, "N m": work, "Pa": 0.0}
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
    if values["adaptive"]:
        text += (
            "; in steps below some microseconds, which --plot solver.step_size shows, forces oscillate by the rounding "
            "of positions: use a larger tolerance then"
        )
    if values["method"] == "radau" or values["rho_inf"] < 1.0:
        return text
    return (
        f"{text}. With 'rho_inf: 1' the reactions of prescribed motions oscillate more and more after each kink of the "
        "acceleration, at any step size: use a smaller 'rho_inf', such as 0.8"
    )


def limit_warnings(
    deck: Deck, sampler: Sampler, extremes: Extremes, places: np.ndarray | None = None, where: str = "t = {:.4g} s"
) -> list[str]:
    """Return warnings about outputs that left the range of validity of their elements, one for those alike.

    ``places`` are the indices of the outputs of the ``extremes`` in a row of the ``sampler``, ascending; default: all.
    ``where`` is the text of a time, or of a load factor.
    """
    alike: dict[tuple[str, str, str], list[tuple[float, float, str, str]]] = {}  # value, time, element, output

    watched = [one for what in ("limits", "bounds") for one in watched_outputs(deck.values, sampler, what)]
    for name, d, output, column, limit, text, _ in watched:
        i = column if places is None else np.searchsorted(places, column)
        low, high = limit if isinstance(limit, tuple) else (-limit, limit)
        beyond = [(extremes.high[i], extremes.high_time[i])] if extremes.high[i] > high else []
        beyond += [(extremes.low[i], extremes.low_time[i])] if extremes.low[i] < low else []
        if beyond:
            key = d["type"], output.partition(".")[0], text
            alike.setdefault(key, []).append((*max(beyond, key=lambda end: abs(end[0])), name, output))
    return [_beyond_limit(kind, found, text, where) for (kind, _, text), found in alike.items()]


def _beyond_limit(kind, found, text, where):
    """Return the warning about the element of a ``kind`` that is farthest beyond a limit, with the number of others."""
    value, time, name, output = max(found, key=lambda one: abs(one[0]))
    others = len({other for _, _, other, _ in found}) - 1
    also = f" (and {others} more beyond it)" if others else ""
    return f"{kind} '{name}': {output} reached {value:.4g} at {where.format(time)}, but {text}{also}"


def until_warnings(values: Values, t: float, met: bool) -> Iterator[str]:
    """Yield a warning if the condition that ends a run was true at its start, or never; ``values``: section ``time``.

    ``met``: whether the run ended by it, at ``t`` [s].
    """
    if met and t <= values["start"]:
        yield f"'time.until', {values['until']}, is true at the start: the run has no steps"
    elif values["until"] and not met:
        yield f"'time.until', {values['until']}, did not become true before 'time.end', {values['end']:g} s"


def waiting_warnings(system: System, phases: np.ndarray) -> Iterator[str]:
    """Yield a text that names the elements that, by the ``phases`` at the end, were activated without effect."""
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


def open_latch_warnings(deck: Deck, row: np.ndarray, sampler: Sampler, extremes: Extremes) -> Iterator[str]:
    """Yield a text that names open latches, with the coordinates and rates of their joints from a row of outputs.

    Of latches with a release, those are open that were open in all steps.
    """
    columns, found = sampler.starts, []
    latched = {name: d for name, d in deck.values["joints"].items() if d.get("latch")}
    for name, d in latched.items():
        closed, release = columns[f"joints/{name}/latched"], d["latch"]["release"]
        if not (extremes.high[closed] if release else row[closed]):
            quantity, wanted = next(iter(d["latch"].items()))
            rate, unit = ("rate", "rad") if quantity == "angle" else ("velocity", "m")
            at, moving = (row[columns[f"joints/{name}/{output}"]] for output in (quantity, rate))
            text = f"{d['type']} '{name}' at {at:.4g} of {wanted:.4g} {unit}, moving at {moving:.3g} {unit}/s"
            found.append(text + (", with a 'release'" if release else ""))
    if found:
        yield f"{len(found)} of {len(latched)} latches never closed: {name_list(found, MOST_LATCHES, '; ')}"


def undeveloped_friction_warnings(deck: Deck, sampler: Sampler, extremes: Extremes, length: float) -> Iterator[str]:
    """Yield a warning for each dry friction that was always below its full value while its part moved far.

    Below the rate of the regularization friction falls to zero, and what sticks creeps; what moves far does not stick:
    its friction is that of a damper. ``length`` [m] is the length scale of the model.
    """
    units = {column.path: column.unit for column in sampler.columns}
    for place, d, field, regularization in _frictions(deck):
        coordinate = next((one for one in LAWS[field] if f"{place}/{one}" in units), None)
        if coordinate is None:
            continue
        i, j = (sampler.starts[f"{place}/{output}"] for output in (coordinate, RATES[coordinate]))
        unit, moved = units[f"{place}/{coordinate}"], extremes.high[i] - extremes.low[i]
        fastest = max(extremes.high[j], -extremes.low[j])
        if fastest < regularization and moved > FAR_MOVED * (1.0 if unit == "rad" else length):
            yield (
                f"{title_of(d['type'], place.partition('/')[2])}: its dry friction never reached its full value: it "
                f"moved by {moved:.3g} {unit} at up to {fastest:.3g} {unit}/s, below the 'regularization' of "
                f"{regularization:g} {unit}/s, braked as by a damper; use a much smaller one"
            )


def _frictions(deck):
    """Yield (path, deck values, field of the law, regularization) of the dry frictions of a deck."""
    for section in SECTIONS:
        for name, d in deck.values[section].items():
            for field in LAWS:
                law = d.get(field)
                for term, values in law if isinstance(law, tuple) else ():
                    if term == "dry_friction":
                        yield f"{section}/{name}", d, field, values["regularization"]
