"""The judges of the reliability scorecard can fail: each is given outcomes that are not as they should be.

And a small scorecard is made in processes that crash, hang and raise.
"""

import os
import resource
import signal
import subprocess
import sys
import time
from types import SimpleNamespace

import numpy as np
import pytest
from scorecard import (
    damaged,
    disk,
    extreme_numbers,
    hard,
    hostile,
    killed,
    malformed,
    physics,
    run,
    semantic,
    signals,
    singular,
    size,
)
from scorecard.outcome import Outcome, unfit, unplaced
from scorecard.trial import Job, Line, Trial, spread

from mecano.errors import NonFiniteError

PLACED = "deck.yaml:3:7: unknown key 'mas'; did you mean 'mass'?\n1 error\n"
TRACE = "Traceback (most recent call last):\n  File x\nKeyError: 'x'\n"


@pytest.mark.parametrize(
    ("outcome", "said"),
    [
        (Outcome(-11), "SIGSEGV"),
        (Outcome(1, err=TRACE), "KeyError: 'x'"),
        (Outcome(0, err=TRACE), "traceback"),
        (Outcome(1, err="mecano: oh"), "exit code 1"),
        (Outcome(42), "exit code 42"),
        (Outcome(2, err="x.py:3: RuntimeWarning: overflow encountered\n" + PLACED), "RuntimeWarning"),
        (Outcome(2, err=PLACED, cpu=5.1), "5.1 s"),
    ],
)
def test_unfit_outcomes_are_recognized(outcome, said):
    assert said in unfit(outcome)


def test_fit_outcomes_are_accepted():
    assert unfit(Outcome(2, err=PLACED, cpu=4.9)) == "" and unfit(Outcome(0, out="all is well")) == ""


def test_refusals_have_places():
    assert unplaced(Outcome(2, err=PLACED)) == ""
    assert "no file:line:column" in unplaced(Outcome(2, err="something is wrong\n"))
    assert "exit code 4" in unplaced(Outcome(4, err=PLACED))
    assert "standard output" in unplaced(Outcome(2, "hello", PLACED))


def test_malformed_decks():
    assert malformed.judged(Outcome(2, err=PLACED)) == "" and malformed.judged(Outcome(0, out="nodes 3")) == ""
    assert "besides" in malformed.judged(Outcome(0, err="by the way"))
    assert "no message" in malformed.judged(Outcome(4))
    assert "KeyError" in malformed.judged(Outcome(1, err=TRACE))


def test_hostile_decks(tmp_path):
    refused = Outcome(2, err=PLACED, memory=100.0)
    assert hostile.judged(refused, tmp_path) == ""
    assert "deck was read" in hostile.judged(Outcome(0), tmp_path) and hostile.judged(Outcome(0), tmp_path, True) == ""
    assert "301 MB" in hostile.judged(Outcome(2, err=PLACED, memory=301.0), tmp_path)
    assert "minute" in hostile.judged(Outcome(-9), tmp_path)
    (tmp_path / "a").mkdir()
    (tmp_path / "a" / "executed").touch()
    assert "executed" in hostile.judged(refused, tmp_path)


def test_semantic_mistakes():
    assert semantic.judged(Outcome(2, err=PLACED), 3, "'mass'") == ""
    assert "instead of 4" in semantic.judged(Outcome(2, err=PLACED), 4, "'mass'")
    assert "no word" in semantic.judged(Outcome(2, err=PLACED), 3, "positive")
    assert "exit code 0" in semantic.judged(Outcome(0), 3, "positive")
    assert semantic.suggested(Outcome(2, err=PLACED), 3, "mass", "mas") == ""
    assert "no word" in semantic.suggested(Outcome(2, err=PLACED), 3, "mast", "mas")


def file_of(rows=5, **changes):
    """What ``held`` says of a small file."""
    time = np.arange(float(rows))
    return {"x": 2.0 * time, "time": time, "steps": time, "events": ["a", "b"], "status": "complete"} | changes


