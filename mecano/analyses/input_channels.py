"""Inputs of a response: signals, or functions of time of loads and prescribed motions, to which sinusoids are added."""

from collections.abc import Iterator, Mapping
from copy import deepcopy
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from mecano.analyses.channel_errors import unknown
from mecano.constraints.along_coordinate.demand import is_formula
from mecano.deck.build import build
from mecano.deck.deck import Deck
from mecano.element_interface import SECTIONS
from mecano.elements import KINDS
from mecano.errors import UsageError
from mecano.laws.formula import evaluate_formula, read_formula
from mecano.laws.law_table import terms_of
from mecano.maths.dual import Dual
from mecano.model.state import State
from mecano.model.system import System
from mecano.schema import MOTION, Field, Values
from mecano.solve.modal.linearize import Linearization

SHIFT = 2.0**-10  # [m] or [rad], of a prescribed motion, in which its constraint is linear


@dataclass(frozen=True)
class Input:
    """An input: a signal of the deck for the response, and the prescribed motions that depend on it."""

    name: str  # as requested
    unit: str  # of the field, or of the motion that a signal prescribes, or ""
    signal: str = ""  # "" for a prescribed motion that is not a signal
    motions: dict[tuple[str, ...], str] = field(default_factory=dict)  # path in the deck -> formula as written

    def columns(self, lin: Linearization, system: System, s: State, deck: Deck) -> np.ndarray:
        """Return Q0, Q1, Q2 (3, n): the forces, per unit of the input and its rates, of the elements that read it.

        The sinusoid acts on everything that reads the signal, but not on the equation of the signal itself.
        """
        Q = np.zeros((3, system.n))
        if self.signal:
            at, own = place_of(system, self.signal)
            for q, A in zip(Q, (lin.K, lin.C, lin.M), strict=True):
                q -= A[:, [at]].toarray().ravel()
                q[own] = 0.0
        for path, text in self.motions.items():
            slope = slope_of(text, deck.values["signals"], self.signal, s.t) if self.signal else 1.0
            if slope:
                moved = System(build(_with_value(deck, path, _shifted)))
                Q[0] -= slope / SHIFT * (_residual(moved, s) - _residual(system, s))
        return Q


def place_of(system: System, signal: str) -> tuple[int, np.ndarray]:
    """Return the index of the value of a signal in z, and the indices (n,) of all unknowns of the signal."""
    b, dofs = _unknowns(system, signal)
    first = 3 * len(b.kind.layout)
    return int(dofs[first]), dofs[first : first + len(b.kind.scalars)]


def unknowns_of(system: System, signal: str) -> np.ndarray:
    """Return the indices (n,) in z of all unknowns of a signal; for a delay its value, then its input."""
    return _unknowns(system, signal)[1]


def _unknowns(system, signal):
    """Return the batch of a signal, and the indices of its local unknowns."""
    for b in system.batches:
        for (path, _), dofs in zip(b.paths, b.dofs, strict=True):
            if path == f"signals/{signal}":
                return b, dofs
    raise AssertionError(f"there is no signal {signal}")


def with_inputs(deck: Deck, names: tuple[str, ...], channel: str = "input") -> tuple[Deck, list[Input]]:
    """Return a Deck in which functions of time that are inputs are signals, and the Inputs. Raises UsageError.

    ``channel``: what the names stand for in messages.
    """
    found, motions = [], _motions(deck)
    for number, name in enumerate(names, start=1):
        signal = name.removeprefix("signals.")
        if signal in deck.values["signals"]:
            found.append(Input(name, _unit_of_motion(deck, motions, signal), signal, motions))
        else:
            deck, one = _law_as_signal(deck, name, f"input_{number}_of_response", channel)
            found.append(one)
    return deck, found


def _law_as_signal(deck, name, signal, channel):
    """Return a Deck in which a function of time is the ``signal``, and its Input; ``name``: NAME.FIELD."""
    known = {".".join(path[1:]): (path, field, value) for path, field, value in _functions_of_time(deck)}
    known |= {".".join(path): one for path, *_ in known.values() for one in [known[".".join(path[1:])]]}
    if name not in known:
        if name.removeprefix("grounds.").partition(".")[0] in deck.values["grounds"]:
            raise UsageError(
                f"{channel} {name}: a ground does not move; stand wheels on plates (wheel_on_body), prescribe the "
                "heights of these by signals (prescribed_position), and give the signals as inputs"
            )
        if text := _absent_field(deck, name):
            raise UsageError(f"{channel} {name}: {text}")
        raise unknown(channel, name, [*deck.values["signals"], *known], _no_inputs_hint(deck, known))
    path, declared, value = known[name]
    if declared.type == MOTION:
        return deck, Input(name, declared.unit, "", {path: ""})
    if len(path) > 3:
        raise UsageError(f"{channel} {name}: write this function of time as a signal, and give its name")
    deck, own = _with_value(deck, path, lambda value: signal), {"type": "curve", "input": "time", "law": value}
    if is_formula(value):
        own = {"type": "formula", "value": value}
    signals = {**deck.values["signals"], signal: {**own, "unit": None}}
    return replace(deck, values={**deck.values, "signals": signals}), Input(name, declared.unit, signal)


