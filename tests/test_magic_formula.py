"""Tyres from .tir files: the Magic Formula against a second implementation, units, errors, ranges, a sweep."""

import json
import math
import textwrap

import numpy as np
import pytest
from magic_formula import forces, read, rolling_radius
from time_runs import INPUTS, RecordedRun, deck, input_deck

from mecano.analyses.law_tests import Tyre
from mecano.deck.deck import Deck
from mecano.deck.read import deck_of_bytes, read_deck
from mecano.elements.wheels.magic_formula import EXAMPLE, MAGIC_FORMULA, relaxation_lengths, slip_stiffness
from mecano.elements.wheels.slip_law import Slip, default_values
from mecano.elements.wheels.tire_law import slip_law_of
from mecano.errors import DeckError
from mecano.laws.probe import curve_at
from mecano.maths.vector import Vec3

CAR = read(INPUTS / "passenger_car.tir")
TURN = {  # plausible values of a car
    "PECP1": 0.7, "PDXP1": 0.4, "PDXP3": 1.5, "PKYP1": 1.0, "PDYP1": 0.4, "PDYP4": 0.1, "PHYP1": 1.0, "PHYP2": 0.15,
    "PHYP4": -4.0, "QDTP1": 10.0, "QCRP1": 0.2, "QCRP2": 0.1, "QBRP1": 0.1, "QDRP1": 1.0, "QDRP2": -1.5,
}  # fmt: skip
SOURCE = "Pacejka 2012, (4.E9)-(4.E78), written once more"
TURNED = "Pacejka 2012, (4.75)-(4.106), written once more"


def tyre(numbers, version, **options):
    given = {"coefficients": {**numbers, "VERSION": version}, "least_speed": 1e-9, **options}
    values = {"magic_formula": default_values(MAGIC_FORMULA.type.options, given), "radius": numbers["UNLOADED_RADIUS"]}
    assert MAGIC_FORMULA.check(values) == []
    return Tyre(slip_law_of(values), values)


def spin(numbers, load, kappa, V):
    """Spin [rad/s] that has the slip: its rolling radius grows with it."""
    omega = 20.0
    for _ in range(60):
        omega = V * (1.0 + kappa) / rolling_radius(numbers, load, omega)
    return omega


def at(tyre, numbers, load, kappa, alpha, gamma, V, yaw=0.0):
    """(Fx, Fy, Mx, My, Mz) of mecano at slips of the file, in its axes."""
    v, omega = (0.0, V * math.tan(alpha)), spin(numbers, load, kappa, V)
    turning = 0.0, omega * math.cos(gamma), omega * math.sin(gamma) + yaw
    k = tyre.forces(load, v, (V, v[1]), turning, math.sin(gamma), omega)
    return np.array([k.F[0], k.F[1], *k.M])


def points(count, most_load):
    rng = np.random.default_rng(3)
    return np.column_stack([
        rng.uniform(0.2, 2.0, count) * most_load, rng.uniform(-0.6, 0.6, count), rng.uniform(-0.35, 0.35, count),
        rng.uniform(-0.15, 0.15, count), rng.uniform(5.0, 40.0, count),
    ])  # fmt: skip


def turned(T, speed, slip, lean, way):
    """Force and moment of a wheel with a speed and slip (2,) each, in the axes (t, l) or, with ``way`` -1, (-t, -l)."""
    spin = way * (speed[0] - slip[0]) / 0.32
    v, u, omega = Vec3(*slip, 0.0), Vec3(*speed, 0.0), Vec3(0.0, way * spin, 0.0)
    t, l, n = Vec3(way, 0.0, 0.0), Vec3(0.0, way, 0.0), Vec3(0.0, 0.0, 1.0)
    k = T.law.forces(T.p[0], T.laws, Slip(3e3, 0.02, 1.0, v, v, u, omega, spin, way * lean, t, l, n, 0.0))
    return np.array([*k.F, *k.M])


