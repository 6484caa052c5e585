"""mecano: flexible multibody dynamics by finite elements.

``run``, ``check``, ``modes``, ``momentum``, ``response``, ``margins`` and ``sweep`` are the commands of the same names;
``Deck`` is a deck of plain Python objects, ``Simulation`` a run that is advanced step by step, ``open_results`` reads a
results file. ``MecanoError`` is the base class of their errors.
"""

from importlib import import_module
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from mecano.errors import DeckError, MecanoError
    from mecano.interface.deck import Deck
    from mecano.interface.margins import margins
    from mecano.interface.modes import modes
    from mecano.interface.momentum import momentum
    from mecano.interface.plugins import load_plugin
    from mecano.interface.response import response
    from mecano.interface.results import Results, open_results
    from mecano.interface.simulation import Simulation
    from mecano.interface.solving import check, run
    from mecano.interface.studies import sweep

__version__ = "0.1.0"

_MODULES = {  # imported at the first use of a name, so that `mecano --help` is fast
    "Deck": "mecano.interface.deck", "DeckError": "mecano.errors", "MecanoError": "mecano.errors",
    "Results": "mecano.interface.results", "Simulation": "mecano.interface.simulation",
    "check": "mecano.interface.solving", "load_plugin": "mecano.interface.plugins",
    "margins": "mecano.interface.margins", "modes": "mecano.interface.modes",
    "momentum": "mecano.interface.momentum",
    "open_results": "mecano.interface.results", "response": "mecano.interface.response",
    "run": "mecano.interface.solving", "sweep": "mecano.interface.studies",
}  # fmt: skip

__all__ = [
    "Deck", "DeckError", "MecanoError", "Results", "Simulation", "check", "load_plugin", "margins", "modes",
    "momentum", "open_results", "response", "run", "sweep",
]  # fmt: skip


def __getattr__(name):
    if name == "errors":
        return import_module("mecano.errors")
    if name in _MODULES:
        return getattr(import_module(_MODULES[name]), name)
    raise AttributeError(f"module 'mecano' has no attribute '{name}'")


def __dir__():
    return [*__all__, "__version__"]
