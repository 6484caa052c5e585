"""Runs that end early and are resumed to the same bits; runs that cannot be resumed; changed bytes."""

import ctypes
import json
import math
import os
import random
import resource
import shutil
import signal
import struct
import subprocess
import sys
import threading
import time
from dataclasses import replace

import h5py
import pytest
from process import COMMAND, flowing, mecano_process
from surviving import (
    FOUR_FEET,
    SWING,
    StopAfter,
    check_same,
    contents,
    decks,
    ended,
    forked,
    listening_resume,
    long_deck,
)
from time_runs import INPUTS, deck, input_deck

import mecano
from mecano.analyses import checkpoint_writer, dynamic, static
from mecano.analyses.dynamic import resume, run
from mecano.errors import AssemblyError, ConvergenceError, ResultsError, UsageError
from mecano.post.info import info
from mecano.process.interrupt import EXIT_CODES, Interruption, Stopped, call_interruptibly, seconds, stopped_by
from mecano.results.disk import Disk
from mecano.results.verify import verify


@pytest.fixture(scope="module", params=decks())
def whole(request, tmp_path_factory):
    """(deck, what the file of its run without a stop holds)."""
    deck, path = decks()[request.param], tmp_path_factory.mktemp("whole") / "whole.h5"
    run(deck, path)
    return deck, contents(path)


def stopped(deck, path, *after):
    """Resume a run and stop it after so many steps, or questions: the Stopped, or None if it came to its end."""
    end = StopAfter(*after)
    try:
        resume(deck, path, interruption=end, observers=(end,))
    except Stopped as error:
        return error
    return None


