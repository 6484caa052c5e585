"""Signals of the type ``external``: a controller in Python, beside the same controller in the deck."""

import copy
import shutil

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import mecano
from mecano.errors import UnknownNameError, UsageError

STIFFNESS, DAMPING, PERIOD = 60.0, 8.0, 10e-3
PENDULUM = {
    "gravity": [0, 0, -9.81],
    "nodes": {"pin": {"position": [0, 0, 0]}},
    "elements": {
        "bar": {"type": "rigid_body", "node": "pin", "mass": 1, "center_of_mass": [0.75, 0, 0],
                "inertia": [1e-4, 0.1875, 0.1875]},
    },
    "joints": {"hinge": {"type": "hinge", "nodes": ["ground", "pin"], "axis": [0, 1, 0]}},
    "signals": {"torque": {"type": "external", "unit": "N m"}},
    "loads": {"motor": {"type": "joint_moment", "joint": "hinge", "value": "torque"}},
    "time": {"end": 0.4, "step": 2e-3},
    "output": {"every": "step"},
}  # fmt: skip


@pytest.fixture(autouse=True)
def folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    return tmp_path


def deck(**time):
    found = copy.deepcopy(PENDULUM)
    found["time"] |= time
    return found


def controlled(s, until):
    """Advance to a time with a proportional and derivative controller, whose torque is held between its samples."""
    while s.time < until - 0.5 * PERIOD:
        s["torque"] = STIFFNESS * (0.5 - s["hinge.angle"]) - DAMPING * s["hinge.rate"]
        s.advance(PERIOD)


def sampled():
    """Return the same controller in the deck."""
    found = deck()
    found["signals"] = {
        "wanted": f"{STIFFNESS}*(0.5 - hinge.angle) - {DAMPING}*hinge.rate",
        "torque": {"type": "sample_and_hold", "input": "wanted", "period": PERIOD},
    }
    return found


def test_controller_in_python_moves_as_the_same_one_in_the_deck():
    with mecano.Simulation(deck(), "python.h5") as s:
        controlled(s, 0.4)
    with mecano.run(sampled(), "deck.h5", quiet=True) as expected, mecano.open_results("python.h5") as found:
        assert found.status == "complete"
        assert len(found.time) == len(expected.time) == 201
        for name in ("hinge.angle", "hinge.rate", "hinge.force", "motor.power", "energy.given"):
            scale = np.abs(expected[name]).max()
            difference = (found[name].values - expected[name].values)[1:]  # no torque is saved at 0
            assert np.abs(difference).max() < 1e-11 * scale
        assert np.ptp(expected["torque"].values) > 20.0


def sampled_reference(until):
    """Return angle and rate of I angle'' = m g l cos(angle) + torque by SciPy, the torque held between samples."""
    inertia, y = 0.1875 + 0.75**2, np.zeros(2)
    for _ in range(round(until / PERIOD)):
        torque = STIFFNESS * (0.5 - y[0]) - DAMPING * y[1]

        def rates(t, y, torque=torque):
            return [y[1], (9.81 * 0.75 * np.cos(y[0]) + torque) / inertia]

        y = solve_ivp(rates, [0, PERIOD], y, rtol=1e-12, atol=1e-13).y[:, -1]
    return y


def test_controller_in_python_agrees_with_scipy():
    """Radau IIA is of fifth order; generalized alpha, of second order, agrees four times as well in half the steps."""
    expected, errors = sampled_reference(0.4), []
    for time in ({"method": "radau"}, {"step": 2e-3}, {"step": 1e-3}):
        with mecano.Simulation(deck(**time), "s.h5", force=True) as s:
            controlled(s, 0.4)
            errors.append(np.abs([s["hinge.angle"], s["hinge.rate"]] - expected))
    assert errors[0].max() < 1e-9
    np.testing.assert_allclose(errors[1] / errors[2], 4.0, rtol=0.1)


@pytest.mark.parametrize("method", ["generalized_alpha", "radau"])
def test_torque_that_balances_gravity_from_an_instant_on(method):
    """With M = -m g l cos(angle) held at the state of rest, the bar stays at rest; before, it falls."""
    with mecano.Simulation(deck(method=method), "s.h5") as s:
        s["torque"] = -9.81 * 0.75
        s.advance(0.1)
        assert abs(s["hinge.angle"]) < 1e-12
        s["signals.torque.value"] = 0
        s.advance(0.1)
        assert s["hinge.angle"] > 0.04
        assert s["torque"] == 0.0


def test_signal_keeps_its_initial_value_without_a_program():
    held = deck()
    held["signals"]["torque"]["initial"] = -9.81 * 0.75
    with mecano.run(held, "held.h5", quiet=True) as results:
        assert abs(results["hinge.angle"][-1]) < 1e-12
        assert results["torque"].unit == "N m"


