"""Values of the curves in a resolved deck, which results files contain."""

from collections.abc import Iterable, Mapping
from typing import Any

import numpy as np


def curve_values(deck: Mapping[str, Any], law: Any, arguments: Iterable[float]) -> np.ndarray:
    """Return the values (n,) of a curve at the ``arguments``; ``law`` is a number, a name, or terms as in the deck."""
    from mecano.laws.probe import curve_at

    checked = checked_law(deck, law)
    return np.array([curve_at(checked, s)[0] for s in arguments])


def checked_law(deck: Mapping[str, Any], law: Any) -> Any:
    """Return the checked law, with defaults for absent fields; ``law`` as in ``curve_values``."""
    from mecano.laws import TERMS

    terms = deck["laws"][law] if isinstance(law, str) else law
    if not isinstance(terms, dict):
        return terms
    return tuple(
        (name, {f.name: values.get(f.name, f.default) for f in TERMS[name].fields}) for name, values in terms.items()
    )