class TestTheSameBits:
    def test_stopped_again_and_again(self, whole, tmp_path):
        deck, expected = whole
        path, stops = tmp_path / "r.h5", 0
        while error := stopped(deck, path, len(expected["steps"]) // 6 + 1):
            stops += 1
            found = contents(path)
            count = len(found["time"])
            assert error.exit_code == 143 and found["status"] == "stopped" and "--resume" in found["reason"]
            assert found["time"].tobytes() == expected["time"][
                :count
            ].tobytes() and "all bytes are unchanged" in verify(path)
        assert stops >= 5 and found["events"] == expected["events"][: len(found["events"])]
        check_same(contents(path), expected)
        results = mecano.open_results(path)
        assert len(results.resumptions) == stops and not any("resumed" in text for text in results.warnings)

    def test_stopped_within_steps(self, whole, tmp_path):
        """Between two trials or two factorizations: the step is left, and tried again from its beginning."""
        deck, expected = whole
        path, stops = tmp_path / "r.h5", 0
        while stopped(deck, path, math.inf, len(expected["steps"]) // 3 + stops):
            stops += 1
        assert stops >= 3
        check_same(contents(path), expected)

    def test_killed_at_random(self, whole, tmp_path):
        """kill -9 while checkpoints are written every 5 ms."""
        deck, expected = whole
        path, kills, rng = tmp_path / "r.h5", 0, random.Random(3)
        begin = time.monotonic()
        assert ended(forked(listening_resume, deck, tmp_path / "one.h5", 0.005)) == 0
        took = time.monotonic() - begin
        for _ in range(3):
            child = forked(listening_resume, deck, path, 0.005)
            time.sleep(rng.uniform(0.1, 0.6) * took)
            os.kill(child, signal.SIGKILL)
            kills += ended(child) == -signal.SIGKILL
            if path.exists():
                verify(path)
        assert ended(forked(listening_resume, deck, path, 0.005)) == 0 and kills
        check_same(contents(path), expected)

    def test_files_of_killed_runs_are_removed(self, tmp_path):
        (tmp_path / ".r.h5.4194305.part").touch()  # Linux gives no process this number
        (tmp_path / f".r.h5.{os.getppid()}.part").touch()
        run(deck(FOUR_FEET), tmp_path / "r.h5")
        assert sorted(os.listdir(tmp_path)) == [f".r.h5.{os.getppid()}.part", "r.h5"]

    def test_redundant_contacts_are_reported_of_once(self, tmp_path):
        """What the time integration has found out is kept: here that four feet are one too many."""
        run(deck(FOUR_FEET), tmp_path / "whole.h5")
        while stopped(deck(FOUR_FEET), tmp_path / "r.h5", 70):
            pass
        reason = contents(tmp_path / "r.h5")["reason"]
        assert reason.count("redundant") == 1 and reason == contents(tmp_path / "whole.h5")["reason"]

    def test_a_start_that_was_found_is_not_looked_for_again(self, tmp_path):
        deck = input_deck("axle_on_slope", "time.end=0.1")
        run(deck, tmp_path / "whole.h5")
        while stopped(deck, tmp_path / "r.h5", 5):
            pass
        check_same(contents(tmp_path / "r.h5"), contents(tmp_path / "whole.h5"))


def test_a_resumed_run_that_fails_reports_the_latches_of_its_checkpoint(tmp_path, monkeypatch):
    """A resumed run that fails in its first step tells of the angle at the checkpoint, (pi/2) (1 - cos(sqrt(6) t))."""
    deck, path = input_deck("panel_lock"), tmp_path / "r.h5"
    assert stopped(deck, path, 300)

    def fail(*_):
        raise ConvergenceError("no way on")

    monkeypatch.setattr("mecano.solve.time.time_integration.TimeIntegrator.to", fail)
    with pytest.raises(ConvergenceError, match="latches never closed") as failed:
        resume(deck, path)
    at = float(str(failed.value).partition("hinge 'hinge' at ")[2].partition(" of")[0])
    assert at == pytest.approx(0.5 * math.pi * (1.0 - math.cos(math.sqrt(6.0) * 0.3)), rel=1e-3)  # from a text


def test_a_resumed_run_that_cannot_begin_leaves_its_file_closed(tmp_path, monkeypatch):
    deck, path = long_deck(), tmp_path / "r.h5"
    assert stopped(deck, path, 300)

    def fail(*_):
        raise AssemblyError("no way to begin")

    monkeypatch.setattr("mecano.analyses.dynamic.prepare", fail)
    with pytest.raises(AssemblyError):
        resume(deck, path)
    h5py.File(path, "r+").close()  # which HDF5 refuses while this process reads it


class TestAFullDisk:
    @pytest.mark.parametrize(("size", "some"), [(50_000, False), (500_000, False), (2_000_000, True)])
    def test_a_run_stopped_by_a_full_disk_is_resumed(self, tmp_path, size, some):
        """The system refuses to let the file grow, wherever it is then, before or after the first checkpoints."""
        deck, path = long_deck(), tmp_path / "r.h5"

        def run_in(size):
            sys.dont_write_bytecode = True  # Python would leave incomplete files
            resource.setrlimit(resource.RLIMIT_FSIZE, (size, size))
            listening_resume(deck, path, 0.002)

        run(deck, tmp_path / "whole.h5")
        assert (tmp_path / "whole.h5").stat().st_size > size
        assert ended(forked(run_in, size)) == 5
        before = contents(path) if path.exists() else None
        assert some == (before is not None and mecano.open_results(path).checkpoint is not None)
        assert before is None or (before["status"] == "failed" and "all bytes are unchanged" in verify(path))
        resume(deck, path)
        check_same(found := contents(path), contents(tmp_path / "whole.h5"))
        assert before is None or before["time"].tobytes() == found["time"][: len(before["time"])].tobytes()
        assert sorted(os.listdir(tmp_path)) == ["r.h5", "whole.h5"]


class TestTheCheckpoint:
    @pytest.fixture
    def left(self, tmp_path):
        """(deck, the file of a run stopped half-way with two checkpoints)."""
        deck, path = decks()["bouncing_ball"], tmp_path / "r.h5"
        assert stopped(deck, path, 150) and stopped(deck, path, 100)
        return deck, path

    @pytest.mark.parametrize(("spoilt", "steps"), [("0", 250), ("1", 150)])
    def test_a_spoilt_one_leaves_the_other(self, left, tmp_path, spoilt, steps):
        deck, path = left
        with h5py.File(path, "r+") as file:
            assert sorted(file["checkpoints"]) == ["0", "1"]
            file["checkpoints"][spoilt][500] ^= 1
        with mecano.open_results(path) as results:
            assert results.checkpoint["file"]["rows"][1] == steps
        run(deck, tmp_path / "whole.h5")
        resume(deck, path)
        check_same(contents(path), contents(tmp_path / "whole.h5"))

    def test_messages_about_a_stopped_run_name_resume(self, left):
        deck, path = left
        with pytest.raises(
            ResultsError, match=r"already exists; .*, or --resume \(in Python resume=True\) to continue it$"
        ):
            run(deck, path)
        assert " ".join(info(path).split()).count("--resume") == 1  # what it was stopped with names the command
        with h5py.File(path, "r+") as file:
            file["run/reason"][()], file["run/status"][()] = b"", b"running"
            file["run"].attrs["process"] = 4194305  # Linux gives no process this number
        assert f"resume with mecano run {deck.file} --set time.end=4 -o {path} --resume" in " ".join(info(path).split())
        resume(deck, path)
        with pytest.raises(ResultsError, match=r"or --force \(in Python force=True\) to replace it$"):
            run(deck, path)

    def test_rows_that_changed_are_not_gone_on_with(self, left):
        deck, path = left
        reported = []
        with h5py.File(path, "r+") as file:
            file["storage/solver"][17, 1] *= 1.0 + 1e-15
        before = path.read_bytes()
        with pytest.raises(ResultsError, match="before its checkpoint have changed"):
            resume(deck, path, announce=reported.append)
        assert not reported and path.read_bytes() == before and os.listdir(path.parent) == ["r.h5"]

    def test_a_limit_that_leaves_no_time_for_a_step_is_refused(self, left):
        """Exit code 75 would let a batch system try the same for ever."""
        deck, path = left
        before = path.read_bytes()
        with pytest.raises(UsageError, match=r"too short: copying .*r\.h5 \(.* MB\), and closing .* about .* s"):
            resume(deck, path, interruption=Interruption(limit=1e-3))
        assert path.read_bytes() == before and os.listdir(path.parent) == ["r.h5"]

    def test_a_signal_while_the_file_is_taken_up_leaves_it_as_it_was(self, left):
        deck, path = left
        before, asked = path.read_bytes(), Interruption()
        with asked.postponed():
            asked._ask(signal.SIGUSR1, None)
        with pytest.raises(Stopped, match="by SIGUSR1 while copying .*the file is unchanged") as stop:
            resume(deck, path, interruption=asked)
        assert stop.value.exit_code == 75 and path.read_bytes() == before and os.listdir(path.parent) == ["r.h5"]

    def test_a_file_without_one_begins_again(self, tmp_path):
        deck, path, reported = decks()["bouncing_ball"], tmp_path / "r.h5", []
        assert stopped(deck, path, 150)
        with h5py.File(path, "r+") as file:
            del file["checkpoints/0"]
        resume(deck, path, announce=reported.append)
        assert reported == [f"{path} has no checkpoint yet: the run starts again"]
        assert contents(path)["status"] == "complete"

    def test_a_complete_file_stays_as_it_is(self, tmp_path):
        deck, path, reported = decks()["bouncing_ball"], tmp_path / "r.h5", []
        run(deck, path)
        before = path.read_bytes()
        assert resume(deck, path, announce=reported.append) is None
        assert path.read_bytes() == before and "is complete" in reported[0]

    @pytest.mark.parametrize(("analysis", "name"), [(dynamic, "bouncing_ball"), (static, "hanging_chain")])
    def test_a_complete_file_that_has_changed_is_refused(self, analysis, name, tmp_path):
        deck, path, reported = input_deck(name), tmp_path / "r.h5", []
        analysis.run(deck, path)
        with h5py.File(path) as file:
            place = file["storage/output"].id.get_chunk_info(0).byte_offset
        data = bytearray(path.read_bytes())
        data[place] ^= 1
        path.write_bytes(data)
        with pytest.raises(ResultsError, match="is damaged"):
            analysis.resume(deck, path, announce=reported.append)
        assert path.read_bytes() == data and not reported

    def test_another_deck_is_refused_with_the_differences(self, left):
        _, path = left
        other = input_deck("bouncing_ball", "time.end=5", "time.step=0.02", "title=Another")
        before = path.read_bytes()
        with pytest.raises(UsageError) as refused:
            resume(other, path)
        assert "time.end: 4.0 instead of 5.0" in str(refused.value) and "time.step: 0.01" in str(refused.value)
        assert "title" in str(refused.value) and path.read_bytes() == before

    def test_another_machine_is_reported(self, left):
        deck, path = left
        with h5py.File(path, "r+") as file:
            file["run"].attrs["processor"] = "Abacus"
            file["run"].attrs["threads"] = 7
        reported = []
        resume(deck, path, announce=reported.append)
        assert "number of threads (7, now" in reported[0] and "processor (Abacus, now" in reported[0]
        with mecano.open_results(path) as results:
            assert reported[0] in results.warnings and reported[0] not in results.resumptions

    def test_a_file_that_is_being_written_is_not_resumed(self, tmp_path):
        """By the process of that number, unless that began only after the run."""
        deck, path = decks()["bouncing_ball"], tmp_path / "r.h5"
        sleeping = subprocess.Popen(["sleep", "60"])
        try:
            child = forked(run, deck, path, observers=(lambda accepted: accepted.run.steps < 99 or os._exit(9),))
            assert ended(child) == 9
            with h5py.File(path, "r+") as file:
                file["run"].attrs["process"] = sleeping.pid
            with pytest.raises(ResultsError, match=f"still being written, by process {sleeping.pid}"):
                resume(deck, path)
            with h5py.File(path, "r+") as file:
                file["run"].attrs["started"] = "2024-02-29T12:00:00+00:00"
            assert mecano.open_results(path).status == "killed"
        finally:
            sleeping.kill()
            sleeping.wait()

    def test_one_that_does_not_fit_is_refused(self, left, monkeypatch):
        deck, path = left
        load = checkpoint_writer.from_plain
        bent = lambda plain: replace(load(plain), motion=replace(load(plain).motion, phases=load(plain).motion.z))  # noqa: E731
        monkeypatch.setattr("mecano.analyses.checkpoint_writer.from_plain", bent)
        with pytest.raises(ResultsError, match="does not fit the deck"):
            resume(deck, path)

    def test_a_short_run_writes_no_checkpoint(self, tmp_path):
        run(decks()["bouncing_ball"], tmp_path / "r.h5")
        with h5py.File(tmp_path / "r.h5") as file:
            assert len(file["checkpoints"]) == 0

    def test_it_may_grow(self, tmp_path):
        """What does not fit the places of the first checkpoints gets new ones."""
        from results_samples import append, create

        with create(tmp_path / "r.h5") as writer:
            for i in range(4):
                append(writer, i)
                writer.checkpoint({"text": "x" * 40_000 * i})
        with mecano.open_results(tmp_path / "r.h5") as results:
            assert len(results.checkpoint["run"]["text"]) == 120_000


def saved(path):
    """Return the number of saved times of a running or ended run."""
    with mecano.open_results(path) as results:
        return len(results.time)


class TestTheCommand:
    @pytest.fixture
    def folder(self, tmp_path):
        (tmp_path / "deck.yaml").write_text(SWING)
        return tmp_path

    def started(self, folder, *arguments):
        """A process of a run that would go on for hours."""
        return subprocess.Popen([*COMMAND, "run", "deck.yaml", "-q", *arguments], cwd=folder, stderr=subprocess.PIPE)

    def test_a_run_ended_by_signals_is_resumed(self, folder):
        """How far a run gets is not known before: the rows that both have are compared."""
        path, reached, file = folder / "deck.h5", [], 0
        for number, code in ((signal.SIGINT, 130), (signal.SIGUSR1, 75)):
            process = self.started(folder, "--resume")
            while not path.exists() or path.stat().st_ino == file:  # the file of the first run
                time.sleep(0.01)
            while saved(path) <= (len(reached[-1]) if reached else 1):
                time.sleep(0.05)
            process.send_signal(number)
            reported = process.communicate()[1].decode()
            assert process.returncode == code and "mecano run deck.yaml -q --resume" in flowing(reported)
            with mecano.open_results(path) as results:
                assert results.status == "stopped" and number.name in results.reason
                reached.append(results["hinge.angle"].values)
            file = path.stat().st_ino
        assert len(reached[1]) > len(reached[0]) > 1
        assert reached[0].tobytes() == reached[1][: len(reached[0])].tobytes()

    def test_a_limit_of_time(self, folder):
        begun = time.monotonic()
        code, _, reported = mecano_process("run", "deck.yaml", "-q", "--max-walltime", "3", cwd=folder)
        assert code == 75 and "limit of wall-clock time" in reported and "--resume" in reported
        assert time.monotonic() - begun < 4.5  # with the time in which Python starts
        with mecano.open_results(folder / "deck.h5") as results:
            assert results.status == "stopped" and results.checkpoint is not None

    def test_a_limit_that_ends_before_the_run(self, folder):
        code, _, reported = mecano_process("run", "deck.yaml", "-q", "--max-walltime", "00:00:01", cwd=folder)
        assert code == 75 and "mecano: stopped by the limit of wall-clock time" in flowing(reported)
        code, _, reported = mecano_process("run", "deck.yaml", "--max-walltime", "soon", cwd=folder)
        assert code == 2 and "'soon' is not a wall-clock time" in reported

    def test_statics_begin_again_unless_complete(self, folder):
        arguments = ("run", INPUTS / "snap_through.yaml", "-o", "s.h5", "--resume")
        assert mecano_process(*arguments, cwd=folder)[0] == 0
        before = (folder / "s.h5").read_bytes()
        code, _, reported = mecano_process(*arguments, cwd=folder)
        assert code == 0 and "is complete" in reported and (folder / "s.h5").read_bytes() == before
        code, _, reported = mecano_process(*arguments, "--set", "title=Another", cwd=folder)
        assert code == 2 and "title" in reported

    def test_a_disk_that_is_read_only(self, folder):
        mount = ["mount", "-t", "tmpfs", "-o", "ro", "tmpfs", str(folder)]
        (folder / "deck.yaml").rename(folder.parent / "deck.yaml")
        if shutil.which("mount") is None or subprocess.run(mount, capture_output=True).returncode:
            pytest.skip("a tmpfs cannot be mounted here")
        try:
            code, _, reported = mecano_process("run", "../deck.yaml", "-q", "--resume", cwd=folder)
            assert code == 5 and reported == "mecano: cannot write deck.h5: Read-only file system\n"
        finally:
            subprocess.run(["umount", str(folder)], check=True)

    def test_wishes_that_contradict(self, folder):
        code, _, reported = mecano_process("run", "deck.yaml", "--resume", "--force", cwd=folder)
        assert code == 2 and "--force replaces it" in reported

    def test_verify(self, folder):
        mecano_process("run", "deck.yaml", "-q", "--set", "time.end=0.1", cwd=folder)
        assert mecano_process("verify", "deck.h5", cwd=folder)[0] == 0
        with h5py.File(folder / "deck.h5") as file:
            place = file["extremes/maximum"].id.get_offset()
        data = bytearray((folder / "deck.h5").read_bytes())
        data[place + 3] ^= 16
        (folder / "deck.h5").write_bytes(data)
        code, _, reported = mecano_process("verify", "deck.h5", cwd=folder)
        assert code == 5 and "extremes/maximum" in reported


def test_times_in_words():
    texts = {"3600": 3600, "90s": 90, "2h30m": 9000, "1d": 86400, "1h2m3s": 3723, "02:30:00": 9000, "1-00:00:01": 86401}
    assert {text: seconds(text) for text in texts} == texts
    assert seconds("999999999d") == seconds("2000000000") == 10**9  # what the timer of the system still takes
    for wrong in ("", "0", "2:30", "h", "1.5h", "-3", "9" * 5000):
        with pytest.raises(UsageError):
            seconds(wrong)


class TestInterruption:
    @pytest.fixture
    def listening(self):
        """An Interruption that hears signals; the handlers are put back."""
        before, hook = {number: signal.getsignal(number) for number in EXIT_CODES}, sys.unraisablehook
        if hasattr(signal, "SIGHUP"):
            signal.signal(signal.SIGHUP, signal.SIG_DFL)  # where the tests run under `nohup` it is ignored
        interruption = Interruption(again="again")
        interruption.listen()
        yield interruption
        sys.unraisablehook = hook
        for number, handler in before.items():
            signal.signal(number, handler)

    def test_a_signal_before_the_run_ends_the_process_at_once(self, listening):
        with pytest.raises(Stopped) as error:
            signal.raise_signal(signal.SIGUSR1)
        assert error.value.exit_code == 75

    def test_one_that_became_another_exception_is_known(self, listening):
        with pytest.raises(SystemError) as error:
            try:
                signal.raise_signal(signal.SIGTERM)
            except Stopped as stopped:
                raise SystemError("returned a result with an exception set") from stopped
        assert stopped_by(error.value).exit_code == 143 and stopped_by(ValueError()) is None

    @pytest.mark.filterwarnings("ignore::pytest.PytestUnraisableExceptionWarning")  # pytest 8.0 has a hook of its own
    def test_one_that_a_destructor_loses_counts_all_the_same(self, listening, capsys):
        class Dying:
            def __del__(self):
                signal.raise_signal(signal.SIGTERM)

        Dying()
        assert listening.wanted(0.0) and listening.stopped("here").exit_code == 143
        assert capsys.readouterr() == ("", "")

    def test_a_signal_interrupts_a_long_call_of_a_library(self, listening):
        """A call of the C library, in which Python runs no handlers, before the time integration and in it."""
        begun, sleep = time.monotonic(), ctypes.CDLL(None).sleep
        threading.Timer(0.1, os.kill, (os.getpid(), signal.SIGHUP)).start()
        with pytest.raises(Stopped, match="by SIGHUP$") as error:
            call_interruptibly(sleep, 60)
        assert error.value.exit_code == 129
        threading.Timer(0.1, os.kill, (os.getpid(), signal.SIGXCPU)).start()
        with listening.postponed(), pytest.raises(Stopped, match="within a step; .* again") as error:
            call_interruptibly(sleep, 60)
        assert error.value.exit_code == 129 and time.monotonic() - begun < 30.0  # that of the first signal

    def test_a_thread_that_cannot_start_leaves_the_stack_of_others(self, listening, monkeypatch):
        def refuse(thread):
            raise RuntimeError("can't start new thread")

        usual = threading.stack_size()
        with monkeypatch.context() as patched, pytest.raises(RuntimeError, match="can't start"):
            patched.setattr(threading.Thread, "start", refuse)
            call_interruptibly(divmod, 7, 2)
        assert threading.stack_size() == usual

    def test_a_call_that_may_be_abandoned_is_one_like_others(self, listening):
        assert call_interruptibly(divmod, 7, 2) == (3, 1)
        assert call_interruptibly(lambda: call_interruptibly(threading.current_thread)) is not threading.main_thread()
        with pytest.raises(ZeroDivisionError):
            call_interruptibly(divmod, 7, 0)
        with listening.postponed():
            signal.raise_signal(signal.SIGTERM)
        assert listening.wanted(0.0)

    def test_a_hangup_that_is_ignored_stays_so(self):
        before = signal.signal(signal.SIGHUP, signal.SIG_IGN)
        try:
            Interruption().listen((signal.SIGHUP,))
            assert signal.getsignal(signal.SIGHUP) == signal.SIG_IGN
        finally:
            signal.signal(signal.SIGHUP, before)

    def test_a_signal_waits_for_the_step_but_a_second_ctrl_c_does_not(self, listening):
        with listening.postponed():
            assert not listening.wanted(0.0)
            signal.raise_signal(signal.SIGTERM)
            signal.raise_signal(signal.SIGTERM)
            assert listening.wanted(0.0) and listening.stopped("here").exit_code == 143
            with pytest.raises(Stopped):
                signal.raise_signal(signal.SIGINT)

    def test_long_steps_are_not_begun_that_would_not_end_in_time(self):
        interruption = Interruption(1e6)
        now = time.monotonic()
        assert not interruption.wanted(now) and not interruption.wanted(now + 4e5)
        assert interruption.wanted(now + 6.5e5)

    def test_time_is_left_for_a_large_file_to_be_closed(self):
        interruption = Interruption(1e6)  # since the process began, which may be long ago
        now = time.monotonic()
        left = interruption._deadline - now
        assert not interruption.wanted(now) and interruption.wanted(now, ending=left + 1.0)


class TestVerify:
    @pytest.fixture
    def path(self, tmp_path):
        run(decks()["bouncing_ball"], tmp_path / "r.h5")
        return tmp_path / "r.h5"

    def test_every_changed_bit_is_found(self, path):
        data, rng, named = path.read_bytes(), random.Random(5), set()
        for _ in range(16):  # the scorecard changes thousands
            bit = rng.randrange(8 * len(data))
            path.write_bytes(data[: bit // 8] + bytes([data[bit // 8] ^ 1 << bit % 8]) + data[bit // 8 + 1 :])
            with pytest.raises(ResultsError) as found:
                verify(path)
            named.add(str(found.value).partition("affected: ")[2].partition(",")[0])
        assert {"storage/output", "storage/solver"} <= named
        path.write_bytes(data)
        assert "all bytes are unchanged" in verify(path)

    @pytest.mark.parametrize("bytes_gone", [1, 100, 20_000, 200_000])
    def test_a_file_that_was_cut(self, path, bytes_gone):
        path.write_bytes(path.read_bytes()[:-bytes_gone])
        with pytest.raises(ResultsError, match="cut short|last bytes"):
            verify(path)

    def test_a_file_that_was_changed_on_purpose_gets_new_sums(self, path):
        with h5py.File(path, "r+") as file:
            file["more"] = list(range(1000))
        with pytest.raises(ResultsError):
            verify(path)
        disk = Disk(path, begun=True)
        disk.seal()
        disk.close()
        assert "all bytes are unchanged" in verify(path)

    def test_a_killed_run(self, tmp_path):
        """Where the sums are lost, those in the checkpoint tell of the rows before it."""
        path, deck = tmp_path / "r.h5", decks()["bouncing_ball"]

        def run_and_die():
            checkpoint_writer.SHARE = 0
            run(deck, path, interval=0.0, observers=(lambda accepted: accepted.run.steps < 200 or os._exit(9),))

        assert ended(forked(run_and_die)) == 9
        assert "killed" in verify(path) and "it was not closed; all bytes are unchanged" in verify(path)
        data = path.read_bytes()
        path.write_bytes(data[: struct.unpack("<Q", data[28:36])[0]])  # what HDF5 uses
        with pytest.raises(ResultsError, match=r"the checksums, are missing.* steps and 3 events are unchanged"):
            verify(path)
        with h5py.File(path, "r+") as file:
            file["events/impulse"][2] += 1.0
        with pytest.raises(ResultsError, match="bytes have changed in events"):
            verify(path)

    def test_verify_refuses_files_that_are_no_results(self, tmp_path):
        (tmp_path / "no.h5").write_text(json.dumps({}))
        for name in ("no.h5", "gone.h5"):
            with pytest.raises(ResultsError):
                verify(tmp_path / name)
