"""Tyre laws: force, stored energy and dissipation agree; Fiala's law against its closed form and against bristles."""

import numpy as np
import pytest
from scipy.integrate import quad
from time_runs import RecordedRun, input_deck

from mecano.analyses.kind_samples import GRAVITY, samples
from mecano.analyses.law_tests import OF_SLIP_LAWS, Tyre, check_power_of_tyres
from mecano.element_interface import Context
from mecano.elements.wheels.fiala import FIALA
from mecano.elements.wheels.flexible_wheel import FLEXIBLE_WHEEL
from mecano.elements.wheels.slip_law import default_values
from mecano.elements.wheels.slip_laws import SLIP_LAWS
from mecano.laws.law_table import LawTable

FRICTION = {
    "friction": (("exponential", {"start": 0.8, "limit": 0.3, "rate": 0.1, "origin": 0.0}),),
    "friction_by_speed": 1.0, "slip_regularization": 0.5,
}  # fmt: skip


@pytest.mark.parametrize("check", OF_SLIP_LAWS, ids=lambda check: check.__name__)
@pytest.mark.parametrize("law", [law for law in SLIP_LAWS.values() if law.sample], ids=lambda law: law.name)
def test_every_law(law, check):
    check(law)


def test_friction_states_its_power():
    law = SLIP_LAWS["friction"]
    check_power_of_tyres(law, [Tyre(law, FRICTION)])


MU, LOAD, HALF = 0.8, 4000.0, 0.06


def brush(C_t=6e4, C_l=6e4, mu=MU):
    values = {
        "cornering_stiffness": C_l, "longitudinal_stiffness": C_t, "friction": mu, "contact_length": 2.0 * HALF,
        "least_speed": 1e-6,
    }  # fmt: skip
    return Tyre(FIALA, {"fiala": default_values(FIALA.type.options, values)})


def test_fiala_is_the_published_cubic_in_pure_side_slip(verify):
    """F = C z - C^2 z|z|/(3 mu N) + C^3 z^3/(27 mu^2 N^2) of z = tan alpha (Fiala 1954; Pacejka 2012, (3.11))."""
    found, expected = [], []
    for z in np.tan(np.radians([-12.0, -5.0, -0.1, 0.0, 0.5, 2.0, 5.0, 9.0, 9.2, 30.0])):
        k = brush().forces(LOAD, (0.0, 20.0 * z))
        C, most = 6e4, MU * LOAD
        force = C * z - C**2 * z * abs(z) / (3 * most) + C**3 * z**3 / (27 * most**2)
        slides = C * abs(z) > 3 * most
        trail = 0.0 if slides else C * z * HALF / 3.0 * (1.0 - C * abs(z) / (3.0 * most)) ** 3
        found += [-k.F[1], k.M[2]]
        expected += [most * np.sign(z) if slides else force, trail]
        assert k.F[0] == 0.0
    np.testing.assert_allclose(found, expected, rtol=1e-12, atol=1e-9)
    source = "Fiala 1954; Pacejka 2012, (3.11)"
    verify("Tyres", "Fiala's tyre at 5 degrees: lateral force [N]", found[12], expected[12], source, relative=1e-12)


def bristles(v_t, v_l, V_r, C):
    """Force (2,) and moment of elastic bristles of one stiffness under a parabolic pressure, summed over the contact.

    A bristle at the distance s behind the leading edge bears c s sigma, but at most mu times the pressure there.
    """
    sigma = np.array([v_t, v_l]) / V_r
    c, size = C / (2.0 * HALF**2), np.hypot(*sigma)
    pressure = lambda x: 0.75 * LOAD / HALF * (1.0 - (x / HALF) ** 2)  # noqa: E731
    borne = lambda x: min(c * (HALF - x) * size, MU * pressure(x))  # noqa: E731
    edge = HALF - min(c * size * 4.0 * HALF**3 / (3.0 * MU * LOAD), 2.0 * HALF)  # where sliding begins
    parts = [(-HALF, edge), (edge, HALF)]
    total = sum(quad(borne, *part, epsabs=1e-10)[0] for part in parts)
    turn = sum(quad(lambda x: x * borne(x), *part, epsabs=1e-12)[0] for part in parts)
    return -total * sigma / size, -turn * sigma[1] / size


@pytest.mark.parametrize("slip", [(0.2, 0.3), (-0.5, 0.1), (1.0, -2.0), (4.0, 3.0)])
def test_fiala_is_the_sum_of_bristles_in_combined_slip(slip):
    """Independent of the closed form: the bristles themselves, integrated over the contact."""
    force, moment = bristles(*slip, 20.0 - slip[0], 6e4)
    k = brush().forces(LOAD, slip)
    np.testing.assert_allclose(k.F[:2], force, rtol=1e-8)
    assert k.M[2] == pytest.approx(moment, rel=1e-7, abs=1e-8)


