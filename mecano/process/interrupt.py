"""Requests to end a process early: signals, the limit of wall-clock time, and the command that resumes the run."""

import os
import re
import shlex
import signal
import sys
import threading
import time
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from types import FrameType
from typing import Any, TypeVar

CLOCK = getattr(signal, "SIGALRM", 14)  # Windows has none: there the clock is checked between steps only
CODES = {"SIGINT": 130, "SIGTERM": 143, "SIGHUP": 129, "SIGXCPU": 152, "SIGUSR1": 75}
EXIT_CODES = {getattr(signal, name): code for name, code in CODES.items() if hasattr(signal, name)} | {CLOCK: 75}
HANGUP = getattr(signal, "SIGHUP", None)
SIGNALS = tuple(number for number in EXIT_CODES if number in signal.valid_signals())
WORDS = {CLOCK: "the limit of wall-clock time"}
STACK = 2**26  # B for a thread: compilers need more than the half megabyte of some systems
BEGUN = time.monotonic()  # start of the process, without the startup of Python
RESERVE, LARGEST_RESERVE = 0.05, 30.0  # share of the wall-clock time, and [s] at most, for the last checkpoint
UNITS = r"(?:(\d{1,9})d)?(?:(\d{1,9})h)?(?:(\d{1,9})m)?(?:(\d{1,12})s?)?"
OF_A_CLOCK = r"(?:(\d{1,9})-)?(\d{1,9}):(\d\d):(\d\d)"
LONGEST_LIMIT = 10**9  # s, thirty years: a timer of the system takes no more than nine times as much
T = TypeVar("T")


class Stopped(KeyboardInterrupt):
    """The run was stopped by a signal or by the limit of wall-clock time; ``exit_code`` is that of the process."""

    def __init__(self, number: int, further: str = ""):
        self.number, self.further, self.exit_code = number, further, EXIT_CODES[number]
        super().__init__(f"stopped by {WORDS.get(number) or signal.Signals(number).name}{further}")

    def __reduce__(self):
        """Return what makes an equal exception in another process: a pool hangs if it cannot make that of a worker."""
        return type(self), (self.number, self.further)


class Interruption:
    """Requests to end the process: handled at once or, within ``postponed``, at the next call of ``wanted``.

    Parameters
    ----------
    limit : float or None
        Wall-clock time of the process [s].
    again : str
        Command that resumes the run, for messages.
    """

    def __init__(self, limit: float | None = None, again: str = ""):
        self.again = again
        self._deadline = float("inf") if limit is None else BEGUN + limit - min(RESERVE * limit, LARGEST_RESERVE)
        self._number: int | None = None  # number of the signal that was received, or of the clock
        self._postponed = False
        self._asked: float | None = None  # time [s] of the last call of ``wanted``
        self._longest = 0.0

    def listen(self, numbers: Iterable[int] = SIGNALS) -> None:
        """Handle these signals and the clock from now on; SIGHUP stays ignored under `nohup`."""
        sys.unraisablehook = _unraisable
        for number in numbers:
            if number != HANGUP or signal.getsignal(number) != signal.SIG_IGN:
                signal.signal(number, self._ask)
        if self._deadline < float("inf") and hasattr(signal, "setitimer"):
            signal.setitimer(signal.ITIMER_REAL, max(self._deadline - time.monotonic(), 1e-6))

    def _ask(self, number: int, frame: FrameType | None) -> None:
        again, self._number = self._number is not None, self._number or number
        if not self._postponed:
            raise Stopped(number)  # may be lost where exceptions cannot propagate; ``wanted`` still returns True
        if _waits_for_a_call or (again and number == signal.SIGINT):
            raise self.stopped("within a step")

    @contextmanager
    def postponed(self) -> Iterator[None]:
        """Postpone the end of the process in this block to ``wanted``, ``call_interruptibly``, or a second SIGINT."""
        self._postponed = True
        try:
            yield
        finally:
            self._postponed = False

    def check(self, what: str, left: float, ending: float) -> None:
        """Raise an exception if an activity before the time integration must not continue.

        Parameters
        ----------
        what : str
            Description of the activity.
        left : float
            Estimated remaining time of the activity [s].
        ending : float
            Time to end the process [s].

        Raises
        ------
        Stopped
            A signal was received.
        UsageError
            The limit of wall-clock time leaves none for the integration, and would not if the run were repeated.
        """
        if self._number is not None and self._number != CLOCK:
            raise Stopped(self._number, f" while {what}; the file is unchanged")
        now = time.monotonic()
        if now + ending > self._deadline:
            from mecano.errors import UsageError  # import takes 1 % of the time of `mecano --help`

            needed = now - BEGUN + left + ending
            raise UsageError(
                f"--max-walltime is too short: {what}, and closing it again, takes about {needed:.2g} s, which leaves "
                "no time for a step; allow several times as much. The file is unchanged"
            )

    def wanted(self, now: float, ending: float = 0.0) -> bool:
        """Return whether the process must end now, because the time limit may expire before the next call.

        ``now`` is monotonic time [s], ``ending`` the time to end the process [s].
        """
        if self._asked is not None:
            self._longest = max(self._longest, now - self._asked)
        self._asked = now
        if self._number is None and now + self._longest + ending > self._deadline:
            self._number = CLOCK
        return self._number is not None

    def raise_if_asked(self, where: str) -> None:
        """Raise Stopped if a signal was received, for example if its own exception was lost."""
        if self._number is not None:
            raise self.stopped(where)

    def stopped(self, where: str) -> Stopped:
        """Return the exception that ends the run; ``where`` describes the place, such as "at t = 1 s"."""
        assert self._number is not None, "nothing has asked for the end"
        return Stopped(self._number, f" {where}; continue with: {self.again}" if self.again else f" {where}")


