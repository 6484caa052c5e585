"""Sampled signals of a deck, as the samplers of its linearized equations."""

from mecano.analyses.input_channels import unknowns_of
from mecano.deck.deck import Deck
from mecano.model.system import System
from mecano.solve.modal.sampled_system import Sampler


def samplers_of(deck: Deck, system: System) -> dict[str, Sampler]:
    """Return {name of the signal: Sampler} of the signals of a deck that are sampled and held."""
    found = {}
    for name, d in deck.values["signals"].items():
        if d["type"] == "sample_and_hold":
            value, source = unknowns_of(system, name)[:2].tolist()
            found[name] = Sampler(value, source, d["period"])
    return found