def test_kills():
    whole = file_of()
    assert killed.lost_rows(file_of(3), (3, 3, 2), whole) == "" and killed.differs(file_of(), whole) == ""
    assert "acknowledged, 3 there" in killed.lost_rows(file_of(3), (4, 3, 2), whole)
    assert "events acknowledged" in killed.lost_rows(file_of(3), (3, 3, 3), whole)
    assert "other events" in killed.lost_rows(file_of(3, events=["b"]), (3, 3, 1), whole)
    other = np.arange(3.0)
    other[1] = np.nextafter(other[1], 2.0)
    assert "x: other bits" in killed.lost_rows(file_of(3, x=other), (3, 3, 2), whole)
    assert "cannot be read" in killed.lost_rows("no HDF5 file", (0, 0, 0), whole)
    assert "status" in killed.differs(file_of(status="failed"), whole) and "x: other" in killed.differs(
        file_of(4), whole
    )
    assert "cannot be read" in killed.differs("no HDF5 file", whole)
    assert "exit code 3" in killed.unlike(Outcome(3)) and killed.unlike(Outcome(-9)) == ""


def test_disks(tmp_path):
    assert disk.refused(Outcome(5, err="mecano: r.h5 already exists"), "r.h5") == ""
    assert "not named" in disk.refused(Outcome(5, err="mecano: no"), "r.h5")
    assert "exit code 0" in disk.refused(Outcome(0), "r.h5") and "SIGBUS" in disk.refused(Outcome(-7), "r.h5")


def test_extreme_numbers(tmp_path):
    judged = extreme_numbers.judged
    assert judged(Outcome(2, err=PLACED), tmp_path) == ""
    assert "no file" in judged(Outcome(0), tmp_path)
    assert "nothing is named" in judged(Outcome(6, err="mecano: not finite"), tmp_path)
    assert extreme_numbers.not_finite(file_of()) == ""
    assert "x is not finite" in extreme_numbers.not_finite(file_of(x=np.array([1.0, np.nan])))
    chosen = ("rigid_body 'bar'", "mass")
    assert extreme_numbers.reported_in(None, chosen, file_of()) == ""
    assert "exit code 3" in extreme_numbers.reported_in(SimpleNamespace(exit_code=3), chosen, file_of())
    assert "no time" in extreme_numbers.reported_in(NonFiniteError("rigid_body 'bar'"), chosen, file_of())
    assert "rigid_body is not named" in extreme_numbers.reported_in(
        NonFiniteError("t = 0.1 s: beam 'b'"), chosen, file_of()
    )
    assert extreme_numbers.reported_in(NonFiniteError("t = 0.1 s: rigid_body 'bar'"), chosen, file_of()) == ""


REDUNDANT = "mobility         1\nredundant        3 constraint(s)\n  3 too many:\n    hinge 'a': x\n    hinge 'b': y\n"


def test_singular_models():
    ran = Outcome(0, err="mecano: 3 redundant constraint(s) among: hinge 'a'; hinge 'b'")
    assert singular.is_redundant(Outcome(0, REDUNDANT), ran, ["a", "b"], 3) == ""
    assert "instead of 2" in singular.is_redundant(Outcome(0, REDUNDANT), ran, ["a", "b"], 2)
    assert "not named" in singular.is_redundant(Outcome(0, REDUNDANT), ran, ["a", "c"], 3)
    guilty = REDUNDANT + "    hinge 'innocent_pin': z\n"
    assert "bystanders" in singular.is_redundant(Outcome(0, guilty), ran, ["a", "b"], 3)
    assert "does not say" in singular.is_redundant(Outcome(0, REDUNDANT), Outcome(0), ["a", "b"], 3)
    assert singular.is_refused(None, Outcome(4, err="mecano: hinge 'a' and motor 'b'"), ["a", "b"]) == ""
    assert "1 of 2" in singular.is_refused(None, Outcome(4, err="mecano: hinge 'a'"), ["a", "b"])
    assert "exit code 0" in singular.is_refused(None, Outcome(0), ["a"])
    assert "IndexError" in singular.is_locked(Outcome(1, err="IndexError: 0"), Outcome(1), [])
    assert "mobility" in singular.is_movable(Outcome(0, "mobility         9\n"), None, ["a"], 6)
    good = Outcome(0, "mobility         5\nredundant        0 constraint(s)")
    assert singular.is_good(good, Outcome(0), 1) == ""
    assert "mobility" in singular.is_good(good, Outcome(0), 2)
    assert "false alarm" in singular.is_good(Outcome(0, REDUNDANT), Outcome(0), 1)
    assert "false alarm" in singular.is_good(good, Outcome(0, err="mecano: 1 redundant constraint"), 1)


