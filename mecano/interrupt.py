"""What asks a process to end early: signals, and the wall-clock time that it was given."""

import re
import shlex
import signal
import sys
import time
from contextlib import contextmanager

CLOCK = getattr(signal, "SIGALRM", 14)  # Windows has none: there the clock is looked at between steps only
EXIT_CODES = {signal.SIGINT: 130, signal.SIGTERM: 143, CLOCK: 75}
if hasattr(signal, "SIGUSR1"):
    EXIT_CODES[signal.SIGUSR1] = 75
SIGNALS = tuple(number for number in EXIT_CODES if number in signal.valid_signals())
WORDS = {CLOCK: "the end of its wall-clock time"}
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
        """From now on these signals and the clock end the process."""
        sys.unraisablehook = _unraisable
        _swallowed.clear()
        for number in numbers:
            signal.signal(number, self._ask)
        if self._deadline < float("inf") and hasattr(signal, "setitimer"):
            signal.setitimer(signal.ITIMER_REAL, max(self._deadline - time.monotonic(), 1e-6))

    def _ask(self, number, frame):
        again, self._number = self._number is not None, self._number or number
        if not self._postponed or (again and number == signal.SIGINT):
            raise Stopped(number)  # where nothing can be raised this is swallowed; then ``wanted`` still knows

    @contextmanager
    def postponed(self):
        """In this block the process ends where ``wanted`` is asked; at once only by a second SIGINT."""
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

    def stopped(self, where):
        """The exception that ends the run; ``where`` it stands, in words."""
        return Stopped(self._number, f" {where}; go on with: {self.again}" if self.again else f" {where}")


def stopped_by(error):
    """The Stopped that an exception comes from, or None: compiled code in between may put another in its place.

    A compiler that calls back to Python swallows the Stopped, and fails later for want of what the call was to give:
    with an error of its own, never with one of mecano's.
    """
    from mecano.errors import MecanoError  # as in ``check``

    known = isinstance(error, MecanoError)
    while error is not None and not isinstance(error, Stopped):
        error = error.__cause__ or error.__context__
    return error or (None if known else next(iter(_swallowed), None))


_swallowed = []  # each Stopped that was raised where none can be: in a destructor, or a call from compiled code


def _unraisable(lost):
    """Say what Python says of exceptions that cannot be raised where they occur, but of Stopped nothing."""
    if isinstance(lost.exc_value, Stopped):
        _swallowed.append(lost.exc_value)
    else:
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
