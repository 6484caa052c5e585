"""Results files of runs killed, interrupted, truncated or stopped by a full disk, and of running ones."""

import contextlib
import errno
import os
import random
import re
import shutil
import signal
import struct
import subprocess
import sys
import textwrap
import time
from pathlib import Path

import h5py
import numpy as np
import pytest
import results_samples as samples

from mecano.errors import ResultsError
from mecano.results import checksums, disk, table
from mecano.results.checksums import BLOCK
from mecano.results.reader import open_results
from mecano.results.verify import verify

HERE = Path(__file__).parent
PAGE = 4096


def script(body, *arguments, **options):
    """Start a Python process that has the samples at hand."""
    head = "import os, sys, time, random, signal, resource\nimport results_samples as samples\n"
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join([str(HERE), str(HERE.parent)])}
    command = [sys.executable, "-c", head + textwrap.dedent(body), *map(str, arguments)]
    return subprocess.Popen(command, env=environment, text=True, **options)


class Recorder:
    """All changes of the file in their order, and the counts acknowledged in between."""

    def __init__(self, monkeypatch):
        self.log = []
        write, truncate = os.pwrite, os.ftruncate

        def pwrite(descriptor, data, offset):
            self.log.append((offset, bytes(data)))
            return write(descriptor, data, offset)

        def ftruncate(descriptor, size):
            self.log.append((size, None))
            truncate(descriptor, size)

        monkeypatch.setattr(os, "pwrite", pwrite)
        monkeypatch.setattr(os, "ftruncate", ftruncate)

    @staticmethod
    def apply(content, offset, data):
        """Make one change to the bytes of a file."""
        end = offset if data is None else offset + len(data)
        content.extend(bytes(max(end - len(content), 0)))
        if data is None:
            del content[offset:]
        else:
            content[offset:end] = data

    @staticmethod
    def torn(content, offset, data):
        """Contents after a kill within one write, which the system only interrupts between pages."""
        first = PAGE - offset % PAGE
        for length in range(first, len(data or b""), PAGE):
            part = bytearray(content)
            Recorder.apply(part, offset, data[:length])
            yield part


def record(path, monkeypatch):
    """Record a run of many flushes with small chunks and some checkpoints.

    Returns the log, where the run starts in it, (changes, acknowledged rows), (changes, row of a checkpoint).
    """
    monkeypatch.setattr(table, "BLOCK_NUMBERS", 256)
    monkeypatch.setattr(table, "CHUNK_NUMBERS", 32)
    recorder = Recorder(monkeypatch)
    writer = samples.create(path)
    start, acknowledged, kept = len(recorder.log), [(len(recorder.log), 0)], []
    for index in range(200):
        samples.append(writer, index)
        if index % 7 == 0 or index > 190:
            count = writer.flush()
            acknowledged.append((len(recorder.log), count))
        if index % 40 == 20:
            writer.checkpoint({"x": np.arange(1000.0), "index": index, "memory": {"a": 1}})
            acknowledged.append((len(recorder.log), index + 1))
            kept.append((len(recorder.log), index))
    writer.close()
    acknowledged.append((len(recorder.log), 200))
    return recorder.log, start, acknowledged, kept


