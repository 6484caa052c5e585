"""Outputs of a response: formulas of outputs of elements, of signals and of the motion of nodes.

Each is a signal that the analysis adds to the deck, so its derivatives are exact, like those of all signals. A
component of the acceleration of a node is the rate of the velocity component, in axes that turn with w: a = v' + w x v.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
import scipy.sparse as sp

from mecano.analyses.channel_errors import hint
from mecano.analyses.input_channels import place_of
from mecano.analyses.observed_outputs import MemberOutput, NodeOutput, member_output, node_output
from mecano.deck.deck import Deck
from mecano.element_interface import SECTIONS
from mecano.elements import KINDS
from mecano.errors import UsageError
from mecano.laws.formula import FormulaError, read_formula
from mecano.model.measured_outputs import AXES, components
from mecano.model.mesh import inner_names, piece_names
from mecano.model.quantity_names import UnknownQuantity, resolve
from mecano.model.state import State
from mecano.model.system import System

RATES = {"acceleration": ("velocity", "m/s2"), "angular_acceleration": ("angular_velocity", "rad/s2")}
"""Quantity of a node -> the quantity of which it is the rate, its unit."""


@dataclass(frozen=True)
class Output:
    """An output: the signals that measure it, one or, for an acceleration, the three components of the velocity."""

    name: str  # as requested
    unit: str  # "" for the unit of the signal
    signals: tuple[str, ...]
    axis: int = 0  # of the acceleration

    def rows(self, system: System, s: State, w: np.ndarray) -> list[sp.csr_matrix]:
        """Return R0, R1, R2, each (1, n), in axes that turn with ``w`` (3,)."""
        at, none = [place_of(system, signal)[0] for signal in self.signals], _row(system.n, [], [])
        if len(at) == 1:
            return [_row(system.n, at, [1.0]), none, none]
        i, j, k = (self.axis + np.arange(3)) % 3
        return [_row(system.n, [at[k], at[j]], [w[j], -w[k]]), _row(system.n, [at[i]], [1.0]), none]


def _row(n, columns, values):
    return sp.csr_matrix((values, ([0] * len(values), columns)), shape=(1, n))


def with_outputs(deck: Deck, names: Sequence[str]) -> tuple[Deck, list[Output | NodeOutput | MemberOutput]]:
    """Return a Deck with the signals that measure the outputs, and the outputs. Raises UsageError."""
    entries = {(s, name): (KINDS[d["type"]], d) for s in SECTIONS for name, d in deck.values[s].items()}
    members = {piece: d for name, d in deck.values["elements"].items() for piece in piece_names(name, d)}
    inner = {node for name, d in deck.values["elements"].items() for node in inner_names(name, d)}
    found: list[Output | NodeOutput | MemberOutput] = []
    signals, nodes = dict(deck.values["signals"]), deck.values["nodes"]
    for number, name in enumerate(names, start=1):
        own = node_output(name, {*nodes, *inner}.__contains__, nodes.__contains__)
        if other := own or member_output(name, lambda name: _unreadable_outputs(members.get(name))):
            found.append(other)
            continue
        texts, axis, unit = _measuring_signals(name, entries, nodes)
        new = tuple(f"output {number} {i}" for i in range(len(texts)))
        signals |= {one: {"type": "formula", "value": text, "unit": None} for one, text in zip(new, texts, strict=True)}
        found.append(Output(name, unit, new, axis))
    return replace(deck, values={**deck.values, "signals": signals}), found


def _unreadable_outputs(d):
    """Yield (name, unit) of the outputs of a flexible element with these values that formulas cannot read."""
    if not d or not (kind := KINDS[d["type"]].chosen(d)).flexible:
        return
    for output in kind.outputs:
        if output.name in kind.hidden and len(output.shape) < 2:
            yield from ((name, output.unit) for name in components(output))


def _measuring_signals(name, entries, nodes):
    """Return (formulas of the signals of an output, axis of an acceleration, its unit). Raises UsageError."""
    try:
        formula = read_formula(name)
    except FormulaError as error:
        raise UsageError(f"output {name}: {error.message}") from None
    owner, _, rest = formula.reference.removeprefix("nodes.").rpartition(".")
    owner, _, what = owner.rpartition(".")
    if owner in nodes and what in RATES and rest in AXES:
        of, unit = RATES[what]
        return [f"nodes.{owner}.{of}.{axis}" for axis in AXES], AXES.index(rest), unit
    for reference in formula.references:
        try:
            resolve(reference, entries, nodes)
        except UnknownQuantity as error:
            raise _explained_error(name, error, entries) from None
    if not formula.references:
        raise UsageError(f"output {name}: it depends on nothing that moves")
    return [name], 0, ""


def _explained_error(name, error, entries):
    """Return the UsageError for an UnknownQuantity in an output; for a member with a mesh, point to its elements."""
    owner, _, what = name.removeprefix("elements.").partition(".")
    _, d = entries.get(("elements", owner), (None, {}))
    if "." in (piece := piece_names(owner, d)[0]):
        return UsageError(f"output {name}: write which of its elements is meant, such as {piece}.{what}")
    found = hint(error.word, error.known)
    return UsageError(f"output {name}: {error.message}" + (f"; {found}" if found else ""))