@pytest.mark.parametrize("slip", [(0.2, 0.3), (-0.5, 0.1), (1.0, -2.0)])
def test_fiala_rolls_backward_as_forward(slip):
    """Bristles enter the contact at the edge that leads: a wheel in reverse is one that rolls forward with -t, -l."""
    force, moment = bristles(*slip, 20.0 - slip[0], 6e4)
    k = brush().forces(LOAD, (-slip[0], -slip[1]), u=(-20.0, 0.0))
    np.testing.assert_allclose(k.F[:2], -force, rtol=1e-8)
    assert k.M[2] == pytest.approx(moment, rel=1e-7, abs=1e-8)


def test_two_stiffnesses_and_a_locked_wheel():
    """Each stiffness is the slope of its own force; a locked wheel slides with mu N against its way."""
    tyre = brush(C_t=9e4, C_l=5e4)
    assert -tyre.forces(LOAD, (1e-6, 0.0)).F[0] == pytest.approx(9e4 * 1e-6 / 20.0, rel=1e-6)
    assert -tyre.forces(LOAD, (0.0, 1e-6)).F[1] == pytest.approx(5e4 * 1e-6 / 20.0, rel=1e-6)
    assert brush().forces(LOAD, (20.0, 0.0)).F[0] == pytest.approx(-MU * LOAD, rel=1e-12)


@pytest.fixture(scope="module")
def fiala_sweep():
    return RecordedRun(input_deck("fiala_sweep"))


def test_a_wheel_in_a_slow_sweep_of_the_slip_angle_has_the_force_of_fiala(fiala_sweep):
    """Quasi-steady, so within 1e-4 of the closed form."""
    recorded = fiala_sweep
    z, force = np.tan(np.radians(recorded.time)), recorded["elements/tire/lateral_force"].ravel()
    G, most = 6e4 * z, MU * LOAD
    closed = np.where(most * 3 > G, G - G**2 / (3 * most) + G**3 / (27 * most**2), most)
    turn = np.where(most * 3 > G, -G * HALF / 3 * np.maximum(0.0, 1.0 - G / (3 * most)) ** 3, 0.0)
    np.testing.assert_allclose(force, closed, atol=1e-4 * most)
    np.testing.assert_allclose(recorded["elements/tire/slip_moment"][:, 2], turn, atol=2e-4 * 20.0)


def test_a_leaning_wheel_is_pushed_to_the_side_of_its_top(fiala_sweep, verify):
    """The second wheel: C_g gamma is added to the shear of the slip angle."""
    recorded = fiala_sweep
    gamma = np.radians(5.0)
    most = MU * 2e5 * (0.3 - 0.28 / np.cos(gamma)) / np.cos(gamma)
    G = 6e4 * np.tan(np.radians(recorded.time)) - 6e3 * gamma
    closed = np.where(most * 3 > G, G - G * abs(G) / (3 * most) + G**3 / (27 * most**2), most)
    force = recorded["elements/leaning_tire/lateral_force"].ravel()
    force, closed = force[recorded.time > 0.1], closed[recorded.time > 0.1]  # its spin has settled
    assert force[0] < 0.0
    source = "Pacejka 2012, (3.11), with C_g gamma added to C tan(alpha)"
    verify("Tyres", "Fiala's tyre at 5 degrees of camber: lateral force over mu N [-]", force / most, closed / most,
           source, absolute=4e-4)  # fmt: skip
    assert np.ptp(recorded["energy/balance"]) < 1e-4 * recorded["energy/dissipated"][-1]


def test_fiala_without_camber_gives_only_the_power_of_its_moment():
    for slip in ((0.2, 0.3), (-1.0, 5.0)):
        k = brush().forces(LOAD, slip, omega=(0.1, 60.0, 0.3))
        assert k.given == pytest.approx(k.M[2] * 0.3, abs=1e-12)
        assert k.lost == pytest.approx(-k.F[0] * slip[0] - k.F[1] * slip[1], rel=1e-12)


def test_a_patch_with_a_relaxation_length_exchanges_nothing_with_the_rolling():
    """Where M = 0 holds, what the wheel loses is stored in K y^2/2 or dissipated: nothing is given."""
    checked = 0
    for sample in samples(FLEXIBLE_WHEEL):
        lateral = sample.values["tire_law"]["lateral"]
        if not lateral["relaxation"]:
            continue
        lateral |= {name: 1.0 for name in ("stiffness_by_load", "stiffness_by_speed")} | {"aligning_moment": 4 * [0.0]}
        table, [instance] = LawTable(), sample.instances
        for name, value in FLEXIBLE_WHEEL.prepare(sample.values, sample.nodes, Context(table, GRAVITY)).items():
            instance.p[name][0] = value
        instance.laws = table.array()
        y = instance.scalars[0, 0]
        instance.scalars[0, 1:] = y / lateral["relaxation"]["relaxation_length"], 0.0  # psi, and no bow
        e = instance.observe(0.0, instance.local(sample.motion), np.zeros(6))[1]
        K = lateral["relaxation"]["cornering_stiffness"] / lateral["relaxation"]["relaxation_length"]
        assert e[1] > 0.5 * K * y * y > 0.0 and e[2] > 0.0
        assert abs(e[3]) < 1e-9 * e[2]
        checked += 1
    assert checked
