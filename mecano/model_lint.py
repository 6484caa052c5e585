"""Legal but suspicious models: massless nodes and strains at the start, which only the assembled model shows."""

import numpy as np

from mecano.elements import KINDS
from mecano.errors import Problem
from mecano.laws.probe import curve_at
from mecano.solve.massless import massless_unknowns

MOST_STRAIN = 2e-3  # of bars, cables and beams: that of steel at its yield strength
MOST_EXTENSION = 0.5  # of springs, over their natural length
MOST_NAMED = 10  # warnings of one sort


def suspicious_model(deck, system, s, length):
    """Warnings (list of Problem) of a model at its start ``s``; ``length`` is its length scale."""
    strained = [*_strained(deck, system, s)]
    return [*_first(strained, "elements"), *_first(_massless(deck, system, s, length), "nodes")]


def _first(problems, what):
    """The first ``MOST_NAMED`` of the problems, the last of which says how many more there are."""
    *shown, last = problems[:MOST_NAMED] or [None]
    more = len(problems) - MOST_NAMED
    if more > 0:
        last = Problem(f"{last.message} (and {more} more {what})", last.mark)
    return [*shown, last] if last else []


def _strained(deck, system, s):
    """Warnings of elements that are much longer or shorter at the start than where they have no force."""
    at = {node.name: s.z[x : x + 3] for node, x in zip(system.nodes, system.numbering.x, strict=True)}
    before = {node.name: node.x for node in system.nodes}
    for name, d in deck.values["elements"].items():
        fields = {field.name for field in KINDS[d["type"]].fields}
        if not fields & {"natural_length", "section"} or d.get("via") is not None or "ground" in d["nodes"]:
            continue
        natural = _natural_length(d, before, s.t)
        if not natural > 0.0:  # a spring that pulls its nodes together has no strain
            continue
        strain = float(np.linalg.norm(np.subtract(*(at[node] for node in d["nodes"])))) / natural - 1.0
        if _is_much(strain, fields, d["type"]):
            text = (
                f"{d['type']} '{name}' is strained by {100.0 * strain:.3g} % at the start: its nodes are "
                f"{natural * (1.0 + strain):.6g} m apart, and without force {natural:.6g} m"
            )
            yield Problem(text, deck.mark("elements", name))


def _natural_length(d, positions, t):
    """Length [m] at the time t at which an element of checked values ``d`` has no force; positions as in the deck."""
    natural = d.get("natural_length")
    if natural is None:
        return float(np.linalg.norm(np.subtract(*(positions[node] for node in d["nodes"]))))
    return natural if isinstance(natural, float) else curve_at(natural, t)[0]


def _is_much(strain, fields, kind):
    """Decide whether a strain at the start is seldom meant; a cable may hang slack, a spring be preloaded."""
    if "axial_stiffness" in fields or "section" in fields:
        return strain > MOST_STRAIN or (strain < -MOST_STRAIN and kind != "cable")
    return abs(strain) > MOST_EXTENSION


def _massless(deck, system, s, length):
    """Warnings of nodes that nothing gives mass; none of a model that has no mass at all, or is in equilibrium."""
    if not deck.values["time"] or not any("mass" in b.p.dtype.names and b.p["mass"].any() for b in system.batches):
        return []
    names, found = system.numbering.name, {}
    for i in massless_unknowns(system, s, length):
        node, _, what = names[i].partition(": ")
        found.setdefault(node, set()).add("rotation" if what.startswith("moment") else "displacement")
    return [_no_mass(deck, node, sorted(sorts)) for node, sorts in found.items()]


def _no_mass(deck, node, sorts):
    names = node.removeprefix("node ").split(", ")
    text = (
        f"{node}: nothing gives mass to its {' and '.join(sorts)}, which follows forces without inertia; is it meant "
        "so, or is a point_mass or a rigid_body missing?"
    )
    return Problem(text, next((mark for name in names if (mark := deck.mark("nodes", name))), None))
