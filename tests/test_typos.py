"""A key, name, type or keyword with one or two wrong letters is answered with the correct one."""

import random
import re
import string
from pathlib import Path

import pytest

from mecano.deck.compose import compose
from mecano.deck.read import deck_of
from mecano.deck.similar_names import edits, similar
from mecano.deck.source import Source, read_source
from mecano.errors import DeckError

INPUTS = Path(__file__).parent.parent / "inputs"
WORD = re.compile(r"[A-Za-z_][A-Za-z0-9_]+")
TRIALS, RIGHT = 1000, 0.97


@pytest.mark.parametrize(
    ("a", "b", "distance"),
    [("axis", "axis", 0), ("axsi", "axis", 1), ("axs", "axis", 1), ("axxis", "axis", 1), ("ayis", "axis", 1),
     ("kitten", "sitting", 3), ("ca", "abc", 3), ("", "abc", 3), ("abcd", "badc", 2)],
)  # fmt: skip
def test_edits(a, b, distance):
    """The optimal string alignment distance: "ca" to "abc" takes 3, as no letters are touched twice."""
    assert edits(a, b) == edits(b, a) == distance


def test_all_that_are_equally_near():
    assert similar("p9", [f"p{i}" for i in range(3)]) == ["p0", "p1", "p2"]
    assert similar("kx_end", [f"k{i}_end" for i in range(1, 8)]) == [f"k{i}_end" for i in range(1, 8)]
    assert similar("lenght", ["length", "height", "weight"]) == ["length"]
    assert similar("bm", ["beam", "bar", "bam", "bam"]) == ["bam"]  # a name of two sections
    assert similar("clockwork", ["hinge", "spherical"]) == []


def mistyped(word, rng):
    """The word with one or two letters replaced, left out, added or exchanged."""
    letters = list(word)
    for _ in range(rng.choice((1, 2))):
        i, letter = rng.randrange(len(letters)), rng.choice(string.ascii_lowercase)
        how = rng.randrange(4)
        if how == 0:
            letters[i] = letter
        elif how == 1 and len(letters) > 2:
            del letters[i]
        elif how == 2:
            letters.insert(i, letter)
        else:
            letters[i : i + 2] = reversed(letters[i : i + 2])
    return "".join(letters)


def words_of(node):
    """Nodes of a tree that are keys, names, types or keywords."""
    if type(node.value) is dict:
        for name, (key, inner) in node.value.items():
            if type(key.value) is str and WORD.fullmatch(key.value):
                yield key
            if name != "title":
                yield from words_of(inner)
    elif type(node.value) is list:
        for inner in node.value:
            yield from words_of(inner)
    elif type(node.value) in (str, bool) and WORD.fullmatch(node.raw):
        yield node


def answers(source, node, word, wrong):
    """Return the Problems of the deck with a word replaced; [] if it is still valid."""
    lines = list(source.lines)
    line, column = lines[node.line], node.column
    assert line[column:].startswith(word)
    lines[node.line] = line[:column] + wrong + line[column + len(word) :]
    try:
        deck_of(Source(source.file, "\n".join(lines) + "\n"))
    except DeckError as error:
        return error.problems
    return []


def is_right(problems, word, wrong):
    """A hint names the word; or, of a name that is mistyped where it is given, the mistyped one for the word."""
    for problem in problems:
        offered = re.findall(r"[\w.$()-]+", problem.hint)
        if word in offered or (repr(word) in problem.message and wrong in offered):
            return True
    return False


def test_typos_are_answered_with_a_correction():
    """Single letters are excluded, as any other is equally near; for names with one digit, all nearest are offered."""
    rng, found = random.Random(1), []
    sources = [read_source(path)[0] for path in sorted(INPUTS.glob("*.yaml")) if "reflector" not in path.name]
    trees = [list(words_of(compose(source, []))) for source in sources]
    while len(found) < TRIALS:
        i = rng.randrange(len(sources))
        node = rng.choice(trees[i])
        word = node.raw if type(node.value) is bool else node.value
        wrong = mistyped(word, rng)
        if wrong != word and (problems := answers(sources[i], node, word, wrong)):
            found.append((is_right(problems, word, wrong), sources[i].file, word, wrong, problems[0].hint))
    missed = [trial[1:] for trial in found if not trial[0]]
    assert len(missed) <= (1.0 - RIGHT) * TRIALS, missed