def _begin():
    global BEGUN
    BEGUN = time.monotonic()


os.register_at_fork(after_in_child=_begin)  # the fork is another process, with limits of its own


def call_interruptibly(call: Callable[..., T], *arguments: Any) -> T:
    """Return ``call(*arguments)``, executed in a separate thread, so that a signal interrupts the wait at once.

    Python runs signal handlers only in the main thread, between two of its instructions, and so not during a long call
    of a library (a compiler, a matrix decomposition). After a signal the thread continues until the process ends, so
    ``call`` must have no permanent effects. Outside the main thread this is an ordinary call.
    """
    global _waits_for_a_call
    if threading.current_thread() is not threading.main_thread():
        return call(*arguments)
    outcome: list[Any] = []
    done = threading.Event()
    _waits_for_a_call = True
    try:
        usual = threading.stack_size(STACK)
        try:
            threading.Thread(target=_keep_outcome, args=(outcome, done, call, arguments), daemon=True).start()
        finally:
            threading.stack_size(usual)
        done.wait()
    finally:
        _waits_for_a_call = False
    result, error = outcome
    if error is not None:
        raise error
    return result


_waits_for_a_call = False  # whether the main thread waits in ``call_interruptibly``


def _keep_outcome(outcome, done, call, arguments):
    """Append the result of a call and its exception to the list ``outcome``; one of them is None."""
    try:
        outcome += [call(*arguments), None]
    except BaseException as error:
        outcome += [None, error]
    done.set()


def stopped_by(error: BaseException | None) -> Stopped | None:
    """Return the Stopped in the chain of an exception, or None; compiled code may replace it by another exception."""
    seen = set()  # a chain of exceptions may be cyclic
    while error is not None and not isinstance(error, Stopped) and id(error) not in seen:
        seen.add(id(error))
        error = error.__cause__ or error.__context__
    return error if isinstance(error, Stopped) else None


def _unraisable(lost):
    """Report unraisable exceptions as Python does, except Stopped."""
    if not isinstance(lost.exc_value, Stopped):
        sys.__unraisablehook__(lost)


def resume_command() -> str:
    """Return the command that resumes the command of this process."""
    words = [word for word in sys.argv[1:] if word not in ("--force", "--resume")]
    return shlex.join(["mecano", *words, "--resume"])


def seconds(text: str) -> int:
    """Return the seconds of "3600", "2h30m", "1d", "90s", "02:30:00" or, as in Slurm, "1-02:30:00".

    Raises UsageError.
    """
    match = re.fullmatch(OF_A_CLOCK, text) or re.fullmatch(UNITS, text)
    numbers = [int(part or 0) for part in match.groups()] if match else [0]
    total = sum(number * size for number, size in zip(numbers, (86400, 3600, 60, 1), strict=False))
    if not total:
        from mecano.errors import UsageError  # import takes 1 % of the time of `mecano --help`

        raise UsageError(f"'{text}' is not a wall-clock time; write 3600, 2h30m or 02:30:00")
    return min(total, LONGEST_LIMIT)
