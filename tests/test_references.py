"""Decks of inputs/ against reference motions; their source, where no other is named: d2_multibody, numbers that were
found with minimal coordinates at tight tolerance and checked a second way, good to 1e-8. g = 9.81 m/s2.

Tolerances come from the order of the method: see convergence.py.
"""

import numpy as np
import pytest
from convergence import at_times, check_second_order, pair
from linkage import FourBar
from scipy.interpolate import CubicHermiteSpline
from scipy.spatial.transform import Rotation
from time_runs import INPUTS, RecordedRun, deck, input_deck

M, MINIMAL, LINKS = "Mechanisms", "minimal coordinates, integrated at tight tolerance", "closed form of the linkage"
HALVES, SECONDS = np.linspace(0.5, 5.0, 10), np.arange(1.0, 11.0)


def test_pendulum(verify):
    """A01: theta = 2 asin(k sn(K - w t, k)) from the vertical, released from the horizontal; x = -1 there."""
    theta = [
        -1.4050273115247993, 0.9166475896632469, -0.1775836983042972, -0.6157410432328381, 1.2294518114853838,
        -1.5390945241972038, 1.5182313402827088, -1.1677182757332674, 0.5217219123608284, 0.2786806735699831,
    ]  # fmt: skip
    coarse, fine = pair("pendulum", lambda m: np.pi / 2 - m["joints/hinge/angle"], SECONDS, 0.01)
    verify.second_order(M, "pendulum: angle at ten times [rad]", coarse, fine, theta, 2e-6, "elliptic functions")


def period(recorded):
    """Time between the first and the third passage through the vertical."""
    angle = recorded["joints/hinge/angle"] - np.pi / 2
    curve = CubicHermiteSpline(recorded.time, angle, recorded["joints/hinge/rate"])
    first, _, third = curve.roots(extrapolate=False)[:3]
    return third - first


def test_period_and_greatest_pin_force_of_the_pendulum(verify):
    """A01: 2.367841947576237 s. The bar of the deck pulls with 5/2 m g where it hangs straight down."""
    periods, forces = [], []
    for h in (0.01, 0.005):
        recorded = RecordedRun(input_deck("pendulum", f"time.step={h}", "time.end=3.2"))
        periods.append(period(recorded))
        angle, force = recorded["joints/hinge/angle"], np.linalg.norm(recorded["joints/hinge/force"], axis=-1)
        near = np.argsort(np.abs(angle - np.pi / 2))[:5]
        forces.append(np.polynomial.polynomial.polyfit(angle[near] - np.pi / 2, force[near], 2)[0])
    verify.second_order(M, "pendulum: period [s]", *periods, 2.367841947576237, 1e-8, "elliptic integral")
    verify(M, "pendulum: greatest force of the pin [N]", forces[1], 24.525, "5/2 m g", relative=1e-4)


def test_double_pendulum_of_rods(verify):
    """Angles from the vertical, [upper, lower] every half second."""
    theta = [
        [0.44814262593198423, 1.0419628873038866], [-1.2077162381906361, -0.8143910230912997],
        [-1.1503256803178465, -2.099126131756428], [-0.08275830682058181, 0.4073620749118491],
        [1.3445575685016586, 1.7311362080510933], [1.0250860122888104, 0.49573464762657954],
        [-0.5842694277353997, -1.4171984676674951], [-1.2514201422954023, -2.6592630068783465],
        [-0.2076907349261397, -0.915257010852987], [1.1385437966688061, 1.244379927759016],
    ]  # fmt: skip

    def angles(m):
        upper = np.pi / 2 - m["joints/shoulder/angle"]
        return np.stack([upper, upper - m["joints/elbow_hinge/angle"]], axis=1)

    coarse, fine = pair("double_pendulum", angles, HALVES, 2e-3)
    verify.second_order(M, "double pendulum: angles over 5 s [rad]", coarse, fine, theta, 2e-5, MINIMAL)


