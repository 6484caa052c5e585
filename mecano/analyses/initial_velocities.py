"""Initial velocities that the constraints change, also of nodes that the deck leaves at rest."""

import numpy as np

from mecano.deck.build import requested_velocities
from mecano.deck.deck import Deck
from mecano.errors import name_list
from mecano.model.state import State
from mecano.model.system import System
from mecano.solve.linear.rounding import ROUNDING

NOTICED = 1e-6  # of the fastest motion: a motion of a node that the deck leaves at rest, which is reported
VIOLATED = 1e-4  # of the fastest motion: a reported change of a velocity, which decks give with some four digits
MOST_NAMES = 3
NOT_NAMED = (
    "Nodes that are not named, including those attached to a body, have no velocity: name all nodes that move, with "
    "'about' for a rotation"
)


def changed_velocities(deck: Deck, system: System, given: State, start: State, length: float) -> list[str]:
    """Return a warning about the node whose velocity, or else angular velocity, the constraints changed most.

    ``given``: the state with the velocities of the deck, ``start``: with consistent ones; ``length`` [m]: the length
    scale. Only nodes that the deck names are considered, and with ``nodes: all`` all if none has its velocity.
    """
    of = system.numbering
    entries = deck.values["initial"]["velocities"]
    everywhere = any(any(e["velocity"] + e["angular_velocity"]) for e in entries if e["nodes"] == "all")
    entries = [entry for entry in entries if entry["nodes"] != "all"]
    named = {name for entry in entries for name in entry["nodes"]}
    turned = {name for entry in entries if any(entry["angular_velocity"]) for name in entry["nodes"]}
    turned &= _turning(system)
    motions = [  # fixed nodes did not receive the requested velocities
        (names, np.where((first < of.n_q)[:, None], before, wanted), reached, unit)
        for names, first, wanted, before, reached, unit in zip(
            (named, turned), (of.x, of.r), requested_velocities(deck, system), _velocities(system, given),
            _velocities(system, start), ("m/s", "rad/s"), strict=False,
        )
    ]  # fmt: skip
    fastest = [np.linalg.norm(np.concatenate([wanted, now]), axis=1).max(initial=0.0) for _, wanted, now, _ in motions]
    for (names, wanted, reached, unit), speed, least in zip(motions, fastest, _rounding(fastest, length), strict=True):
        change, limit = np.linalg.norm(reached - wanted, axis=1), max(VIOLATED * speed, least)
        movable = np.array([not node.fixed for node in system.nodes])
        nowhere = everywhere and change[movable].min(initial=np.inf) > limit
        change[~movable if nowhere else [node.name not in names for node in system.nodes]] = 0.0
        if change.max(initial=0.0) > limit:
            i = int(np.argmax(change))
            was, is_ = (_vector_text(vector, speed) for vector in (wanted[i], reached[i]))
            return [
                "the initial velocities violate the constraints and were replaced by the nearest admissible ones "
                f"(momenta kept): node '{system.nodes[i].name}' from {was} to {is_} {unit}. "
                + ("No node can move as 'nodes: all' demands" if nowhere else NOT_NAMED)
            ]
    return []


def _rounding(fastest, length):
    """Return the rounding errors of speeds [m/s] and, derived from these, of angular velocities [rad/s]."""
    return ROUNDING * fastest[1] * length, ROUNDING * fastest[0] / length


def _vector_text(vector, size):
    """Return a vector as text, with components at the rounding level of ``size`` replaced by zero."""
    rounded = np.where(np.abs(vector) <= ROUNDING * size, 0.0, vector)
    return "[" + ", ".join(f"{component + 0.0:.4g}" for component in rounded) + "]"


def _turning(system):
    """Return the names of the nodes whose rotation is free or held; that of a point mass is neither."""
    nodes, of = system.nodes, system.numbering
    held = {of.r[i] for i, node in enumerate(nodes) if node.fixed}
    return {node.name for i, node in enumerate(nodes) if of.r[i] < of.n_q or of.r[i] in held}


def _velocities(system, s):
    """Return the velocities and angular velocities of all nodes, (n_nodes, 3) each, in inertial axes."""
    of, three = system.numbering, np.arange(3)
    return s.v[of.x[:, None] + three], np.einsum("nij,nj->ni", s.R[of.rotation], s.v[of.r[:, None] + three])


def set_in_motion(deck: Deck, system: System, given: State, start: State, length: float) -> str:
    """Describe the nodes, not named in ``initial.velocities``, that the constraints set in motion; "" if none.

    Nodes attached to a body whose node is named are not listed. Arguments as in ``changed_velocities``. A drive whose
    rate is not zero at the start moves what it drives; one that would move nothing by more than the rounding of
    positions until the end is at rest.
    """
    time = deck.values["time"]
    still = ROUNDING / (time["end"] - time["start"])  # 1/s
    of, named = system.numbering, requested_velocities(deck, system)[2]
    moving = {node.name for node, given in zip(system.nodes, named, strict=True) if given}
    bodies = [d for d in deck.values["elements"].values() if d.get("attached") and d["node"] in moving]
    carried = {name for d in bodies for name in d["attached"]}
    quiet = np.array([node.internal or node.name in carried for node in system.nodes])
    motions = [
        (first, np.linalg.norm(now - before, axis=1), np.linalg.norm(now, axis=1).max(initial=0.0), unit)
        for first, before, now, unit in zip(
            (of.x, of.r), _velocities(system, given), _velocities(system, start), ("m/s", "rad/s"), strict=True
        )
    ]
    found = []
    rounding = _rounding([m[2] for m in motions], length)
    for (first, change, fastest, unit), least, size in zip(motions, rounding, (length, 1.0), strict=True):
        wanted = np.isin(first, first[named])  # of a named node, or of one that shares its unknowns
        moved = (change > max(NOTICED * fastest, least, still * size)) & ~quiet & ~wanted
        found += [f"node '{system.nodes[i].name}' by {change[i]:.4g} {unit}" for i in np.argsort(-change) if moved[i]]
        quiet |= moved
    return name_list(found, MOST_NAMES, "; ")
