"""Mutations of all decks of inputs/: each is read, or refused in time with line and column, without a Python warning.

200 decks per run, the same ones each time; marked slow: 5,000.
"""

import random
import time
import warnings

import pytest
from scorecard.mutate import mutate, overrides
from test_deck_fuzz import INPUTS, outcome

SMALL = [path for path in INPUTS if path.stat().st_size < 20_000]


def longest_check(seeds):
    """The longest CPU time [s] of the checks of as many decks; about every sixth one has overrides."""
    longest = 0.0
    for path in SMALL:  # what they compile is not counted
        outcome(path.read_bytes(), str(path), {})
    for seed in seeds:
        rng = random.Random(seed)
        path = rng.choice(SMALL)
        text = path.read_text()
        data = mutate(text, rng).encode("utf-8", rng.choice(["replace", "surrogatepass"]))
        start = time.process_time()
        outcome(data, str(path), {}, overrides(text, rng) if rng.random() < 0.15 else ())
        longest = max(longest, time.process_time() - start)
    return longest


@pytest.fixture
def warnings_are_errors():
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        yield


def test_equal_seeds_give_equal_decks():
    text = SMALL[0].read_text()
    made = [[mutate(text, random.Random(seed)) for seed in range(50)] for _ in range(2)]
    assert made[0] == made[1] and len(set(made[0])) > 45


def test_mutated_decks(warnings_are_errors):
    assert longest_check(range(200)) < 5.0


@pytest.mark.slow
def test_five_thousand_mutated_decks(warnings_are_errors):
    assert longest_check(range(1000, 6000)) < 5.0
