"""Line 6: disks that are full, read-only or gone, files that may not grow, and files of running simulations."""

import os
import random
import resource
import shutil
import signal
import struct
import subprocess
import sys
import time
from functools import partial
from mmap import mmap

from scorecard.damaged import ended
from scorecard.killed import DECKS, arguments, differs, held, lost_rows, reference, started, witnessed
from scorecard.outcome import forked, in_process, last_line, unfit
from scorecard.trial import Job, Line

LINES = (
    Line(
        6, "full, read-only, forbidden, vanishing disks and files of running simulations: exit 5, nothing lost", 7, 150
    ),
)
SIZES, LIMITS = 100, 25  # of 150: sizes of a disk, of a file
ROOM = 2**24  # bytes
NOBODY = 65534
TRIES = 10
SETTLED = 15.0  # s for the other run to write its first rows


def jobs(lines, factor, seed):
    """Trials of each sort in their shares of a full run."""
    for name in DECKS:
        reference(name)
    rng = random.Random(f"{seed} disk")
    for sort, share in ((full_disk, SIZES), (full_file, LIMITS)):
        for i in range(max(round(factor * share), 1)):
            name = list(DECKS)[i % len(DECKS)]
            yield Job(6, f"{sort.__name__} {name} {i}", partial(sort, name, rng.uniform(0.02, 1.05)))
    others = list(OTHERS)
    for i in range(max(round(factor * (LINES[0].count - SIZES - LIMITS)), len(others) if factor >= 1 else 1)):
        sort = others[i % len(others)]
        yield Job(6, f"{sort.__name__} {i}", partial(sort, rng.uniform(0.0, 1.0)))


def full_disk(name, share, folder):
    """A tmpfs of ``share`` of the size that the file comes to; then one with more room."""
    place, size = folder / "disk", len_of(name, folder)
    place.mkdir()
    mounted = subprocess.run(
        ["mount", "-t", "tmpfs", "-o", f"size={int(share * size)}", "tmpfs", place], capture_output=True
    )
    if mounted.returncode:
        return "no tmpfs can be mounted here: a scorecard needs that"
    try:
        why = filled(name, place)
        subprocess.run(["mount", "-o", f"remount,size={ROOM}", place], check=True)
        return why or completed(name, place)
    finally:
        subprocess.run(["umount", "-l", place], check=True)


def full_file(name, share, folder):
    """A limit on the size of a file (RLIMIT_FSIZE); then none."""
    size = int(share * len_of(name, folder))

    def limited():
        sys.dont_write_bytecode = True  # Python would leave incomplete files
        resource.setrlimit(resource.RLIMIT_FSIZE, (size, size))

    return filled(name, folder, limited) or completed(name, folder)


def len_of(name, folder):
    """Bytes of the results file of a run without a stop."""
    outcome = started(name, folder).ended()
    assert outcome.code == 0, outcome.err
    size = (folder / "r.h5").stat().st_size
    (folder / "r.h5").unlink()
    return size


def filled(name, folder, before=lambda: None):
    """A run that may be met by a full disk: exit code 0 or 5, and a file with all that was acknowledged."""
    said = mmap(-1, 24)

    def both():
        witnessed(said)
        before()

    outcome, path = started(name, folder, both).ended(), folder / "r.h5"
    if why := unfit(outcome, (0, 5)):
        return why
    if not path.exists():
        return "" if outcome.code == 5 and not struct.unpack("3q", said)[0] else "no file is left"
    found = held(path)
    why = lost_rows(found, struct.unpack("3q", said), reference(name)[0])
    wanted = "complete" if outcome.code == 0 else "failed"
    return why or (
        "" if found["status"] == wanted else f"exit code {outcome.code}, and the file says {found['status']}"
    )


def completed(name, folder):
    """With room again: the run comes to the same end."""
    outcome = started(name, folder).ended()
    if outcome.code:
        return f"with room again: exit code {outcome.code}: {last_line(outcome.err)}"
    return differs(held(folder / "r.h5"), reference(name)[0])


def refused(outcome, what=""):
    """Exit code 5 that names ``what``."""
    if why := unfit(outcome, (5,)):
        return why
    return "" if what in outcome.err else f"{what} is not named: {last_line(outcome.err)}"


def ran(folder, output, *more, before=lambda: None):
    """A short run into ``output``."""
    return forked(
        [word for word in arguments("friction_pendulum", output) if word != "--resume"] + list(more), folder, before
    ).ended()


def read_only_disk(_, folder):
    place = folder / "disk"
    place.mkdir()
    subprocess.run(["mount", "-t", "tmpfs", "-o", "ro", "tmpfs", place], check=True)
    try:
        return refused(ran(folder, place / "r.h5"), "r.h5")
    finally:
        subprocess.run(["umount", "-l", place], check=True)


