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

    found = deck["laws"][law] if isinstance(law, str) else law
    if not isinstance(found, dict | list):
        return found
    return tuple(
        (name, {f.name: values.get(f.name, f.default) for f in TERMS[name].fields})
        for name, values in terms_of(deck, law)
    )


def terms_of(deck: Mapping[str, Any], law: Any) -> list[tuple[str, dict[str, Any]]]:
    """Return the terms (name, values) of a law, a mapping or a list of such; none of a number or of None."""
    found = deck.get("laws", {}).get(law) if isinstance(law, str) else law
    parts = found if isinstance(found, list) else [found]
    return [term for part in parts if isinstance(part, dict) for term in part.items()]