def test_every_instant_of_a_run_leaves_a_readable_file(tmp_path, monkeypatch):
    """Kill after changes of the file, and between the pages of each.

    After each change at first, near checkpoints and at the end, and after every 97th of the others, which repeat.
    """
    path = tmp_path / "r.h5"
    log, start, acknowledged, kept = record(path, monkeypatch)
    monkeypatch.undo()
    final, content, tried, compared = path.read_bytes(), bytearray(), 0, 0
    for done, (offset, data) in enumerate(log, start=1):
        least = max((count for changes, count in acknowledged if changes < done), default=0)
        last = max((index for changes, index in kept if changes < done), default=-1)
        torn = list(Recorder.torn(content, offset, data)) if done > start else []
        Recorder.apply(content, offset, data)
        near_checkpoint = any(changes - 8 < done < changes + 3 for changes, _ in kept)
        if done < start or not (done < start + 50 or near_checkpoint or done > len(log) - 50 or done % 97 == 0):
            continue
        for state in (*torn, content):
            path.write_bytes(state)
            with open_results(path) as results:
                assert results.status in ("running", "complete")  # "truncated" would be unreadable for others
                count = samples.check(results)
                assert count >= least and len(results.steps) >= least and len(results.events) >= least
                if count:
                    samples.check_extremes(results, count)
                if last >= 0 and any(changes - 30 < done < changes + 3 for changes, _ in kept):
                    assert results.checkpoint["run"]["index"] >= last
                    compared += 1
            tried += 1
    assert bytes(content) == final and tried > 200 and compared > 40


@pytest.fixture
def closing(tmp_path, monkeypatch):
    """(path, its bytes before it is closed, changes while it is) of a file."""
    path, recorder = tmp_path / "r.h5", Recorder(monkeypatch)
    writer = samples.create(path)
    for index in range(40):
        samples.append(writer, index)
    writer.flush()
    content = bytearray(path.read_bytes())
    del recorder.log[:]
    writer.close("stopped", "by hand")
    monkeypatch.undo()
    return path, content, recorder.log


def test_no_instant_of_closing_a_file_seems_to_be_damage(closing):
    path, content, log = closing
    closed, words = path.read_bytes(), []
    for offset, data in log:
        for length in range(BLOCK - offset % BLOCK, len(data or b""), BLOCK):  # killed within a change
            torn = bytearray(content)
            Recorder.apply(torn, offset, data[:length])
            path.write_bytes(torn)
            words.append(verify(path))
        Recorder.apply(content, offset, data)
        path.write_bytes(content)
        words.append(verify(path))
    assert bytes(content) == closed and len(words) > 40
    assert all("all bytes are unchanged" in text for text in words)
    assert "stopped" in words[-1] and "killed" not in words[-1] and "running" in words[0]


def test_changed_bytes_are_found_at_every_instant_of_a_run(tmp_path, monkeypatch):
    """Every changed bit of a file whose writer was killed at any instant is found."""
    path, rng = tmp_path / "r.h5", random.Random(11)
    log, start, *_ = record(path, monkeypatch)
    monkeypatch.undo()
    content, instants, named = bytearray(), {rng.randrange(start, len(log)) for _ in range(30)}, set()
    for done, (offset, data) in enumerate(log, start=1):
        Recorder.apply(content, offset, data)
        if done not in instants:
            continue
        path.write_bytes(content)
        assert "all bytes are unchanged" in verify(path)
        place = rng.randrange(struct.unpack("<Q", content[28:36])[0])  # before the end of what HDF5 uses
        content[place] ^= 1 << (bit := rng.randrange(8))
        path.write_bytes(content)
        with pytest.raises(ResultsError, match="bytes have changed") as found:
            verify(path)
        named.add(str(found.value).partition("affected: ")[2].partition(",")[0])
        content[place] ^= 1 << bit
    assert len(instants) > 25 and "storage/output" in named


def test_a_disk_that_has_no_room_for_the_sums_of_a_closed_file(tmp_path, monkeypatch):
    """Those of a file that is being written stay, which show changed bytes as well."""
    path = tmp_path / "r.h5"
    writer = samples.create(path)
    samples.append(writer, 0)
    writer.flush()
    write = os.pwrite

    def pwrite(descriptor, data, offset):
        if checksums.MARK in bytes(data):
            raise OSError(errno.ENOSPC, "No space left on device")
        return write(descriptor, data, offset)

    monkeypatch.setattr(os, "pwrite", pwrite)
    writer.close("complete", "the end was reached")
    monkeypatch.undo()
    with open_results(path) as results:
        assert samples.check(results) == 1
        assert (results.status, results.reason) == ("complete", "the end was reached")
    assert "complete, 1 saved times up to 0; all bytes are unchanged" in verify(path)