@pytest.mark.parametrize("version", [6.1, 5.2])
def test_a_wheel_in_reverse_is_one_that_rolls_forward_the_other_way(version):
    """Between them, within the least speed, forces and their slopes are continuous; at rest both count for a half."""
    car = tyre({**EXAMPLE, "UNLOADED_RADIUS": 0.32}, version, least_speed=0.5)
    for speed, slip, lean in (((-8.0, 0.3), (0.2, 0.3), 0.05), ((-20.0, -1.0), (-1.0, -1.0), -0.1)):
        reverse = turned(car, speed, slip, lean, 1.0)
        np.testing.assert_array_equal(reverse, turned(car, speed, slip, lean, -1.0))
        assert reverse[1] * slip[1] < 0.0  # against the slip
    for V in (-0.5, 0.0, 0.5):
        values = [turned(car, (V + step, 0.1), (0.1, 0.1), 0.05, 1.0) for step in np.array([-2, -1, 0, 1, 2]) * 1e-5]
        slopes = np.diff(values, axis=0) / 1e-5
        np.testing.assert_allclose(slopes[1], slopes[2], rtol=2e-3, atol=1e-3 * np.abs(slopes).max())
    np.testing.assert_allclose(turned(car, (0.0, 0.1), (0.1, 0.1), 0.0, 1.0)[:2], [
        turned(car, (0.0, 0.1), (0.1, 0.1), 0.0, -1.0)[i] for i in range(2)], rtol=1e-12)  # fmt: skip


@pytest.mark.parametrize("version", [6.1, 5.2])
@pytest.mark.parametrize(("name", "numbers", "V_scale"), [("car", CAR, 1.0), ("all terms", EXAMPLE, 0.1)])
def test_forces_at_50_points(name, numbers, V_scale, version, verify):
    """Both versions, combined slip, camber, load, another pressure than that of the file."""
    numbers = {**numbers, "LMUV": 0.0}
    numbers = {**numbers, "PHY3": 0.02} if version < 6 else numbers
    pressure, found, expected = 1.15 * numbers["NOMPRES"], [], []
    one = tyre(numbers, version, pressure=pressure)
    for load, kappa, alpha, gamma, V in points(50, numbers["FNOMIN"]):
        found.append(at(one, numbers, load, kappa, alpha, gamma, V * V_scale))
        expected.append(forces(numbers, load, kappa, alpha, gamma, V * V_scale, pressure, version))
    found, expected = np.array(found), np.array(expected)
    size = np.abs(expected).max(axis=0)
    assert np.all(size > 0.0)
    for i, what in enumerate(("F_x", "F_y", "M_x", "M_y", "M_z")):
        label = f"Magic Formula {version}, {name}: {what} at 50 points, over the largest"
        verify("Tyres", label, found[:, i] / size[i], expected[:, i] / size[i], SOURCE, absolute=1e-7)


def test_friction_falls_with_the_slip_speed():
    """LMUV, (4.E7): the slip speed is that of the point of contact against the effective rolling radius."""
    numbers = {**CAR, "LMUV": 0.3}
    V, kappa, alpha = 20.0, -0.3, 0.1
    Vs = math.hypot(V * kappa, V * math.tan(alpha))
    expected = forces(numbers, 4e3, kappa, alpha, 0.0, V, CAR["INFLPRES"], Vs=Vs)
    found = at(tyre(numbers, 6.1), numbers, 4e3, kappa, alpha, 0.0, V)
    np.testing.assert_allclose(found, expected, rtol=1e-7)


def test_a_mirrored_tyre_is_the_mirror_image():
    one, other = tyre(CAR, 6.1), tyre(CAR, 6.1, mirrored=True)
    for load, kappa, alpha, gamma, V in points(10, 4e3):
        a, b = at(one, CAR, load, kappa, alpha, gamma, V), at(other, CAR, load, kappa, -alpha, -gamma, V)
        np.testing.assert_allclose(b, a * [1, -1, -1, 1, -1], rtol=1e-9, atol=1e-9)


