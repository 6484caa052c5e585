"""Scale of an error of the energy balance, for warnings, summaries and pictures."""

from collections.abc import Mapping
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from mecano.model.extremes import Extremes
    from mecano.model.sampler import Sampler

EXCHANGED = ("kinetic", "potential", "dissipated", "given")
OF_OTHERS = 0.1  # of an error of the balance: smaller changes of the other energies count as zero


def energy_ranges(sampler: "Sampler", extremes: "Extremes") -> dict[str, tuple[float, float]]:
    """Return {name: (smallest, largest)} [J] of the energies and of their balance, for ``scale_of_balance``."""
    places = {name: sampler.starts[f"energy/{name}"] for name in (*EXCHANGED, "balance")}
    return {name: (extremes.low[i], extremes.high[i]) for name, i in places.items()}


def scale_of_balance(ranges: Mapping[str, tuple[float, float]]) -> tuple[str, float]:
    """Return the energy with which an error of the balance is compared, as (description, energy [J]).

    ``ranges`` {name: (least, largest)} [J] are those of the energies ``EXCHANGED`` and of the "balance". Errors are
    compared with the largest change of an energy, as the kinetic energy of a vehicle says little about motions in it.
    Where nothing else changes the kinetic energy, its change is the error, which is compared with the energy itself.
    """
    change = {name: ranges[name][1] - ranges[name][0] for name in EXCHANGED if name in ranges}
    off, others = ranges["balance"][1] - ranges["balance"][0], [change[name] for name in change if name != "kinetic"]
    if "kinetic" in change and max(others, default=0.0) < OF_OTHERS * off:
        return "the kinetic energy", ranges["kinetic"][1]
    return "the largest change of an energy", max(change.values(), default=0.0)