NURSERY = """
    folder, runs = sys.argv[1], int(sys.argv[2])
    with samples.create(f"{folder}/first.h5") as writer:
        samples.append(writer, 0)  # compiles, so that the children do not
    pick = random.Random(7)
    for number in range(runs):
        child = os.fork()
        if child == 0:
            told = os.open(f"{folder}/{number}.txt", os.O_WRONLY | os.O_CREAT)
            writer = samples.create(f"{folder}/{number}.h5")
            for index in range(10**7):
                samples.append(writer, index)
                if index % 3 == 0:
                    os.pwrite(told, b"%9d" % writer.flush(), 0)
        while not os.path.exists(f"{folder}/{number}.h5"):
            time.sleep(0.001)
        time.sleep(pick.uniform(0.0, 0.15))
        os.kill(child, signal.SIGKILL)
        os.waitpid(child, 0)
"""


def test_a_kill_loses_no_acknowledged_step(tmp_path):
    """30 runs killed with -9 at random instants: each flushed row is there and right, bit for bit."""
    nursery = script(NURSERY, tmp_path, 30)
    assert nursery.wait(120) == 0
    flushed = []
    for number in range(30):
        reported = (tmp_path / f"{number}.txt").read_text()
        with open_results(tmp_path / f"{number}.h5") as results:
            count = samples.check(results)
            assert results.status == "killed" and results.reason == ""
            if count:
                samples.check_extremes(results, count)
        flushed.append(int(reported or 0))
        assert count >= flushed[-1]
    assert np.count_nonzero(flushed) > 15  # most of them while rows were written


def test_reading_while_another_process_writes(tmp_path):
    path = tmp_path / "r.h5"
    writing = script(
        """
        writer = samples.create(sys.argv[1])
        for index in range(1500):
            samples.append(writer, index)
            if index % 5 == 0:
                print(writer.flush(), flush=True)
                time.sleep(0.001)
        writer.close()
        """,
        path,
        stdout=subprocess.PIPE,
    )
    counts = []
    with writing:
        for number, line in enumerate(writing.stdout):
            if number % 10:
                continue
            with open_results(path) as results:
                counts.append(samples.check(results))
                assert counts[-1] >= int(line) and results.status in ("running", "complete")
            assert plainly_read(path) >= int(line)
    assert writing.returncode == 0 and len(counts) > 5 and counts == sorted(counts)
    with open_results(path) as results:
        assert results.status == "complete" and samples.check(results) == 1500


def plainly_read(path):
    """Rows that plain HDF5 sees; it may have to try again between two writes of one flush."""
    for _ in range(100):
        with contextlib.suppress(OSError), h5py.File(path, "r", locking=False) as file:
            return len(file["joints/knee/angle"])
        time.sleep(0.001)
    raise AssertionError("plain HDF5 cannot open the file")


def test_refresh_shows_added_rows(tmp_path):
    with samples.create(tmp_path / "r.h5") as writer, open_results(tmp_path / "r.h5") as results:
        assert results.status == "running" and len(results.time) == 0
        samples.append(writer, 0)
        writer.flush()
        assert len(results.time) == 0
        results.refresh()
        assert samples.check(results) == 1


FILL = """
    from mecano.errors import ResultsError

    def fill(path, limit):
        if limit:
            resource.setrlimit(resource.RLIMIT_FSIZE, (limit, limit))
        try:
            writer = samples.create(path)
            for index in range(10**6):
                samples.append(writer, index)
                if index % 10 == 0:
                    print(writer.flush(), flush=True)
        except ResultsError as error:
            print(error, file=sys.stderr)
            sys.exit(error.exit_code)

    sys.dont_write_bytecode = True  # Python would leave incomplete files
    for limit in map(int, sys.argv[2:]):
        child = os.fork()
        if child == 0:
            fill(f"{sys.argv[1]}/{limit}/r.h5", limit)
        code = os.waitstatus_to_exitcode(os.waitpid(child, 0)[1])
        print("code", code, flush=True)
        print("code", code, file=sys.stderr, flush=True)
"""


