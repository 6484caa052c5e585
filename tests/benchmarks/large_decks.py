"""`mecano check` of large decks: nodes in a straight line and a beam between each two, written out or by ``repeat``.

    python tests/benchmarks/large_decks.py [nodes ...]

CPU time and memory of the whole command, each in a process of its own. Recorded in docs/benchmarks.md.
"""

import resource
import subprocess
import sys
import tempfile
from pathlib import Path

MOST_REPEATED = 25_000  # decks may not repeat more

HEAD = """\
mecano: 1
gravity: [0, 0, 0]
sections:
  tube: {type: tube, diameter: 0.05, thickness: 0.003, E: 70e9, nu: 0.33, density: 2700}
time: {end: 1, step: 1e-3}
"""


def written(count):
    """The deck with every node and beam on a line of its own."""
    nodes = [f"  n{i}: {{position: [{0.1 * i:.6g}, 0, {0.01 * (i % 7):.6g}]}}" for i in range(count + 1)]
    beams = [f"  b{i}: {{type: beam, nodes: [n{i - 1}, n{i}], section: tube}}" for i in range(1, count + 1)]
    return HEAD + "\n".join(["nodes:", *nodes, "elements:", *beams, ""])


def repeated(count):
    """The same in two lines."""
    return HEAD + (
        f"nodes:\n  n$i: {{repeat: {{i: 0..{count}}}, position: [0.1 * $i, 0, 0.01 * ($i % 7)]}}\n"
        f"elements:\n  b$i: {{repeat: {{i: 1..{count}}}, type: beam, nodes: [n$(i - 1), n$i], section: tube}}\n"
    )


def measured(path):
    """(CPU time [s], memory [MB]) of the command on a deck."""
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    command = [sys.executable, "-c", "from mecano.cli import program; program()", "check", str(path)]
    subprocess.run(command, stdout=subprocess.DEVNULL, check=True)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime, after.ru_maxrss / 1024


def main():
    """Check every size, the smallest first, so that the memory is its own."""
    counts = sorted(int(text) for text in sys.argv[1:]) or [10_000, 100_000]
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "deck.yaml"
        path.write_text(written(10))
        measured(path)  # compiles
        for count in counts:
            for name, make in (("written out", written), ("repeated", repeated)):
                if name == "repeated" and count > MOST_REPEATED:
                    continue
                path.write_text(make(count))
                cpu, memory = measured(path)
                print(f"{count:7d} beams, {name}: {cpu:.2f} s of CPU, {memory:.0f} MB", flush=True)


if __name__ == "__main__":
    main()