def forbidden_folder(_, folder):
    place = folder / "closed"
    place.mkdir(mode=0o555)
    os.chmod(folder, 0o755)
    return refused(ran(folder, place / "r.h5", before=lambda: os.setuid(NOBODY)), "r.h5")


def forbidden_file(_, folder):
    path = folder / "r.h5"
    path.write_bytes(b"something that is not to be lost")
    path.chmod(0o400)
    os.chmod(folder, 0o555)
    why = refused(ran(folder, path, "--force", before=lambda: os.setuid(NOBODY)), "r.h5")
    return why or ("" if path.read_bytes().startswith(b"something") else "the file was replaced")


def no_folder(_, folder):
    return refused(ran(folder, folder / "nowhere" / "r.h5"), "nowhere")


def a_folder_there(_, folder):
    (folder / "r.h5").mkdir()
    return refused(ran(folder, "r.h5", "--force"), "r.h5")


def name_too_long(share, folder):
    return refused(ran(folder, "n" * (252 + int(1000 * share)) + ".h5"))


def path_too_long(share, folder):
    return refused(ran(folder, "/".join(["d" * 200] * (21 + int(20 * share))) + "/r.h5"))


def device(_, folder):
    return refused(ran(folder, "/dev/full", "--force"), "/dev/full")


def link_to_nowhere(_, folder):
    (folder / "r.h5").symlink_to("nowhere/at/all.h5")
    return dangling(ran(folder, "r.h5"), folder)


def dangling(outcome, folder):
    """A link to nowhere is replaced, or refused; nothing else."""
    if outcome.code == 0:
        return "" if isinstance(held(folder / "r.h5"), dict) else "no file is left"
    return refused(outcome, "r.h5")


def existing(_, folder):
    (folder / "r.h5").write_bytes(b"something that is not to be lost")
    why = refused(ran(folder, "r.h5"), "r.h5")
    return why or (
        "" if (folder / "r.h5").read_bytes() == b"something that is not to be lost" else "the file was changed"
    )


def vanishing_path(share, folder):
    """The folder is removed while the run writes: it must not say that there are results."""
    place = folder / "gone"
    place.mkdir()
    run = started("double_pendulum", place)
    waited(place / "r.h5")
    time.sleep(0.5 * share * reference("double_pendulum")[1])
    os.kill(run.pid, signal.SIGSTOP)  # it does not end while its folder is being removed
    found = held(place / "r.h5")
    complete = ended(run.pid) or (isinstance(found, dict) and found["status"] == "complete")
    shutil.rmtree(place)
    os.kill(run.pid, signal.SIGCONT)
    outcome = run.ended()
    return unfit(outcome, (0, 5)) if complete else refused(outcome)


def waited(path):
    """Wait until a file is there."""
    end = time.monotonic() + SETTLED
    while not path.exists() and time.monotonic() < end:
        time.sleep(0.005)


def stopped_run(folder, share):
    """A run that has begun its file, stopped so that it seems to run, and does not end before the trial is made."""
    for _ in range(TRIES):
        run = started("bouncing_ball", folder)
        waited(folder / "r.h5")
        time.sleep(0.3 * share * reference("bouncing_ball")[1])
        os.kill(run.pid, signal.SIGSTOP)
        if not ended(run.pid):
            return run
        run.ended()  # it had come to its end: this process got no processor in the meantime
        (folder / "r.h5").unlink()
    raise RuntimeError(f"a run has ended before it could be stopped, {TRIES} times")


def live_file(words, share, folder):
    """A second run into the file of a running one: refused, and the first reaches its end unaffected."""
    path = folder / "r.h5"
    run = stopped_run(folder, share)
    second = forked([word for word in arguments("bouncing_ball") if word != "--resume"] + list(words), folder).ended()
    os.kill(run.pid, signal.SIGCONT)
    first = run.ended()
    if first.code:
        return f"the first run: exit code {first.code}: {last_line(first.err)}"
    return refused(second, "r.h5") or differs(held(path), reference("bouncing_ball")[0])


def live_file_plain(share, folder):
    return live_file((), share, folder)


def live_file_forced(share, folder):
    return live_file(("--force",), share, folder)


def live_file_resumed(share, folder):
    return live_file(("--resume",), share, folder)


def export_over_live(share, folder):
    """`export --vtk` into the file of a running simulation is refused."""
    run = stopped_run(folder, share)
    outcome = in_process(["export", "r.h5", "--vtk", "--force"], folder)
    os.kill(run.pid, signal.SIGCONT)
    first = run.ended()
    if first.code:
        return f"the run: exit code {first.code}: {last_line(first.err)}"
    return refused(outcome, "r.h5") or differs(held(folder / "r.h5"), reference("bouncing_ball")[0])


OTHERS = (
    live_file_forced, vanishing_path, read_only_disk, forbidden_folder, live_file_plain, no_folder, a_folder_there,
    name_too_long, live_file_resumed, path_too_long, device, link_to_nowhere, existing, export_over_live,
    forbidden_file,
)  # fmt: skip
