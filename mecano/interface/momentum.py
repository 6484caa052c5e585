"""Momentum of a run from Python."""

import os
from collections.abc import Sequence
from typing import TYPE_CHECKING

from mecano.interface.deck import AnyDeck, AnyPath, Values, checked_deck

if TYPE_CHECKING:
    from mecano.analyses.momentum import Momentum


def momentum(
    deck: AnyDeck, results: AnyPath, *, about: Sequence[float] = (0.0, 0.0, 0.0), set: Values | None = None
) -> "Momentum":
    """Compute linear and angular momentum, mass and centre of mass at the saved times of a dynamic run.

    Parameters
    ----------
    deck : str, Path, Deck or dict
    results : Results, str or Path
        Results of a run of this deck, or their file.
    about : sequence of float
        Inertial point to which the angular momentum refers [m].
    set : dict
        Overrides of values of the deck, as in the run.

    Returns
    -------
    Momentum
        With ``time`` (n,) [s], ``mass`` [kg], ``center_of_mass`` (n, 3) [m], ``linear`` (n, 3) [N s], ``angular`` and
        ``angular_about_center`` (n, 3) [N m s], all inertial; as text, a table with the largest changes.

    Raises
    ------
    DeckError, UsageError, ResultsError

    Examples
    --------
    >>> run = mecano.run("pendulum.yaml", quiet=True, set={"time.end": 0.5})
    >>> found = mecano.momentum("pendulum.yaml", run)
    >>> found.mass, found.linear.shape
    (1.0, (51, 3))
    """
    from mecano.analyses.momentum import momentum as find

    return find(checked_deck(deck, set), os.fspath(results), about)
