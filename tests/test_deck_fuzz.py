"""Malformed decks, made and mutated: each is read, or refused with line and column.

3,900 decks per run, the same ones each time; the scorecard has 100,000 more (scorecard/malformed.py).
"""

import contextlib
import json
import random
import re
import time
from pathlib import Path

import pytest
from deck_samples import FAKE, FAKE_KINDS, REAL, VALID
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from scorecard.mutate import NASTY, mutate, overrides

from mecano.analyses.summary import summary
from mecano.deck.compose import compose
from mecano.deck.format import deck_error_text
from mecano.deck.read import deck_of_bytes
from mecano.deck.sections import SECTIONS
from mecano.deck.source import Source
from mecano.errors import AssemblyError, DeckError
from mecano.laws import TERMS

INPUTS = sorted((Path(__file__).parent.parent / "inputs").glob("*.yaml"))
DECKS = [(VALID, "fake.yaml", FAKE), (REAL, "real.yaml", {})] + [(path.read_text(), str(path), {}) for path in INPUTS]


def outcome(data, file="deck.yaml", options=FAKE, overrides=()):
    """True when the deck is read, False when it is refused as it must be."""
    try:
        deck = deck_of_bytes(data, file, overrides=overrides, **options)
    except DeckError as error:
        assert error.exit_code == 2 and error.problems
        for problem in error.problems:
            assert problem.message and problem.message.isprintable()
            assert problem.hint.isprintable()
            assert problem.mark.line >= 1 and problem.mark.column >= 1
            assert problem.mark.file == file or problem.mark.file.startswith(("override", str(Path(file).parent)))
        text = deck_error_text(error)
        text.encode()
        assert re.match(r".+:\d+:\d+: ", text) and re.search(r"\b\d+ errors?(; consistency is checked .*)?$", text)
        return False
    assert json.loads(json.dumps(deck.resolved(), allow_nan=False))["mecano"] == 1
    if not options:  # of real kinds: what `mecano check` does with it
        with contextlib.suppress(AssemblyError):
            summary(deck)
    return True


def with_bytes(rng, data):
    """Bytes inserted or changed at random."""
    i = rng.randrange(len(data) + 1)
    new = bytes(rng.randrange(256) for _ in range(rng.choice([1, 1, 2, 8])))
    return data[:i] + new + data[i + rng.choice([0, len(new)]) :]


def fuzz(count):
    """Settings of one test: as many examples, the same each time."""
    return settings(
        max_examples=count, derandomize=True, database=None, deadline=None, suppress_health_check=list(HealthCheck)
    )


@pytest.mark.parametrize("text,file,options", DECKS, ids=[Path(file).name for _, file, _ in DECKS])
def test_the_decks_are_valid(text, file, options):
    assert outcome(text.encode(), file, options)


def test_mutated_texts():
    """About every sixth one with overrides."""
    refused, longest = [], 0.0

    @fuzz(400)
    @given(st.sampled_from(DECKS), st.integers(0, 2**32))
    def mutated(deck, seed):
        nonlocal longest
        (text, file, options), rng = deck, random.Random(seed)
        data = mutate(text, rng).encode("utf-8", rng.choice(["replace", "surrogatepass"]))
        start = time.process_time()
        refused.append(not outcome(data, file, options, overrides(text, rng) if rng.random() < 0.15 else ()))
        longest = max(longest, time.process_time() - start)

    mutated()
    assert len(refused) >= 400 and sum(refused) > 0.7 * len(refused) and longest < 5.0


@fuzz(300)
@given(st.sampled_from(DECKS), st.integers(1, 3), st.integers(0, 2**32))
def test_mutated_bytes(deck, count, seed):
    data, rng = deck[0].encode(), random.Random(seed)
    for _ in range(count):
        data = with_bytes(rng, data)
    outcome(data, *deck[1:])


WORDS = sorted(
    {field.name for field in SECTIONS}
    | set(FAKE_KINDS)
    | {field.name for kind in FAKE_KINDS.values() for field in kind.fields}
    | set(TERMS)
    | {"a", "b", "ground", "all", "position", "end", "step", "velocities", "adaptive", "type", "$a", "-$a", "automatic"}
)
WORD = st.sampled_from(WORDS)
SCALAR = st.one_of(st.none(), st.booleans(), st.integers(), st.floats(), WORD, st.text(max_size=8))
VALUE = st.recursive(SCALAR, lambda inner: st.lists(inner, max_size=4) | st.dictionaries(WORD, inner, max_size=4))


def written(value):
    """JSON, with the numbers that it does not know as YAML writes them."""
    text = json.dumps(value, ensure_ascii=True)
    return re.sub(r"-?Infinity|NaN", lambda match: {"I": ".inf", "-": "-.inf", "N": ".nan"}[match[0][0]], text)


def plain(node):
    """The values of a tree of nodes."""
    if isinstance(node.value, dict):
        return {key: plain(value) for key, (_, value) in node.value.items()}
    return [plain(item) for item in node.value] if isinstance(node.value, list) else node.value


def grafted(tree, rng, values):
    """The tree in which a value, at any depth, is another one, or has gained or lost one."""
    if not isinstance(tree, dict | list) or not tree or rng.random() < 0.15:
        return values.pop() if values else None
    keys = list(tree) if isinstance(tree, dict) else list(range(len(tree)))
    copy, key = tree.copy(), rng.choice(keys)
    kind = rng.random()
    if kind < 0.1:
        del copy[key]
    elif kind < 0.2 and isinstance(tree, dict):
        copy[rng.choice(WORDS)] = values.pop() if values else tree[key]
    else:
        copy[key] = grafted(tree[key], rng, values)
    return copy


@fuzz(150)
@given(st.sampled_from(DECKS), st.lists(VALUE, min_size=1, max_size=2), st.integers(0, 2**32))
def test_made_values_in_a_deck(deck, values, seed):
    tree, rng = plain(compose(Source("", deck[0]), [])), random.Random(seed)
    for value in values:
        tree = grafted(tree, rng, [value])
    outcome(written(tree).encode(), *deck[1:])


@fuzz(200)
@given(st.binary(max_size=60) | st.text(alphabet="[]{}:,-?&*!|>'\"%@#\n\t a1", max_size=60).map(str.encode))
def test_noise(data):
    assert not outcome(data)


@fuzz(300)
@given(
    st.lists(WORD | st.sampled_from(["top", "leg", "0", "7", ""]), min_size=1, max_size=5),
    st.sampled_from(NASTY) | VALUE.map(written),
)
def test_overrides(path, value):
    outcome(VALID.encode(), overrides=[".".join(path) + "=" + value])