def test_stiffnesses_are_the_slopes_of_the_formula():
    numbers = {**CAR, **dict.fromkeys(("PHX1", "PHX2", "PHY1", "PHY2", "PVX1", "PVX2", "PVY1", "PVY2", "RHX1", "RHY1",
                                       "RHY2", "RVY1", "RVY2"), 0.0)}  # fmt: skip
    defaults = {**{name: 1.0 for name in ("LFZO", "LKX", "LKY")}, "PKY4": 2.0, "PTX1": 0.0, "PTY1": 0.0, **numbers}
    for load in (2e3, 4e3, 7e3):
        K_x, K_y = slip_stiffness(defaults, load)
        h, p = 1e-6, CAR["INFLPRES"]
        ahead, aside = forces(numbers, load, h, 0.0, 0.0, 20.0, p), forces(numbers, load, 0.0, h, 0.0, 20.0, p)
        assert ahead[0] / h == pytest.approx(K_x, rel=1e-6) and -aside[1] / h == pytest.approx(K_y, rel=1e-6)
        dp = CAR["INFLPRES"] / CAR["NOMPRES"] - 1.0
        lengths = relaxation_lengths(defaults, load)
        assert lengths[1] == pytest.approx(K_y / (CAR["LATERAL_STIFFNESS"] * (1.0 + CAR["PCFY3"] * dp)), rel=1e-12)
    old = {**defaults, "PTX1": 2.0, "PTX2": 0.3, "PTX3": -0.2, "PTY1": 1.9, "PTY2": 2.1, "LSGKP": 1.0, "LSGAL": 1.0}
    along, aside = relaxation_lengths(old, 6e3)
    assert along == pytest.approx(1.5 * (2.0 + 0.3 * 0.5) * math.exp(0.2 * 0.5) * 0.32, rel=1e-12)
    assert aside == pytest.approx(1.9 * math.sin(2 * math.atan(6e3 / (2.1 * 4e3))) * 0.32, rel=1e-12)


def test_a_slow_sweep_of_the_slip_angle():
    """inputs/magic_formula_sweep.yaml: the wheel rolls freely but for its rolling resistance."""
    recorded = RecordedRun(input_deck("magic_formula_sweep"))
    names = "normal_force", "longitudinal_force", "lateral_force", "slip_moment", "spin_rate", "slip_angle"
    tire = {name: recorded[f"elements/tire/{name}"] for name in names}
    alpha = -np.radians(recorded.time)
    load, omega = tire["normal_force"].ravel(), tire["spin_rate"].ravel()
    V_x = 20.0 * np.cos(alpha)
    V = np.hypot(V_x, 1.0)  # least_speed
    kappa = -(V_x - rolling_radius(CAR, load, omega) * omega) / V
    slip = np.arctan(20.0 * np.sin(alpha) / V)
    expected = forces(CAR, load, kappa, slip, 0.0, V_x, CAR["INFLPRES"])
    later = recorded.time > 0.1
    for name, i, share in (("longitudinal_force", 0, 1.0), ("lateral_force", 1, 1.0)):
        np.testing.assert_allclose(tire[name].ravel()[later], share * expected[i][later], atol=1e-3 * 4e3)
    Mx, My, Mz = tire["slip_moment"].T
    for found, i, share in ((Mx, 2, 1.0), (My, 3, V_x / V), (Mz, 4, V_x / V)):
        np.testing.assert_allclose(found[later], (share * expected[i])[later], atol=1e-3 * np.abs(expected[i]).max())
    np.testing.assert_allclose(tire["slip_angle"].ravel(), alpha, atol=1e-4)
    np.testing.assert_allclose(recorded["elements/tire/slip_ratio"].ravel()[later], (kappa * V / V_x)[later], atol=1e-5)
    drag = (My - 0.4 * np.gradient(omega, recorded.time)) / 0.301  # rolling resistance and the spin, over the height
    settled = recorded.time > 0.5
    np.testing.assert_allclose(tire["longitudinal_force"].ravel()[settled], drag[settled], rtol=1e-3)


