"""Runs killed, stopped by signals or by full disks at random: all are resumed to the same bits.

    python tests/benchmarks/survive.py [kills] [signals] [levels]

Each case is a fork of this process that does what `mecano run --resume` does; default 200 kill -9, 200 signals (SIGINT,
SIGTERM, SIGUSR1), both at random instants from before the first step to the end, and 100 sizes of a small tmpfs
(as root, where mount is permitted), which is made larger before the run is resumed. The decks are those of
tests/surviving.py, for the disks mostly a longer one; checkpoints are written every 5 ms. After each end the file is
checked by `verify`; in the end all series, steps, events and extremes must equal those of the run without a stop.
Recorded in docs/long-runs.md.
"""

import os
import random
import signal
import subprocess
import sys
import tempfile
import time
from collections import Counter
from pathlib import Path

for _variable in ("OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "OMP_NUM_THREADS"):
    os.environ.setdefault(_variable, "1")
sys.path.insert(0, str(Path(__file__).parent.parent))

from surviving import check_same, contents, decks, ended, forked, listening_resume, long_deck

from mecano import open_results
from mecano.analyses.dynamic import run
from mecano.process.interrupt import EXIT_CODES
from mecano.results.verify import verify

INTERVAL = 0.005  # s between checkpoints
MOST = 3  # times that one run is ended
SIGNALS = (signal.SIGINT, signal.SIGTERM, signal.SIGUSR1)
ENDINGS = ("killed", *(number.name for number in SIGNALS))


class Case:
    """A deck, what its run without a stop leaves, and how long that takes in a fork [s]."""

    def __init__(self, deck, folder):
        self.deck, path = deck, folder / "whole.h5"
        run(deck, path)  # compiles, if need be
        path.unlink()
        begun = time.monotonic()
        assert ended(forked(listening_resume, deck, path, INTERVAL)) == 0
        self.duration, self.whole = time.monotonic() - begun, contents(path)
        self.size = path.stat().st_size
        path.unlink()


def interrupted(case, path, rng, numbers, count):
    """End a run of the case up to MOST times by signals of ``numbers``, let it come to its end, compare."""
    for _ in range(rng.randint(1, MOST)):
        number = rng.choice(numbers)
        child = forked(listening_resume, case.deck, path, INTERVAL)
        time.sleep(rng.uniform(0.0, 0.8) * case.duration)
        os.kill(child, number)
        code = ended(child)
        if code == 0:
            count["ended before"] += 1
        elif code == -number:  # killed, or a signal that came before the process listened
            count["killed" if number == signal.SIGKILL else "not yet listening"] += 1
        else:
            assert code == EXIT_CODES[number], (code, number)
            count[signal.Signals(number).name] += 1
        if path.exists():
            verify(path)
            with open_results(path) as results:
                count["with a checkpoint" if results.checkpoint else "without a checkpoint"] += 1
        else:
            count["before the file"] += 1
    complete(case, path)


def complete(case, path):
    """Resume to the end, compare, and leave nothing."""
    assert ended(forked(listening_resume, case.deck, path, INTERVAL)) == 0
    assert "all bytes are unchanged" in verify(path)
    check_same(contents(path), case.whole)
    path.unlink()


def full_disks(cases, folder, levels, count):
    """Run on a tmpfs of each size, from 20 KB to what the files need, then with more room."""
    mount = ["mount", "-t", "tmpfs", "-o", "size=16m", "tmpfs", str(folder)]
    subprocess.run(mount, check=True)
    try:
        for level in range(levels):
            case = cases[level % len(cases)]
            size = 20_000 + (case.size - 20_000) * (level + 1) / levels
            path = folder / "r.h5"
            resize(folder, int(size))
            code = ended(forked(listening_resume, case.deck, path, INTERVAL))
            assert code in (0, 5), code
            count["came to its end" if code == 0 else "full"] += 1
            if code and path.exists():
                reported = verify(path)
                with open_results(path) as results:
                    assert results.status == "failed", reported
                    assert results.time.tobytes() == case.whole["time"][: len(results.time)].tobytes()
                    count["with a checkpoint" if results.checkpoint else "without a checkpoint"] += 1
            assert os.listdir(folder) in ([], ["r.h5"])
            resize(folder, 2**24)
            complete(case, path)
    finally:
        subprocess.run(["umount", str(folder)], check=True)


def resize(folder, size):
    subprocess.run(["mount", "-o", f"remount,size={size}", str(folder)], check=True)


def main(kills=200, signals=200, levels=100):
    with tempfile.TemporaryDirectory() as name:
        folder, rng = Path(name), random.Random(6)
        cases = [Case(deck, folder) for deck in decks().values()]
        for what, numbers, times in (("kill -9", (signal.SIGKILL,), kills), ("signals", SIGNALS, signals)):
            count = Counter()
            while sum(count[ending] for ending in ENDINGS) < times:
                count["runs"] += 1
                interrupted(cases[count["runs"] % len(cases)], folder / "r.h5", rng, numbers, count)
            print(f"{what}: all runs equal, bit for bit; {dict(count)}", flush=True)
        count = Counter()
        if levels:
            full_disks([cases[0], *[Case(long_deck(), folder)] * 3], folder, levels, count)
            print(f"full disks: {levels} runs equal, bit for bit; {dict(count)}")


if __name__ == "__main__":
    main(*map(int, sys.argv[1:]))
