"""Runs that are stopped and resumed, in this process or in a fork of it, and the content of their files."""

import math
import os
import signal
import traceback

import numpy as np
import pytest
from time_runs import deck, input_deck

import mecano
from mecano.analyses import checkpoint_writer
from mecano.analyses.dynamic import resume
from mecano.process.interrupt import SIGNALS, Interruption, Stopped, stopped_by

SWING = """\
mecano: 1
gravity: [0, 0, -9.81]
nodes: {pin: {position: [0, 0, 0]}}
elements:
  bar: {type: rigid_body, node: pin, mass: 1.0, center_of_mass: [0.5, 0, 0], inertia: [1.0e-4, 0.0833, 0.0833]}
joints: {hinge: {type: hinge, nodes: [ground, pin], axis: [0, 1, 0]}}
time: {end: 1.0e5, step: 1.0e-3}
output: {every: 0.002}
"""
FOUR_FEET = """
    mecano: 1
    gravity: [0, 0, -9.81]
    nodes:
      middle: {position: [0, 0, 1]}
      left: {position: [-0.5, 0, 1]}
      right: {position: [0.5, 0, 1]}
      front: {position: [0, 0.4, 1]}
      back: {position: [0, -0.4, 1]}
    elements:
      bar: {type: rigid_body, node: middle, mass: 2, inertia: [0.1, 0.1, 0.1], attached: [left, right, front, back]}
      a: {type: plane_contact, node: left, ground: floor, restitution: 0.5}
      b: {type: plane_contact, node: right, ground: floor, restitution: 0.5}
      c: {type: plane_contact, node: front, ground: floor, restitution: 0.5}
      d: {type: plane_contact, node: back, ground: floor, restitution: 0.5}
    grounds: {floor: {plane: {point: [0, 0, 0], normal: [0, 0, 1]}}}
    time: {end: 1.6, step: 1.0e-2}
"""


def decks():
    """Cheap decks by name: adaptive steps with events, a law with corners, shocks, shocks of redundant contacts."""
    return {
        "nose_gear_rigid": input_deck("nose_gear_rigid", "time.end=0.8"),
        "strut": input_deck("strut", "time.end=1", "output.every=step"),
        "bouncing_ball": input_deck("bouncing_ball", "time.end=4"),
        "four_feet": deck(FOUR_FEET),
    }


def long_deck():
    """Many rows for the time they take: a file that grows all the while."""
    return input_deck("double_pendulum", "time.end=0.4", "time.step=5.0e-5", "output.every=1.0e-4")


class StopAfter(Interruption):
    """Wants the end after so many steps, of which it is an observer, or questions, as a signal would."""

    def __init__(self, steps=math.inf, questions=math.inf):
        super().__init__(again="mecano run deck.yaml --resume")
        self.steps, self.questions = steps, questions

    def __call__(self, accepted):
        self.steps -= 1

    def wanted(self, now, ending=0.0):
        self.questions -= 1
        if self.steps <= 0 or self.questions < 0:
            self._number = signal.SIGTERM
        return self._number is not None


def resumed(deck, path, stops):
    """Run a deck that is stopped after each of the numbers of steps ``stops``, and resumed, to its end."""
    for steps in stops:
        end = StopAfter(steps)
        with pytest.raises(Stopped):
            resume(deck, path, interruption=end, observers=(end,))
    resume(deck, path)


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
    signal.pthread_sigmask(signal.SIG_BLOCK, SIGNALS)  # before ``try`` the child would end in the tests
    child = os.fork()
    if child:
        signal.pthread_sigmask(signal.SIG_UNBLOCK, SIGNALS)
        return child
    code = 1
    try:
        for number in SIGNALS:  # which other tests in this process may have handled
            signal.signal(number, signal.SIG_DFL)
        signal.pthread_sigmask(signal.SIG_UNBLOCK, SIGNALS)
        action(*arguments, **options)
        code = 0
    except BaseException as error:
        code = getattr(stopped_by(error) or error, "exit_code", 1)
        if isinstance(error, KeyboardInterrupt) and code == 1:
            code = 130
        elif code == 1:
            traceback.print_exc()
    finally:
        os._exit(code)


def ended(child):
    """The exit code of a child, negative the number of the signal that killed it."""
    return os.waitstatus_to_exitcode(os.waitpid(child, 0)[1])


def listening_resume(deck, path, interval):
    """What ``mecano run --resume`` does, for a fork."""
    interruption = Interruption(again="mecano run deck.yaml --resume")
    interruption.listen()
    checkpoint_writer.SHARE = 0  # as many checkpoints as the interval asks for
    resume(deck, path, interruption=interruption, interval=interval)
