"""Malformed decks with expressions, units, repeats, templates and includes: read, or refused with line and column.

400 decks per run, the same ones each time; marked slow: 10,000 of them, whose time and memory are measured.
"""

import gc
import os
import random
import subprocess
import time
from pathlib import Path

import pytest
from deck_samples import FAKE
from scorecard.mutate import mutate
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
                files[name] = mutate(files[name], rng)
            for name, text in files.items():
                (folder / name).write_bytes(text.encode("utf-8", "replace"))
            data, options = files["deck.yaml"], FAKE
        else:
            data, options = rng.choice(SINGLE)
            data = mutate(data, rng)
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
