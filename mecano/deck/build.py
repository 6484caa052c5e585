"""Checked deck -> model: nodes, elements, laws, and the velocities at the start."""

import numpy as np

from mecano.constraints.uses.demand import is_formula
from mecano.contract import SECTIONS
from mecano.deck.physics import element_nodes, poses
from mecano.elements import KINDS
from mecano.laws.table import LawTable, breakpoints
from mecano.model.model import Element, Model, Node
from mecano.schema import CURVE, DRIVE


def build(deck):
    """The Model of a checked deck (deck.Deck)."""
    values = deck.values
    at = poses(values["nodes"])
    nodes = [Node(name, *at[name], d["fixed"]) for name, d in values["nodes"].items()]
    elements = [
        Element(name, KINDS[d["type"]], tuple(element_nodes(KINDS[d["type"]], d)), d)
        for section in SECTIONS
        for name, d in values[section].items()
    ]
    return Model(nodes, elements, LawTable(), np.array(values["gravity"], float))


def asked_velocities(deck, system):
    """Velocities [m/s], angular velocities [rad/s] (n_nodes, 3), inertial, that ``initial.velocities`` asks for.

    Entries add up. Also which nodes (n_nodes,) an entry names.
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


def set_velocities(deck, system, s):
    """Set the velocities of the state ``s`` in place to those that the deck asks for.

    An unknown that several nodes share takes the mean over those that an entry names; what is fixed stays at rest.
    """
    of, (v, omega, named) = system.numbering, asked_velocities(deck, system)
    sums, counts = np.zeros_like(s.v), np.zeros_like(s.v)
    for i in np.flatnonzero(named):
        for first, value in ((of.x[i], v[i]), (of.r[i], system.nodes[i].R.T @ omega[i])):
            sums[first : first + 3] += value
            counts[first : first + 3] += 1.0
    free = np.arange(of.n_all) < of.n_q
    s.v[:] = np.where(free & (counts > 0), sums / np.maximum(counts, 1.0), 0.0)


def time_breakpoints(deck):
    """Times [s] at which a law of time has a jump or a corner, or a signal is sampled, ascending: steps end there."""
    times, run = set(), deck.values["time"]
    for section in SECTIONS:
        for d in deck.values[section].values():
            times |= set(KINDS[d["type"]].times(d, run["start"], run["end"]))
            laws = (d[field.name] for field in KINDS[d["type"]].fields if field.type in (CURVE, DRIVE))
            times |= {t for law in laws if not is_formula(law) for t in breakpoints(law)}
    return tuple(sorted(times))
