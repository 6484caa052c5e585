"""Runs that are stopped and gone on with, in this process or in a fork of it, and what their files hold."""

import os
import signal

import numpy as np

import mecano
from mecano.errors import MecanoError
from mecano.interrupt import Interruption, Stopped
from mecano.run import resume


class StopAfter(Interruption):
    """Wants the end after so many steps, as a signal would."""

    def __init__(self, steps):
        super().__init__(again="mecano run deck.yaml --resume")
        self.steps = steps

    def wanted(self, now):
        self.steps -= 1
        if self.steps < 0:
            self._number = signal.SIGTERM
        return self.steps < 0


def contents(path):
    """All numbers and events of a results file: name -> array, list or dict."""
    with mecano.open_results(path) as results:
        found = {name: results[name].values for name in results.names()}
        return found | {
            "time": results.time, "steps": results.steps, "events": results.events, "extremes": results.extremes,
            "status": results.status, "reason": results.reason, "automatic": results.automatic,
        }  # fmt: skip


def check_same(found, expected):
    """Two ``contents`` are the same, bit for bit."""
    assert found.keys() == expected.keys()
    for name, value in expected.items():
        same = found[name].tobytes() == value.tobytes() if isinstance(value, np.ndarray) else found[name] == value
        assert same, name


def forked(action, *arguments, **options):
    """Call in a fork of this process, quietly; returns its id. Its exit code is that of the command line."""
    child = os.fork()
    if child:
        return child
    code = 1
    try:
        action(*arguments, **options)
        code = 0
    except Stopped as stopped:
        code = stopped.exit_code
    except MecanoError as error:
        code = error.exit_code
    finally:
        os._exit(code)


def ended(child):
    """The exit code of a child, negative the number of the signal that killed it."""
    return os.waitstatus_to_exitcode(os.waitpid(child, 0)[1])


def listening_resume(deck, path, interval):
    """What ``mecano run --resume`` does, for a fork."""
    interruption = Interruption(again="mecano run deck.yaml --resume")
    interruption.listen()
    resume(deck, path, interruption=interruption, interval=interval)
