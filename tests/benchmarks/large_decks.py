"""`mecano check` of large decks: nodes in a straight line and a beam between each two, written out or by ``repeat``.

    python tests/benchmarks/large_decks.py [nodes ...]

CPU time and memory of a process of its own for each, the whole command as a user has it; the parts of it in brackets.
Recorded in docs/benchmarks.md.
"""

import resource
import subprocess
import sys
import tempfile
import time
from pathlib import Path

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


def check(path):
    """Check a deck in this process and say what it took."""
    from mecano.deck.read import read_deck
    from mecano.summary import summary

    begun = time.process_time()
    deck = read_deck(path)
    read = time.process_time()
    summary(deck)
    done = time.process_time()
    memory = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
    print(
        f"{done:.2f} s of CPU (imports {begun:.2f}, deck {read - begun:.2f}, model {done - read:.2f}), {memory:.0f} MB"
    )


def main():
    """Check every size in a process of its own."""
    if sys.argv[1:2] == ["--one"]:
        check(sys.argv[2])
        return
    counts = [int(text) for text in sys.argv[1:]] or [10_000, 100_000]
    with tempfile.TemporaryDirectory() as folder:
        for count in counts:
            for name, text in (("written out", written(count)), ("repeated", repeated(min(count, 25_000)))):
                path = Path(folder) / "deck.yaml"
                path.write_text(text)
                one = [sys.executable, __file__, "--one", str(path)]
                found = subprocess.run(one, stdout=subprocess.PIPE, text=True, check=True).stdout.strip()
                print(f"{min(count, 25_000) if name == 'repeated' else count:7d} beams {name}: {found}", flush=True)


if __name__ == "__main__":
    main()
