"""Line 11: changed results files of finished and killed runs: no traceback, no signal, nothing resumed from damage."""

import mmap
import os
import random
import signal
import struct
import tempfile
import time
from functools import partial
from pathlib import Path

from scorecard.killed import arguments, differs, held, reference, started, witnessed
from scorecard.outcome import in_process, unfit
from scorecard.trial import Job, Line

LINES = (
    Line(
        11,
        "changed results files, finished and killed: no traceback, each change seen, nothing resumed from damage",
        6,
        2000,
    ),
)
NAMES = ("friction_pendulum", "cable_snatch", "nose_gear_rigid")
KILLED = 4  # files of killed runs for each deck
TRIES = 100  # to kill a run before it has ended
PICTURES = 20  # one of so many trials draws
OTHER_VERSIONS = (0, 2, 99)


def jobs(lines, factor, seed):
    """Damage files of finished and killed runs in turn."""
    whole = {name: finished(name) for name in NAMES}
    rng, stopped = random.Random(f"{seed} damaged"), {}
    for i in range(max(round(factor * LINES[0].count), 40)):
        name = NAMES[i % len(NAMES)]
        if i % 2:
            key = name, i // 6 % KILLED
            if key not in stopped:
                stopped[key] = killed(name, rng.uniform(0.3, 0.8))
            data = stopped[key]
        else:
            data = whole[name]
        sort = "killed" if i % 2 else "finished"
        yield Job(11, f"{name} {sort} {i}", partial(trial, name, data, sort, rng.random(), i), cpu=60.0)
    for version in OTHER_VERSIONS:
        yield Job(11, f"format {version}", partial(other_format, whole[NAMES[0]], version), cpu=60.0)


def finished(name):
    """Bytes of the file of a run that came to its end."""
    with tempfile.TemporaryDirectory() as folder:
        assert started(name, folder).ended().code == 0
        return Path(folder, "r.h5").read_bytes()


def killed(name, share):
    """Bytes of the file of a run that was killed when so large a share of its rows was acknowledged."""
    rows, said = share * len(reference(name)[0]["time"]), mmap.mmap(-1, 24)
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder, "r.h5")
        for _ in range(TRIES):
            run = started(name, folder, partial(witnessed, said))
            while struct.unpack("3q", said)[0] < rows and not ended(run.pid):
                time.sleep(0.002)
            run.kill(signal.SIGKILL)
            if run.ended().code == -signal.SIGKILL:
                return path.read_bytes()
            path.unlink()
            said[:] = bytes(24)
    raise AssertionError(f"{name} ended {TRIES} times before it could be killed")


def ended(pid):
    """Whether a child of this process has ended."""
    return os.waitid(os.P_PID, pid, os.WEXITED | os.WNOHANG | os.WNOWAIT) is not None


def trial(name, data, sort, place, number, folder):
    """Damage a file and give it to the commands."""
    from scorecard.damage import damage

    changed, what = damage(data, random.Random(place))
    path = folder / "r.h5"
    path.write_bytes(changed)
    (folder / "what.txt").write_text(f"{what}\n")
    for words in reading(number):
        outcome = in_process(words, folder)
        if why := unfit(outcome, (0, 2, 5), cpu=30.0):
            return f"{words[0]}: {why}"
    seen = in_process(["verify", "r.h5"], folder)
    if why := unfit(seen, (0, 5), cpu=30.0):
        return f"verify: {why}"
    if changed != data and seen.code == 0 and not harmless(path, data, folder):
        return f"verify sees nothing: {what.split()[0]}, {sort}"
    path.write_bytes(changed)
    return resumed(name, path, seen.code == 5)


def reading(number):
    """Commands that read a file, those of pictures for few."""
    few = [["post", "r.h5", "-o", "p"], ["post", "r.h5", "--animate", "a.html"]] if number % PICTURES == 0 else []
    return [["info", "r.h5"], ["info", "r.h5", "--names"], ["export", "r.h5", "-o", "r.csv", "--force"],
            ["export", "r.h5", "--vtk", "-o", "r.vtkhdf", "--force"], *few]  # fmt: skip


def harmless(path, data, folder):
    """Whether a change is of no data: all that can be read is as it was."""
    before = folder / "before.h5"
    before.write_bytes(data)
    return isinstance(found := held(path), dict) and isinstance(was := held(before), dict) and not differs(found, was)


def resumed(name, path, seen):
    """--resume refuses what is damaged, or comes to the end of a run that was never stopped."""
    outcome = in_process([word for word in arguments(name)], path.parent)
    if why := unfit(outcome, (0, 2, 5), cpu=60.0):
        return f"--resume: {why}"
    if outcome.code:
        return ""
    found = held(path)
    if isinstance(found, dict) and found["status"] == "complete" and not differs(found, reference(name)[0]):
        return ""
    return "a damaged file was said to be complete" if seen else "resumed from damaged data"


def other_format(data, version, folder):
    """A file of an older or a newer format: refused by number, or read."""
    import h5py

    path = folder / "r.h5"
    path.write_bytes(data)
    with h5py.File(path, "a", locking=False) as file:
        file.attrs["format_version"] = version
    for words in (*reading(0), ["verify", "r.h5"]):
        outcome = in_process(words, folder)
        if why := unfit(outcome, (0, 2, 5), cpu=30.0):
            return f"{words[0]}: {why}"
        if version > 2 and words[0] in ("info", "export") and outcome.code == 0:
            return f"{words[0]} reads a format that it cannot know"
    return ""
