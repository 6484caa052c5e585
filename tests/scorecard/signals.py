"""Line 13: signals at random instants, the limit of wall-clock time, and studies whose parent is stopped or killed."""

import os
import random
import shutil
import signal
import subprocess
import tempfile
import time
from functools import partial
from pathlib import Path

from scorecard.killed import DECKS, arguments, differs, held, reference, started
from scorecard.outcome import COMMAND, INPUTS, Outcome, in_process, last_line, unfit
from scorecard.trial import Job, Line

LINES = (
    Line(
        13,
        "signals, --max-walltime, studies stopped or killed: answered in 2 s, resumable to the bit, no orphans",
        4,
        200,
    ),
)
CODES = {"SIGINT": 130, "SIGTERM": 143, "SIGUSR1": 75, "SIGHUP": 129, "SIGXCPU": 152}
ANSWER = 2.0  # s, of wall-clock time; on a busy machine of processor time
LATEST = 30.0  # s of wall-clock time, however busy
COMPILING = 8  # of 200: code is compiled anew, which takes a minute
CLOCKS, STUDIES = 20, 20
CASES, SPOILED = 10, 1
GONE = 5.0  # s until the cases of a killed study must have ended


def jobs(lines, factor, seed):
    """Trials of each sort in their shares of a full run."""
    for name in DECKS:
        reference(name)
    rng = random.Random(f"{seed} signals")
    counts = {
        compiling: COMPILING,
        clock: CLOCKS,
        study: STUDIES,
        marching: LINES[0].count - COMPILING - CLOCKS - STUDIES,
    }
    for sort, full in counts.items():
        for i in range(max(round(factor * full), 0 if sort is compiling else 1)):
            yield Job(13, f"{sort.__name__} {i}", partial(sort, i, random.Random(rng.random())))


