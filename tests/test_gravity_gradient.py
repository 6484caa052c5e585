"""Gravity gradient: libration of a satellite, relative motion on an orbit, tethers at rest and paid out."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.special import ellipj, ellipk
from small_motions import eigenvalues
from time_runs import RecordedRun, deck, input_deck

from mecano.analyses.prepare import mass_of, prepare, warnings_of
from mecano.errors import ConvergenceError, DeckError

N = 1.1e-3


def _libration(t):
    """Angle of the long axis to the vertical: 2 a is the angle of a pendulum of the frequency n sqrt(3 (B - A)/C)."""
    frequency, m = N * np.sqrt(3.0 * (100.0 - 20.0) / 90.0), np.sin(np.radians(40.0)) ** 2
    return np.arcsin(np.sqrt(m) * ellipj(frequency * t + ellipk(m), m)[0])


def test_libration_and_relative_motion(verify):
    found = []
    for h, stride in ((20.0, 1), (10.0, 2)):
        m = RecordedRun(input_deck("gravity_gradient", f"time.step={h}"))
        t = m.time[::stride]
        w, _, _, z = m["nodes/satellite/rotation"][::stride].T
        tilt = np.mod(2.0 * np.arctan2(z, w) - N * t + np.pi, 2.0 * np.pi) - np.pi
        x, y, height = m["nodes/debris/position"][::stride].T / 100.0
        up, along = x * np.cos(N * t) + y * np.sin(N * t), y * np.cos(N * t) - x * np.sin(N * t)
        found.append([tilt, up, along, height])
    known = [_libration(t), np.cos(N * t), -2.0 * np.sin(N * t), 0.5 * np.cos(N * t)]
    what = "gravity gradient: libration of 40 degrees [rad], relative ellipse [100 m]"
    verify.second_order("Gravity", what, *np.array(found), np.array(known), 3e-5, "elliptic function; ellipse")


def test_a_tether_that_is_paid_out_librates(verify):
    """At the length L and the angle q to the vertical: q'' + 2 L'/L (q' + n) + 3 n^2 sin q cos q = 0.

    Its tension is that of the reduced mass m: m L ((q' + n)^2 - n^2 (1 - 3 cos^2 q)), as L'' = 0.
    """
    first, rate = 100.0, 0.2
    swing = lambda t, y: [y[1], -2.0 * rate / (first + rate * t) * (y[1] + N) - 1.5 * N * N * np.sin(2.0 * y[0])]  # noqa: E731
    x, y = 50.0 * np.cos(0.3), 50.0 * np.sin(0.3)
    text = f"""
        mecano: 1
        gravity: none
        nodes: {{up: {{position: [{x}, {y}, 0]}}, low: {{position: [{-x}, {-y}, 0]}}}}
        elements: {{$i: {{repeat: {{i: [up, low]}}, type: point_mass, node: $i, mass: 10}}}}
        joints: {{tether: {{type: prescribed_length, nodes: [up, low], length: {first} + {rate}*time}}}}
        loads:
          $i: {{repeat: {{i: [up, low]}}, type: gravity_gradient, node: $i, mass: 10, rate: {N}, normal: [0, 0, 1],
            radial: [1, 0, 0]}}
        initial: {{velocities: [{{nodes: [up, low], angular_velocity: [0, 0, {N}], about: [0, 0, 0]}}]}}
        time: {{end: 3000, step: 2, method: radau}}
    """
    m = RecordedRun(deck(text))
    t = m.time[1:]
    q, q_rate = solve_ivp(swing, (0.0, 3000.0), [0.3, 0.0], "DOP853", t, rtol=1e-11, atol=1e-13).y
    length = first + rate * t
    half = 0.5 * length * np.array([np.cos(N * t + q), np.sin(N * t + q)])
    what = "tether paid out from 100 to 700 m in orbit"
    verify("Gravity", f"{what}: place [m]", m["nodes/up/position"][1:, :2], half.T, "SciPy", absolute=1e-5)
    tension = 5.0 * length * ((q_rate + N) ** 2 - N * N * (1.0 - 3.0 * np.cos(q) ** 2))
    verify("Gravity", f"{what}: tension [N]", -m["joints/tether/force"][1:], tension, "SciPy", relative=1e-6)


def test_a_vertical_tether_is_in_equilibrium():
    """Of the masses m at y from the point on the orbit, 3 m n^2 y pulls; in turning axes it rests, at n about it."""
    m = RecordedRun(
        deck(f"""
        mecano: 1
        gravity: none
        nodes: {{up: {{position: [200, 0, 0]}}, down: {{position: [-100, 0, 0]}}}}
        elements: {{up: {{type: point_mass, node: up, mass: 10}}, down: {{type: point_mass, node: down, mass: 20}}}}
        joints: {{tether: {{type: rigid_rod, nodes: [up, down]}}}}
        loads:
          up: {{type: gravity_gradient, node: up, mass: 10, rate: {N}, normal: [0, 0, 1], radial: [1, 0, 0]}}
          down: {{type: gravity_gradient, node: down, mass: 20, rate: {N}, normal: [0, 0, 1], radial: [1, 0, 0]}}
        initial:
          velocities: [{{nodes: [up], velocity: [0, {200 * N}, 0]}}, {{nodes: [down], velocity: [0, {-100 * N}, 0]}}]
        time: {{end: 3000, step: 10}}
        """)
    )
    np.testing.assert_allclose(m["joints/tether/tension"][1:], 3.0 * 10.0 * N**2 * 200.0, rtol=1e-4)
    up = m["nodes/up/position"]
    np.testing.assert_allclose(up[:, 0], 200.0 * np.cos(N * m.time), atol=2e-3)


FACING = f"""
    mecano: 1
    gravity: none
    nodes: {{a: {{position: [0, 0, 0]}}}}
    elements: {{body: {{type: rigid_body, node: a, mass: 200, inertia: [20, 80, 90]}}}}
    loads:
      orbit: {{type: gravity_gradient, node: a, mass: 200, inertia: [20, 80, 90], rate: {N}, normal: [0, 0, 1],
        radial: [1, 0, 0]}}
    initial: {{steady: {{angular_velocity: [0, 0, {N}], about: [0, 0, 0]}}}}
    time: {{end: 1, step: 0.1}}
"""


def test_modes_of_a_satellite_that_faces_the_earth(verify):
    """Pitch: s^2 = -3 (B - A)/C n^2; roll and yaw: s^4 + (1 + 3 k1 + k1 k3) s^2 + 4 k1 k3 = 0 (Hughes 1986, 9.3).

    The orbit, of Clohessy and Wiltshire: s = i n in its plane and across it, and two drifts.
    """
    yaw, roll, pitch = 20.0, 80.0, 90.0
    k1, k3 = (pitch - yaw) / roll, (pitch - roll) / yaw
    squares = [3.0 * (roll - yaw) / pitch, 1.0, 1.0, *-np.roots([1.0, 1.0 + 3.0 * k1 + k1 * k3, 4.0 * k1 * k3])]
    found = eigenvalues(deck(FACING), frame="a") / N
    known = np.sort(np.sqrt(squares))
    np.testing.assert_allclose(found.real, 0.0, atol=1e-6)
    what = "satellite that faces the Earth: librations and orbits, over the mean motion"
    verify("Gravity", what, found.imag[found.imag > 0.0], known, "Hughes 1986; Clohessy and Wiltshire", absolute=1e-6)


def test_a_satellite_that_turns_faster_than_its_orbit_is_not_steady():
    faster = FACING.replace(f"[0, 0, {N}], about", f"[0, 0, {2 * N}], about").replace("[1, 0, 0]", "[1, 0.1, 0]")
    with pytest.raises(ConvergenceError, match="the forces change over time"):
        eigenvalues(deck(faster))


def test_a_heavy_tether_hangs_in_its_orbit():
    """The tension of a line of masses m at x from the point on the orbit: 3 n^2 times the sum of m x beyond it."""
    n, x = 20, np.linspace(-100.0, 100.0, 21)
    places = ", ".join(f"p{i}: {{position: [{x[i]}, 0, 0]}}" for i in range(n + 1))
    m = RecordedRun(
        deck(f"""
        mecano: 1
        gravity: none
        nodes: {{{places}}}
        elements:
          m$i: {{repeat: {{i: 0..{n}}}, type: point_mass, node: p$i, mass: 0.5}}
          c$i: {{repeat: {{i: 1..{n}}}, type: cable, nodes: [p$(i - 1), p$i], axial_stiffness: 1.0e4}}
        loads:
          g$i: {{repeat: {{i: 0..{n}}}, type: gravity_gradient, node: p$i, mass: 0.5, rate: 0.01, normal: [0, 0, 1],
            radial: [1, 0, 0]}}
        initial: {{steady: {{angular_velocity: [0, 0, 0.01], about: [0, 0, 0]}}}}
        time: {{end: 10, step: 0.1}}
        """)
    )
    tension = np.array([m[f"elements/c{i}/tension"][[0, -1]] for i in (10, 14, 20)]).T
    known = [3e-4 * 0.5 * x[i:].sum() for i in (11, 14, 20)]
    np.testing.assert_allclose(tension, [known, known], rtol=2e-5)


BODY = """
    mecano: 1
    gravity: none
    nodes: {a: {position: [0, 0, 0]}}
    elements: {body: {type: rigid_body, node: a, mass: 1, inertia: [1, 1, 1]}}
    loads: {orbit: {type: gravity_gradient, node: a, mass: 1, rate: 1, normal: [0, 0, 1], MORE}}
    time: {end: 1, step: 0.1}
    """


@pytest.mark.parametrize(
    ("more", "message"),
    [
        ("radial: [0, 0, 2]", "'radial' must not be along 'normal'"),
        ("radial: [1, 0, 0], center_of_mass: [1, 0, 0]", "'center_of_mass' belongs to 'inertia'"),
    ],
)
def test_wrong_orbits(more, message):
    with pytest.raises(DeckError, match=message):
        deck(BODY.replace("MORE", more))


PAIR = f"""
    mecano: 1
    gravity: none
    nodes: {{a: {{position: [0, 0, 0]}}, b: {{position: [100, 0, 0]}}}}
    elements:
      a: {{type: point_mass, node: a, mass: 10}}
      b: {{type: rigid_body, node: b, mass: 20, inertia: [1, 1, 1], center_of_mass: [0, 0, 1]}}
    loads:
      a: {{type: gravity_gradient, node: a, mass: 10, rate: {N}, normal: [0, 0, 1], radial: [1, 0, 0]}}
      b: {{type: gravity_gradient, node: b, mass: 20, inertia: [1, 1, 1], center_of_mass: [0, 0, 1],
        rate: {N}, normal: [0, 0, 1], radial: [1, 0, 0]}}
    time: {{end: 1, step: 0.1}}
    """


def test_the_mass_on_which_the_load_acts_is_not_counted_again():
    prepared = prepare(deck(PAIR))
    assert mass_of(prepared.system) == pytest.approx(30.0, rel=1e-12)
    assert not [text for text in warnings_of(prepared) if "gravity" in text]


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("gravity: none", "gravity: [0, 0, -9.81]", "'gravity' accelerates a model in orbit, which falls freely"),
        ("mass: 10, rate", "mass: 1, rate", "'a': 'mass' is 1 kg, but what its node carries, 'a', has 10 kg"),
        ("center_of_mass: [0, 0, 1],", "", "gravity_gradient 'b': 'center_of_mass' is not that of 'b', [0, 0, 1] m"),
        ("gradient, node: a", "gradient, node: b", "point_mass 'a' has no gravity_gradient, as others have"),
    ],
)
def test_loads_of_other_bodies_are_suspicious(old, new, message):
    assert PAIR.count(old) == 1
    assert [text for text in warnings_of(prepare(deck(PAIR.replace(old, new)))) if message in text]
