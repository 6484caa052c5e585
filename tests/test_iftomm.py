"""Benchmarks A04 and A05 of the IFToMM (Gonzalez et al., Multibody System Dynamics 16 (2006) 179-190)."""

import numpy as np
from scipy.integrate import solve_ivp
from scipy.spatial.transform import Rotation
from time_runs import RecordedRun, input_deck

S, G = "Mechanisms", 9.81

CORNERS = np.array([[0, 0, 0], [1, 0, 0], [1, -1, 0], [1, -1, 1], [0, -1, 1], [0, 0, 1]], float)
AXES = np.array([[0, 1, 0], [0, 0, 1], [1, 0, 0], [0, 1, 0], [0, 0, 1]], float)
ALONG, ACROSS = 0.1**2 / 6, (1 + 0.1**2) / 12  # inertia of a rod [kg m2]


def bricard_angles(a):
    """Angles (5,) of the hinges before each rod where the first has turned by ``a``."""
    b = -np.arcsin(np.sin(a) / (1 + np.sin(a)))
    return np.array([a, b, a, b, a])


def bricard_rods(a):
    """Centres (5, 3) and rotations (5, 3, 3) of the rods, from the first hinge outwards."""
    turn, start, centres, turns = np.eye(3), CORNERS[0], [], []
    for axis, angle, rod in zip(AXES, bricard_angles(a), np.diff(CORNERS, axis=0), strict=True):
        turn = turn @ Rotation.from_rotvec(angle * axis).as_matrix()
        centres.append(start + turn @ rod / 2)
        turns.append(turn)
        start = start + turn @ rod
    return np.array(centres), np.array(turns)


def bricard_time(angle):
    """Time [s] at which the first hinge has turned by ``angle``, from the conservation of energy.

    M da/dt^2 = 2 (V(0) - V(a)) with the inertia M(a); a = x^2 removes the singularity at the start.
    """
    nodes, weights = np.polynomial.legendre.leggauss(40)
    total, h, end = 0.0, 1e-5, np.sqrt(angle)
    height = bricard_rods(0.0)[0][:, 1].sum()
    for x, w in zip((nodes + 1) * end / 2, weights * end / 2, strict=True):
        a = x * x
        (before, R0), (centres, R), (after, R1) = (bricard_rods(a + d) for d in (-h, 0.0, h))
        spin = np.swapaxes(R, 1, 2) @ (R1 - R0) / (2 * h)  # of the rods about their axes, for a rate of 1
        omega = np.stack([spin[:, 2, 1], spin[:, 0, 2], spin[:, 1, 0]], axis=1)
        inertia = np.where(np.diff(CORNERS, axis=0) != 0, ALONG, ACROSS)
        mass = np.sum(((after - before) / (2 * h)) ** 2) + np.sum(inertia * omega**2)
        total += w * 2 * x * np.sqrt(mass / (2 * G * (height - centres[:, 1].sum())))
    return total


def test_bricards_mechanism(verify):
    """A04, within the tolerance of the deck; one of the constraints of the six hinges is redundant."""
    recorded = RecordedRun(input_deck("bricard", "time.end=2.6"))
    angles = np.stack([recorded[f"joints/hinge_{i}/angle"] for i in range(1, 7)], axis=1)
    first = bricard_angles(angles[:, 0]).T
    assert np.abs(angles - np.column_stack([first, -first[:, 1]])).max() < 1e-8
    swing = slice(1, 1 + int(np.argmax(angles[:, 0])))
    at = np.array([0.5, 1.0, 2.0, 3.0])
    times = np.interp(at, angles[swing, 0], recorded.time[swing])
    exact = [bricard_time(a) for a in at]
    verify(
        S, "Bricard's mechanism: times at which the first hinge has turned by 0.5 to 3 rad [s]", times, exact,
        "conservation of energy with the relation of the angles", absolute=1e-4,
    )  # fmt: skip
    verify(
        S, "Bricard's mechanism: angle of the turning point [rad]", angles[:, 0].max(), np.pi, "symmetry", absolute=1e-4
    )


def governor(times, tilt=np.pi / 6, speed=2 * np.pi):
    """Heights (n,) of the slider of the flyball governor [m], from Lagrange's equations of tilt and height.

    The turn of the shaft is cyclic. ``b`` is the tilt of the rods below the horizontal, s the height of the slider.
    """
    ball, rod, slider, e, k, c, rest = 5.0, 0.3, 3.0, 0.05, 8e5, 4e4, 0.5
    along, across = 5.0e-6, 0.0250025
    swing = 2 * (ball + rod / 4 + across)

    def about_shaft(b):
        arm = ball * (e + np.cos(b)) ** 2 + rod * (e + np.cos(b) / 2) ** 2
        return 5.0e-6 + 0.005 + 2 * (arm + across * np.cos(b) ** 2 + along * np.sin(b) ** 2)

    momentum = about_shaft(tilt) * speed

    def rates(t, y):
        b, s, db, ds = y
        x, z = np.cos(b) / 2, 1 - np.sin(b) / 2 - s
        length, h = np.hypot(x, z), 1e-6
        by_b, by_s = (-x * np.sin(b) / 2 - z * np.cos(b) / 2) / length, -z / length
        force = 2 * (k * (length - rest) + c * (by_b * db + by_s * ds))
        turning = (about_shaft(b + h) - about_shaft(b - h)) / (2 * h) * (momentum / about_shaft(b)) ** 2 / 2
        weight = -2 * G * (ball + rod / 2) * np.cos(b)
        return [db, ds, (turning - weight - force * by_b) / swing, (-slider * G - force * by_s) / slider]

    return solve_ivp(rates, (0, times[-1]), [tilt, 0.5, 0, 0], "Radau", times, rtol=1e-8, atol=1e-10).y[1]


def test_the_flyball_governor(verify):
    """A05, within the tolerance of the deck: springs of 800 kN/m in a motion of seconds."""
    recorded = RecordedRun(input_deck("flyball_governor", "time.end=2"))
    height = recorded["nodes/slider/position"][:, 2]
    times = np.linspace(0.25, 2.0, 8)
    exact, found = governor(times), np.interp(times, recorded.time, height)
    verify(S, "flyball governor: height of the slider over 2 s [m]", found, exact, "minimal coordinates", absolute=1e-4)
    assert np.ptp(exact) > 0.2