def _absent_field(deck, name):
    """Return what to do about a function of time that an element or joint may have, and does not have in the deck."""
    for section in SECTIONS:
        owner, _, field = name.removeprefix(f"{section}.").partition(".")
        d = deck.values[section].get(owner)
        fields = {one.name: one for one in (KINDS[d["type"]].fields if d else ()) if one.type.name == "drive"}
        if field in fields:
            what = f"{d['type']} '{owner}' has no '{field}' in the deck"
            return f"{what}; give it one [{fields[field].unit}]: {fields[field].doc}"
    return ""


def _no_inputs_hint(deck, known):
    """Return a hint for a deck without inputs."""
    if known or deck.values["signals"]:
        return ""
    return "the deck has no signals, loads or prescribed motions; write a force as a load: {type: force, ..., value: 0}"


def _functions_of_time(deck) -> Iterator[tuple[tuple[str, ...], Field, Any]]:
    """Yield (path, Field, value) of all functions of time, and formulas, that elements, joints and loads take."""
    for section in SECTIONS:
        for name, d in deck.values[section].items():
            for path, declared, value in _drives(KINDS[d["type"]].fields, d):
                yield (section, name, *path), declared, value


def _drives(fields, d):
    for declared in fields:
        value = d.get(declared.name)
        if declared.type.name == "drive" and value is not None:
            yield (declared.name,), declared, value
        elif declared.type.name == "mapping" and type(value) is dict:
            for path, inner, one in _drives(declared.type.options, value):
                yield (declared.name, *path), inner, one


def _motions(deck) -> dict[tuple[str, ...], str]:
    """Return {path: formula as written} of the prescribed motions that are formulas or signals."""
    written = {(id(container), key): text for container, key, text in deck.motions}
    paths = [path for path, declared, _ in _functions_of_time(deck) if declared.type == MOTION]
    found = {path: written.get((id(_container(deck.values, path)), path[-1])) for path in paths}
    return {path: text for path, text in found.items() if text is not None}


def _unit_of_motion(deck, motions, signal):
    """Return the unit of the prescribed motion that is a ``signal``, or ""."""
    units = {path: declared.unit for path, declared, _ in _functions_of_time(deck)} if motions else {}
    return next((units[path] for path, text in motions.items() if text.removeprefix("signals.") == signal), "")


def _container(values, path):
    """Return the mapping that holds the value at a path."""
    for key in path[:-1]:
        values = values[key]
    return values


def slope_of(text: str, signals: Mapping[str, Values], signal: str, t: float) -> float:
    """Return the exact slope of the motion that a formula (text) prescribes by the value of a ``signal`` at ``t`` [s].

    ``signals``: those of the deck; the others in the formula are formulas of the time themselves, or a whole curve.
    """
    if text.removeprefix("signals.") == signal:
        return 1.0
    if signals.get(text.removeprefix("signals."), {}).get("type") == "curve":
        return 0.0
    return _value_and_slope(text, signals, signal, t).slope


def _value_and_slope(text, signals, signal, t):
    """Return the value of a formula of the time and its slope by the value of a ``signal``."""
    found = read_formula(text)
    q = [Dual(0.0, 0.0)]
    for name in (name.removeprefix("signals.") for name in found.references):
        one = _value_and_slope(signals[name]["value"], signals, signal, t)
        q.append(Dual(one.value, 1.0) if name == signal else one)
    return evaluate_formula(np.array(found.numbers), 0, t, q, 0)


def _with_value(deck, path, change):
    """Return a Deck with a changed value at a path; no container of the value is shared with ``deck``."""
    values = deepcopy(deck.values)
    container = _container(values, path)
    container[path[-1]] = change(container[path[-1]])
    return replace(deck, values=values)


def _shifted(value):
    """Return a prescribed motion that is larger by SHIFT: a formula, a law or a number."""
    if is_formula(value):
        return f"({value}) + {SHIFT!r}"
    return (*terms_of(value), ("constant", {"value": SHIFT}))


def _residual(system, s):
    """Return the residual (n,) of the equations at a state, with its reactions."""
    return system.assemble(s).residual[: system.n].copy()
