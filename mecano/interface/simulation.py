"""Dynamic runs advanced step by step from Python."""

import os
from contextlib import ExitStack, suppress
from functools import cached_property
from typing import Any, Self

import numpy as np

from mecano.analyses.dynamic import begun, continued, layout_of
from mecano.errors import ResultsError, UnknownNameError, UsageError
from mecano.interface.deck import AnyDeck, AnyPath, Values, checked_deck, name_of
from mecano.interface.results import Results
from mecano.interface.solving import interruptible, refuse_both, resuming
from mecano.process.cores import bounded_blas
from mecano.process.interrupt import Interruption
from mecano.results.lookup import ByName, Lookup, require_names
from mecano.results.recorded import MAGNITUDE


class Simulation(ByName):
    """A dynamic run advanced step by step in a ``with`` block; it writes the results file of ``mecano.run``.

    Every ``advance`` ends with a step, which is shortened if the duration is not a multiple of a fixed step size. At
    the end of the block the file is closed: as complete if the end time was reached, otherwise with a checkpoint, from
    which ``resume=True``, here or in ``mecano.run``, continues. The same happens if an exception leaves the block.
    Ctrl-C in ``advance`` also leaves a checkpoint, and raises KeyboardInterrupt. After this or an error in ``advance``
    the Simulation cannot continue, even if the exception is caught in the block. A Simulation can be entered only once.

    ``s["torque"] = 2.5`` sets a signal of the type ``external``.

    ``deck``, ``path``, ``set``, ``force`` and ``resume`` are those of ``mecano.run``.

    Raises
    ------
    DeckError, AssemblyError, ResultsError
        As ``mecano.run``, when the block begins.
    UsageError
        The deck is static, or the run to be resumed is complete.

    Examples
    --------
    >>> with mecano.Simulation("pendulum.yaml", force=True) as s:
    ...     while s["hinge.angle"] < 1.0:
    ...         s.advance(0.01)
    >>> round(s.time, 2)
    0.46
    >>> s.results().status
    'stopped'
    """

    def __init__(
        self, deck: AnyDeck, path: AnyPath | None = None, *, set: Values | None = None, force: bool = False,
        resume: bool = False,
    ):  # fmt: skip
        refuse_both(resume, force)
        self._checked = checked_deck(deck, set)
        if self._checked.values["static"]:
            raise UsageError("a Simulation advances in time, but this deck asks for equilibria; use mecano.run")
        self.path = os.fspath(path or f"{name_of(deck)}.h5")
        self._force, self._resume, self._open, self._left = force, resume, ExitStack(), False
        self._given: dict[str, float] = {}  # new values of external signals
        self._run: Any = None
        self._failure: BaseException | None = None  # raised in ``advance``
        self._interruption = Interruption(again=resuming(deck, self.path, set))

    def __enter__(self) -> Self:
        if self._run is not None:
            raise UsageError("a Simulation has one block: make another one, or continue its file with resume=True")
        self._file = os.path.abspath(self.path)  # also after os.chdir in the block
        with ExitStack() as opened:
            opened.enter_context(bounded_blas())
            self._run = opened.enter_context(self._begun())
            if self._run is None:
                raise UsageError(f"{self.path} is complete: there is nothing to resume")
            self._open = opened.pop_all()
        columns = self._run.recorder.sampler.columns
        self._starts = {column.path: column.start for column in columns}
        return self

    def _begun(self):
        if self._resume:
            return continued(self._checked, self.path, interruption=self._interruption)
        return begun(self._checked, self.path, self._force, interruption=self._interruption)

    def __exit__(self, kind, error, trace) -> None:
        self._left = True
        if error is None and self._failure is not None:  # the last checkpoint is later than the state of the run
            kind, error, trace = type(self._failure), self._failure, self._failure.__traceback__
        try:
            if error is None:
                self._run.leave()
            elif self._failure is None:  # an exception of the calling program, between two steps
                with suppress(ResultsError):
                    self._run.checkpoint()
        except BaseException as failure:
            self._open.__exit__(type(failure), failure, failure.__traceback__)
            raise
        self._open.__exit__(kind, error, trace)

    @property
    def time(self) -> float:
        """Time [s] reached by the last ``advance`` that was not interrupted."""
        return self._started.state.motion.t

    @property
    def end(self) -> float:
        """End time of the deck [s]."""
        return self._checked.values["time"]["end"]

    def advance(self, duration: float) -> None:
        """Advance by ``duration`` [s], or to the end time of the deck if that comes first.

        Raises
        ------
        UsageError
            The duration is not positive, the end time has been reached, or the block or the run has ended.
        ConvergenceError, NonFiniteError, ResultsError
            As ``mecano.run``.
        """
        self._require_running()
        if not isinstance(duration, int | float | np.number) or not duration > 0.0:
            raise UsageError(f"a duration must be a number greater than zero, in seconds, got {duration!r}")
        if self.time >= self.end:
            raise UsageError(f"the deck ends at t = {self.end:g} s; set its 'time.end'")
        if self._started.ended:
            raise UsageError(f"the run ended at t = {self.time:.9g} s, by the condition of 'time.until'")
        try:
            with interruptible(self._interruption):
                self._started.advance(min(self.time + duration, self.end), self._given)
        except BaseException as failure:
            self._failure = failure
            raise
        self._given = {}

    def _require_running(self):
        if self._left:
            raise UsageError("the block of this Simulation has ended: resume=True continues the file")
        if self._failure is not None:
            raise UsageError(f"this Simulation has ended, it cannot advance further: {self._failure}")

    def __setitem__(self, name: str, value: float) -> None:
        """Set a signal of the type ``external`` from the current time on, until it is set again.

        ``value`` is in SI units; outputs contain it after the next ``advance``. Raises UnknownNameError for other
        names, and UsageError for a value that is not a finite number or after the end of the run.
        """
        require_names([name])
        self._require_running()
        signals = self._checked.values["signals"].items()
        external = [known for known, signal in signals if signal["type"] == "external"]
        signal = name.replace("/", ".").removeprefix("signals.").removesuffix(".value")
        if signal not in external:
            there_are = f"there are {', '.join(external)}" if external else "the deck has none"
            raise UnknownNameError(f"only signals of the type 'external' can be set, not '{name}': {there_are}")
        number = np.asarray(value)
        if number.size != 1 or number.dtype.kind not in "iuf" or not np.isfinite(number.item()):
            raise UsageError(f"{name} = {value!r}: write a finite number, in SI units")
        self._given[signal] = float(number.item())

    def __getitem__(self, name: str) -> float | np.ndarray:
        """Return the current value of an output, named by any ending of its path. Raises UnknownNameError."""
        require_names([name])
        if name.endswith(MAGNITUDE):
            return float(np.linalg.norm(self[name.removesuffix(MAGNITUDE)]))
        row = self._started.recorder.row
        series, component = self._lookup.find(name)
        start = self._starts[series.path]
        if component is not None:
            return float(row[start + component])
        values = row[start : start + series.width]
        return values.reshape(series.shape).copy() if series.shape else float(values[0])

    def __repr__(self):
        if self._run is None:
            return f"Simulation {self.path!r}: not begun"
        ended = "ended " if self._left or self._failure is not None else ""
        return f"Simulation {self.path!r}: {ended}at t = {self.time:g} of {self.end:g} s"

    def results(self) -> Results:
        """Open the results saved so far. Raises ResultsError."""
        if not self._left:
            self._started.recorder.flush()
            self._started.recorder.writer.flush()
        return Results(self._file)

    @cached_property
    def _lookup(self) -> Lookup:
        return Lookup(layout_of(self._started.recorder.sampler).series)

    @property
    def _started(self):
        if self._run is None:
            raise UsageError("a Simulation begins in a block: with mecano.Simulation(deck) as s")
        return self._run