def test_n_four_bar_passes_singular_positions(verify):
    """A02, N = 2: five turns, ten passages through positions where the linkage could change its form."""
    theta = [
        3.3378708031051834, 6.341033361312233, 10.006351828767652, 12.684259593513458, 16.65435348664972,
        19.031946612933098, 23.27203891627352, 25.386512181592177, 29.85381671457402, 31.75059718698085,
    ]  # fmt: skip
    rate = [
        6.807385240869514, 1.0189645914381467, 6.558724215059134, 1.076511180084325, 6.105067553525153,
        1.174597480331436, 5.516646107368909, 1.3164754083291035, 4.867357433995681, 1.506642180827251,
    ]  # fmt: skip
    cranks = [f"joints/hinge_a{i}" for i in range(3)]
    h, found = 2e-3, {"angle": [], "rate": []}
    for step in (h, h / 2):
        recorded = RecordedRun(input_deck("n_four_bar", f"time.step={step}"))
        for what in found:
            every = np.stack([recorded[f"{crank}/{what}"] for crank in cranks], axis=1)
            found[what].append(at_times(recorded, every, SECONDS))
        start = recorded["energy/balance"][0]
        assert start == pytest.approx(35.835, rel=1e-12)
        apart = np.ptp(np.stack([recorded[f"{crank}/angle"] for crank in cranks]), axis=0)
        assert apart.max() < 1e-9  # no change of form: all cranks stay parallel
    theta, rate = (np.tile(values, (3, 1)).T for values in (theta, rate))
    verify.second_order(M, "N-four-bar: crank angles over 10 s [rad]", *found["angle"], theta, 5e-6, MINIMAL)
    verify.second_order(M, "N-four-bar: crank rates over 10 s [rad/s]", *found["rate"], rate, 1.2e-5, MINIMAL)


def test_heavy_top(verify):
    """Centre of mass at 2 s, force of the pivot at 0 and 2 s, energy at the start."""
    x = [-0.15041682274637816, -0.7241655916371939, -0.6730222695599588]
    force = [-260.7352113104331, 613.6126989826779, 309.71663139032404]
    at_start = [0.0, -319.525988166, -317.26246153846233]
    positions, forces = [], []
    for h in (2.5e-4, 1.25e-4):
        recorded = RecordedRun(input_deck("heavy_top", f"time.step={h}"))
        positions.append(recorded["elements/top/center_of_mass"][-1])
        forces.append(recorded["joints/ball/force"][-1])
        np.testing.assert_allclose(recorded["joints/ball/force"][0], at_start, rtol=0, atol=1e-8)
        assert recorded["energy/total"][0] == pytest.approx(5435.696790865547, rel=1e-12)
    verify.second_order(M, "heavy top: centre of mass at 2 s [m]", *positions, x, 3e-7, MINIMAL)
    verify.second_order(M, "heavy top: force of the pivot at 2 s [N]", *forces, force, 3e-4, MINIMAL)


FREE_BODY = [
    [-0.04688970218434159, 0.9989501267976614, 0.033159433906186545],
    [-0.2172275174686638, 0.976172221308519, 0.1268697420527565],
    [-0.7680989107910595, 0.6404092935315479, 0.4438753341342635],
    [-0.8036645188774618, -0.595166649853217, 0.4643908766339494],
    [-0.23345721722609378, -0.972418494129477, 0.13613996752723972],
    [-0.05121578195106197, -0.9987376751074993, 0.03522809636668242],
    [0.007490102836366154, -1.0000219489388684, 0.019630772106579833],
    [0.08460100266529402, -0.9964650873703638, 0.05246373239987002],
    [0.3592083158592969, -0.9333109802298052, 0.20827114873202737],
    [0.9725266235226108, -0.23300636587802834, 0.5618149260685682],
    [0.5489491345919376, 0.8359155744635598, 0.3175138592089277],
    [0.13863425324268425, 0.9903941355984621, 0.0822991619482638],
]  # w every 2.5 s, material axes


def material_spin(recorded):
    """Angular velocity of the free body in its own axes."""
    turn = Rotation.from_quat(np.roll(recorded["nodes/body/rotation"], -1, axis=1))
    return turn.inv().apply(recorded["nodes/body/angular_velocity"])


def test_free_body_flips_twice():
    """Euler's equations, moments of inertia 1, 2, 3: Jacobi's elliptic functions, a flip every 16.5974985 s."""
    check_second_order(*pair("free_body", material_spin, np.arange(2.5, 30.1, 2.5), 0.05), FREE_BODY, 3e-6)


def test_time_between_the_flips():
    """A flip is where the middle component goes through zero; its rate there is w1 w3 (I3 - I1)/I2."""
    intervals = []
    for h in (0.05, 0.025):
        recorded = RecordedRun(input_deck("free_body", f"time.step={h}"))
        w = material_spin(recorded)
        first, second = CubicHermiteSpline(recorded.time, w[:, 1], w[:, 2] * w[:, 0]).roots(extrapolate=False)
        intervals.append(second - first)
    check_second_order(*intervals, 16.597498504458635, 1e-6)


# every 30 degrees of the driving shaft from 30 to 360
CARDAN_RATIO = [
    1.0658774200423862, 0.9237604307034013, 0.8660254037844387, 0.9237604307034012, 1.0658774200423862,
    1.1547005383792517, 1.0658774200423862, 0.9237604307034014, 0.8660254037844387, 0.9237604307034013,
    1.065877420042386, 1.1547005383792517,
]  # fmt: skip
CARDAN_ANGLE = [
    0.5880026035475674, 1.1071487177940904, 1.5707963267948966, 2.0344439357957027, 2.5535900500422257,
    3.141592653589793, 3.7295952571373605, 4.248741371383883, 4.71238898038469, 5.176036589385496,
    5.695182703632018, 6.283185307179586,
]  # fmt: skip


