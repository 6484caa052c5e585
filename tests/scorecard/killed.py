"""Lines 4 and 5: runs killed with -9 at random instants, and resumed to the bits of a run that was never stopped."""

import mmap
import random
import signal
import struct
import time
from functools import cache, partial
from pathlib import Path

import numpy as np
from scorecard.outcome import INPUTS, forked, last_line
from scorecard.trial import Job, Line, Trial

LINES = (
    Line(4, "kill -9 at random instants: every acknowledged row readable and equal to the bit", 10, 300),
    Line(5, "resume after kills, chains of up to 20: the bits of a run never stopped", 10, 300),
)
LONGEST_CHAIN = 20
CHAINS = (1, 1, 1, 2, 2, 3, 5, 8, LONGEST_CHAIN)  # kills of one run
DECKS = {  # name -> overrides: runs of some 0.3 s, with many rows
    "nose_gear_rigid": ("time.end=0.4",),  # wheels, struts with corners, adaptive steps
    "deployment_lock": ("time.end=1.2", "output.every=step"),  # a latch that shocks
    "cable_snatch": ("time.step=1e-3", "output.every=step"),  # a cable, taut and slack
    "friction_pendulum": ("time.end=0.7", "output.every=step"),
    "bouncing_ball": ("time.end=3", "time.step=5e-3", "output.every=step"),  # shocks, ever faster
    "double_pendulum": ("time.end=0.1", "time.step=5.0e-5", "output.every=1.0e-4"),  # a file that grows all the while
}


def jobs(lines, factor, seed):
    """A job for each chain of kills; its first kill and each further one count for line 4, the chain for line 5."""
    count = max(round(factor * LINES[1].count), len(DECKS))
    for name in DECKS:
        reference(name)  # here, so that workers have it
    return [Job(5, f"{seed}-{i}", partial(chain, random.Random(f"{seed} killed {i}"), i)) for i in range(count)]


def chain(rng, index, folder):
    """Kill one run several times, look at its file each time, and let it come to its end: Trials."""
    name = list(DECKS)[index % len(DECKS)]
    whole, duration = reference(name)
    path, trials, lost = folder / "r.h5", [], ""
    for kill in range(rng.choice(CHAINS)):
        said = mmap.mmap(-1, 24)
        run = started(name, folder, partial(witnessed, said))
        time.sleep(rng.uniform(0.0, 1.0 if kill == 0 else 0.5) * duration)
        run.kill(signal.SIGKILL)
        outcome = run.ended()
        why = unlike(outcome) or (
            lost_rows(held(path), struct.unpack("3q", said), whole) if path.exists() else unmade(said)
        )
        lost = lost or why
        trials.append(Trial(4, f"{name} kill {kill + 1} of chain {index}", why))
    outcome = started(name, folder).ended()
    why = lost or (
        f"exit code {outcome.code}: {last_line(outcome.err)}" if outcome.code else differs(held(path), whole)
    )
    return [*trials, Trial(5, f"{name} chain {index} of {len(trials)} kills", why)]


def arguments(name, output="r.h5"):
    """The command that begins or resumes a run of a deck."""
    settings = [word for text in DECKS[name] for word in ("--set", text)]
    return ["run", INPUTS / f"{name}.yaml", "-o", output, "--resume", "--checkpoint", "0", "--quiet", *settings]


def started(name, folder, before=lambda: None):
    """The command in a fork, with a checkpoint whenever three times as long as the last one took has gone by."""

    def prepared():
        import mecano.analyses.checkpoint_writer

        mecano.analyses.checkpoint_writer.SHARE = 3
        before()

    return forked(arguments(name), folder, prepared)


def witnessed(said):
    """Let this process say in shared memory, as soon as each flush has returned, how many rows it has acknowledged."""
    from mecano.results.writer import Writer

    flush = Writer.flush

    def flushed(writer):
        count = flush(writer)
        said[:] = struct.pack("3q", count, writer._steps.written, writer._events.written)
        return count

    Writer.flush = flushed


@cache
def reference(name):
    """(what a run without a stop leaves, how long it takes [s])."""
    import tempfile

    with tempfile.TemporaryDirectory() as folder:
        outcome = started(name, folder).ended()  # modules are imported, code is compiled
        assert outcome.code == 0, outcome.err
        Path(folder, "r.h5").unlink()
        outcome = started(name, folder).ended()
        return held(Path(folder, "r.h5")), outcome.seconds


def held(path):
    """All that a results file holds, or the error of reading it: dict, or text."""
    import mecano
    from mecano.errors import MecanoError

    try:
        with mecano.open_results(path) as results:
            return {name: results[name].values for name in results.names()} | {
                "time": results.time, "steps": results.steps, "events": results.events, "status": results.status,
                "extremes": results.extremes, "reason": results.reason,
            }  # fmt: skip
    except MecanoError as error:
        return str(error)


def unlike(outcome):
    """Why a process that was killed did not end as one: by the signal, or as a run that came to its end before."""
    return "" if outcome.code in (-signal.SIGKILL, 0) else f"exit code {outcome.code}: {last_line(outcome.err)}"


def unmade(said):
    """Why there may not be no file."""
    return "rows were acknowledged, and there is no file" if struct.unpack("3q", said)[0] else ""


def lost_rows(found, said, whole):
    """Why a file does not hold what was acknowledged: (saved times, steps, events) of ``said``; or empty.

    ``found`` and ``whole`` are what ``held`` returns, of the file and of a run that was never stopped.
    """
    if isinstance(found, str):
        return f"cannot be read: {found}"
    for what, promised in zip(("time", "steps", "events"), said, strict=True):
        if len(found[what]) < promised:
            return f"{promised} {what} acknowledged, {len(found[what])} there"
    if found["events"] != whole["events"][: len(found["events"])]:
        return "other events"
    for name, rows in found.items():
        if isinstance(rows, np.ndarray) and rows.tobytes() != whole[name][: len(rows)].tobytes():
            return f"{name}: other bits"
    return ""


def differs(found, whole):
    """What of a file is not as in that of a run that was never stopped; or empty."""
    if isinstance(found, str):
        return f"cannot be read: {found}"
    if found.keys() != whole.keys():
        return f"other series: {sorted(found.keys() ^ whole.keys())[:3]}"
    for name, value in whole.items():
        same = found[name].tobytes() == value.tobytes() if isinstance(value, np.ndarray) else found[name] == value
        if not same:
            return f"{name}: other values"
    return ""