def test_a_tyre_at_rest_is_in_equilibrium():
    """Conicity and ply steer come from rolling: at rest they push no wheel forward, and the weight alone acts."""
    text = f"""
    mecano: 1
    gravity: [0, 0, -9.81]
    nodes: {{carriage: {{position: [0, 0, 0.31]}}, hub: {{position: [0, 0, 0.31]}}}}
    elements:
      load: {{type: rigid_body, node: carriage, mass: 390.0, inertia: [10, 10, 10]}}
      rim: {{type: rigid_body, node: hub, mass: 10.0, inertia: [0.2, 0.4, 0.2]}}
      tire: {{type: wheel, node: hub, axis: [0, 1, 0], tire_law: car, ground: road}}
    joints:
      level: {{type: held_rotation, nodes: [ground, carriage]}}
      track: {{type: prescribed_position, node: carriage, direction: [0, 1, 0], value: 0.0}}
      bearing: {{type: hinge, nodes: [carriage, hub], axis: [0, 1, 0]}}
    tire_laws: {{car: {{magic_formula: {{coefficients: {CAR}}}}}}}
    grounds: {{road: {{plane: {{point: [0, 0, 0], normal: [0, 0, 1]}}}}}}
    initial: static
    time: {{end: 0.2, step: 0.005}}
    """
    recorded = RecordedRun(deck(text))
    np.testing.assert_allclose(recorded["elements/tire/normal_force"], 400.0 * 9.81, rtol=1e-9)
    for name in ("longitudinal_force", "lateral_force", "spin_rate"):
        np.testing.assert_allclose(recorded[f"elements/tire/{name}"], 0.0, atol=1e-6)


DECK = """
    mecano: 1
    gravity: [0, 0, -9.81]
    nodes: {hub: {position: [0, 0, 0.301]}}
    elements:
      rim: {type: rigid_body, node: hub, mass: 10.0, inertia: [0.2, 0.4, 0.2]}
      tire: {type: wheel, node: hub, axis: [0, 1, 0], tire_law: car, ground: road}
    tire_laws: {car: {magic_formula: {file: own.tir}}}
    grounds: {road: {plane: {point: [0, 0, 0], normal: [0, 0, 1]}}}
    time: {end: 0.1, step: 0.001}
"""


def with_file(folder, text, deck=DECK):
    (folder / "own.tir").write_text(text)
    (folder / "deck.yaml").write_text(textwrap.dedent(deck))
    return read_deck(folder / "deck.yaml")


ORIGINAL = (INPUTS / "passenger_car.tir").read_text()


def test_radius_and_radial_law_are_those_of_the_file(tmp_path):
    """F_z = F_z0 (q_1 w/R0 + q_2 (w/R0)^2)(1 + p_Fz1 dp), q_1 so that the slope is the stiffness there (Besselink)."""
    checked = with_file(tmp_path, ORIGINAL)
    law = checked.values["tire_laws"]["car"]
    q_1 = math.sqrt((210e3 * 0.32 / 4e3) ** 2 - 4.0 * 15.0)
    pressed = 1.0 + 0.7 * (240e3 / 220e3 - 1.0)
    numbers = [0.0, pressed * 4e3 * q_1 / 0.32, pressed * 4e3 * 15.0 / 0.32**2]
    assert law["radius"] == 0.32 and law["radial_damping"] == 50.0 / 4e3
    np.testing.assert_allclose(law["radial"][0][1]["coefficients"], numbers, rtol=1e-12)
    assert isinstance(checked, Deck) and list(checked.files) == ["own.tir"]
    again = deck_of_bytes(json.dumps(checked.resolved()).encode(), "again.yaml")
    assert again.values["tire_laws"]["car"] == law