def marching(i, rng, folder):
    """A signal at a random instant between the start of the process and its end."""
    name, sent = list(DECKS)[i % len(DECKS)], list(CODES)[i // len(DECKS) % len(CODES)]
    path, (whole, _) = folder / "r.h5", reference(name)
    duration = command_time(name)
    process = begun([*arguments(name), "--checkpoint", "1000"], folder)
    time.sleep(rng.uniform(0.0, 1.0) * duration)
    why = answered(process, sent, path)
    if why:
        return why
    outcome = started(name, folder).ended()
    return f"--resume: {last_line(outcome.err)}" if outcome.code else differs(held(path), whole)


TIMES = {}


def command_time(name):
    """How long the command takes [s]."""
    if name not in TIMES:
        with tempfile.TemporaryDirectory() as folder:
            first = time.monotonic()
            begun(arguments(name), folder).wait()
            TIMES[name] = time.monotonic() - first
    return TIMES[name]


def begun(words, folder, **environment):
    """A process of the command line, as a user starts it, also where this one runs under nohup; it says in said.txt."""
    with open(Path(folder) / "said.txt", "ab") as said:
        return subprocess.Popen(
            [*COMMAND, *map(str, words)], cwd=folder, stdin=subprocess.DEVNULL, stdout=said, stderr=said,
            start_new_session=True, env={**os.environ, **environment},
            preexec_fn=lambda: signal.signal(signal.SIGHUP, signal.SIG_DFL),
        )  # fmt: skip


def answered(process, sent, path):
    """Send a signal, and judge how the process ends and what it leaves."""
    number = getattr(signal, sent)
    cpu, first = spent(process.pid), time.monotonic()
    alive = process.poll() is None
    if alive:
        os.kill(process.pid, number)
    ended, seconds, cpu = waited(process, first, cpu)
    said = (path.parent / "said.txt").read_text(errors="replace")
    return judged(Outcome(ended, "", said, cpu, 0.0, seconds), sent, held(path) if path.exists() else None)


def waited(process, first, cpu):
    """(code, seconds, processor time) from a signal to the end of a process, which is killed when it is too late."""
    last = cpu
    while process.poll() is None and time.monotonic() - first < LATEST:
        last = spent(process.pid) or last
        time.sleep(0.005)
    seconds = time.monotonic() - first
    if process.poll() is None:
        process.kill()
        process.wait()
    return process.returncode, seconds, last - cpu


def judged(outcome, sent, found):
    """Why a process has not answered a signal as it should; ``found`` is what ``held`` says of its file, or None.

    The Outcome's cpu and seconds count from the signal on. A process that is not listening yet, and has no file, may
    be ended by the signal itself.
    """
    number = getattr(signal, sent)
    if "Traceback" in outcome.err:
        return f"{sent}: a traceback: {last_line(outcome.err)}"
    if outcome.seconds >= LATEST or min(outcome.seconds, outcome.cpu) > ANSWER:
        return f"{sent} answered after {outcome.seconds:.1f} s, {outcome.cpu:.1f} s of processor time"
    if not (outcome.code in (CODES[sent], 0) or outcome.code == -number and found is None):
        return f"{sent}: exit code {outcome.code}: {last_line(outcome.err)}"
    if isinstance(found, str):
        return f"{sent}: the file cannot be read: {found}"
    if found is not None and found["status"] not in ("complete" if outcome.code == 0 else "stopped",):
        return f"{sent}: exit code {outcome.code}, and the file says {found['status']}"
    return ""


def spent(pid):
    """Processor time of a process [s]; 0 where it is gone."""
    try:
        fields = Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()
    except OSError:
        return 0.0
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")


def compiling(i, rng, folder):
    """A signal while code is compiled; what has been compiled may be used again."""
    sent = list(CODES)[i % len(CODES)]
    store = folder / "store"
    process = begun(["run", INPUTS / "pendulum.yaml", "-o", "r.h5"], folder, MECANO_CACHE_DIR=str(store))
    time.sleep(rng.uniform(1.0, 10.0))
    why = answered(process, sent, folder / "r.h5")
    shutil.rmtree(store, ignore_errors=True)
    return why


def clock(i, rng, folder):
    """--max-walltime: 75 in time, or the end; then --resume to the same bits."""
    name = list(DECKS)[i % len(DECKS)]
    whole, _ = reference(name)
    limit = max(rng.uniform(0.4, 1.1) * command_time(name), 0.5)
    first = time.monotonic()
    process = begun([*arguments(name), "--max-walltime", f"{max(round(limit), 1)}s"], folder)
    code = process.wait()
    seconds, said = time.monotonic() - first, (folder / "said.txt").read_text()
    if why := unfit(Outcome(code, "", said), (0, 75, 2)):
        return why
    if seconds > max(round(limit), 1) + ANSWER:
        return f"limit {max(round(limit), 1)} s, ended after {seconds:.1f} s"
    if code == 2 and "max-walltime" not in said:
        return f"exit code 2: {last_line(said)}"
    outcome = started(name, folder).ended()
    return f"--resume: {last_line(outcome.err)}" if outcome.code else differs(held(folder / "r.h5"), whole)


STUDY = """study: 1
deck: pendulum.yaml
grid: {elements.bar.mass: [%s]}
outputs: {last: {of: hinge.angle, take: final}}
"""


def study(i, rng, folder):
    """Ctrl-C, or kill -9 of the parent of a study of which a tenth of the cases is spoiled."""
    masses = [f"{1 + 0.1 * k:.3g}" for k in range(CASES)]
    for k in rng.sample(range(CASES), SPOILED):
        masses[k] = rng.choice(["-1", "1e300", "none", "1e-300"])
    (folder / "study.yaml").write_text(STUDY % ", ".join(masses))
    shutil.copy(INPUTS / "pendulum.yaml", folder)
    process = begun(["sweep", "study.yaml", "--jobs", "2"], folder)
    time.sleep(rng.uniform(0.5, 6.0))
    sent = ("SIGINT", "SIGKILL", "SIGTERM", "SIGKILL")[i % 4]
    cpu, first = spent(process.pid), time.monotonic()
    if process.poll() is None:
        os.kill(process.pid, getattr(signal, sent))
    code, seconds, _ = waited(process, first, cpu)
    if sent == "SIGKILL":
        end = time.monotonic() + GONE
        while orphans(folder) and time.monotonic() < end:
            time.sleep(0.1)
    if seconds >= LATEST:  # it was killed then, and what it had begun may not have ended yet
        return f"{sent} of a study answered after {seconds:.1f} s"
    left = orphans(folder)
    for pid in left:
        os.kill(pid, signal.SIGKILL)
    if left:
        return f"{sent} of a study leaves {len(left)} processes"
    wanted = {"SIGINT": (130, 3, 2), "SIGTERM": (143, 3, 2), "SIGKILL": (-9, 3, 2)}[sent]
    unheard = code == -getattr(signal, sent) and not (folder / "study_runs").exists()  # nothing had begun
    if code not in wanted and not unheard:
        return f"{sent} of a study: exit code {code}"
    return unresumed(folder)


def orphans(folder):
    """Processes that work in a folder."""
    found = []
    for path in Path("/proc").glob("[0-9]*"):
        try:
            where, words = os.readlink(path / "cwd"), (path / "cmdline").read_bytes()
        except OSError:
            continue
        if int(path.name) != os.getpid() and b"mecano" in words and where.startswith(str(folder)):
            found.append(int(path.name))
    return found


def unresumed(folder):
    """Resume a study: all but what is spoiled must be complete."""
    outcome = in_process(["sweep", "study.yaml", "--jobs", "2", "--resume"], folder)
    if why := unfit(outcome, (0, 3, 2), cpu=LATEST):
        return f"--resume of a study: {why}"
    complete = sum(isinstance(found := held(path), dict) and found["status"] == "complete"
                   for path in (folder / "study_runs").glob("0*.h5"))  # fmt: skip
    return "" if complete >= CASES - SPOILED or outcome.code == 2 else f"{complete} of {CASES} cases are complete"
