"""Warnings about small motions within the regularized range of friction, or within free play: what acts there."""

from collections.abc import Iterable, Iterator, Mapping
from typing import Any

import numpy as np

from mecano.deck.deck import Deck
from mecano.model.state import State
from mecano.model.system import System

SECTIONS = "elements", "joints"
WITHIN = "between"  # phase of laws and teeth within their play
PLAY = "dead_band", "backlash"  # laws and fields that leave a range without elastic force


def friction_and_play_warnings(deck: Deck, system: System, s: State) -> Iterator[str]:
    """Yield warnings about friction that sticks at ``s``, and about free play within which ``s`` lies."""
    yield from sticking_warnings(deck, system, s)
    yield from play_warnings(deck, system, s)


def sticking_warnings(deck: Deck, system: System, s: State) -> Iterator[str]:
    """Yield a warning about friction in its regularized range, where it acts as a viscous damper."""
    first = {one.name: one.nodes[:2] for one in system.model.elements if one.kind.section == "joints"}
    stuck = [  # a coupler has no nodes of its own: its friction opposes the rate of its first coordinate
        f"{d['type']} '{name}'"
        for section in SECTIONS
        for name, d in deck.values[section].items()
        if any(_sticks(system, s, d.get("nodes") or first.get(name, ()), one) for one in _frictions(d))
    ]
    if stuck:
        yield (
            f"{', '.join(stuck)}: regularized friction acts as a strong viscous damper while it sticks, and small "
            "motions include that damper; for those of a sliding part remove the friction, for those of a sticking "
            "one replace it by a fixed joint or a stiff spring"
        )


def play_warnings(deck: Deck, system: System, s: State) -> Iterator[str]:
    """Yield a warning about free play within which small motions about ``s`` meet no elastic force."""
    within = {
        name
        for batch in system.batches
        for name, phase in zip(batch.names, s.phases[batch.phases], strict=True)
        if batch.kind.phases[phase] == WITHIN
    }
    entries = ((f"{d['type']} '{name}'", d) for section in SECTIONS for name, d in deck.values[section].items())
    loose = [name for name, d in entries if name in within and any(_play(d))]
    if loose:
        yield (
            f"{', '.join(loose)}: small motions lie within the free play, where it exerts no elastic force; for those "
            "of parts that touch remove the play, or load them"
        )


def _sticks(system, s, pair, friction):
    """Return whether friction between a pair of nodes acts in its regularized range."""
    return (
        bool(pair) and friction.get("force") != 0.0 and _sliding(system, s, pair, friction) < friction["regularization"]
    )


def _frictions(value: Any) -> Iterator[Mapping[str, Any]]:
    """Yield the mappings of regularized friction in the fields of an element or in its laws."""
    if isinstance(value, dict):
        if "regularization" in value:
            yield value
        value = list(value.values())
    if isinstance(value, (list, tuple)):
        for part in value:
            yield from _frictions(part)


def _play(value: Any) -> Iterator[bool]:
    """Yield True for each free play in the fields of an element or in its laws."""
    named: Iterable[tuple[Any, Any]] = value.items() if isinstance(value, dict) else ()
    if isinstance(value, (list, tuple)):
        is_term = len(value) == 2 and isinstance(value[0], str)
        named = [(value[0], value[1])] if is_term else [(None, part) for part in value]
    for name, part in named:
        if name in PLAY and part and not (name == "dead_band" and part["lower"] == part["upper"]):
            yield True
        yield from _play(part)


def _sliding(system, s, pair, friction):
    """Return an upper bound [m/s] of the sliding speed of two nodes, rotation taken at the largest radius given."""
    of, names = system.numbering, [node.name for node in system.nodes]
    motion = []
    for i in (names.index(name) for name in pair if name in names):
        x, r = of.x[i], of.r[i]
        motion.append((s.v[x : x + 3], s.R[of.rotation[i]] @ s.v[r : r + 3]))
    v, omega = (np.linalg.norm(m[-1] - m[0] if len(m) > 1 else m[0]) for m in zip(*motion, strict=True))
    radius = max((value for key, value in friction.items() if "radius" in key and value), default=1.0)
    return max(float(v), radius * float(omega))
