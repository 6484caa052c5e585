"""Checked deck -> model: nodes, elements, laws, and the initial velocities."""

import re

import numpy as np

from mecano.constraints.along_coordinate.demand import is_formula
from mecano.deck.deck import Deck
from mecano.deck.laws_of_time import uses_of_time
from mecano.deck.physics import element_nodes, poses
from mecano.deck.values import in_si
from mecano.element_interface import SECTIONS
from mecano.elements import KINDS
from mecano.laws.formula import read_formula
from mecano.laws.formula_rate import LONGEST
from mecano.laws.law_table import LawTable, breakpoints, landmarks
from mecano.model.model import Element, Model, Node
from mecano.model.state import State
from mecano.model.system import System

WITH_CORNERS = r"\b(?:abs|min|max|step)\("


def _with_unit_in_si(d):
    """Return the values of an entry; a signal whose unit is given has values in the corresponding SI unit."""
    return {**d, "unit": in_si(d["unit"])} if d.get("unit") else d


def build(deck: Deck) -> Model:
    """Return the Model of a checked deck (deck.Deck)."""
    values = deck.values
    at = poses(values["nodes"])
    nodes = [Node(name, *at[name], d["fixed"]) for name, d in values["nodes"].items()]
    elements = [
        Element(name, _kind_in(d, values["time"]), tuple(element_nodes(KINDS[d["type"]], d)), _with_unit_in_si(d))
        for section in SECTIONS
        for name, d in values[section].items()
    ]
    if values["time"] and values["time"]["until"]:
        from mecano.constraints.run_end import RUN_END  # few decks need it

        elements.append(Element("until", RUN_END, (), {"until": values["time"]["until"]}))
    return Model(nodes, elements, LawTable(), np.array(values["gravity"], float), deck.units_in_formulas)


def _kind_in(d, time):
    """Return the Kind of an entry, or the one that replaces it in a run with this section 'time'."""
    kind = KINDS[d["type"]]
    return kind.in_run(d, time) if time and kind.in_run else kind


def requested_velocities(deck: Deck, system: System) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return the velocities [m/s] and angular velocities [rad/s] (n_nodes, 3), inertial, of ``initial.velocities``.

    Entries add up. The third return value is a mask (n_nodes,) of the nodes named by an entry.
    """
    n_nodes = len(system.nodes)
    v, omega, named = np.zeros((n_nodes, 3)), np.zeros((n_nodes, 3)), np.zeros(n_nodes, bool)
    index = {node.name: i for i, node in enumerate(system.nodes)}
    for entry in deck.values["initial"]["velocities"]:
        names = list(index) if entry["nodes"] == "all" else entry["nodes"]
        for i in (index[name] for name in names):
            x = system.nodes[i].x
            about = x if entry["about"] in (None, "own") else np.array(entry["about"])
            spin = np.array(entry["angular_velocity"])
            v[i] += np.array(entry["velocity"]) + np.cross(spin, x - about)
            omega[i] += spin
            named[i] = True
    return v, omega, named


def set_velocities(deck: Deck, system: System, s: State) -> None:
    """Set the velocities of the state ``s`` in place to the initial velocities of the deck.

    A shared unknown takes the mean over the nodes named by an entry; fixed unknowns stay at rest.
    """
    of, (v, omega, named) = system.numbering, requested_velocities(deck, system)
    sums, counts = np.zeros_like(s.v), np.zeros_like(s.v)
    for i in np.flatnonzero(named):
        for first, value in ((of.x[i], v[i]), (of.r[i], system.nodes[i].R.T @ omega[i])):
            sums[first : first + 3] += value
            counts[first : first + 3] += 1.0
    free = np.arange(of.n_all) < of.n_q
    s.v[:] = np.where(free & (counts > 0), sums / np.maximum(counts, 1.0), 0.0)


def time_breakpoints(deck: Deck) -> tuple[float, ...]:
    """Return the times [s], ascending, of jumps and corners of laws and formulas of time, and of samples of signals."""
    return tuple(sorted(_samples(deck) | _corners(deck)))


def time_samples(deck: Deck) -> tuple[float, ...]:
    """Return those of ``time_breakpoints`` at which signals are sampled and no law has a jump or corner."""
    return tuple(sorted(_samples(deck) - _corners(deck)))


def _samples(deck):
    run, signals = deck.values["time"], deck.values["signals"].values()
    return {t for d in signals for t in KINDS[d["type"]].sampling_times(d, run["start"], run["end"])}


def _corners(deck):
    run = deck.values["time"]
    entries = [d for section in SECTIONS for d in deck.values[section].values()]
    times = {t for d in entries for t in KINDS[d["type"]].times(d, run["start"], run["end"])}
    return times.union(*(breakpoints(law) for law in _laws_of_time(deck)), _formula_corners(deck))


def _formula_corners(deck):
    formulas = {text for text in _formulas_of_time(deck) if re.search(WITH_CORNERS, text)}
    if not formulas:
        return ()
    from mecano.laws.formula_corners import corners  # few runs need it

    start, end = deck.values["time"]["start"], deck.values["time"]["end"]
    return {t for text in formulas for t in corners(read_formula(text, LONGEST).program, start, end)}


def _formulas_of_time(deck):
    """Return the formulas of a deck (set of texts) that contain the time."""
    return {law for _, _, law in uses_of_time(deck.values, KINDS) if is_formula(law) and "time" in law}


def time_landmarks(deck: Deck) -> tuple[float, ...]:
    """Return the times [s], ascending, at which adaptive steps end so that they do not pass over a pulse.

    The pulses are those of laws, and of formulas as far as these depend on the time itself.
    """
    found = {t for law in _all_laws_of_time(deck) for t in landmarks(law)}
    if formulas := _formulas_of_time(deck):
        from mecano.laws.formula_pulses import pulses  # few runs need it

        run = deck.values["time"]
        found.update(
            t for text in formulas for t in pulses(read_formula(text, LONGEST).program, run["start"], run["end"])
        )
    return tuple(sorted(found))


def places_of_laws(deck: Deck) -> tuple[float, ...]:
    """Return the times [s], ascending, of corners and pulses of laws of time."""
    return tuple(sorted({t for law in _all_laws_of_time(deck) for t in (*breakpoints(law), *landmarks(law))}))


def _laws_of_time(deck):
    return (law for _, _, law in uses_of_time(deck.values, KINDS) if not is_formula(law))


def _all_laws_of_time(deck):
    """Yield the laws of time, and those of signals that are curves of the time."""
    yield from _laws_of_time(deck)
    for d in deck.values["signals"].values():
        if d["type"] == "curve" and d["input"].strip() == "time":
            yield d["law"]
