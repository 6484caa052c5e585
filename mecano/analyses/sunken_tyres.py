"""Tyres that are deformed beyond the range of their law in an initial state that is computed."""

from typing import TYPE_CHECKING

from mecano.elements.wheels.tire_wheel import deepest
from mecano.errors import ConvergenceError
from mecano.model.measured_outputs import index_of

if TYPE_CHECKING:
    from mecano.deck.deck import Deck
    from mecano.model.state import State
    from mecano.model.system import System


def refuse_sunken_tyres(deck: "Deck", system: "System", s: "State", state: str) -> None:
    """Raise ConvergenceError if a tyre is deformed more in ``s`` than a deck may have it at the start.

    ``state`` describes ``s`` in words. The search for it has no such bound: a tyre that is too soft sinks as deep as
    its load requires.
    """
    outputs, texts = system.observe(s).outputs, []
    for batch in system.batches:
        w_at, load_at = (index_of(name, batch.kind, "") for name in ("deformation", "normal_force"))
        if w_at is None or load_at is None:
            continue
        values = batch.outputs(outputs)
        for (path, _), name, w, load in zip(batch.paths, batch.names, values[:, w_at], values[:, load_at], strict=True):
            most, because = deepest(deck.values["elements"][path.partition("/")[2]]["tire_law"])
            if w > most:
                texts.append(f"{name} carries {load:.4g} N with its rim {w:.4g} m below the ground{because}")
    if texts:
        raise ConvergenceError(
            f"{state} was found only with tyres deformed beyond their range: {'; '.join(texts)}\n"
            "what to try: a stiffer radial law (in N and m, also by the units of a .tir file); masses in kg; "
            "'valid_deformation', if the tyre may be deformed further"
        )