def check_full(folder, reason, *limits):
    """Fill a file for each limit of the size of files (0: none); return the numbers of rows that they hold.

    Each time a process must report the reason and end cleanly, and the file must hold all acknowledged data.
    """
    for limit in limits:
        (folder / f"{limit}").mkdir()
    filling = script(FILL, folder, *limits, stdout=subprocess.PIPE, stderr=subprocess.PIPE)
    said = [re.split(r"code (-?\d+)\n", text) for text in filling.communicate(timeout=120)]
    outs, errors = (parts[0:-1:2] for parts in said)
    assert said[0][1::2] == ["5"] * len(limits)
    paths = (folder / f"{limit}" / "r.h5" for limit in limits)
    return [check_filled(path, reason, *of) for path, *of in zip(paths, outs, errors, strict=True)]


def check_filled(path, reason, out, reported):
    """Check the file of a process that wrote until there was no room, and what it said; return the number of rows."""
    assert reason in reported and reported.count("\n") == 1
    assert os.listdir(path.parent) in ([path.name], [])
    if not path.exists():
        assert out == "" and "cannot write" in reported
        return 0
    with open_results(path) as results:
        count = samples.check(results)
        assert 0 <= count - int(out.split()[-1] if out else 0) <= 10  # the writer flushes by itself once a second
        assert f"{count} saved times" in reported
        assert (results.status, results.reason) == ("failed", f"writing failed: {reason}")
    return count


def test_a_file_that_may_not_grow_keeps_its_rows(tmp_path):
    """The limit of the file size varies from the first byte to many rows."""
    counts = check_full(tmp_path, "File too large", *range(1, 60_000, 19_001), *range(60_000, 800_000, 180_003))
    assert counts[0] == 0 and counts[-1] > 500 and counts == sorted(counts)


def test_a_full_disk(tmp_path):
    mount = ["mount", "-t", "tmpfs", "-o", "size=600k", "tmpfs", str(tmp_path)]
    if shutil.which("mount") is None or subprocess.run(mount, capture_output=True).returncode:
        pytest.skip("a tmpfs cannot be mounted here")
    try:
        assert check_full(tmp_path, "No space left on device", 0)[0] > 300
    finally:
        subprocess.run(["umount", str(tmp_path)], check=True)


def test_a_process_that_forgets_to_close(tmp_path):
    process = script("samples.append(samples.create(sys.argv[1]), 0)", tmp_path / "r.h5", stderr=subprocess.PIPE)
    assert process.communicate(timeout=60)[1] == "" and process.returncode == 0
    with open_results(tmp_path / "r.h5") as results:
        assert (samples.check(results), results.status) == (1, "failed")
        assert results.reason == "the process ended before the run did"


class Interrupted(Exception):
    pass


def test_a_signal_handler_that_raises_waits_for_the_end_of_a_flush(tmp_path, monkeypatch):
    def interrupt(*_):
        raise Interrupted

    put = disk.Disk._put

    def put_with_signal(*arguments):
        signal.raise_signal(signal.SIGUSR1)
        return put(*arguments)

    before = signal.signal(signal.SIGUSR1, interrupt)
    try:
        with samples.create(tmp_path / "r.h5") as writer:
            samples.append(writer, 0)
            monkeypatch.setattr(disk.Disk, "_put", put_with_signal)
            with pytest.raises(Interrupted):
                writer.flush()
            assert writer.acknowledged == 1
            monkeypatch.undo()
            assert signal.getsignal(signal.SIGUSR1) is interrupt
            samples.append(writer, 1)
    finally:
        signal.signal(signal.SIGUSR1, before)
    with open_results(tmp_path / "r.h5") as results:
        assert (samples.check(results), results.status) == (2, "complete")