CURVE = "[DEFLECTION_LOAD_CURVE]\n{pen fz}\n0 0\n0.01 2000 $ stiffer than linear\n0.02, 4500\n"


def test_the_deflection_load_curve_of_a_file_is_the_radial_law(tmp_path):
    """Also in millimetres and kilonewtons; its loads grow with the pressure as those of the stiffness do."""
    one = with_file(tmp_path, ORIGINAL + CURVE).values["tire_laws"]["car"]
    pressed = 1.0 + 0.7 * (240e3 / 220e3 - 1.0)
    for w, F in ((0.0, 0.0), (0.01, 2000.0), (0.02, 4500.0)):
        assert curve_at(one["radial"], w)[0] == pytest.approx(pressed * F, rel=1e-12)
    assert curve_at(one["radial"], 0.03)[0] > pressed * 6900.0  # along the end tangent
    text = ORIGINAL + CURVE.replace("0.01 2000", "10 2").replace("0.02, 4500", "20, 4.5")
    text = (
        text.replace("'meter'", "'mm'").replace("'newton'", "'kN'").replace("= 0.32", "= 320").replace("= 4000", "= 4")
    )
    other = with_file(tmp_path, text).values["tire_laws"]["car"]
    np.testing.assert_allclose(other["radial"][0][1]["points"], one["radial"][0][1]["points"], rtol=1e-12)
    again = deck_of_bytes(json.dumps(with_file(tmp_path, ORIGINAL + CURVE).resolved()).encode(), "again.yaml")
    assert again.values["tire_laws"]["car"]["radial"] == one["radial"]


@pytest.mark.parametrize("rows", ["0 0\n", "0 0\n0.02 1\n0.01 2\n", "0 0\n0.01 x\n"])
def test_a_curve_that_is_none_is_refused(tmp_path, rows):
    with pytest.raises(DeckError, match="in ascending order|not a deflection and a load"):
        with_file(tmp_path, f"{ORIGINAL}[DEFLECTION_LOAD_CURVE]\n{rows}")


def test_units_of_the_file(tmp_path):
    """The same tyre in millimetres, kilonewtons and degrees."""
    text = ORIGINAL.replace("'meter'", "'mm'").replace("'newton'", "'kN'").replace("'radians'", "'degree'")
    scales = {
        "UNLOADED_RADIUS": 1e3, "FNOMIN": 1e-3, "FZMIN": 1e-3, "FZMAX": 1e-3, "NOMPRES": 1e-9, "INFLPRES": 1e-9,
        "PRESMIN": 1e-9, "PRESMAX": 1e-9, "LONGVL": 1e3, "VXLOW": 1e3, "VERTICAL_DAMPING": 1e-6,
        "VERTICAL_STIFFNESS": 1e-6, "LONGITUDINAL_STIFFNESS": 1e-6, "LATERAL_STIFFNESS": 1e-6,
        **dict.fromkeys(("ALPMIN", "ALPMAX", "CAMMIN", "CAMMAX"), 180.0 / math.pi),
    }  # fmt: skip
    lines = []
    for line in text.splitlines():
        key, _, value = line.partition("=")
        scale = scales.get(key.strip())
        lines.append(f"{key}= {float(value.split()[0]) * scale!r}" if scale else line)
    one, other = (with_file(tmp_path, t).values["tire_laws"]["car"] for t in (ORIGINAL, "\n".join(lines)))
    for name, value in one["magic_formula"]["coefficients"].items():
        assert other["magic_formula"]["coefficients"][name] == pytest.approx(value, rel=1e-12), name


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ("FITTYP                   = 61 ", "FITTYP                   = 99 ", "has FITTYP = 99; supported: 6, 21"),
        ("[MODEL]\n", "[MODEL]\nPCY2 = 0.9\n", "is for the Magic Formula of motorcycles (PAC_MC, MF-MCTyre)"),
        (
            "[MODEL]\n",
            "[MODEL]\nPROPERTY_FILE_FORMAT = 'PAC_MC'\n",
            "supported: 5.2, 6.1 and 6.2, for motorcycles with",
        ),
        ("PCX1                     = 1.62", "PCX1                     = abc", "PCX1 = 'abc', which is not a number"),
        ("PKY1                     = -24.0\n", "", "'magic_formula' has no PKY1"),
        ("FNOMIN                   = 4000", "FNOMINAL = 4000", "'magic_formula' has no FNOMIN"),
        ("PKY1                     = -24.0", "PKY1 = 24.0", "PKY1 = 24 gives a force that drives the slip"),
        ("PKX1                     = 22.0", "PKX1 = -22.0", "(ISO 8855) PKX1 is positive"),
        ("LMUY                     = 1", "LMUY = 0", "LMUY must be greater than zero, got 0"),
        ("PKY1                     = -24.0", "PKY1 = -24.0\nPKY1 = -23", "has PKY1 twice: -24.0 and -23"),
        ("'meter'", "'furlong'", "has the unit LENGTH = 'furlong'; known: meter"),
        ("VERTICAL_STIFFNESS       = 210000\n", "", "missing 'radial', radial force"),
        ("FNOMIN                   = 4000", "FNOMIN                   = -4000", "FNOMIN must be greater than zero"),
    ],
)
def test_what_is_wrong_in_a_file(tmp_path, old, new, said):
    assert ORIGINAL.count(old) == 1
    with pytest.raises(DeckError) as error:
        with_file(tmp_path, ORIGINAL.replace(old, new))
    assert said in str(error.value)


