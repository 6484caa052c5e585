"""Tyres with a contact length: the stretched string of von Schlippe and Dietrich, and the straight tangent.

The exact string: the leading edge of the contact -a < x < a follows sigma dv1/ds + v1 = sigma (theta - eta' - a
theta') over the way s, for a wheel at the yaw theta and the lateral position eta, and every point behind it repeats its
place on the ground; force c (integral of v + sigma (v(a) + v(-a))), moment c (integral of v x + sigma (sigma + a) (v(a)
- v(-a))) (Pacejka, Tire and Vehicle Dynamics, chapter 5). Here as responses at the path frequency p, by quadrature, per
cornering stiffness 2c (sigma + a)^2.
"""

import numpy as np
import pytest
from scipy.optimize import brentq, fsolve
from small_motions import eigenvalues
from time_runs import RecordedRun, input_deck

from mecano.elements.wheels.lateral_law import FORMS
from mecano.elements.wheels.string_law import prepare_string

SIGMA, A, STIFFNESS, TRAIL, INERTIA = 0.3, 0.1, 6.0e4, 0.1, 1.0
STRING = {
    "cornering_stiffness": STIFFNESS, "relaxation_length": SIGMA, "contact_length": 2 * A,
    "torsional_stiffness": 1.0e4, "least_speed": 1.0e-3,
}  # fmt: skip
YAW, SHIFT = (1.0, 0.0), (0.0, 1.0)  # (theta, eta)


def exact(p, motion):
    """Return force and moment (2,) of the exact string, with its delay, at the path frequency p [1/m]."""
    theta, eta = motion
    v1 = SIGMA * (theta - p * eta - A * p * theta) / (1 + SIGMA * p)
    front = eta + A * theta + v1
    x, w = np.polynomial.legendre.leggauss(40)
    v = front * np.exp(-p * A * (1 - x)) - eta - A * x * theta
    v2 = front * np.exp(-2 * p * A) - eta + A * theta
    force = A * (w @ v) + SIGMA * (v1 + v2)
    moment = A * A * (w @ (v * x)) + SIGMA * (SIGMA + A) * (v1 - v2)
    return np.array([force, moment]) / (2 * (SIGMA + A) ** 2)


def of_law(form):
    """Return the response of a law as in the element: F, M and X with v_C = 0, dy/dt = v_lat - V psi, at V = 1 m/s."""
    r = prepare_string({**dict.fromkeys(FORMS), form: STRING, "relaxation_in_air": 1e-3})

    def response(p, motion):
        theta, eta = motion
        rows = np.array(r["A0"]) + p * np.array(r["A1"])
        rows[0] = [p, 1.0, 0.0]
        right = [p * eta - theta, -r["turning"][1] * p * theta, 0.0]
        q = np.linalg.solve(rows, right)
        # y is counted to the right, F pushes the patch back: force of the ground to the left
        return np.array([-(np.array(r["A0"])[0] @ q), np.array(r["moment"]) @ q]) / STIFFNESS

    return response


@pytest.mark.parametrize(
    ("form", "contact_lengths", "force", "moment"),
    [
        ("string", 20, 2e-4, 2e-4), ("string", 10, 2e-3, 3e-3), ("string", 5, 0.015, 0.09),
        ("straight_tangent", 40, 0.02, 0.08), ("straight_tangent", 20, 0.04, 0.16),
    ],
)  # fmt: skip
def test_response_against_the_exact_delay(form, contact_lengths, force, moment):
    """The errors that the documentation states, for a yawing and a swaying wheel; and they are not far smaller."""
    p, response = 2j * np.pi / (contact_lengths * 2 * A), of_law(form)
    errors = np.array([abs(response(p, m) - exact(p, m)) / abs(exact(p, m)) for m in (YAW, SHIFT)]).max(axis=0)
    assert np.all(errors < [force, moment]) and np.all(errors > 0.3 * np.array([force, moment]))


@pytest.mark.parametrize("form", ["string", "straight_tangent"])
def test_steady_rolling_has_the_cornering_stiffness_and_the_pneumatic_trail(form):
    trail = A * (SIGMA * (SIGMA + A) + A * A / 3) / (SIGMA + A) ** 2
    np.testing.assert_allclose(of_law(form)(1e-9, YAW), [1.0, -trail], rtol=1e-6)
    np.testing.assert_allclose(exact(1e-7, YAW), [1.0, -trail], rtol=1e-5)


def lateral(form, **values):
    """Return the override of a tyre law."""
    fields = {**STRING, **values}
    if form == "straight_tangent":  # whose psi is no twist
        del fields["torsional_stiffness"]
    constants = ", ".join(f"{key}: {value!r}" for key, value in fields.items())
    return f"tire_laws.rubber.lateral={{{form}: {{{constants}}}}}"


