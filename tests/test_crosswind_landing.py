"""inputs/crosswind_landing.yaml: order of touch-downs, momentum across the path, friction, slip of a rolling tyre."""

import numpy as np
import pytest
from scipy.integrate import trapezoid
from time_runs import RecordedRun, input_deck

from mecano.laws.probe import curve_at

TYRES = {"left": ("dry", 0.8), "right": ("wet", 0.3)}  # with the friction at rest
MASSES = {"cylinder": 80.0, "axle": 60.0, "hub": 70.0}
SIGMA = 0.35  # m


@pytest.fixture(scope="module")
def landing():
    return RecordedRun(input_deck("crosswind_landing"))


def of_wheel(landing, side, name):
    return landing[f"elements/{side}_wheel/{name}"].squeeze()


def test_the_low_wheel_touches_down_first_and_both_stay_down(landing):
    """It is 5 mm above the ground and sinks with 1.8 m/s, as lift is weight."""
    touched = [(h.element, h.name, h.t) for h in landing.event_records if "wheel" in h.element]
    assert [(name, event) for name, event, _ in touched] == [
        ("flexible_wheel 'right_wheel'", "touch_down"), ("flexible_wheel 'left_wheel'", "touch_down"),
    ]  # fmt: skip
    assert touched[0][2] == pytest.approx(0.005 / 1.8, rel=0.01)
    assert touched[1][2] < 2 * 2.6 * np.sin(np.radians(4.0)) / 1.8 * 1.1  # as its rim was higher, sinking on


def test_momentum_across_the_path_is_the_impulse_of_the_side_forces(landing):
    """They push against the drift from the touch-down on."""
    momentum = 16000.0 * landing["nodes/body/velocity"][:, 1]
    impulse = 0.0
    for side in ("left", "right"):
        momentum = momentum + sum(m * landing[f"nodes/{side}_{node}/velocity"][:, 1] for node, m in MASSES.items())
        force = of_wheel(landing, side, "contact_force")[:, 1]
        assert force.max() < 1e-3 * -force.min()
        impulse += trapezoid(force, landing.time)
    assert momentum[0] == pytest.approx(16420.0 * 65.0 * np.sin(np.arctan(15 * 1852 / 3600 / 65.0)), rel=1e-9)
    assert momentum[-1] - momentum[0] == pytest.approx(impulse, rel=1e-3)
    assert momentum[-1] < 0.4 * momentum[0]


@pytest.mark.parametrize("side", TYRES)
def test_a_tyre_slides_at_its_friction_and_never_beyond(landing, side):
    """Where it slides its coefficient is that of the slip speed; the wet wheel slides sideways, the dry one rolls.

    That is the slip speed with the patch held in the wheel, which differs by dy/dt: by up to 5 m/s, 3 % of friction.
    """
    N, along, across = (of_wheel(landing, side, f"{way}_force") for way in ("normal", "longitudinal", "lateral"))
    slip = np.hypot(of_wheel(landing, side, "longitudinal_slip"), of_wheel(landing, side, "lateral_slip"))
    tyre, at_rest = TYRES[side]
    friction = landing.prepared.deck.values["tire_laws"][tyre]["friction"]
    assert np.all(np.hypot(along, across) <= at_rest * N + 1e-6 * N.max())
    sliding = (N > 1e3) & (slip > 1.0)
    found = np.hypot(along, across)[sliding] / N[sliding]
    assert found == pytest.approx([curve_at(friction, speed)[0] for speed in slip[sliding]], rel=0.03)
    late = (landing.time > 0.5) & (landing.time < 1.2)
    assert (slip[late].min() > 1.0) if side == "right" else (slip[late].max() < 0.1)


def test_the_deformation_of_a_rolling_tyre_follows_the_motion_of_its_axle(landing):
    """dy/dt = v_y - v_x y/sigma of the point of contact.

    Up to creep (0.1 of 7 m/s, 1.4 %), lean (4 degrees, 0.3 %) and the torque link, which gives way by F_x y/k = 0.4
    mrad of 0.1 rad.
    """
    t, y = landing.time, of_wheel(landing, "left", "y")
    v, turning = landing["nodes/left_hub/velocity"], landing["nodes/left_axle/angular_velocity"][:, 0]
    across = v[:, 1] + turning * of_wheel(landing, "left", "height")
    first = int(np.searchsorted(t, 0.35))
    expected = np.full(len(t), y[first])
    for i in range(first, len(t) - 1):  # exact for velocities that are constant over a step
        rate, aim = v[i : i + 2, 0].mean() / SIGMA, SIGMA * across[i : i + 2].mean() / v[i : i + 2, 0].mean()
        expected[i + 1] = aim + (expected[i] - aim) * np.exp(-rate * (t[i + 1] - t[i]))
    assert np.abs(expected - y)[first:].max() < 0.022 * np.abs(y).max()


def test_the_budget_closes(landing):
    """To 1e-4 of what is dissipated, most of it in the spin-up and by the sliding wheel."""
    assert np.ptp(landing["energy/balance"]) < 1e-4 * np.ptp(landing["energy/dissipated"])