@pytest.mark.parametrize("line", ["USE_MODE = 214", "MC_CONTOUR_A = 0.5"])
def test_the_file_of_a_motorcycle_tyre_asks_for_a_crown(tmp_path, line):
    """A warning, unless the tyre law rounds the tread."""
    text = ORIGINAL.replace("[MODEL]\n", f"[MODEL]\n{line}\n")
    (found,) = with_file(tmp_path, text).warnings
    assert "without 'crown_radius' it stands on the ground as a disc" in found.message
    rounded = DECK.replace("{file: own.tir}", "{file: own.tir}, crown_radius: 0.1")
    assert with_file(tmp_path, text, rounded).warnings == ()


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ("file: own.tir", "file: none.tir", "file 'none.tir' cannot be read"),
        ("file: own.tir", "file: ../own.tir", "must lie in the folder of the deck"),
        ("file: own.tir", "pressure: 2.4 bar", "either 'file' or 'coefficients'"),
        ("{magic_formula: {file: own.tir}}", "{radius: 0.3}", "missing a slip law, one of 'friction', 'fiala'"),
        ("own.tir}}", "own.tir}, friction: 0.8, slip_regularization: 0.1}", "a tyre has one slip law"),
        ("type: wheel", "type: flexible_wheel", "a flexible_wheel needs 'tire_law.friction'"),
    ],
)
def test_what_is_wrong_in_a_deck(tmp_path, old, new, said):
    assert DECK.count(old) == 1
    with pytest.raises(DeckError) as error:
        with_file(tmp_path, ORIGINAL, DECK.replace(old, new))
    assert said in str(error.value)


def test_a_pressure_needs_the_nominal_one_of_the_file(tmp_path):
    own = "{file: own.tir, pressure: 2.4 bar}"
    lines = [line for line in ORIGINAL.splitlines() if not line.startswith(("NOMPRES", "INFLPRES"))]
    with_file(tmp_path, ORIGINAL, DECK.replace("{file: own.tir}", own))
    with pytest.raises(DeckError, match="pressure': the file has no NOMPRES, so its forces do not depend on"):
        with_file(tmp_path, "\n".join(lines), DECK.replace("{file: own.tir}", own))
    with_file(tmp_path, "\n".join(lines))


