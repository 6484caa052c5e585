"""Names and folders that cannot be read or written: exit code 5 with file and reason, no loss of data."""

import os
import resource
import shutil
import signal
import subprocess
import sys
import time

import pytest
from scorecard.damage import in_a_fork
from time_runs import INPUTS

import mecano
import mecano.commands.studies  # what the commands import, once, and not by each fork
from mecano.analyses import modal  # noqa: F401
from mecano.post import export, pictures, report_page  # noqa: F401
from mecano.results.verify import verify
from mecano.solve.modal import modes_dense  # noqa: F401

LONG = "n" * 303
LONGEST = "k" * 251 + ".h5"  # what a file system takes
STUDY = "study: 1\ndeck: deck.yaml\ngrid: {time.step: [0.01, 0.02]}\noutputs:\n  z: {of: ball.position.z, take: max}\n"


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    folder = tmp_path_factory.mktemp("made")
    text = (INPUTS / "bouncing_ball.yaml").read_text()
    (folder / "deck.yaml").write_text(text.replace("end: 5", "end: 1"))
    (folder / "study.yaml").write_text(STUDY)
    code, said = in_a_fork(["run", folder / "deck.yaml", "-o", folder / "r.h5", "-q"], folder)
    assert code == 0, said
    return folder


@pytest.fixture
def folder(made, tmp_path, monkeypatch):
    for name in ("deck.yaml", "study.yaml", "r.h5"):
        shutil.copy(made / name, tmp_path)
    for name in ("f", "f.h5", "f.csv", "f.png", "f.html", "f.vtkhdf"):
        (tmp_path / name).mkdir()
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(report_page, "_image", lambda figure: "")  # also in forks: no page of a report is seen
    return tmp_path


COMMANDS = {
    "run": ["run", "deck.yaml", "-o", "{}.h5", "-q"],
    "force": ["run", "deck.yaml", "-o", "{}.h5", "-q", "--force"],
    "resume": ["run", "deck.yaml", "-o", "{}.h5", "-q", "--resume"],
    "modes": ["modes", "deck.yaml", "-o", "{}.h5", "-q", "--force"],
    "sweep": ["sweep", "study.yaml", "-o", "{}.csv", "-q"],
    "info": ["info", "{}.h5"],
    "verify": ["verify", "{}.h5"],
    "post": ["post", "{}.h5"],
    "export": ["export", "{}.h5"],
    "picture": ["post", "r.h5", "--plot", "ball.position.z", "-o", "{}.png"],
    "page": ["post", "r.h5", "--animate", "{}.html"],
    "report": ["post", "r.h5", "--report", "{}.html"],
    "columns": ["export", "r.h5", "-o", "{}.csv", "--force"],
    "cells": ["export", "r.h5", "--vtk", "-o", "{}.vtkhdf", "--force"],
}
TAKES_FOLDERS = ("sweep", "picture")


@pytest.mark.parametrize("command", COMMANDS)
@pytest.mark.parametrize("place, reason", [(LONG, "File name too long"), ("f", "folder"), ("/proc/f", "")])
def test_each_command_says_which_file_and_why(folder, command, place, reason):
    if place == "f" and command in TAKES_FOLDERS:
        pytest.skip("takes a folder")
    words = [word.format(place) for word in COMMANDS[command]]
    before = sorted(os.listdir(folder))
    code, said = in_a_fork(words, folder)
    assert code == 5 and place in said and reason in said and said.count("\n") == 1, said
    assert sorted(os.listdir(folder)) == sorted({*before, "said.txt"})


def test_a_name_as_long_as_a_file_system_takes(folder):
    """Those of hidden files beside it are not longer."""
    for words in (["run", "deck.yaml", "-o", LONGEST, "-q"], ["export", LONGEST, "--vtk"], ["verify", LONGEST]):
        assert in_a_fork(words, folder)[0] == 0
    assert not [name for name in os.listdir(folder) if name.startswith(".")]


@pytest.mark.parametrize("command", ["run", "force", "modes", "sweep", "picture", "page", "report", "columns", "cells"])
def test_a_disk_without_room(folder, command):
    """No file may exceed 600 bytes: existing files are kept, and no incomplete file is left."""
    place = "r" if command == "force" else "new"
    words = [word.format(place) for word in COMMANDS[command]]
    before = {name: (folder / name).read_bytes() for name in os.listdir(folder) if (folder / name).is_file()}

    def small():
        sys.dont_write_bytecode = True  # Python would leave incomplete files
        resource.setrlimit(resource.RLIMIT_FSIZE, (600, 600))

    code, said = in_a_fork(words, folder, first=small)
    assert code == 5 and "File too large" in said and place in said, said
    left = {name: (folder / name).read_bytes() for name in os.listdir(folder) if (folder / name).is_file()}
    left.pop("said.txt")
    assert left == before


def test_a_folder_that_vanishes_while_a_run_writes_there(folder):
    """The open file can still be written, but is deleted: the run must not end as if there were results.

    It says so in other words if the file has been created but is not open yet.
    """
    (folder / "gone").mkdir()
    words = [sys.executable, "-m", "mecano", "run", "deck.yaml", "-o", "gone/r.h5", "-q", "--set", "time.step=1e-5"]
    process = subprocess.Popen(words, stderr=subprocess.PIPE, text=True)
    while not (folder / "gone" / "r.h5").exists():
        assert process.poll() is None
        time.sleep(0.005)
    shutil.rmtree(folder / "gone")
    process.send_signal(signal.SIGTERM)
    _, said = process.communicate()
    removed = "gone/r.h5: it was removed while it was written", "cannot write gone/r.h5: No such file"
    assert process.returncode == 5 and any(text in said for text in removed)
    assert "Traceback" not in said


def test_a_full_disk_under_a_run_loses_nothing_acknowledged(folder):
    """And what is in its file has its sums all the same."""
    words = ["run", "deck.yaml", "-o", "full.h5", "-q", "--set", "time.step=1e-4", "--set", "output.every=step"]
    limit = 900_000

    def small():
        sys.dont_write_bytecode = True
        resource.setrlimit(resource.RLIMIT_FSIZE, (limit, limit))

    code, said = in_a_fork(words, folder, first=small)
    assert code == 5 and "cannot write full.h5: File too large" in said
    saved = int(said.partition("; ")[2].split()[0])
    with mecano.open_results("full.h5") as results:
        assert results.status == "failed" and len(results.time) == saved > 100
    assert "all bytes are unchanged" in verify("full.h5")