def test_ctrl_c_ends_the_file_as_stopped(tmp_path):
    with pytest.raises(KeyboardInterrupt), samples.create(tmp_path / "r.h5") as writer:
        samples.append(writer, 0)
        raise KeyboardInterrupt
    with open_results(tmp_path / "r.h5") as results:
        assert (samples.check(results), results.status, results.reason) == (1, "stopped", "interrupted")


TOO_SHORT = ("not a results file", "cannot be read", "too little is left")


def test_files_cut_short_are_read_as_far_as_they_reach(tmp_path, monkeypatch):
    monkeypatch.setattr(table, "BLOCK_NUMBERS", 1024)
    with samples.create(tmp_path / "whole.h5") as writer:
        for index in range(1000):
            samples.append(writer, index)
    whole, counts = (tmp_path / "whole.h5").read_bytes(), []
    for part in np.linspace(0.0, 0.99, 17):  # the last 0.5 % are sums, behind the HDF5 file
        (tmp_path / "r.h5").write_bytes(whole[: int(part * len(whole))])
        try:
            with open_results(tmp_path / "r.h5") as results:
                assert results.status == "truncated"
                counts.append(samples.check(results))
        except ResultsError as error:
            assert not counts and any(text in str(error) for text in TOO_SHORT)
    assert len(counts) > 13 and counts == sorted(counts) and counts[0] < 130 and 330 < counts[len(counts) // 2] < 670


def test_a_removed_file_is_reported(tmp_path):
    samples.create(tmp_path / "r.h5").close()
    with open_results(tmp_path / "r.h5") as results:
        (tmp_path / "r.h5").unlink()
        with pytest.raises(ResultsError, match="No such file"):
            results.refresh()


def test_two_runs_at_once_do_not_share_a_file(tmp_path, monkeypatch):
    """The name is taken in one step: the second of two runs that start together is refused."""
    first = samples.create(tmp_path / "r.h5")
    monkeypatch.setattr(Path, "exists", lambda path: False)
    with pytest.raises(ResultsError, match="already exists"):
        samples.create(tmp_path / "r.h5")
    monkeypatch.undo()
    samples.append(first, 0)
    first.close()
    with open_results(tmp_path / "r.h5") as results:
        assert samples.check(results) == 1
    assert os.listdir(tmp_path) == ["r.h5"]


def test_a_file_replaced_while_it_is_written(tmp_path):
    """The second run is whole; the rows of the first would reach nobody."""
    first = samples.create(tmp_path / "r.h5")
    second = samples.create(tmp_path / "r.h5", force=True)
    samples.append(second, 0)
    samples.append(first, 0)
    samples.append(first, 1)
    second.close()
    with pytest.raises(ResultsError, match="r.h5: it was replaced while it was written$"):
        first.close()
    with open_results(tmp_path / "r.h5") as results:
        assert samples.check(results) == 1


@pytest.mark.parametrize("size", [0, 5000, 200_000])
@pytest.mark.parametrize("ended", ["flush", "close"])
def test_a_file_that_is_cut_short_while_it_is_written(tmp_path, ended, size):
    """HDF5 must not see this: it would fail at the exit of the process, with a signal."""
    writer = samples.create(tmp_path / "r.h5")
    samples.append(writer, 0)
    writer.flush()
    os.truncate(tmp_path / "r.h5", size)
    samples.append(writer, 1)
    with pytest.raises(ResultsError, match="r.h5: it was cut short while it was written$"):
        getattr(writer, ended)()


@pytest.mark.parametrize("ended", ["flush", "close"])
def test_a_file_that_is_removed_while_it_is_written(tmp_path, ended):
    """Its rows would reach nobody: the run must not end as if there were results."""
    path = tmp_path / "gone" / "r.h5"
    path.parent.mkdir()
    writer = samples.create(path)
    samples.append(writer, 0)
    writer.flush()
    path.unlink()
    path.parent.rmdir()
    samples.append(writer, 1)
    with pytest.raises(ResultsError, match="r.h5: it was removed while it was written$"):
        getattr(writer, ended)()