def test_a_nominal_load_outside_of_the_range_of_the_file_is_warned_of(tmp_path):
    """In kN, beside limits in N."""
    warnings = with_file(tmp_path, ORIGINAL.replace("FNOMIN                   = 4000", "FNOMIN = 4")).warnings
    said = "tire law 'car': the nominal load FNOMIN = 4 N is outside of FZMIN = 100 to FZMAX = 9000 N"
    assert warnings[-1].message.startswith(said)
    assert with_file(tmp_path, ORIGINAL).warnings == ()


PAIR = """
mecano: 1
gravity: [0, 0, -9.81]
nodes: {left: {position: [0, 0.7, 0.3]}, right: {position: [0, -0.7, 0.3]}}
elements:
  left_rim: {type: rigid_body, node: left, mass: 20, inertia: [0.5, 0.9, 0.5]}
  right_rim: {type: rigid_body, node: right, mass: 20, inertia: [0.5, 0.9, 0.5]}
  left: {type: wheel, node: left, axis: [0, 1, 0], tire_law: one, ground: road}
  right: {type: wheel, node: right, axis: [0, 1, 0], tire_law: LAW, ground: road}
tire_laws:
  one: {magic_formula: {file: own.tir}}
  other: {magic_formula: {file: own.tir, mirrored: true}}
grounds: {road: {plane: {point: [0, 0, 0], normal: [0, 0, 1]}}}
time: {end: 1, step: 1 ms}
"""


@pytest.mark.parametrize(
    ("law", "even", "warned"), [("one", False, True), ("other", False, False), ("one", True, False)]
)
def test_an_uneven_tyre_on_both_sides_is_warned_of(tmp_path, law, even, warned):
    """With ply steer and conicity, not mirrored on the right; a file without them is the same on both sides."""
    uneven = ("PHY1 ", "PVY1 ", "QHZ1 ", "QDZ6 ", "QSX1 ")
    text = "\n".join(line for line in ORIGINAL.splitlines() if not (even and line.startswith(uneven)))
    found = with_file(tmp_path, text, PAIR.replace("LAW", law)).warnings
    said = [problem.message for problem in found if "ply steer" in problem.message]
    assert len(said) == warned
    for message in said:
        assert message.startswith(
            "tire law 'one': wheels on both sides use it, 'left' and 'right', and its file has ply"
        )
        assert "(PHY1 = 0.0025, PVY1 = 0.02, " in message and message.endswith("a law with 'mirrored: true'")


def test_the_ranges_of_a_file_are_watched(tmp_path):
    law = with_file(tmp_path, ORIGINAL).values["tire_laws"]["car"]
    watched_outputs = {output: value for output, value, _ in MAGIC_FORMULA.limits(law)}
    assert watched_outputs == {"slip_ratio": 1.5, "slip_angle": 0.5, "lean": 0.2, "normal_force": 9000.0}


YAW = 1.2  # most rate of yaw [rad/s] at the points of ``points``


@pytest.mark.parametrize(("name", "numbers", "V_scale"), [("car", CAR, 1.0), ("all terms", EXAMPLE, 0.1)])
def test_turn_slip_at_50_points(name, numbers, V_scale, verify):
    """Turns of both senses with combined slip, camber and load."""
    numbers, found, expected = {**TURN, **numbers, "LMUV": 0.0}, [], []
    one, rng = tyre(numbers, 6.1, turn_slip=True), np.random.default_rng(5)
    for load, kappa, alpha, gamma, V in points(50, numbers["FNOMIN"]):
        V, yaw = V * V_scale, rng.uniform(-YAW, YAW)
        found.append(at(one, numbers, load, kappa, alpha, gamma, V, yaw))
        turn = yaw, spin(numbers, load, kappa, V)
        expected.append(forces(numbers, load, kappa, alpha, gamma, V, one.p[0].pressure, turn=turn))
    found, expected = np.array(found), np.array(expected)
    size = np.abs(expected).max(axis=0)
    for i, what in enumerate(("F_x", "F_y", "M_x", "M_y", "M_z")):
        label = f"Magic Formula 6.1 with turn slip, {name}: {what} at 50 points, over the largest"
        verify("Tyres", label, found[:, i] / size[i], expected[:, i] / size[i], TURNED, absolute=1e-6)


