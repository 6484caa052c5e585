"""Line 1: mutated decks and studies, checked, run to a tiny end and swept: refused with a place, or read."""

import os
import random
import shutil
import tempfile
from functools import cache, partial
from pathlib import Path

from scorecard.outcome import DOCUMENTED, INPUTS, in_command, in_process, unfit, unplaced
from scorecard.trial import Job, Line

LINES = (
    Line(
        1,
        "malformed decks and studies, in process and as commands: exit 2 with file:line:column, or a documented code",
        10,
        102_000,
    ),
)
COMMANDS = 2_000  # of 102,000: through the command
RUNS, SWEEPS = 25, 500  # one of so many trials is a run, a sweep
LARGE, LARGE_SHARE = ("reflector", "reflector_template"), 0.02  # which take 0.3 s each
CHECK_CPU, RUN_CPU = 6.0, 60.0  # s
STUDIES = (
    "study: 1\ntitle: Two\ndeck: pendulum.yaml\nset: {time.end: 2 ms}\ngrid:\n  elements.bar.mass: [1, 2 kg]\n"
    "outputs:\n  last: {of: hinge.angle, take: final}\n",
    "study: 1\ndeck: bouncing_ball.yaml\nset: {time.end: 0.01, time.step: 1e-3}\n"
    "list: [{elements.ball.mass: 1, contact.restitution: 0.5}]\n"
    "outputs: {hits: {event: contact touches, take: count}}\n",
    "study: 1\ndeck: oscillator.yaml\nset: {time.end: 5e-3}\n"
    "latin_hypercube: {ranges: {elements.mass.mass: [1, 3]}, number: 2, seed: 1}\n"
    "outputs: {low: {of: weight.position.z, take: min}}\n",
)


def jobs(lines, factor, seed):
    """Trials in process, then through the command."""
    names = sorted(path.stem for path in INPUTS.glob("*.yaml"))
    for i in range(max(round(factor * LINES[0].count), 200)):
        rng = random.Random(f"{seed} malformed {i}")
        name = rng.choice(names)
        if name in LARGE and rng.random() > LARGE_SHARE * len(names) / len(LARGE):
            name = "pendulum"
        through = in_command if i % (LINES[0].count // COMMANDS) == 0 else in_process
        if i % SWEEPS == 1:
            yield Job(1, f"study {i}", partial(sweep, rng, through), cpu=RUN_CPU)
        elif i % RUNS == 2:
            yield Job(1, f"{name} run {i}", partial(run, name, rng, through), cpu=RUN_CPU)
        else:
            yield Job(1, f"{name} {i}", partial(check, name, rng, through), cpu=CHECK_CPU)


@cache
def place(process):
    """A folder of this process with all inputs, beside which decks lie."""
    folder = Path(tempfile.mkdtemp(prefix="scorecard-inputs"))
    for path in INPUTS.iterdir():
        if path.is_file():
            shutil.copy(path, folder)
    return folder


def spoiled(text, rng):
    """Bytes of a mutated text; some are bytes at random."""
    from scorecard.mutate import mutate

    data = mutate(text, rng).encode("utf-8", "surrogatepass")
    if rng.random() < 0.15:
        at = rng.randrange(len(data) + 1)
        new = bytes(rng.randrange(256) for _ in range(rng.choice([1, 1, 2, 8])))
        data = data[:at] + new + data[at + rng.choice([0, len(new)]) :]
    return data


def settings(rng):
    """Options --set in some decks, with mutated values."""
    from scorecard.mutate import mutate

    if rng.random() > 0.15:
        return []
    text = mutate(
        rng.choice(["time.step=1e-3", "elements.bar.mass=2", "title=x", "gravity=[0, 0, 0]", "time.end=1"]), rng
    )
    return ["--set", text.replace("\0", "").encode("utf-8", "replace").decode()]


def written(data, folder, name="deck.yaml"):
    """The folder of a file with these bytes, which is kept if it is not handled well."""
    (folder / name).write_bytes(data)
    beside = place(os.getpid())
    (beside / name).write_bytes(data)
    return beside


def check(name, rng, through, folder):
    beside, words = written(spoiled((INPUTS / f"{name}.yaml").read_text(), rng), folder), settings(rng)
    (folder / "command.txt").write_bytes(" ".join(["check", "deck.yaml", *words]).encode("utf-8", "replace"))
    return judged(through(["check", "deck.yaml", *words], beside))


def judged(outcome):
    """Why a deck was not checked as it should be; empty where it was read, or refused with a place."""
    if why := unfit(outcome, (0, 2, 4, 6)):
        return why
    if outcome.code == 2:
        return unplaced(outcome)
    if outcome.code == 0 and outcome.err:
        return f"something on the terminal besides: {outcome.err[:80]!r}"
    return "" if outcome.code == 0 or outcome.err.startswith("mecano: ") else f"no message: {outcome.err[:80]!r}"


def run(name, rng, through, folder):
    text = (INPUTS / f"{name}.yaml").read_text()
    beside, words = written(spoiled(text, rng), folder), settings(rng)
    tiny = ["--set", "time.end=2e-3"] if "\ntime:" in text and rng.random() < 0.8 else []
    command = ["run", "deck.yaml", "-o", "r.h5", "--force", "--quiet", *tiny, *words]
    command += [] if "\nstatic:" in text else ["--max-walltime", "2s"]
    (folder / "command.txt").write_bytes(" ".join(command).encode("utf-8", "replace"))
    outcome = through(command, beside)
    return unfit(outcome, DOCUMENTED, cpu=RUN_CPU) or (place_or_option(outcome) if outcome.code == 2 else "")


def place_or_option(outcome):
    """As ``unplaced``; what is wrong with --max-walltime stands in no deck."""
    return "" if "max-walltime" in outcome.err else unplaced(outcome)


def sweep(rng, through, folder):
    beside = written(spoiled(rng.choice(STUDIES), rng), folder, "study.yaml")
    shutil.rmtree(beside / "runs", ignore_errors=True)
    outcome = through(["sweep", "study.yaml", "-o", "runs", "--force", "--time-limit", "5s"], beside)
    return unfit(outcome, (0, 2, 3), cpu=RUN_CPU) or (unplaced(outcome) if outcome.code == 2 else "")
