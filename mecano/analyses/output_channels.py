"""Outputs of a response: formulas of outputs of elements, of signals and of the motion of nodes.

Each is a signal that the analysis adds to the deck, so its derivatives are exact, as those of all signals. A component
of the acceleration of a node is the rate of that of its velocity, in axes that turn with w: a = v' + w x v.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np
import scipy.sparse as sp

from mecano.analyses.channel_errors import unknown
from mecano.analyses.input_channels import place_of
from mecano.element_interface import SECTIONS
from mecano.elements import KINDS
from mecano.errors import UsageError
from mecano.laws.formula import FormulaError, read_formula
from mecano.model.measured_outputs import AXES
from mecano.model.quantity_names import UnknownQuantity, resolve

if TYPE_CHECKING:
    from mecano.deck.deck import Deck
    from mecano.model.system import System

RATES = {"acceleration": ("velocity", "m/s2"), "angular_acceleration": ("angular_velocity", "rad/s2")}
"""Quantity of a node -> the quantity of which it is the rate, its unit."""


@dataclass(frozen=True)
class Output:
    """An output: the signals that measure it, one or, for an acceleration, the three components of the velocity."""

    name: str  # as asked for
    unit: str  # "" if it is that of the signal
    signals: tuple[str, ...]
    axis: int = 0  # of the acceleration

    def rows(self, system: "System", w: np.ndarray) -> tuple[sp.csr_matrix, sp.csr_matrix]:
        """Return R0, R1, each (1, n), in axes that turn with ``w`` (3,)."""
        at = [place_of(system, signal)[0] for signal in self.signals]
        if len(at) == 1:
            return _row(system.n, at, [1.0]), _row(system.n, [], [])
        i, j, k = (self.axis + np.arange(3)) % 3
        return _row(system.n, [at[k], at[j]], [w[j], -w[k]]), _row(system.n, [at[i]], [1.0])


def _row(n, columns, values):
    return sp.csr_matrix((values, ([0] * len(values), columns)), shape=(1, n))


def with_outputs(deck: "Deck", names: Sequence[str]) -> "tuple[Deck, list[Output]]":
    """Return a Deck with the signals that measure the outputs, and the Outputs. Raises UsageError."""
    entries = {(s, name): (KINDS[d["type"]], d) for s in SECTIONS for name, d in deck.values[s].items()}
    found, signals = [], dict(deck.values["signals"])
    for number, name in enumerate(names, start=1):
        texts, axis, unit = _measured(name, entries, deck.values["nodes"])
        own = tuple(f"output {number} {i}" for i in range(len(texts)))
        signals |= {one: {"type": "formula", "value": text, "unit": None} for one, text in zip(own, texts, strict=True)}
        found.append(Output(name, unit, own, axis))
    return replace(deck, values={**deck.values, "signals": signals}), found


def _measured(name, entries, nodes):
    """Return (formulas of the signals of an output, axis of an acceleration, its unit). Raises UsageError."""
    try:
        formula = read_formula(name)
    except FormulaError as error:
        raise UsageError(f"--output {name}: {error.message}") from None
    owner, _, rest = formula.reference.removeprefix("nodes.").rpartition(".")
    owner, _, what = owner.rpartition(".")
    if owner in nodes and what in RATES and rest in AXES:
        of, unit = RATES[what]
        return [f"nodes.{owner}.{of}.{axis}" for axis in AXES], AXES.index(rest), unit
    for reference in formula.references:
        try:
            resolve(reference, entries, nodes)
        except UnknownQuantity as error:
            raise _explained(name, error) from None
    if not formula.references:
        raise UsageError(f"--output {name}: it depends on nothing that moves")
    return [name], 0, ""


def _explained(name, error):
    """Return the UsageError for an UnknownQuantity in an output."""
    message = f"--output {name}: {error.message}"
    near = unknown("output", error.word, error.known) if error.known else None
    return UsageError(f"{message}; {str(near).partition('; ')[2]}" if near else message)
