"""What a run says while it goes on: a bar on a terminal, plain lines otherwise."""

import os
import shutil
import sys
import time
from textwrap import wrap

from mecano.jit.store import before_compiling, compile_time

BAR = 30  # characters
INTERVAL = 0.1  # s between redrawings of the bar
LINES = 10  # plain lines for a whole run
WIDTH = 110  # characters of a note, or the width of the terminal
NOTICED = 0.01  # s for compiling
COMPILING = "compiling elements used for the first time: this takes a minute or two, once"


class Progress:
    """Reporter of a march; all output goes to the standard error stream."""

    def __init__(self, values, quiet, path):
        self.start, self.end, self.path = values["start"], values["end"], path
        self.quiet, self.terminal = quiet, sys.stderr.isatty()
        self.begun = self.drawn = time.monotonic()
        self.compiled = compile_time()
        self.tenths, self.marching = 0, None

    def announce_compiling(self):
        """Report, before the first function is compiled, that this takes a while; nothing where none is."""
        before_compiling(lambda: self.note(COMPILING))

    def note(self, text):
        """A text on lines of its own."""
        if not self.quiet:
            self._clear()
            width = min(shutil.get_terminal_size((WIDTH, 24)).columns, WIDTH) if self.terminal else WIDTH
            lines = wrap(
                f"mecano: {text}", width, subsequent_indent="  ", break_long_words=False, break_on_hyphens=False
            )
            self._say("\n".join(lines) + "\n")

    def __call__(self, run):
        """Show simulated time, step size and the time that is left."""
        if self.quiet:
            return
        now, share = time.monotonic(), self._share(run)
        self.marching = self.marching or (now, share)
        if self.terminal and now - self.drawn >= INTERVAL:
            self.drawn = now
            filled = int(BAR * share)
            bar = "#" * filled + "." * (BAR - filled)
            self._say(f"\r[{bar}] {self._numbers(run, now, share)}\x1b[K")
        elif not self.terminal and int(LINES * share) > self.tenths:
            self.tenths = int(LINES * share)
            self._say(f"{self._numbers(run, now, share)}\n")

    def done(self, run):
        """The last lines: how it went and where the results are."""
        self.finished(
            f"{run.steps} steps, {run.rejected} rejected, {run.iterations} Newton iterations with those of rejected "
            "steps"
        )

    def finished(self, text):
        """The last lines: what was done, in how long, and where the results are."""
        compiling = compile_time() - self.compiled
        more = f" and {compiling:.2f} s for compiling" if compiling >= NOTICED else ""
        self.note(f"{text}, in {time.monotonic() - self.begun - compiling:.2f} s{more}")
        self.note(f"results in {self.path}")

    def _share(self, run):
        return (run.motion.t - self.start) / (self.end - self.start)

    def _numbers(self, run, now, share):
        begun, first = self.marching
        text = f"t = {run.motion.t:.4g} of {self.end:g} s, step {run.h:.2g} s"
        return f"{text}, {(now - begun) * (1 - share) / (share - first):.0f} s left" if share > first else text

    def _clear(self):
        if self.terminal:
            self._say("\r\x1b[K")

    def _say(self, text):
        """Print; continue the run in silence when the terminal is gone or nobody reads."""
        try:
            print(text, end="", file=sys.stderr, flush=True)
        except OSError:
            self.quiet = True
            os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stderr.fileno())


class StaticProgress(Progress):
    """Observer of the points of a path of equilibria; a line for each of the first, then ever fewer."""

    def __init__(self, values, quiet, path):
        super().__init__({"start": 0.0, "end": values["end"]}, quiet, path)
        self.what = "t =" if values["over"] == "time" else "load factor"
        self.points, self.iterations, self.rejected = -1, 0, 0

    def __call__(self, point):
        """Show where the path is, and how the point was found."""
        self.points += 1
        self.iterations += point.iterations
        self.rejected += point.rejected
        now = time.monotonic()
        if not self.quiet and (self.points <= LINES or now - self.drawn >= 1.0):
            self.drawn = now
            unstable = point.stability.unstable
            text = f", {unstable} unstable direction(s)" if unstable > 0 else ""
            self._say(f"{self.what} {point.parameter:.6g}: {point.iterations} iterations{text}\n")

    def done(self, point):
        """The last line."""
        self.finished(
            f"{self.points} steps, {self.rejected} rejected, {self.iterations} Newton iterations; "
            f"{self.what} {point.parameter:.6g}"
        )


class SweepProgress(Progress):
    """Told of every state of a sweep of modes: a bar on a terminal, else a line for each tenth of a long one."""

    LONG = 50  # states
    WHAT = "states"

    def __init__(self, quiet, path):
        super().__init__({"start": 0.0, "end": 1.0}, quiet, path)

    def __call__(self, done, total, text):
        """Show how many states are done, which was the last, and the time that is left."""
        now, share = time.monotonic(), done / total
        left = (now - self.begun) * (1 - share) / share
        numbers = f"{done} of {total} {self.WHAT}, {text}, {left:.0f} s left"
        if self.quiet:
            return
        if self.terminal and now - self.drawn >= INTERVAL:
            self.drawn = now
            filled = int(BAR * share)
            self._say(f"\r[{'#' * filled + '.' * (BAR - filled)}] {numbers}\x1b[K")
        elif not self.terminal and total >= self.LONG and int(LINES * share) > self.tenths:
            self.tenths = int(LINES * share)
            self._say(f"{numbers}\n")

    def done(self, total):
        """The last lines."""
        self.finished(f"{total} {self.WHAT}")


class StudyProgress(SweepProgress):
    """Told of every case of a study as it ends."""

    LONG, WHAT = LINES, "cases"
