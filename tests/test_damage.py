"""Damaged files: a clear error or the remaining data, never a signal, a traceback or silently wrong numbers."""

import mmap
import os
import random
import signal

import h5py
import pytest
from scorecard.damage import subjects
from surviving import decks
from time_runs import INPUTS, input_deck

import mecano
from mecano.analyses.dynamic import resume, run
from mecano.cli import main
from mecano.errors import ResultsError
from mecano.post.info import info
from mecano.results import global_heap, layout, trial_reading
from mecano.results.checked import Checked
from mecano.results.opening import format_of

TRIALS = 15


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
    """The format comes first: what another deck is compared with may be written otherwise in it."""
    assert layout.FORMAT_VERSION == 1
    deck, path = decks()["bouncing_ball"], tmp_path / "r.h5"
    run(deck, path)
    with h5py.File(path, "r+") as file:
        file.attrs["format_version"] = version
    before = path.read_bytes()
    for resumed in (deck, input_deck("bouncing_ball", "title=Another")):
        with pytest.raises(ResultsError, match=reported):
            resume(resumed, path)
    assert path.read_bytes() == before


def endless(*_):
    while True:
        pass


@pytest.mark.parametrize(
    "reading, reported",
    [
        (lambda path: os.kill(os.getpid(), signal.SIGKILL), "ends by SIGKILL"),
        (trial_reading._read_quietly, "does not end"),
    ],
)
def test_a_file_without_sums_at_which_hdf5_would_crash_or_hang_is_refused(tmp_path, monkeypatch, reading, reported):
    run(decks()["bouncing_ball"], tmp_path / "r.h5")
    data = (tmp_path / "r.h5").read_bytes()
    (tmp_path / "r.h5").write_bytes(data[:-100])
    assert "complete" in info(tmp_path / "r.h5")  # it lacks the sums only
    monkeypatch.setattr(trial_reading, "_ends", {})
    monkeypatch.setattr(trial_reading, "PATIENCE", 0.1)
    monkeypatch.setattr(trial_reading, "_read_item", endless)
    monkeypatch.setattr(trial_reading, "_read_quietly", reading)
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
    assert format_of(path) == "mecano modes"
    data[heap + 16 : heap + size] = bytes(size - 16)
    path.write_bytes(data)
    source = Checked(path)
    source.seek(heap)
    with pytest.raises(OSError, match=f"the texts from byte {heap} on cannot be read"):
        source.readinto(bytearray(8))
    source.close()
    assert format_of(path) == ""


def _set_attribute(name, value):
    def change(file):
        file["run"].attrs[name] = value

    return change


def _replace(name, value):
    def change(file):
        del file[name]
        file[name] = value

    return change


def _delete_attribute(name):
    return lambda file: file["run"].attrs.__delitem__(name)


RUBBISH = [
    ("run/status", _replace("run/status", b"rubbish"), "'rubbish' is not one of complete, stopped, failed, running"),
    ("run/status", _replace("run/status", b"\xff\xfe"), "'utf-8' codec"),
    ("run/status", _replace("run/status", 3.0), "it is not a text"),
    ("run/reason", _replace("run/reason", [1.0, 2.0]), "it is not a text"),
    ("run/started", _delete_attribute("started"), "started"),
    ("run/host", _set_attribute("host", 5), "it is not a text"),
    ("run/process", _set_attribute("process", "five"), "it is not a whole number"),
    ("run/processor", _set_attribute("processor", [0.0, 1.0]), "it is neither a text nor a number"),
    ("run/plugins", _set_attribute("plugins", "[1, 2"), "delimiter"),
    ("run/clock", _replace("run/clock", [b"x", b"y"]), "could not convert"),
    ("run/acknowledged", _replace("run/acknowledged", [1, 2]), "not enough values"),
    ("storage/output", lambda file: file.__delitem__("storage/output"), "object 'output' doesn't exist"),
    ("events/name", _replace("events/name", 5), "scalar dataset"),
    ("deck/displays", _replace("deck/displays", b'{"point_mass": 1}'), "must be a mapping"),
    ("deck/resolved", _replace("deck/resolved", b"[]"), "it is not a mapping"),
    ("deck/warnings", _replace("deck/warnings", b"{}"), "it is not a list"),
    ("deck/resumptions", _replace("deck/resumptions", b"{}"), "it is not a list"),
]


@pytest.fixture(scope="module")
def left(tmp_path_factory):
    """A deck, and the file of its run as it was left in the middle."""
    folder = tmp_path_factory.mktemp("left")
    with mecano.Simulation(INPUTS / "bouncing_ball.yaml", folder / "r.h5") as simulation:
        simulation.advance(0.05)
    return folder / "r.h5"


@pytest.mark.parametrize(("place", "change", "text"), RUBBISH)
def test_other_contents_are_named_by_file_and_place(place, change, text, left, tmp_path, monkeypatch, capsys):
    """HDF5 that another program has rewritten, without checksums."""
    monkeypatch.chdir(tmp_path)
    ends = {}
    for command in (
        "info r.h5",
        "verify r.h5",
        "post r.h5",
        "export r.h5",
        f"run {INPUTS}/bouncing_ball.yaml -o r.h5 --resume",
    ):
        (tmp_path / "r.h5").write_bytes(left.read_bytes())
        with h5py.File(tmp_path / "r.h5", "r+") as file:
            change(file)
        monkeypatch.setattr("sys.argv", ["mecano", *command.split()])
        try:
            main()
            code = 0
        except SystemExit as end:
            code = end.code
        ends[command.split()[0]] = code, capsys.readouterr().err
    assert all(code in (0, 5) for code, _ in ends.values())
    assert any(f"'{place}' in r.h5 cannot be read" in said and text in said for _, said in ends.values()), ends
    assert all(place in said or "checksums" in said or "cut short" in said for code, said in ends.values() if code), (
        ends
    )


def test_options_that_exclude_one_another_are_no_damage(left, tmp_path, monkeypatch, capsys):
    path = tmp_path / "r.h5"
    path.write_bytes(left.read_bytes()[:-100])  # without checksums
    monkeypatch.setattr("sys.argv", ["mecano", "post", str(path), "--report", str(tmp_path / "r.html"), "--csv"])
    with pytest.raises(SystemExit) as end:
        main()
    assert end.value.code == 2 and "cannot be read" not in capsys.readouterr().err


def test_heaps_are_sought_without_the_byte_behind_the_file(tmp_path, monkeypatch):
    """``mmap.find`` of Python before 3.11.4 reads one byte behind what it searches: behind whole pages, a crash."""
    heap = global_heap.HEADER.pack(global_heap.SIGNATURE, 4096)
    path, searched = tmp_path / "pages", []
    path.write_bytes(bytes(4096) + heap + bytes(4096 - len(heap)))

    class Mapped(mmap.mmap):
        def find(self, sub, start, end):
            searched.append(end)
            return super().find(sub, start, end)

    monkeypatch.setattr(global_heap.mmap, "mmap", Mapped)
    with open(path, "rb") as file:
        assert global_heap.endless_heaps(file.fileno(), 8192) == [4096]
    assert len(searched) == 2 and max(searched) < 8192
