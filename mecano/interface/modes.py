"""Compute modes from Python."""

import os
from dataclasses import dataclass, field

import numpy as np

from mecano.interface.deck import AnyDeck, AnyPath, Values, checked_deck
from mecano.interface.results import preformatted
from mecano.interface.saved_state import SavedState, saved_state
from mecano.interface.solving import require
from mecano.process.cores import bounded_blas
from mecano.solve.modal import SOLVERS


@bounded_blas()
def modes(
    deck: AnyDeck, path: AnyPath | None = None, *, set: Values | None = None,
    at: SavedState | None = None, at_rest: bool = False, number: int = 10,
    frame: str = "inertial", solver: str = "automatic", force: bool = False,
) -> "Modes":  # fmt: skip
    """Compute modes about the initial state of a deck, its equilibrium, or a saved state.

    Parameters
    ----------
    deck : str, Path, Deck or dict
    path : str or Path
        File for the shapes; by default none is written.
    set : dict
        Overrides of values of the deck.
    at : str, Path or tuple
        "results.h5:1.25", or ("results.h5", 1.25): linearize about the saved state nearest to that time; without a
        time, the last one.
    at_rest : bool
        Linearize about the equilibrium near the state of ``at``.
    number : int
        Number of modes, from the lowest frequency.
    frame : str
        Axes of the motions: "inertial", those of a node, or turning at "wx,wy,wz" [rad/s].
    solver : {"automatic", "dense", "sparse"}
    force : bool
        Replace an existing file.

    Returns
    -------
    Modes

    Raises
    ------
    DeckError, UsageError, AssemblyError, ConvergenceError, NonFiniteError, ResultsError

    Examples
    --------
    >>> found = mecano.modes("pendulum.yaml", set={"initial": "static"})
    >>> float(round(found.frequency[0], 4))  # of a point mass on 1 m: sqrt(9.81)/(2 pi)
    0.4985
    """
    from mecano.analyses.modal import modes as find

    require(isinstance(number, int | np.integer) and number >= 1, "number", number, "a whole number of 1 or more")
    require(solver in SOLVERS, "solver", solver, " or ".join(map(repr, SOLVERS)))
    place, checked = saved_state(at, at_rest), checked_deck(deck, set)
    where = None if path is None else os.fspath(path)
    text, found, about = find(
        checked, where, at=place, at_rest=at_rest, number=number, frame=frame, method=solver, force=force
    )
    return Modes(found.values, found.frequency, found.natural_frequency, found.damping_ratio, tuple(found.kinds),
                 found.shapes, about.words, text)  # fmt: skip


@dataclass(frozen=True)
class Modes:
    """Modes by ascending natural frequency; of a conjugate pair, the one with the positive imaginary part."""

    eigenvalues: np.ndarray  # (m,) complex [1/s]
    frequency: np.ndarray  # damped (m,) [Hz]
    natural_frequency: np.ndarray  # (m,) [Hz]
    damping_ratio: np.ndarray  # (m,)
    kinds: tuple[str, ...]  # free, oscillation, flutter, decay or divergence
    shapes: np.ndarray = field(repr=False)  # (m, n) complex, over the degrees of freedom
    about: str
    text: str = field(repr=False)  # the table that `mecano modes` prints

    def __str__(self):
        return self.text

    def _repr_html_(self) -> str:
        return preformatted(self.text)
