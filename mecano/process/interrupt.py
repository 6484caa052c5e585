"""What asks a process to end early: signals, and the wall-clock time that it was given."""

import re
import shlex
import signal
import sys
import threading
import time
from contextlib import contextmanager

CLOCK = getattr(signal, "SIGALRM", 14)  # Windows has none: there the clock is looked at between steps only
CODES = {"SIGINT": 130, "SIGTERM": 143, "SIGHUP": 129, "SIGXCPU": 152, "SIGUSR1": 75}
EXIT_CODES = {getattr(signal, name): code for name, code in CODES.items() if hasattr(signal, name)} | {CLOCK: 75}
HANGUP = getattr(signal, "SIGHUP", None)
SIGNALS = tuple(number for number in EXIT_CODES if number in signal.valid_signals())
WORDS = {CLOCK: "the end of its wall-clock time"}
STACK = 2**26  # B for a thread: compilers need more than the half megabyte that some systems give
BEGUN = time.monotonic()  # of the process, but for the time in which Python starts
RESERVE, LARGEST_RESERVE = 0.05, 30.0  # share of the wall-clock time, and [s], left for the last checkpoint
UNITS = re.compile(r"(?:(\d+)d)?(?:(\d+)h)?(?:(\d+)m)?(?:(\d+)s?)?")
OF_A_CLOCK = re.compile(r"(?:(\d+)-)?(\d+):(\d\d):(\d\d)")


class Stopped(KeyboardInterrupt):
    """A signal, or the end of the wall-clock time, ends the run; ``exit_code`` is what the process returns."""

    def __init__(self, number, further=""):
        self.exit_code = EXIT_CODES[number]
        super().__init__(f"stopped by {WORDS.get(number) or signal.Signals(number).name}{further}")


class Interruption:
    """Whether the process is to end: at once, or while ``postponed`` where ``wanted`` is asked next.

    Parameters
    ----------
    limit : float or None
        Wall-clock time of the process [s].
    again : str
        Command that takes the run up again, for people.
    """

    def __init__(self, limit=None, again=""):
        self.again = again
        self._deadline = float("inf") if limit is None else BEGUN + limit - min(RESERVE * limit, LARGEST_RESERVE)
        self._number, self._postponed = None, False
        self._asked, self._longest = None, 0.0

    def listen(self, numbers=SIGNALS):
        """From now on these signals and the clock end the process; not SIGHUP where `nohup` has it ignored."""
        sys.unraisablehook = _unraisable
        for number in numbers:
            if number != HANGUP or signal.getsignal(number) != signal.SIG_IGN:
                signal.signal(number, self._ask)
        if self._deadline < float("inf") and hasattr(signal, "setitimer"):
            signal.setitimer(signal.ITIMER_REAL, max(self._deadline - time.monotonic(), 1e-6))

    def _ask(self, number, frame):
        again, self._number = self._number is not None, self._number or number
        if not self._postponed:
            raise Stopped(number)  # where nothing can be raised this is swallowed; then ``wanted`` still knows
        if _abandonable or (again and number == signal.SIGINT):
            raise self.stopped("in the midst of a step")

    @contextmanager
    def postponed(self):
        """In this block the process ends where ``wanted`` is asked, in ``abandonable``, or by a second SIGINT."""
        self._postponed = True
        try:
            yield
        finally:
            self._postponed = False

    def check(self, what, left, ending):
        """Raise Stopped or UsageError where ``what`` is done before a march is not to be gone on with.

        Parameters
        ----------
        what : str
            For the user, such as "taking up r.h5".
        left : float
            Time that the rest of it takes [s].
        ending : float
            Time that the end of the process takes [s].

        Raises
        ------
        Stopped
            A signal asks for it.
        UsageError
            The wall-clock time leaves none for the march: asked for again, it would not either.
        """
        if self._number not in (None, CLOCK):
            raise Stopped(self._number, f" while {what}; the file is as it was")
        now = time.monotonic()
        if now + ending > self._deadline:
            from mecano.errors import UsageError  # takes a hundredth of the time of `mecano --help`

            needed = now - BEGUN + left + ending
            raise UsageError(
                f"--max-walltime is too short: {what}, and closing it again, takes about {needed:.2g} s, which leaves "
                "no time for a step; allow several times as much. The file is as it was"
            )

    def wanted(self, now, ending=0.0):
        """True when the process is to end, or would not come to the next question in time.

        ``now`` monotonic [s]; ``ending``: time that the end of the process takes [s].
        """
        if self._asked is not None:
            self._longest = max(self._longest, now - self._asked)
        self._asked = now
        if self._number is None and now + self._longest + ending > self._deadline:
            self._number = CLOCK
        return self._number is not None

    def raise_if_asked(self, where):
        """Raise Stopped where a signal has asked for it, be it that the exception was lost where none can be raised."""
        if self._number is not None:
            raise self.stopped(where)

    def stopped(self, where):
        """The exception that ends the run; ``where`` it stands, in words."""
        return Stopped(self._number, f" {where}; go on with: {self.again}" if self.again else f" {where}")


def abandonable(call, *arguments):
    """Return ``call(*arguments)``, made in a thread of its own: a signal ends the wait for it at once.

    The handlers of Python run in the main thread only, between two of its instructions. While a library works there for
    long, as a compiler or a decomposition of a matrix does, no signal is answered. What the thread does then goes on
    until the process ends, so it must change nothing that lasts. In another thread than the main one this is a call.
    """
    global _abandonable
    if threading.current_thread() is not threading.main_thread():
        return call(*arguments)
    outcome, done = [], threading.Event()
    _abandonable = True
    try:
        usual = threading.stack_size(STACK)
        threading.Thread(target=_keep_outcome, args=(outcome, done, call, arguments), daemon=True).start()
        threading.stack_size(usual)
        done.wait()
    finally:
        _abandonable = False
    result, error = outcome
    if error is not None:
        raise error
    return result


_abandonable = False  # while the main thread waits in ``abandonable``


def _keep_outcome(outcome, done, call, arguments):
    """Put the result of a call and the exception that it raised into the list ``outcome``; one of them is None."""
    try:
        outcome += [call(*arguments), None]
    except BaseException as error:
        outcome += [None, error]
    done.set()


def stopped_by(error):
    """The Stopped that an exception comes from, or None: compiled code in between may put another in its place."""
    seen = set()  # a chain of exceptions may be a ring
    while error is not None and not isinstance(error, Stopped) and id(error) not in seen:
        seen.add(id(error))
        error = error.__cause__ or error.__context__
    return error if isinstance(error, Stopped) else None


def _unraisable(lost):
    """Say what Python says of exceptions that cannot be raised where they occur, but of Stopped nothing."""
    if not isinstance(lost.exc_value, Stopped):
        sys.__unraisablehook__(lost)


def again():
    """The command that goes on with what this process was told to do."""
    words = [word for word in sys.argv[1:] if word not in ("--force", "--resume")]
    return shlex.join(["mecano", *words, "--resume"])


def seconds(text):
    """Seconds of "3600", "2h30m", "1d", "90s", "02:30:00" or, as Slurm writes it, "1-02:30:00". Raises UsageError."""
    match = OF_A_CLOCK.fullmatch(text) or UNITS.fullmatch(text)
    numbers = [int(part or 0) for part in match.groups()] if match else [0]
    total = sum(number * size for number, size in zip(numbers, (86400, 3600, 60, 1), strict=False))
    if not total:
        from mecano.errors import UsageError  # takes a hundredth of the time of `mecano --help`

        raise UsageError(f"'{text}' is no wall-clock time; write 3600, 2h30m or 02:30:00")
    return total