def test_names_are_whole_words():
    assert singular.names_in("node door.left: force x", ["door", "left", "door.left"]) == {"door.left"}
    assert singular.names_in("hinge 'pin-1': moment", ["pin", "pin-1"]) == {"pin-1"}


def test_hard_decks():
    said = "mecano: no step could be taken at t = 0.25 s; on it act hinge 'a'\nwhat to try: less"
    assert hard.unexplained(said, 0.25) == ""
    assert "no element" in hard.unexplained(said.replace("hinge 'a'", "it"), 0.25)
    assert "the last in the file 0.2 s" in hard.unexplained(said, 0.2)
    assert "no advice" in hard.unexplained(said.partition("\n")[0], 0.25)
    energies = dict.fromkeys(hard.EXCHANGED, (10.0, 0.0))
    assert hard.unbalanced(energies | {"balance": (1.05, 1.0)}) == ""
    assert "2 %" in hard.unbalanced(energies | {"balance": (1.2, 1.0)})
    assert hard.unbalanced(energies | {"balance": (np.nan, 1.0)})


def test_rejected_steps_that_leave_something_are_seen(tmp_path, monkeypatch):
    """A time integration whose state moves with each trial comes to another end."""
    (tmp_path / "deck.yaml").write_text(
        "mecano: 1\ngravity: [0, 0, -9.81]\nnodes: {a: {position: [0, 0, 1]}}\n"
        "elements: {m: {type: point_mass, node: a, mass: 1}}\ntime: {end: 0.1, step: 1e-2}\n"
    )
    assert hard.rejected(tmp_path) == ""
    from mecano.solve.time.trials import Trials

    step = Trials._step

    def forgetful(trials, run, h):
        run.motion.z[0] += 1e-3 * (h < 5e-3)  # of the trial that is thrown away
        return step(trials, run, h)

    monkeypatch.setattr(Trials, "_step", forgetful)
    assert "rejected steps move the end" in hard.rejected(tmp_path)


def test_sizes(tmp_path, monkeypatch):
    def command(*_, **__):
        return Outcome(0, "memory 100 MB", memory=150.0)

    monkeypatch.setattr(size, "in_command", command)
    assert "100 MB predicted" in size.prediction(2, tmp_path)
    monkeypatch.setattr(size, "in_command", lambda *_, **__: Outcome(0, memory=2001.0))
    assert "2001 MB" in size.large_check(2, tmp_path) and "predicts no memory" in size.prediction(2, tmp_path)
    monkeypatch.setattr(size, "in_command", lambda *_, **__: Outcome(-11))
    assert "SIGSEGV" in size.too_little(0.5, 2, tmp_path)
    monkeypatch.setattr(size, "in_command", lambda *_, **__: Outcome(7, err="out of memory"))
    assert size.too_little(0.5, 2, tmp_path) == ""


def test_damage(tmp_path, monkeypatch):
    """A file whose damage `verify` does not see, and a resume that takes it."""
    monkeypatch.setattr(damaged, "in_process", lambda words, folder: Outcome(0))
    monkeypatch.setattr(damaged, "held", lambda path: file_of(x=np.zeros(5)))
    monkeypatch.setattr(damaged, "reference", lambda name: (file_of(), 1.0))
    (tmp_path / "r.h5").touch()
    assert "resumed from damaged data" in damaged.resumed("friction_pendulum", tmp_path / "r.h5", False)
    assert "was said" in damaged.resumed("friction_pendulum", tmp_path / "r.h5", True)
    monkeypatch.setattr(damaged, "in_process", lambda words, folder: Outcome(1, err=TRACE))
    assert "KeyError" in damaged.resumed("friction_pendulum", tmp_path / "r.h5", False)


def test_reports_of_pytest():
    text = (
        '<testsuite><testcase classname="a" name="x"/>'
        '<testcase classname="a" name="y"><failure message="off by 2"/></testcase>'
        '<testcase classname="a" name="z"><skipped/></testcase></testsuite>'
    )
    assert [(trial.held, trial.why) for trial in physics.outcomes(text)] == [(True, ""), (False, "off by 2")]