def test_cardan_joint(verify):
    """Angles are exact (constraints on positions), the ratio of the rates is of second order."""
    ratios = []
    for h in (1 / 480, 1 / 960):
        recorded = RecordedRun(input_deck("cardan", f"time.step={h}"))
        angle = at_times(recorded, recorded["joints/bearing_2/angle"], np.arange(1, 13) / 12)
        verify(M, f"cardan joint: output angle, step {h:.2g} s [rad]", angle, CARDAN_ANGLE, LINKS, absolute=2e-10)
        ratios.append(at_times(recorded, recorded["joints/bearing_2/rate"], np.arange(1, 13) / 12) / (2 * np.pi))
    verify.second_order(M, "cardan joint: ratio of the rates [-]", *ratios, CARDAN_RATIO, 1e-9, LINKS)
    even = recorded["joints/bearing_3/angle"].ravel()
    source = "both shafts turn alike"
    verify(M, "constant-velocity joint: output angle [rad]", even, 2 * np.pi * recorded.time, source, absolute=1e-9)
    bending = 10.0 * np.tan(np.radians(15.0))
    moment, source = recorded["joints/rzeppa/moment"][1:], "moment along the line that halves the angle of the shafts"
    np.testing.assert_allclose(moment[:, 2], 10.0, rtol=1e-7)
    found = np.hypot(moment[:, 0], moment[:, 1])
    verify(M, "constant-velocity joint: bending moment [N m]", found, bending, source, relative=1e-7)
    np.testing.assert_allclose(recorded["joints/rzeppa/bend"], np.pi / 6, rtol=1e-9)


# every 45 degrees of the crank from 45 to 360
FOUR_BAR_COUPLER = [
    0.5719898958384424, 0.43082792878279264, 0.4218141136343374, 0.537533165130624, 0.7683197404064797,
    1.0137415177385267, 1.0980118709904856, 0.8725738534323367,
]  # fmt: skip
FOUR_BAR_ROCKER = [
    1.6152753027050701, 1.834176176358, 2.163491709047695, 2.423021700436639, 2.509997335819837, 2.417089765313734,
    2.1412972778571135, 1.7451477068646735,
]  # fmt: skip


def test_driven_four_bar(verify):
    """fourbar: the crank of the deck turned once in 1 s; angles of coupler and rocker from the ground link."""
    text = (INPUTS / "four_bar.yaml").read_text()
    motor = "{type: prescribed_angle, nodes: [ground, crank], axis: [0, -1, 0], value: {linear: {slope: $turn}}}"
    text = text.replace("joints:\n", f"parameters: {{turn: {2 * np.pi}}}\njoints:\n  motor: {motor}\n")
    recorded = RecordedRun(deck(text.replace("time: {end: 3.0", "time: {end: 1.0")))
    eighths = np.arange(1, 9) / 8
    crank = at_times(recorded, recorded["joints/hinge_a/angle"], eighths)
    coupler = crank + at_times(recorded, recorded["joints/hinge_b/angle"], eighths) + FOUR_BAR_COUPLER[-1]
    rocker = at_times(recorded, recorded["joints/hinge_d/angle"], eighths) + FOUR_BAR_ROCKER[-1]
    np.testing.assert_allclose(crank, 2 * np.pi * eighths, rtol=0, atol=2e-10)
    verify(M, "driven four-bar: angle of the coupler [rad]", coupler, FOUR_BAR_COUPLER, LINKS, absolute=1e-9)
    verify(M, "driven four-bar: angle of the rocker [rad]", rocker, FOUR_BAR_ROCKER, LINKS, absolute=1e-9)


def test_the_closed_form_of_the_four_bar_is_that_of_the_reference():
    """So that the other tests may use it at any angle."""
    angles = FourBar().angles(np.pi / 4 * np.arange(1, 9))
    np.testing.assert_allclose(angles, [FOUR_BAR_COUPLER, FOUR_BAR_ROCKER], rtol=0, atol=1e-14)


def test_four_bar_under_its_weight(verify):
    """The crank angle of the one equation of motion, three swings."""
    times = np.linspace(0.25, 3.0, 12)
    coarse, fine = pair("four_bar", lambda m: m["joints/hinge_a/angle"], times, 2e-3)
    exact = FourBar().motion(times)[:, 0]
    verify.second_order(M, "four-bar under its weight: crank [rad]", coarse, fine, exact, 3e-6, MINIMAL)
