"""Progress of a run: a bar on a terminal, plain lines otherwise."""

import math
import os
import sys
import time
from collections import deque
from textwrap import wrap
from typing import TYPE_CHECKING

from mecano.jit.machine_code import compile_time, while_compiling

if TYPE_CHECKING:
    from contextlib import AbstractContextManager

    from mecano.schema import Values
    from mecano.solve.statics.continuation import Point
    from mecano.solve.time.run_state import RunState

BAR = 30  # characters
INTERVAL = 0.1  # s between redrawings of the bar
LINES = 10  # plain lines for a whole run
LONGEST = 60.0  # s between plain lines
PACE, SAMPLED = 30.0, 1.0  # s over which the pace is measured, between its samples
WIDTH = 110  # characters of a note, at most; less on a narrower terminal
NOTICED = 0.01  # s, least compile time reported
COMPILING = "compiling elements used for the first time, once; usually less than a minute"


class Messages:
    """Messages about a run on the standard error stream: notes, progress of the compilation, the last lines."""

    def __init__(self, quiet: bool, path: str | os.PathLike[str]):
        self.quiet, self.path, self.terminal = quiet, path, sys.stderr.isatty()
        self.begun = self.drawn = time.monotonic()
        self.compiled = compile_time()
        self.announced, self.tenths = False, 0

    def announcing_compiling(self) -> "AbstractContextManager[None]":
        """Within the block, print a note before the first function is compiled, and show the number compiled."""
        return while_compiling(self._show_compiling)

    def _show_compiling(self, done, n):
        if not self.announced:
            self.announced = True
            self.note(COMPILING)
        if self.terminal and not self.quiet and n > 1:
            self._say(f"\r[{_bar(done / n)}] compiled {done} of {n}\x1b[K" if done < n else "\r\x1b[K")

    def note(self, text: str) -> None:
        """Print a text on separate lines."""
        if not self.quiet:
            self._clear()
            width = WIDTH
            if self.terminal:
                from shutil import get_terminal_size  # takes long to import

                width = min(get_terminal_size((WIDTH, 24)).columns, WIDTH)
            lines = wrap(
                f"mecano: {text}", width, subsequent_indent="  ", break_long_words=False, break_on_hyphens=False
            )
            self._say("\n".join(lines) + "\n")

    def show(self, share: float, numbers: str, by_tenths: bool = True) -> None:
        """Show the ``share`` of the work done: a bar on a terminal, otherwise a line for each tenth and each minute."""
        now = time.monotonic()
        if self.terminal and now - self.drawn >= INTERVAL:
            self.drawn = now
            self._say(f"\r[{_bar(share)}] {numbers}\x1b[K")
        elif not self.terminal and by_tenths and (int(LINES * share) > self.tenths or now - self.drawn >= LONGEST):
            self.tenths, self.drawn = int(LINES * share), now
            self._say(f"{numbers}\n")

    def finished(self, text: str) -> None:
        """Print the last lines: ``text``, elapsed time, results file."""
        compiling = compile_time() - self.compiled
        more = f" and {compiling:.2f} s for compiling" if compiling >= NOTICED else ""
        self.note(f"{text}, in {time.monotonic() - self.begun - compiling:.2f} s{more}")
        self.note(f"results in {self.path}")

    def _clear(self):
        if self.terminal:
            self._say("\r\x1b[K")

    def _say(self, text):
        """Print; if the terminal or the reader of the stream is gone, continue without output."""
        try:
            print(text, end="", file=sys.stderr, flush=True)
        except OSError:
            self.quiet = True
            os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stderr.fileno())


class Progress(Messages):
    """Progress of a dynamic run, called between steps; ``values`` are the section ``time`` of the deck."""

    def __init__(self, values: "Values", quiet: bool, path: str | os.PathLike[str]):
        super().__init__(quiet, path)
        self.start, self.end = values["start"], values["end"]
        late = max(abs(self.start), abs(self.end)) / (self.end - self.start)
        self.digits = 4 + int(math.log10(late))  # of times, enough to show a hundredth of the run
        self.passed: deque[tuple[float, float]] = deque()  # wall-clock time [s] and share of the run, of late

    def __call__(self, run: "RunState") -> None:
        """Show simulated time, step size and remaining time."""
        if self.quiet:
            return
        now, share = time.monotonic(), (run.motion.t - self.start) / (self.end - self.start)
        if not self.passed or now - self.passed[-1][0] >= SAMPLED:
            self.passed.append((now, share))
        while now - self.passed[0][0] > PACE and len(self.passed) > 1:
            self.passed.popleft()
        text = f"t = {run.motion.t:.{self.digits}g} of {self.end:.{self.digits + 2}g} s, step {run.h:.2g} s"
        self.show(share, text + self._left(now, share))

    def _left(self, now, share):
        """Return the remaining wall-clock time at the present pace, as text; "" before it is known."""
        then, before = self.passed[0]
        return f", {(now - then) * (1 - share) / (share - before):.0f} s left" if share > before else ""

    def done(self, run: "RunState") -> None:
        """Print the last lines: numbers of steps and iterations, elapsed time, results file."""
        self.finished(
            f"{run.steps} steps, {run.rejected} rejected, {run.iterations} Newton iterations including rejected steps"
        )


def _bar(share):
    filled = int(BAR * share)
    return "#" * filled + "." * (BAR - filled)


class StaticProgress(Messages):
    """Observer of the points of an equilibrium path: a line for each of the first, then at most one per second.

    ``values`` are the section ``static`` of the deck.
    """

    def __init__(self, values: "Values", quiet: bool, path: str | os.PathLike[str]):
        super().__init__(quiet, path)
        self.what = "t =" if values["over"] == "time" else "load factor"
        self.points, self.iterations, self.rejected = -1, 0, 0

    def __call__(self, point: "Point") -> None:
        """Show the parameter, the iterations and the number of unstable directions."""
        self.points += 1
        self.iterations += point.iterations
        self.rejected += point.rejected
        now = time.monotonic()
        if not self.quiet and (self.points <= LINES or now - self.drawn >= 1.0):
            self.drawn = now
            unstable = point.stability.unstable
            text = f", {unstable} unstable direction(s)" if unstable > 0 else ""
            self._say(f"{self.what} {point.parameter:.6g}: {point.iterations} iterations{text}\n")

    def done(self, point: "Point") -> None:
        """Print the last lines."""
        self.finished(
            f"{self.points} steps, {self.rejected} rejected, {self.iterations} Newton iterations; "
            f"{self.what} {point.parameter:.6g}"
        )


class SweepProgress(Messages):
    """Progress of a sweep of modes: a bar on a terminal, otherwise a line for each tenth of a long sweep."""

    LONG = 50  # states
    WHAT = "states"

    def __call__(self, done: int, total: int, text: str) -> None:
        """Show the number of states computed, the last of them, and the estimated remaining time."""
        if self.quiet:
            return
        share = done / total
        left = (time.monotonic() - self.begun) * (1 - share) / share
        numbers = f"{done} of {total} {self.WHAT}, {text}, {left:.0f} s left"
        self.show(share, numbers, by_tenths=total >= self.LONG)

    def done(self, total: int) -> None:
        """Print the last lines."""
        self.finished(f"{total} {self.WHAT}")


class StudyProgress(SweepProgress):
    """Progress of a study, called as each case ends."""

    LONG, WHAT = LINES, "cases"