def test_signals():
    judged, stopped = signals.judged, file_of(status="stopped")
    assert judged(Outcome(130, cpu=0.1, seconds=0.2), "SIGINT", stopped) == ""
    assert judged(Outcome(-15, cpu=0.1, seconds=0.2), "SIGTERM", None) == ""
    assert "exit code -15" in judged(Outcome(-15), "SIGTERM", stopped)
    assert "exit code 143" in judged(Outcome(143), "SIGINT", stopped)
    assert "after 3.0 s" in judged(Outcome(130, cpu=2.5, seconds=3.0), "SIGINT", stopped)
    assert "traceback" in judged(Outcome(130, err=TRACE), "SIGINT", stopped)
    assert "file says failed" in judged(Outcome(130), "SIGINT", file_of(status="failed"))
    assert "cannot be read" in judged(Outcome(130), "SIGINT", "no HDF5 file")


def test_orphans_are_found(tmp_path):
    process = signals.begun(["--help"], tmp_path)
    os.kill(process.pid, signal.SIGSTOP)
    os.waitpid(process.pid, os.WUNTRACED)  # a process that is still in execve has no command line
    try:
        assert signals.orphans(tmp_path) == [process.pid]
    finally:
        process.kill()
        process.wait()
    assert signals.orphans(tmp_path) == []


def crash(folder):
    os.kill(os.getpid(), signal.SIGKILL)


def spin(folder):
    while True:
        pass


def sleep(folder):
    time.sleep(60.0)


def stumble(folder):
    (folder / "deck.yaml").write_text("mecano: 1\n")
    raise KeyError("x")


def test_trials_that_crash_hang_or_raise_are_counted(tmp_path):
    jobs = [
        Job(1, "good", lambda folder: ""),
        Job(1, "crash", crash),
        Job(1, "spin", spin, cpu=0.2),
        Job(1, "sleep", sleep, wall=0.5),
        Job(1, "stumble", stumble),
        Job(1, "both", lambda folder: [Trial(1, "one"), Trial(2, "two", "no")]),
    ]
    found = {trial.name: trial.why for trials in spread(jobs, tmp_path) for trial in trials}
    assert found["good"] == found["one"] == "" and found["two"] == "no"
    assert "SIGKILL" in found["crash"] and "processor time" in found["spin"] and "0.5 s" in found["sleep"]
    assert "KeyError" in found["stumble"]
    assert (tmp_path / "line_1" / "stumble" / "deck.yaml").exists()


def test_points():
    line, tally = Line(4, "kills", 10, 4), run.Tally()
    assert tally.share == 0.0  # where nothing was tried nothing was held
    for why in ("", "", "", "lost"):
        tally.take(Trial(4, "x", why))
    text = run.table({4: run.row(line, tally, "7, abc, 2026-01-31")})
    assert tally.share == 0.75 and "| 4 | kills | 4 | 3 | 7.50 of 10 | 7, abc, 2026-01-31 |" in text


def test_rows_are_written_beside_those_of_other_lines(tmp_path, monkeypatch):
    page = tmp_path / "reliability.md"
    page.write_text(f"before\n\n{run.BEGIN}\n{run.END}\n\nafter\n")
    monkeypatch.setattr(run, "PAGE", page)
    for number, held in ((4, 1), (12, 2), (4, 3)):
        run.write({number: [str(number), "kills", "1,000", str(held), f"{held}.00 of 10", f"{number}, abc, today"]})
    lines = page.read_text().splitlines()
    assert lines[:2] + lines[-2:] == ["before", "", "", "after"] and len(lines) == 11
    assert lines[5:8] == [
        "| 4 | kills | 1,000 | 3 | 3.00 of 10 | 4, abc, today |",
        "| 12 | kills | 1,000 | 2 | 2.00 of 10 | 12, abc, today |",
        "|  | all | 2,000 | 5 | 5.00 of 20 |  |",
    ]


@pytest.mark.slow
def test_quick_trials_are_held(tmp_path):
    """Decks, numbers and models of the scorecard; the other lines take longer, and have tests of their own."""
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    lines = [word for number in (1, 3, 5, 7, 8) for word in ("--line", str(number))]
    command = [sys.executable, run.__file__, "--quick", "--seed", "5", "--keep", str(tmp_path), *lines]
    ended = subprocess.run(command, capture_output=True, text=True)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    assert ended.returncode == 0, ended.stdout + ended.stderr
    assert after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime < 60.0
