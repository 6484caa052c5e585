"""Legal but suspicious input seen in the assembled model: massless nodes, strains and slip at the start."""

import math

import numpy as np

from mecano.elements import KINDS
from mecano.errors import Problem
from mecano.laws.probe import curve_at
from mecano.solve.time.massless import massless_unknowns

MOST_STRAIN = 2e-3  # of bars, cables and beams: the strain of steel at its yield strength
MOST_EXTENSION = 0.5  # of springs, over their natural length
MOST_NAMED = 10  # warnings of one sort


def suspicious_model(deck, system, s, length):
    """Return the warnings (list of Problem) about a model at its start ``s``; ``length`` [m] is its length scale."""
    strained, swinging = [*_strained(deck, system, s)], [*_swinging(deck, system, s)]
    massless = _massless(deck, system, s, length)
    return [*_first(strained, "elements"), *_first(massless, "nodes"), *_first(swinging, "elements")]


def _first(problems, what):
    """Return the first ``MOST_NAMED`` problems; the last of them gives the number of further ones."""
    *shown, last = problems[:MOST_NAMED] or [None]
    more = len(problems) - MOST_NAMED
    if more > 0:
        last = Problem(f"{last.message} (and {more} more {what})", last.mark)
    return [*shown, last] if last else []


def _strained(deck, system, s):
    """Yield warnings about elements whose length at the start differs much from their length without force."""
    at = {node.name: s.z[x : x + 3] for node, x in zip(system.nodes, system.numbering.x, strict=True)}
    before = {node.name: node.x for node in system.nodes}
    for name, d in deck.values["elements"].items():
        fields = {field.name for field in KINDS[d["type"]].fields}
        if not fields & {"natural_length", "section"} or d.get("via") is not None or "ground" in d["nodes"]:
            continue
        natural = _natural_length(d, before, s.t)
        if not natural > 0.0:  # strain is undefined for a spring of natural length zero
            continue
        strain = float(np.linalg.norm(np.subtract(*(at[node] for node in d["nodes"])))) / natural - 1.0
        if _is_much(strain, fields, d["type"]):
            text = (
                f"{d['type']} '{name}' is strained by {100.0 * strain:.3g} % at the start: its nodes are "
                f"{natural * (1.0 + strain):.6g} m apart, its length without force is {natural:.6g} m"
            )
            yield Problem(text, deck.mark("elements", name))


def _natural_length(d, positions, t):
    """Return the length [m] without force, at time ``t``, of an element with checked values ``d``.

    ``positions`` are those of the nodes in the deck.
    """
    natural = d.get("natural_length")
    if natural is None:
        return float(np.linalg.norm(np.subtract(*(positions[node] for node in d["nodes"]))))
    return natural if isinstance(natural, float) else curve_at(natural, t)[0]


def _is_much(strain, fields, kind):
    """Decide whether a strain at the start is rarely intended; a cable may be slack, a spring preloaded."""
    if "axial_stiffness" in fields or "section" in fields:
        return strain > MOST_STRAIN or (strain < -MOST_STRAIN and kind != "cable")
    return abs(strain) > MOST_EXTENSION


def _swinging(deck, system, s):
    """Yield warnings about wheels whose twist is damped too little at their initial slip angle.

    At a slip angle alpha, spin inertia I and speed V, twist and spin oscillate with growing amplitude unless
    C1 > V I alpha^2/(r^2 kap C K): docs/tyres.md, Twist.
    """
    at = {node.name: i for i, node in enumerate(system.nodes)}
    for name, d in deck.values["elements"].items():
        if "psi" not in KINDS[d["type"]].scalars or not (law := d["tire_law"]["lateral"]["moreland"]):
            continue
        speed, angle, inertia = _rolling(d, system, s, at[d["node"]])
        stiffness = law["torsional_stiffness"] * law["yaw_coefficient"] * law["lateral_stiffness"]
        needed = speed * inertia * angle**2 / (d["tire_law"]["radius"] ** 2 * stiffness)
        if 0.0 < law["yaw_time"] < needed:
            text = (
                f"{d['type']} '{name}': rolling at its initial slip angle, {math.degrees(angle):.3g} deg at "
                f"{speed:.3g} m/s, the twist of its patch and its spin oscillate with growing amplitude, unless "
                f"'tire_law.lateral.moreland.yaw_time' ({law['yaw_time']:g} s) is more than {needed:.2g} s"
            )
            yield Problem(text, deck.mark("elements", name))


def _rolling(d, system, s, i):
    """Return speed [m/s], slip angle [rad] and spin inertia [kg m2] of the wheel with values ``d`` on node ``i``."""
    of, node, normal = system.numbering, system.nodes[i], np.array(d["ground"]["plane"]["normal"])
    own = node.R.T @ d["axis"] / np.linalg.norm(d["axis"])
    v, ahead = s.v[of.x[i] : of.x[i] + 3], np.cross(s.R[of.rotation[i]] @ own, normal)
    along, across = abs(v @ ahead), abs(v @ np.cross(normal, ahead)) / np.linalg.norm(normal)
    system.assemble(s, 1.0, 0.0, 0.0, 0.0, 1.0)
    rows, cols = (numbers - of.r[i] for numbers in (system.rows, system.cols))
    turning, M = (0 <= rows) & (rows < 3) & (0 <= cols) & (cols < 3), np.zeros((3, 3))
    np.add.at(M, (rows[turning], cols[turning]), system.data[: len(rows)][turning])
    return np.hypot(along, across) / np.linalg.norm(ahead), math.atan2(across, along), own @ M @ own


def _massless(deck, system, s, length):
    """Return warnings about nodes without mass; none for statics or for a model without any mass."""
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
        f"{node}: nothing gives mass to its {' and '.join(sorts)}, which follows forces without inertia; is this "
        "intended, or is a point_mass or a rigid_body missing?"
    )
    return Problem(text, next((mark for name in names if (mark := deck.mark("nodes", name))), None))
