"""Damage to files, and what commands make of it: nothing may be silently wrong, end by a signal or in a traceback.

    python tests/scorecard/damage.py [TRIALS [SEED]]

Each trial damages a finished or a killed results file, or a file of modes, and lets a command read it in a fork of this
process. A command may end with exit code 5 and a message that names the file, or with 0; then what it shows is what it
shows of the whole file, unless it says itself that the file is cut short.
"""

import os
import random
import signal
import sys
import tempfile
from collections import Counter
from pathlib import Path

HERE = Path(__file__).parent
INPUTS = HERE.parent.parent / "inputs"
PATIENCE = 60  # s for a command


def damage(data, rng):
    """Return (damaged bytes, description) of the bytes of a file; ``rng`` a random.Random."""
    kind = rng.choice((_flip, _flip, _flip_in_text, _cut, _zero, _zero_the_end, _scramble))
    return kind(bytearray(data), rng)


def _flip(data, rng):
    bits = [rng.randrange(8 * len(data)) for _ in range(rng.choice((1, 1, 2, 30)))]
    for bit in bits:
        data[bit // 8] ^= 1 << bit % 8
    return bytes(data), f"bits flipped in bytes {sorted(bit // 8 for bit in bits)}"


def _flip_in_text(data, rng):
    """In an attribute, a name or JSON: wherever there are letters."""
    for _ in range(1000):
        place = rng.randrange(len(data) - 8)
        if bytes(data[place : place + 8]).isascii() and bytes(data[place : place + 8]).decode().isprintable():
            break
    data[place] ^= 1 << rng.randrange(8)
    return bytes(data), f"a bit flipped in the text at byte {place}"


def _cut(data, rng):
    size = rng.choice((rng.randrange(len(data)), len(data) - rng.randrange(1, 2000)))
    return bytes(data[:size]), f"cut to {size} of {len(data)} bytes"


def _zero(data, rng):
    place, size = rng.randrange(len(data)), rng.choice((8, 512, 4096, 65536))
    end = min(place + size, len(data))
    data[place:end] = bytes(end - place)
    return bytes(data), f"zeros from byte {place} to {end}"


def _zero_the_end(data, rng):
    place = rng.randrange(len(data))
    data[place:] = bytes(len(data) - place)
    return bytes(data), f"zeros from byte {place} to the end"


def _scramble(data, rng):
    place, size = rng.randrange(len(data)), rng.choice((4, 100, 5000))
    end = min(place + size, len(data))
    data[place:end] = rng.randbytes(end - place)
    return bytes(data), f"random bytes from {place} to {end}"


class Subjects:
    """Whole files in a folder, the commands that read them, and what these show of them.

    ``files``: {name: (bytes, deck, (names of commands,))}.
    """

    def __init__(self, folder, files):
        self.folder, self.files = Path(folder), files
        self.shown = {
            (name, command): self.outcome(data, deck, command)
            for name, (data, deck, commands) in files.items()
            for command in commands
        }

    def outcome(self, data, deck, command):
        """(exit code or minus the signal, all that was shown and written) of a command on a file of these bytes."""
        for old in self.folder.iterdir():
            old.unlink()
        path = self.folder / "r.h5"
        path.write_bytes(data)
        code, said = in_a_fork(_words(command, path, deck), self.folder)
        written = sorted(self.folder.glob("*.csv"))
        return code, said + "".join(one.read_text() for one in written)

    def trial(self, rng):
        """What is wrong with how a command meets a damaged file, or ""; and what it was, for people."""
        name = rng.choice(sorted(self.files))
        data, deck, commands = self.files[name]
        command = rng.choice(commands)
        damaged, description = damage(data, rng)
        code, said = self.outcome(damaged, deck, command)
        about = f"{command} of {name}: {description}: exit {code}: {said[-300:]}"
        return _verdict(code, said, self.shown[name, command][1], command), about


def _words(command, path, deck):
    """Arguments of the command line."""
    return {
        "info": ["info", str(path)],
        "names": ["info", str(path), "--names"],
        "verify": ["verify", str(path)],
        "export": ["export", str(path), "--force"],
        "cells": ["export", str(path), "--vtk", "--force"],
        "post": ["post", str(path), "--plot", "solver.step_size", "--csv", "-o", str(path.parent / "p.png")],
        "resume": ["run", str(deck), "-o", str(path), "--resume", "-q"],
        "modes": ["modes", str(deck), "--at", str(path), "-o", str(path.with_name("m.h5")), "-q"],
    }[command]


def in_a_fork(words, folder, first=lambda: None):
    """(exit code or minus the signal, output and errors) of a command in a fork of this process, and ``first`` before.

    What it says goes through ``said.txt`` in the folder.
    """
    reported = folder / "said.txt"
    child = os.fork()
    if not child:
        _command([str(word) for word in words], reported, first)
    _, status = os.waitpid(child, 0)
    return os.waitstatus_to_exitcode(status), reported.read_text(errors="replace")


def _command(words, reported, first):
    code = 1
    try:
        descriptor = os.open(reported, os.O_WRONLY | os.O_CREAT | os.O_TRUNC)
        os.dup2(descriptor, 1)
        os.dup2(descriptor, 2)
        sys.stdout = sys.stderr = os.fdopen(1, "w", buffering=1, errors="replace")
        signal.signal(signal.SIGALRM, signal.SIG_DFL)  # ends even a loop of the HDF5 library
        signal.alarm(PATIENCE)
        sys.argv = ["mecano", *words]
        from mecano.cli import main

        first()
        main()
        code = 0
    except SystemExit as ended:
        code = ended.code or 0
    except BaseException:
        import traceback

        traceback.print_exc()
    finally:
        sys.stdout.flush()
        os._exit(code)


CUT = ("cut short", "has no checkpoint")  # what commands say of files that are read as far as they reach


def _verdict(code, said, whole, command):
    """What is wrong with an outcome, or ""."""
    if code < 0:
        return f"signal {-code}"
    if "Traceback" in said or code == 1:
        return "traceback"
    if code == 5:
        return "" if "r.h5" in said else "a message that does not name the file"
    if code == 2 and command == "resume":
        return ""  # it is of another deck, says a file that has lost its sums
    if code:
        return f"exit code {code}"
    if command in ("resume", "modes", "cells") or any(text in said for text in CUT):
        return ""
    lines = [line for line in said.splitlines() if line not in whole]
    return "" if not lines else f"silently another output: {lines[0][:80]}"


def subjects(folder):
    """The Subjects of the repository, in a new folder: a finished run, a killed one with a checkpoint, modes."""
    sys.path[:0] = [str(HERE.parent), str(HERE.parent.parent)]
    from surviving import ended, forked

    from mecano.analyses import checkpoint_writer
    from mecano.analyses.dynamic import run
    from mecano.analyses.modal import modes
    from mecano.deck.read import read_deck
    from mecano.post import export, info, pictures  # noqa: F401  once, and not by each fork
    from mecano.solve.modal import modes_dense  # noqa: F401

    made = Path(folder) / "made"
    made.mkdir()
    deck = made / "deck.yaml"
    deck.write_text((INPUTS / "bouncing_ball.yaml").read_text().replace("end: 5", "end: 4"))
    checked = read_deck(str(deck), ())
    run(checked, made / "finished.h5")

    def run_and_die():
        checkpoint_writer.SHARE = 0
        run(checked, made / "killed.h5", interval=0.0, observers=(lambda a: a.run.steps < 200 or os._exit(9),))

    assert ended(forked(run_and_die)) == 9
    modes(checked, made / "modes.h5")
    every = ("info", "names", "verify", "export", "post", "cells", "resume", "modes")
    files = {
        "a finished run": ((made / "finished.h5").read_bytes(), deck, every),
        "a killed run": ((made / "killed.h5").read_bytes(), deck, tuple(c for c in every if c != "cells")),
        "modes": ((made / "modes.h5").read_bytes(), deck, ("info", "verify")),
    }
    (Path(folder) / "trial").mkdir()
    return Subjects(Path(folder) / "trial", files)


def main(trials=2000, seed=1):
    """Try so many damages; print those after which a command did not end as it should, and how the others ended."""
    rng, ends, wrong = random.Random(seed), Counter(), 0
    with tempfile.TemporaryDirectory() as folder:
        tried = subjects(folder)
        for _ in range(trials):
            verdict, about = tried.trial(rng)
            ends[about.split(" of ")[0], about.partition(": exit ")[2].partition(":")[0]] += 1
            if verdict:
                wrong += 1
                print(f"{verdict}: {about}\n", flush=True)
    for (command, code), count in sorted(ends.items()):
        print(f"{command:10} exit code {code:>3}: {count}")
    print(f"{wrong} of {trials} are wrong")
    return wrong


if __name__ == "__main__":
    sys.exit(bool(main(*map(int, sys.argv[1:]))))
