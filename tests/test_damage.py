"""Damaged files: a clear error or the remaining data, never a signal, a traceback or silently wrong numbers."""

import os
import random
import signal

import h5py
import pytest
from scorecard.damage import subjects
from surviving import decks

from mecano.analyses.dynamic import resume, run
from mecano.errors import ResultsError
from mecano.post.info import info
from mecano.results import checked, layout

TRIALS = 120


@pytest.fixture(scope="module")
def tried(tmp_path_factory):
    return subjects(tmp_path_factory.mktemp("damage"))


def test_commands_meet_damaged_files(tried):
    """A sample of `tests/scorecard/damage.py`, of which 2000 trials are run by hand."""
    rng = random.Random(20)
    wrong = [about for verdict, about in (tried.trial(rng) for _ in range(TRIALS)) if verdict]
    assert not wrong, "\n".join(wrong)


@pytest.mark.parametrize("version, reported", [(0, "format 0 of another version"), (2, "format 2 of a newer mecano")])
def test_a_run_of_another_format_is_not_resumed(tmp_path, version, reported):
    assert layout.FORMAT_VERSION == 1
    deck, path = decks()["bouncing_ball"], tmp_path / "r.h5"
    run(deck, path)
    with h5py.File(path, "r+") as file:
        file.attrs["format_version"] = version
    before = path.read_bytes()
    with pytest.raises(ResultsError, match=reported):
        resume(deck, path)
    assert path.read_bytes() == before


def endless(*_):
    while True:
        pass


@pytest.mark.parametrize(
    "reading, reported",
    [(lambda path: os.kill(os.getpid(), signal.SIGKILL), "ends by SIGKILL"), (checked._read_quietly, "does not end")],
)
def test_a_file_without_sums_at_which_hdf5_would_crash_or_hang_is_refused(tmp_path, monkeypatch, reading, reported):
    run(decks()["bouncing_ball"], tmp_path / "r.h5")
    data = (tmp_path / "r.h5").read_bytes()
    (tmp_path / "r.h5").write_bytes(data[:-100])
    assert "complete" in info(tmp_path / "r.h5")  # it lacks the sums only
    monkeypatch.setattr(checked, "_ends", {})
    monkeypatch.setattr(checked, "PATIENCE", 0.1)
    monkeypatch.setattr(checked, "_read_item", endless)
    monkeypatch.setattr(checked, "_read_quietly", reading)
    with pytest.raises(ResultsError, match=f"sums at its end.* are missing, and reading it {reported}"):
        info(tmp_path / "r.h5")


def test_texts_that_the_library_would_read_for_ever_are_refused(tmp_path):
    """Zeros in the heap of the texts: free space without size, in a file without checksums."""
    path = tmp_path / "heap.h5"
    with h5py.File(path, "w") as file:
        file.attrs["format"] = "mecano modes"
        file["numbers"] = [1.0] * 1000  # pages of zeros at the end would count as missing
    data = bytearray(path.read_bytes())
    heap = data.index(b"GCOL")
    size = int.from_bytes(data[heap + 8 : heap + 16], "little")
    assert checked.format_of(path) == "mecano modes"
    data[heap + 16 : heap + size] = bytes(size - 16)
    path.write_bytes(data)
    source = checked.Checked(path)
    source.seek(heap)
    with pytest.raises(OSError, match=f"the texts from byte {heap} on cannot be read"):
        source.readinto(bytearray(8))
    source.close()
    assert checked.format_of(path) == ""