def caster(form, V, damping=20.0):
    """Eigenvalues of small motions of caster_shimmy.yaml at V [m/s]: frequency above 1 rad/s, slowest decay first."""
    overrides = (
        f"parameters.speed={V!r}", lateral(form),
        f"elements.damper.law={{damper: {{coefficient: {damping}}}}}",
    )  # fmt: skip
    found = eigenvalues(input_deck("caster_shimmy", *overrides), largest=1e4)
    found = found[found.imag > 1.0]
    return found[np.argsort(-found.real)]


def characteristic(s, V, response, damping=20.0):
    """(I s^2 + c s) theta + L F - M for theta = 1, eta = -L: the trailing wheel."""
    F, M = response(s / V, (1.0, -TRAIL))
    return INERTIA * s * s + damping * s + STIFFNESS * (TRAIL * F - M)


def root(response, V, guess):
    """The root of the characteristic equation near ``guess``."""

    def parts(z):
        value = characteristic(complex(*z), V, response)
        return [value.real, value.imag]

    return complex(*fsolve(parts, [guess.real, guess.imag], xtol=1e-13))


def test_shimmy_on_a_string(verify):
    """Growth and frequency of the exact delay within 1e-3, of the law's own equations to rounding."""
    for V, accuracy in ((20.0, 1e-3), (60.0, 1e-4)):
        found = caster("string", V)[0]
        what, own = f"stretched string at {V:g} m/s: eigenvalue [1/s], ", root(of_law("string"), V, found)
        verify("Shimmy", what + "of the law", found, own, "characteristic equation of the law", relative=1e-8)
        verify("Shimmy", what + "of the delay", found, root(exact, V, found), "exact delay", relative=accuracy)


def test_shimmy_on_a_straight_tangent():
    found = caster("straight_tangent", 20.0)[0]
    assert found == pytest.approx(root(of_law("straight_tangent"), 20.0, found), rel=1e-8)


@pytest.mark.slow
def test_critical_speeds_of_a_string():
    """c = 20 N m s/rad: the exact delay shimmies between 6.8319 and 151.9193 m/s, the string law within 1.3 %, 1e-5."""

    def borderline(V, w):
        return [(z := characteristic(1j * w, V, exact)).real, z.imag]

    for guess, low, high, accuracy in (((6.8, 45.0), 6.5, 7.5, 0.013), ((152.0, 100.0), 140.0, 160.0, 1e-5)):
        expected, _ = fsolve(lambda z: borderline(*z), guess, xtol=1e-12)
        found = brentq(lambda V: caster("string", V)[0].real, low, high, xtol=1e-6)
        assert found == pytest.approx(expected, rel=accuracy)


def test_leading_edge_after_a_step_of_yaw():
    """The leading edge of the string is at psi0 [(sigma + a) - sigma exp(-x/sigma)] after the way x."""
    slip = "tire_laws.rubber.slip_regularization=1e-3"
    recorded = RecordedRun(input_deck("step_steer", lateral("string"), slip, "elements.tire.type=adhesive_wheel"))
    y, psi, bow = (recorded[f"elements/tire/{name}"] for name in ("y", "psi", "bow"))
    c_3 = (A * y - A * (A + SIGMA) * psi - (A + 3 * SIGMA) * bow) / (5 * SIGMA)
    edge = A * 0.02 - y + (A * psi - c_3) + bow + c_3  # to the left; v(a) is the sum of the coefficients
    expected = 0.02 * ((SIGMA + A) - SIGMA * np.exp(-10.0 * recorded.time / SIGMA))
    np.testing.assert_allclose(edge, expected, atol=3e-3 * expected[-1])


@pytest.mark.parametrize("kind", ["flexible_wheel", "adhesive_wheel"])
def test_the_patch_starts_displaced(kind):
    """F = K y relaxes over 1/(C K) = 0.3 m from the y of the deck, here at 10 m/s without a slip angle."""
    rolling = "{nodes: all, velocity: [10, 0, 0]}, {nodes: [hub], angular_velocity: [0, 33.3333333, 0]}"
    constants = "lateral_stiffness: 2.0e5, yaw_coefficient: 1.66667e-5, yaw_time: 1e-4"
    recorded = RecordedRun(input_deck(
        "step_steer", "elements.tire.axis=[0, 1, 0]", "joints.bearing.axis=[0, 1, 0]",
        f"initial.velocities=[{rolling}]", f"tire_laws.rubber.lateral={{moreland: {{{constants}}}}}",
        "elements.tire.initial={y: 2.0e-3, psi: 6.66667e-3}", "tire_laws.rubber.slip_regularization=1e-3",
        f"elements.tire.type={kind}",
    ))  # fmt: skip
    assert recorded["elements/tire/y"][0] == 2.0e-3 and recorded["elements/tire/psi"][0] == pytest.approx(6.66667e-3)
    C1 = 1e-4  # psi + C1 psi' = y/0.3, y' = -V psi
    rate = np.roots([C1, 1.0, 10.0 / 0.3]).max()
    y = recorded["elements/tire/y"]
    np.testing.assert_allclose(y, 2.0e-3 * np.exp(rate * recorded.time), atol=2e-5)
