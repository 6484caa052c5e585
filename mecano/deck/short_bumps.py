"""The angle by which wheels turn at most in an adaptive step, lest they pass over a bump of their ground.

A wheel that rolls on a flat stretch has no error, however long its steps are.
"""

import math

import numpy as np

from mecano.deck.deck import Deck
from mecano.deck.laws import Law
from mecano.laws import TERMS
from mecano.laws.law_table import terms_of

LEAST = 0.1  # rad: steps are not limited further for the sake of points of a table that are closer together


def turn_over_bumps(deck: Deck) -> float:
    """Return the angle [rad] in which a wheel of a checked deck rolls from one end of a bump to its middle, or inf."""
    turn = math.inf
    for d in deck.values["elements"].values():
        profile = d["ground"]["profile"] if d.get("ground") else None
        radius = d.get("tire_law", d).get("radius")
        if profile and radius:
            turn = min(turn, max(shortest_part(profile["height"]) / radius, LEAST))
    return turn


def shortest_part(law: Law) -> float:
    """Return the least distance of two places where a term that may be flat elsewhere changes, or inf."""
    shortest = math.inf
    for name, values in terms_of(law):
        term = TERMS[name]
        if marks := term.landmarks(values):
            places = sorted({*marks, *term.breakpoints(values)})
            shortest = min(shortest, float(np.diff(places).min(initial=math.inf)))
    return shortest