def test_a_tyre_on_the_spot_has_the_moment_of_the_file():
    """QCRP1 mu_y R0 N sqrt(N/F_z0) against the turn, (4.95), also of a mirrored tyre; no other force or moment.

    Spins of the rest vanish as 1/(R0 W/v_0), 1e-4 here.
    """
    numbers = {**TURN, **CAR}
    for mirrored in (False, True):
        car = tyre(numbers, 6.1, turn_slip=True, least_speed=1e-5, mirrored=mirrored)
        for load, W in ((4e3, 0.3), (6e3, -0.3)):
            k = car.forces(load, (0.0, 0.0), (0.0, 0.0), (0.0, 0.0, W), spin=0.0)
            dp, df = car.p[0].pressure / numbers["NOMPRES"] - 1.0, load / 4e3 - 1.0
            mu = (numbers["PDY1"] + numbers["PDY2"] * df) * (1 + numbers["PPY3"] * dp + numbers["PPY4"] * dp**2)
            most = 0.2 * mu * 0.32 * load * math.sqrt(load / 4e3)
            assert k.M[2] == pytest.approx(-math.copysign(most, W), rel=1e-8)
            assert k.lost == pytest.approx(most * abs(W), rel=1e-8)
            assert np.abs([k.F[0], k.F[1], k.M[1]]).max() < 1e-3 * load


def test_turn_slip_without_a_turn_is_the_formula_without():
    """An upright tyre that runs straight has the same forces to 1e-6; the residual moment apart."""
    numbers = {**TURN, **CAR, "QDZ6": 0.0, "QDZ7": 0.0}
    for load, kappa, alpha, _, V in points(10, 4e3):
        one, other = (at(tyre(numbers, 6.1, turn_slip=on), numbers, load, kappa, alpha, 0.0, V) for on in (True, False))
        np.testing.assert_allclose(one, other, rtol=1e-5)


@pytest.mark.parametrize(("mode", "turns"), [(4, False), (25, True), (-15, True), (124, False)])
def test_the_file_says_whether_it_has_turn_slip(tmp_path, mode, turns):
    """USE_MODE 25 is that of combined slip with transients and turn slip."""
    lines = "".join(f"{name} = {number}\n" for name, number in TURN.items())
    text = ORIGINAL.replace("FITTYP ", f"USE_MODE = {mode}\nFITTYP ") + lines + "YAW_STIFFNESS = 4700\n"
    law = with_file(tmp_path, text).values["tire_laws"]["car"]["magic_formula"]
    assert law["turn_slip"] is turns and law["torsional_stiffness"] == (4700.0 if turns else None)
    named = {name: law["coefficients"][name] for name in TURN}
    assert named == TURN


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ("own.tir}", "own.tir, turn_slip: true}", "has no PHYP1, PHYP2, QCRP1, QDRP1, or zero"),
        ("own.tir}", "own.tir, torsional_stiffness: 9}", "needs 'turn_slip'"),
    ],
)
def test_what_is_wrong_with_turn_slip(tmp_path, old, new, said):
    with pytest.raises(DeckError) as error:
        with_file(tmp_path, ORIGINAL, DECK.replace(old, new))
    assert said in str(error.value)


def test_turn_slip_needs_version_6(tmp_path):
    text = ORIGINAL.replace("FITTYP                   = 61 ", "FITTYP                   = 6 ")
    with pytest.raises(DeckError, match=r"available for files of version 6.1 and 6.2, not of 5.2"):
        with_file(tmp_path, text, DECK.replace("own.tir}", "own.tir, turn_slip: true}"))
