"""A car with double wishbones, a driver and a speed control: inputs/car.yaml."""

import numpy as np
import pytest
from time_runs import RecordedRun, input_deck

from mecano.analyses.modal import modes

CORNERS = ("front_left", "front_right", "rear_left", "rear_right")
WIDTH = 1.8  # m
LANES = ((0.0, 15.0, 0.0, 1.1), (45.0, 70.0, 3.5, 1.2), (95.0, 110.0, 0.0, 1.3))
"""Of ISO 3888-1: beginning, end, and middle [m]; share of the width of the car that a lane has beside 0.25 m."""


@pytest.fixture(scope="module")
def lane_change():
    return RecordedRun(input_deck("car"))


def test_the_loads_of_the_wheels_balance_the_weight(lane_change, verify):
    """Straight running without acceleration: the loads have the resultant of the weights, in the ground."""
    masses = {name: d["mass"] for name, d in input_deck("car").values["elements"].items() if d["type"] == "rigid_body"}
    centres = np.array([lane_change[f"elements/{name}/center_of_mass"][0, 0] for name in masses])
    m = np.array(list(masses.values()))
    loads = np.array([lane_change[f"elements/{corner}_tyre/radial_force"][0] for corner in CORNERS]).ravel()
    at = np.array([lane_change[f"elements/{corner}_tyre/contact_point"][0, 0] for corner in CORNERS])
    found, expected = [loads.sum() / (9.81 * m.sum()), loads @ at / loads.sum()], [1.0, m @ centres / m.sum()]
    what = "car: load of its wheels over its weight, centre of the loads [m]"
    verify("Tyres", what, found, expected, "statics", absolute=1e-6)


def test_the_driver_stays_in_the_lanes(lane_change):
    x, y, _ = lane_change["nodes/chassis/position"].T
    for begin, end, middle, share in LANES:
        inside = (x >= begin) & (x <= end)
        assert np.abs(y[inside] - middle).max() < ((share - 1.0) * WIDTH + 0.25) / 2
    speed = np.linalg.norm(lane_change["nodes/chassis/velocity"], axis=1)
    assert np.abs(speed / speed[0] - 1.0).max() < 0.01


def test_a_car_that_is_steered_over_time_has_no_growing_mode():
    """Position, heading and angles of the wheels are free; the damper of the rack acts on the rate of the steering."""
    found = modes(input_deck("car", "signals.steer=0*time"), None)[1]
    free, coasting = found.values == 0.0, found.natural_frequency > 0.05
    assert np.count_nonzero(free) == 6  # two displacements and the angles of four wheels: headings belong to chains
    assert np.all(free | coasting)
    assert found.values.real.max() <= 0.0
