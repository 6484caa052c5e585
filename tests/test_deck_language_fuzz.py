"""Malformed decks with expressions, units, repeats, templates and includes: read, or refused with line and column.

400 decks per run, the same ones each time; marked slow: 10,000 of them, whose time and memory are measured
(docs/decks.md).
"""

import gc
import os
import random
import subprocess
import time
from pathlib import Path

import pytest
from deck_samples import FAKE
from scorecard.mutate import MUTATIONS
from test_deck_copies import CHAIN, LAWS, LEG, MAIN, PARTS
from test_deck_fuzz import outcome

from mecano.deck.sample_decks import starters
from mecano.elements import KINDS

INPUTS = Path(__file__).parent.parent / "inputs"
PAGE = (INPUTS / "reflector_template.yaml").read_text()
REAL = {"kinds": KINDS}
SINGLE = [(CHAIN, FAKE), (LEG, FAKE), (PAGE, REAL), *((text, REAL) for text in starters().values())]
FILES = {"deck.yaml": MAIN, "parts/leg.yaml": PARTS, "laws.yaml": LAWS, "parts/more.yaml": "laws: {more: 1}\n",
         "parts/push.csv": "t [ms], F [kN]\n0,0\n1,5\n"}  # fmt: skip
NASTY = [  # in place of a value
    "$", "$$", "$()", "$(", "$(i", "$(i+)", "$i$", "$(k % 0)", "$(1/0)", "=", "=1/0", "=9**9**9", "='a'",
    "=__import__('os')", "=open('executed', 'w')", "$(open('executed', 'w'))", "=(1).__class__", "$i.real",
    "=lambda: 1", "=[x for x in (1,)]", "$(__import__('os').system('id'))", "={}", "=1 if 1 else 2", "=10**400",
    "=-1**0.5", "=(((((((1)))))))", "=" + "(" * 80, "=" + "-" * 300 + "1", "=sqrt(-1)", "=atan2(1)", "=f'{1}'", "0..",
    "..5", "0..5..7", "5..0", "0..1e9", "0..$n", "0..$i", "-3..3", "0..30", "1..400", "[1, 2, 3]", "[]", "[[1]]",
    "{}", "{i: 0..2, j: 0..3}", "[{i: 1}, {j: 2}]", "[{}]", "{repeat: {i: 0..3}}", "leg", "hip", "top", "ground",
    "left", "null", "3 mm", "3 bar", "-1e308 km", "1e400 m", "5 %", "1 N/m s", "2 furlong", "7 m^9", "4 m/s/s/s",
    "1 °", "3 µm", "1 Gm9", "../deck.yaml", "deck.yaml", "/etc/passwd", "parts/leg.yaml", "[laws.yaml, laws.yaml]",
    "parts", "''", "x\\0y", "~", ".inf",
]  # fmt: skip
LINES = [
    "include: laws.yaml", "include: [deck.yaml]", "place: {a: {template: leg}}",
    "  b$i: {repeat: {i: 0..3}, template: leg}", "    place: {again: {template: leg}}",
    "    place: {c$k: {repeat: {k: 1..40}, template: batten}}", "templates: {t: {}}",
    "    parameters: {length: $length}", "  x$i: {repeat: {i: 1..9}, position: [$i, $i, $i]}", "parameters: {n: $n}",
    "  length: $half", "    nodes: {$a: {position: [0, 0, 0]}}", "repeat: {i: 1..3}",
]  # fmt: skip


def spoiled(rng, text):
    """A text with one to four things wrong, or merely unusual."""
    for _ in range(rng.randint(1, 4)):
        kind = rng.random()
        if kind < 0.4:
            begin = rng.choice([i for i, c in enumerate(text) if c in " :[,("] or [0]) + 1
            end = min([i for i in (text.find(c, begin) for c in ",]}\n)") if i >= 0] or [len(text)])
            text = text[:begin] + " " * (begin > 0) + rng.choice(NASTY) + text[end:]
        elif kind < 0.55:
            lines = text.split("\n")
            lines.insert(rng.randrange(len(lines) + 1), rng.choice(LINES))
            text = "\n".join(lines)
        else:
            text = rng.choice(MUTATIONS)(rng, text)
    return text


def study(count, folder, seed):
    """(refused, longest CPU time [s]) of as many decks; every third one is in several files."""
    rng, refused, longest = random.Random(seed), 0, 0.0
    (folder / "parts").mkdir()
    for text, options in SINGLE:  # what they compile is not counted
        assert outcome(text.encode(), "deck.yaml", options)
    for i in range(count):
        if i % 3 == 0:
            files = dict(FILES)
            for name in rng.sample(list(files), rng.randint(1, 2)):
                files[name] = spoiled(rng, files[name])
            for name, text in files.items():
                (folder / name).write_bytes(text.encode("utf-8", "replace"))
            data, options = files["deck.yaml"], FAKE
        else:
            data, options = rng.choice(SINGLE)
            data = spoiled(rng, data)
        start = time.process_time()
        refused += not outcome(data.encode("utf-8", "replace"), str(folder / "deck.yaml"), options)
        longest = max(longest, time.process_time() - start)
    return refused, longest


@pytest.fixture
def nothing_runs(monkeypatch, tmp_path):
    """Whoever starts a program or writes a file is caught."""

    def caught(*_, **__):
        raise AssertionError("a deck had something executed")

    for owner, name in ((os, "system"), (os, "popen"), (subprocess, "Popen")):
        monkeypatch.setattr(owner, name, caught)
    monkeypatch.chdir(tmp_path)
    yield
    assert not any(path.name == "executed" for path in tmp_path.rglob("*"))


def test_spoiled_decks(tmp_path, nothing_runs):
    refused, longest = study(400, tmp_path, 1)
    assert 250 < refused < 400 and longest < 5.0


@pytest.mark.slow
def test_ten_thousand_spoiled_decks(tmp_path, nothing_runs):
    before = resident()
    refused, longest = study(10_000, tmp_path, 2)
    grown = resident() - before
    print(f"{refused} of 10000 refused, longest {longest:.2f} s, {grown:.0f} MB more")
    assert 6_000 < refused < 10_000 and longest < 5.0 and grown < 100


def resident():
    """Return the memory of this process [MB]."""
    gc.collect()
    return int(Path("/proc/self/statm").read_text().split()[1]) * os.sysconf("SC_PAGE_SIZE") / 1e6