def test_value_set_where_a_law_has_a_corner_is_kept():
    """The step of the load ends the step of the run at the same instant, and both forces act from there on."""
    pushed = deck()
    pushed["loads"]["push"] = {
        "type": "joint_moment", "joint": "hinge", "value": {"step": {"time": 0.1, "rise": 0, "from": 0, "to": 1}}
    }  # fmt: skip
    with mecano.Simulation(pushed, "s.h5") as s:
        s["torque"] = -9.81 * 0.75
        s.advance(0.1)
        s["torque"] = -9.81 * 0.75 - 1.0
        s.advance(0.1)
        assert abs(s["hinge.angle"]) < 1e-12


def test_stopped_run_continues_with_its_value_to_the_same_bits(folder):
    with mecano.Simulation(deck(), "whole.h5") as s:
        controlled(s, 0.4)
    with mecano.Simulation(deck(), "first.h5") as s:
        controlled(s, 0.2)
    shutil.copy("first.h5", "branch.h5")
    with mecano.Simulation(deck(), "first.h5", resume=True) as s:
        assert s.time == pytest.approx(0.2, abs=1e-12)
        controlled(s, 0.4)
    with mecano.Simulation(deck(), "branch.h5", resume=True) as s:
        kept = s["torque"]
        s.advance(0.2)
        assert kept == s["torque"] != 0.0
    with mecano.open_results("whole.h5") as whole, mecano.open_results("first.h5") as first:
        np.testing.assert_array_equal(whole["hinge.angle"], first["hinge.angle"])


@pytest.mark.parametrize("error", [ValueError("of the controller"), KeyboardInterrupt()])
def test_exception_of_the_program_leaves_a_checkpoint(error):
    with pytest.raises(type(error)), mecano.Simulation(deck(), "s.h5") as s:
        controlled(s, 0.1)
        raise error
    with mecano.open_results("s.h5") as results:
        assert results.resumable
        assert results.status == ("failed" if isinstance(error, ValueError) else "stopped")
    with mecano.Simulation(deck(), "s.h5", resume=True) as s:
        assert s.time == pytest.approx(0.1, abs=1e-12)


def test_what_cannot_be_set_is_refused():
    with mecano.Simulation(deck(), "s.h5") as s:
        with pytest.raises(UnknownNameError, match="type 'external' can be set, not 'hinge.angle': there are torque"):
            s["hinge.angle"] = 1.0
        for value in (np.nan, [1.0, 2.0], "5 N m", None, True, 1j):
            with pytest.raises(UsageError, match="torque = .*: write a finite number, in SI units"):
                s["torque"] = value
        s["torque"] = np.array([[2]])  # the product of a gain and a state
        s.advance(1.0)
    with pytest.raises(UsageError, match="block of this Simulation has ended"):
        s["torque"] = 1.0


def test_simulation_has_one_block_and_does_not_resume_what_is_complete():
    with mecano.Simulation(deck(), "s.h5", force=True) as s:
        s.advance(1.0)
    with pytest.raises(UsageError, match="a Simulation has one block"):
        s.__enter__()
    with pytest.raises(UsageError, match="is complete"), mecano.Simulation(deck(), "s.h5", resume=True):
        pass
    with pytest.raises(UsageError, match="resume=True continues"):
        mecano.Simulation(deck(), "s.h5", resume=True, force=True)


def test_modes_about_a_state_that_was_reached_with_its_torque():
    """A torque holds the bar near 0.6 rad: I s^2 + c s + m g l sin(angle) = 0 there, and at rest near it at 0.6."""
    turned = deck(end=2.0)
    turned["joints"]["hinge"]["turning_law"] = {"damper": 3.0}
    weight, inertia = 9.81 * 0.75, 0.1875 + 0.75**2
    with mecano.Simulation(turned, "s.h5") as s:
        s["torque"] = -weight * np.cos(0.6)
        s.advance(2.0)
        angle = s["hinge.angle"]
    assert 0.5 < angle < 0.59  # still moving
    for at_rest, about in ((False, angle), (True, 0.6)):
        found = mecano.modes(turned, at=("s.h5", 2.0), at_rest=at_rest).eigenvalues
        expected = np.roots([inertia, 3.0, weight * np.sin(about)])
        np.testing.assert_allclose(found, expected[expected.imag > 0], rtol=1e-6)


def test_modes_take_the_value_as_constant_and_say_so():
    assert "external 'torque'" in mecano.modes(deck()).text


def test_set_point_that_would_jump_is_refused():
    jumping = deck()
    jumping["joints"]["hinge"] |= {"turning_law": {"spring": 10}, "natural_angle": "torque"}
    with pytest.raises(mecano.DeckError, match="external 'torque'"):
        mecano.check(jumping)
