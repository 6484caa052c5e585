"""Straight steady running, and modes over parameters of a deck: root loci, critical values, maps, files, pictures.

References: the benchmark bicycle (Meijaard, Papadopoulos, Ruina & Schwab, Proc. R. Soc. A 463 (2007), table 2 and
section 7); a trailing wheel with Moreland's tyre, whose eigenvalues are the roots of
(I s^2 + c s + k)[C1 s^2 + (1 + V C D) s + V C K] + L (K + D s)(V + L s)(1 + C1 s); the thin disc, which stays upright
above v^2 = g r/3.
"""

import csv
import json
import math
import re
import textwrap
from dataclasses import replace
from types import SimpleNamespace

import h5py
import numpy as np
import pytest
from matplotlib.figure import Figure
from time_runs import INPUTS, deck, input_deck

from mecano.analyses import sweep as sweeps
from mecano.analyses.operating_point import operating_point
from mecano.analyses.sweep import sweep, sweep_into
from mecano.analyses.sweep_axis import Axis
from mecano.analyses.sweep_text import _numbers, known_digits
from mecano.errors import ConvergenceError, DeckError, ResultsError, UsageError
from mecano.post import loci as loci_pictures
from mecano.post.loci import _mark, _shortened, real_range, shown_modes, sweep_figure
from mecano.post.pictures import post
from mecano.results.sweep_file import read_sweep
from mecano.solve.modal.critical import critical
from mecano.solve.modal.modes import solve, unstable
from mecano.solve.modal.tracking import Spectrum, growing, loci, track

G = 9.81


def running(base, node):
    """Position, velocity and angular velocity (inertial) of a node of a state."""
    system, s = base.prepared.system, base.state
    of, i = system.numbering, [n.name for n in system.nodes].index(node)
    x, r = of.x[i], of.r[i]
    return s.z[x : x + 3], s.v[x : x + 3], s.R[of.rotation[i]] @ s.v[r : r + 3]


TROLLEY = """
    mecano: 1
    parameters: {{speed: 15.0, drag: 0.0, slope: 0.0}}
    gravity: [0, 0, -9.81]
    nodes:
      carriage: {{position: [0, 0, 0.5]}}
      hub: {{position: [0, 0, 0.5]}}
    elements:
      load: {{type: rigid_body, node: carriage, mass: 200.0, inertia: [1, 1, 1]}}
      rim: {{type: rigid_body, node: hub, mass: 10.0, inertia: [0.3, 0.5, 0.3]}}
      tire: {{type: wheel, node: hub, axis: [0, 1, 0], tire_law: rubber, ground: road}}
      grease: {{type: torsion_spring_damper, nodes: [carriage, hub], axis: [0, 1, 0],
               law: {{damper: {{coefficient: $drag}}}}}}
    joints:
      level: {{type: held_rotation, nodes: [ground, carriage]}}
      bearing: {{type: hinge, nodes: [carriage, hub], axis: [0, 1, 0]}}
      {tow}
    tire_laws:
      rubber:
        radius: 0.4
        radial: {{polynomial: {{coefficients: [0, 1.0e5, 3.0e5]}}}}
        friction: 0.8
        slip_regularization: 0.01
    grounds:
      road: {{plane: {{point: [0, 0, 0], normal: [$slope, 0, 1]}}}}
    initial:
      steady: {{velocity: [$speed, 0, 0]}}
    time: {{end: 1.0, step: 1.0e-3}}
"""
TOW = "tow: {type: prescribed_position, node: carriage, direction: [1, 0, 0], value: {linear: {slope: $speed}}}"


def trolley(tow="", **parameters):
    text = TROLLEY.format(tow=tow)
    for name, value in parameters.items():
        text = text.replace(f"{name}: {'15.0' if name == 'speed' else '0.0'}", f"{name}: {value!r}")
    return operating_point(deck(text))


def test_a_tyre_in_the_air_comes_down_and_rolls():
    """1e5 w + 3e5 w^2 = m g, spin = v/(radius - w), without friction: the hub was 0.1 m above the road."""
    base = trolley()
    w = np.roots([3e5, 1e5, -210.0 * G]).max()
    position, velocity, spin = running(base, "hub")
    assert position[2] == pytest.approx(0.4 - w, abs=1e-10)
    np.testing.assert_allclose(velocity, [15.0, 0, 0], atol=1e-9)
    np.testing.assert_allclose(spin, [0, 15.0 / (0.4 - w), 0], atol=1e-6)
    assert np.abs(base.state.a).max() < 1e-7


def test_a_vehicle_stands_on_all_wheels_that_just_touch():
    """The axle loads m g b/l: not balanced on one wheel, with the other in the air; and it starts where it is."""
    base = operating_point(
        deck("""
    mecano: 1
    gravity: [0, 0, -9.81]
    nodes:
      body: {position: [0, 0, 1.5]}
      front: {position: [3, 0, 0.35]}
      rear: {position: [-1, 0, 0.35]}
      front_hub: {position: [3, 0, 0.35]}
      rear_hub: {position: [-1, 0, 0.35]}
    elements:
      body: {type: rigid_body, node: body, mass: 3000, inertia: [8000, 8000, 8000], attached: [front, rear]}
      front_rim: {type: rigid_body, node: front_hub, mass: 10, inertia: [0.3, 0.6, 0.3]}
      rear_rim: {type: rigid_body, node: rear_hub, mass: 10, inertia: [0.3, 0.6, 0.3]}
      front_wheel: {type: wheel, node: front_hub, axis: [0, 1, 0], tire_law: rubber, ground: road}
      rear_wheel: {type: wheel, node: rear_hub, axis: [0, 1, 0], tire_law: rubber, ground: road}
    joints:
      plane: {type: planar, nodes: [ground, body], axis: [0, 1, 0]}
      front: {type: hinge, nodes: [front, front_hub], axis: [0, 1, 0]}
      rear: {type: hinge, nodes: [rear, rear_hub], axis: [0, 1, 0]}
    tire_laws: {rubber: {radius: 0.35, radial: {linear: {slope: 400 kN/m}}, friction: 0.8, slip_regularization: 0.1}}
    grounds: {road: {plane: {point: [0, 0, 0], normal: [0, 0, 1]}}}
    initial: {steady: {velocity: [20, 0, 0]}}
    time: {end: 1, step: 1 ms}
    """)
    )
    sunk = [0.35 - running(base, hub)[0][2] for hub in ("front_hub", "rear_hub")]
    x = [running(base, name)[0][0] for name in ("front_hub", "body", "rear_hub")]
    arm = (x[1] - x[2]) / (x[0] - x[2])
    np.testing.assert_allclose(4e5 * np.array(sunk), G * np.array([3000.0 * arm + 10.0, 3000.0 * (1 - arm) + 10.0]),
                               rtol=1e-6)  # fmt: skip
    np.testing.assert_allclose(x, [3.0, 0.0, -1.0], atol=0.05)


def test_drag_of_a_towed_wheel_is_made_up_by_slip():
    """A bearing that takes c spin: friction 2 mu N slip/eps (nearly) at the rim, c spin = friction r."""
    base = trolley(TOW, drag=0.5)
    w = np.roots([3e5, 1e5, -210.0 * G]).max()
    r, load = 0.4 - w, 210.0 * G
    _, _, spin = running(base, "hub")
    slip = 15.0 - spin[1] * r
    u = slip / 0.01
    assert 0.0 < u < 1.0
    assert 0.5 * spin[1] == pytest.approx(0.8 * load * u * (2.0 - u) * r, rel=1e-6)


@pytest.mark.parametrize(
    ("tow", "parameters", "text"),
    [
        ("", {"drag": 0.5}, "along the road some 51.8 N remain backward: wheel 'tire' 51.8 N; causes are"),
        ("", {"slope": 0.02}, "forces remain out of balance"),
        (TOW.replace("$speed", "14.0"), {}, "the constraint 'prescribed_position 'tow'"),
    ],
    ids=["drag without a drive", "downhill", "towed otherwise"],
)
def test_where_there_is_no_steady_running(tow, parameters, text):
    with pytest.raises(ConvergenceError, match="no straight steady running with the velocity") as info:
        trolley(tow, **parameters)
    assert text in str(info.value)


@pytest.mark.parametrize(
    ("way", "said"),
    [
        ("[-1, 0, 0]", "along the road some 30 N remain backward"),
        ("[1, 0, 0]", "along the road some 30 N remain forward"),
        ("[0, 1, 0]", "across the road some 30 N remain to the left"),
        ("[0, -1, 0]", "across the road some 30 N remain to the right"),
    ],
)
def test_the_load_that_pushes_is_named(way, said):
    """A force against the motion, with it, or to a side, on a carriage that nothing drives or guides, on ice."""
    loads = f"loads: {{headwind: {{type: force, node: carriage, direction: {way}, value: 30}}}}"
    on_ice = textwrap.dedent(TROLLEY.format(tow="")).replace("friction: 0.8", "friction: 1.0e-6")
    with pytest.raises(ConvergenceError, match="no straight steady running") as info:
        operating_point(deck(on_ice + loads))
    assert f"{said}: force 'headwind' 30 N; " in str(info.value)


def test_loads_of_which_each_is_small_are_named_by_their_kind():
    """Twelve carts on a slope of 2 %, each on a wheel: 12 m g sin(slope)."""
    text = """
    mecano: 1
    gravity: [0.2, 0, -9.81]
    nodes: {hub$i: {repeat: {i: 1..12}, position: [3*$i, 0, 0.4]}}
    elements:
      cart$i: {repeat: {i: 1..12}, type: rigid_body, node: hub$i, mass: 50, inertia: [1, 1, 1]}
      tyre$i: {repeat: {i: 1..12}, type: wheel, node: hub$i, axis: [0, 1, 0], tire_law: rubber, ground: road}
    joints:
      upright$i: {repeat: {i: 1..12}, type: planar, nodes: [ground, hub$i], axis: [0, 1, 0]}
    tire_laws: {rubber: {radius: 0.4, radial: {linear: {slope: 400 kN/m}}, friction: 0.8, slip_regularization: 0.1}}
    grounds: {road: {plane: {point: [0, 0, 0], normal: [0, 0, 1]}}}
    initial: {steady: {velocity: [20, 0, 0]}}
    time: {end: 1, step: 1 ms}
    """
    with pytest.raises(ConvergenceError, match="along the road some 120 N remain forward: 12 rigid_body 120 N; causes"):
        operating_point(deck(text))


@pytest.mark.parametrize("unit", [1.0, 1e-3, 1e3])
def test_drag_is_balanced_by_the_integrator_of_a_drive(unit):
    """The thrust is c spin/r, whatever the unit of the signal, whose 50 N are many length scales."""
    signals = f"""signals:
  missing: $speed - carriage.velocity.x
  stored: {{type: integrator, input: missing}}
  thrust: 100*missing + 10*stored*{unit}
loads: {{thrust: {{type: force, node: carriage, direction: [1, 0, 0], value: thrust}}}}
"""
    free = textwrap.dedent(TROLLEY.format(tow="")).replace("drag: 0.0", "drag: 0.5")
    base = operating_point(deck(free + signals))
    r = 0.4 - np.roots([3e5, 1e5, -210.0 * G]).max()
    q, names = base.state.z, base.prepared.system.numbering.name
    thrust = 10 * unit * q[names.index("integrator 'stored': value")]
    slip = 15.0 - running(base, "hub")[2][1] * r
    assert 0.8 * 210.0 * G * slip / 0.01 * (2.0 - slip / 0.01) == pytest.approx(thrust, rel=1e-6)
    assert thrust == pytest.approx(0.5 * 15.0 / r**2, rel=1e-3)


@pytest.mark.parametrize(
    ("read", "text"),
    [
        ("carriage.position.x", "the forces change over time, in node carriage, hub: force x"),
        ("bearing.angle", "forces remain out of balance"),
    ],
)
def test_signals_may_vary_in_steady_running_if_no_force_varies(read, text):
    """A driver measures the way; the wheel spins as without it."""
    law = "{table: {points: [[50, 0], [60, 9]]}}"
    signals = f"signals: {{way: {read}, push: {{type: curve, input: way, law: {law}}}}}"
    load = "loads: {push: {type: force, node: carriage, direction: [1, 0, 0], value: %s}}"
    free = textwrap.dedent(TROLLEY.format(tow=""))
    base = operating_point(deck(free + signals + "\n" + load % "push"))
    assert running(base, "hub")[2][1] == pytest.approx(running(trolley(), "hub")[2][1], rel=1e-9)
    with pytest.raises(ConvergenceError, match=text):
        operating_point(deck(free + signals + "\n" + load % "way - push"))


def test_no_running_is_steady_on_a_wavy_road():
    wavy = ", profile: {direction: [1, 0, 0], height: {sine: {amplitude: 1 mm, frequency: 0.5}}}}\n"
    text = TROLLEY.format(tow=TOW).replace("[$slope, 0, 1]}}\n", "[0, 0, 1]}" + wavy)
    with pytest.raises(ConvergenceError, match="no straight steady running(.|\n)*the road, which is flat at the"):
        operating_point(deck(text))


def test_a_rim_whose_principal_axis_is_not_its_axle_is_named():
    """Set by 0.01 rad about the vertical, axle and wheel; the inertia is still that about y."""
    text = TROLLEY.format(tow=TOW).replace("axis: [0, 1, 0]", "axis: [-0.01, 1, 0]")
    with pytest.raises(ConvergenceError, match="'tire' wobbles as it spins: its 'axis' is not a principal axis of"):
        operating_point(deck(text))


def test_cornering_tyre():
    """At the slip angle alpha: F = K y = psi/C but for the drag; the rest creeps, V sin(alpha - atan psi) = u eps."""
    base = operating_point(input_deck("step_steer", "nodes.hub.orientation=[0, 0, 0.02]",
                            "initial={steady: {velocity: [10, 0, 0]}}"))  # fmt: skip
    names = base.prepared.system.numbering.name
    y, psi = (abs(base.state.z[names.index(f"flexible_wheel 'tire': {name}")]) for name in ("y", "psi"))
    assert 2e5 * y == pytest.approx(6e4 * psi, rel=1e-3) and psi == pytest.approx(0.02, rel=5e-3)
    u = 10.0 * np.sin(0.02 - np.arctan(psi)) / 0.01
    assert 2e5 * y == pytest.approx(0.8 * 1e4 * u * (2.0 - u), rel=1e-3)
    assert np.abs(base.state.a).max() < 1e-6


def test_a_run_from_steady_running_stays_there(tmp_path):
    from mecano.analyses.dynamic import run
    from mecano.results.reader import open_results

    run(input_deck("caster_shimmy", "parameters.swing=0", "time.end=0.05"), tmp_path / "s.h5")
    with open_results(tmp_path / "s.h5") as results:
        assert np.abs(results["joints/caster/angle"].values).max() < 1e-9  # rounding, which shimmy lets grow
        spin = results["nodes/hub/angular_velocity"].values
        np.testing.assert_allclose(spin, [[0, 20.0 / 0.3, 0]] * len(spin), atol=1e-9)


BICYCLE = "Meijaard, Papadopoulos, Ruina & Schwab 2007"


def caster_roots(V, c=20.0, k=0.0, D=0.0, C1=0.0, I=1.0, L=0.1, K=2e5, C=1 / 6e4):  # noqa: E741
    left = np.polymul([I, c, k], [C1, 1 + V * C * D, V * C * K])
    right = L * np.polymul(np.polymul([D, K], [L, V]), [C1, 1.0])
    roots = np.roots(np.trim_zeros(np.polyadd(left, right), "f"))
    return np.sort_complex(roots[roots.imag > -1e-9])


def test_bicycle(verify):
    """Weave and capsize speeds, and the eigenvalues at 5 m/s, from one sweep."""
    (locus,) = sweep(INPUTS / "bicycle.yaml", (), ["speed=4:6.5:0.5"]).loci
    weave, capsize = locus.critical
    assert not weave.destabilizes and capsize.destabilizes and capsize.value.imag == 0.0
    verify("Rolling", "bicycle: weave speed [m/s]", weave.place, 4.2923825363, BICYCLE, relative=1e-8)
    verify("Rolling", "bicycle: capsize speed [m/s]", capsize.place, 6.0242620154, BICYCLE, relative=1e-8)
    frequency = weave.value.imag
    verify("Rolling", "bicycle: weave frequency there [rad/s]", frequency, 3.4350338486, BICYCLE, relative=1e-8)
    expected = [-0.322866429004087, -0.775341882195845 + 4.464867713788229j, -14.078389692798215]
    found = sorted(locus.values[:, 2], key=abs)
    verify("Rolling", "bicycle: eigenvalues at 5 m/s [1/s]", found, expected, BICYCLE, relative=1e-8)
    assert locus.values.shape == (3, 6) and np.all(np.isfinite(locus.values.real))
    np.testing.assert_array_equal(locus.count, [1, 0, 0, 0, 0, 1])


@pytest.mark.parametrize(("speeds", "count"), [("1,5,300", 2), ("6.0242,6.0243", 1)])
def test_how_well_a_critical_value_is_known(speeds, count):
    """Free motions hide a real eigenvalue within 1e-9 m/s of the capsize speed; the digits reported are correct."""
    (locus,) = sweep(INPUTS / "bicycle.yaml", (), [f"speed={speeds}"]).loci
    assert len(locus.critical) == count
    for c, exact in zip(locus.critical[::-1], (6.024262015388837, 4.292382536341), strict=False):
        assert abs(c.place - exact) < max(c.error, 5e-12) and c.error < 1e-9
        reported = known_digits(c.place, c.error)
        unit = 10.0 ** -len(reported.partition(".")[2])
        assert abs(float(reported) - exact) < 0.5 * unit + c.error and 2.0 * c.error < unit < 1e-8


def test_digits_that_hold():
    assert known_digits(6.02426201447, 1.1e-9) == "6.02426201" and known_digits(6.02426201447, 1e-13) == "6.0242620145"
    assert known_digits(126.7200000, 2e-3) == "126.72" and known_digits(-0.0456789, 4e-5) == "-0.0457"
    assert known_digits(3.14, 7.0) == "3" and known_digits(0.0, 1e-3) == "0" and known_digits(2.5, 0.0) == "2.5"


def test_disc_that_stays_upright(tmp_path, verify):
    """Neutral above the critical speed: the border of growth, where a pair of real eigenvalues becomes imaginary."""
    from test_rigid_wheel import UPRIGHT

    text = UPRIGHT.format(kind="rigid_wheel", v="$v", w="'$v / 0.3225'")
    (tmp_path / "disc.yaml").write_text("\n".join(line[4:] for line in text.splitlines()) + "\nparameters: {v: 1}\n")
    (locus,) = sweep(tmp_path / "disc.yaml", (), ["v=0.8:1.4:0.2"]).loci
    (border,) = locus.critical
    verify("Rolling", "disc: critical speed [m/s]", border.place, 1.0269250216057646, "sqrt(g r/3)", relative=1e-9)


SHIMMY = {
    "undamped": ({"c": 0.0}, None),
    "damped": ({}, (3.5692509722800376, 50.430749027719955)),
    "moreland": ({"c": 4.0, "k": 5e4, "C1": 1e-3}, (15.694164989939658, 126.71999999999922)),
}


def shimmy(case, speeds, verify):
    """A sweep of the trailing wheel of b1, and the constants of the case."""
    values, critical = SHIMMY[case]
    law = f"{{spring: {{stiffness: {values.get('k', 0.0)}}}, damper: {{coefficient: {values.get('c', 20.0)}}}}}"
    overrides = (f"elements.damper.law={law}", "tire_laws.rubber.lateral={moreland: {lateral_stiffness: 2.0e5, "
                 f"yaw_coefficient: {1 / 6e4!r}, yaw_time: {values.get('C1', 0.0)!r}}}}}")  # fmt: skip
    (locus,) = sweep(INPUTS / "caster_shimmy.yaml", overrides, [speeds]).loci
    for V, column in zip(locus.axis.values, locus.values.T, strict=True):
        found = np.sort_complex(column[np.isfinite(column.real)])
        expected = caster_roots(V, **values)
        if len(found) > len(expected):  # a pair of real values is on two branches
            found = np.unique(np.round(found, 9))
        what = f"{case} trailing wheel at {V:g} m/s: eigenvalues [1/s]"
        tolerance = 2e-8 if len(found) != len(column) else 1e-8
        verify("Shimmy", what, found, expected, "characteristic polynomial", relative=tolerance)
    if critical:
        within = [v for v in critical if locus.axis.values[0] < v < locus.axis.values[-1]]
        places = [c.place for c in locus.critical]
        assert len(places) == len(within)
        verify("Shimmy", f"{case} trailing wheel: critical speeds [m/s]", places, within, "its roots", relative=1e-6)
    else:
        assert not locus.critical and np.all(locus.count > 0)


def test_shimmy(verify):
    """Some speeds of b1; eigenvalues to 1e-8, the critical speed to 1e-6."""
    shimmy("damped", "speed=1,20,40,60", verify)


@pytest.mark.slow
@pytest.mark.parametrize("case", SHIMMY)
def test_shimmy_at_all_speeds(case, verify):
    shimmy(case, "speed=1,5,10,20,40,60,80,120,130", verify)


def test_growing_oscillations_are_shown_apart_from_a_slow_divergence(tmp_path):
    """The weave of the bicycle grows below 4.29 m/s, its capsize slowly above 6.02 m/s; at first it falls over."""
    text, _ = sweep_into(
        tmp_path / "b.h5", str(INPUTS / "bicycle.yaml"), (), ["speed=0.2,2,5,8", "elements.rider.mass=85,86"]
    )
    assert "unstable at speed 0.2 to 2, 8; oscillations grow at 2\n" in text
    file = read_sweep(tmp_path / "b.h5")
    swings, growth = file.map["oscillation_growth"][0], file.map["growth"][0]
    assert np.isnan(swings[0]) and swings[1] == growth[1] > 0.0 > swings[3] and growth[3] > 0.0
    (axes, *_) = sweep_figure(file).axes
    assert axes.get_legend_handles_labels()[1][0] == "an oscillation grows"


@pytest.mark.parametrize(
    ("longest", "shown"), [(29, "1: a moves; b turns; c moves"), (25, "1: a moves; b turns ..."), (8, "1: a ...")]
)
def test_legends_end_between_motions(longest, shown):
    assert _shortened("1: a moves; b turns; c moves", longest) == shown


def test_map_files_and_pictures(tmp_path):
    """The border in speed and damping: where the roots of b1 become imaginary."""
    path = tmp_path / "map.h5"
    reported = []
    text, total = sweep_into(path, INPUTS / "caster_shimmy.yaml", (), ["speed=20:60:20", "damping=16,24"], columns=True,
                             progress=lambda *done: reported.append(done))  # fmt: skip
    assert total == 6 == len(reported) and reported[-1][:2] == (6, 6) and "damping 24, speed 60" in reported[-1][2]
    file = read_sweep(path)
    assert file.names == ("speed", "damping") and not file.modes
    for i, damping in enumerate((16.0, 24.0)):
        for j, speed in enumerate((20.0, 40.0, 60.0)):
            roots = caster_roots(speed, c=damping)
            assert file.map["growth"][i, j] == pytest.approx(roots.real.max(), rel=1e-8)
            assert file.map["growing"][i, j] == (roots.real.max() > 0)
    (border,) = file.critical["parameter"]
    assert abs(caster_roots(border, c=24.0).real.max()) < 1e-8 and file.critical["other"][0] == 24.0
    assert f"critical speed {border:.11g}: mode 1 (oscillates at 11.3053 Hz) grows below it" in text
    shown = [label.get_text() for label in sweep_figure(file).legends[0].get_texts()]
    assert shown == ["border: unstable below"]
    with open(path.with_suffix(".csv"), newline="") as table:
        rows = list(csv.reader(table))
    assert rows[0][:3] == ["damping", "speed", "growth [1/s]"] and len(rows) == 7
    assert float(rows[1][2]) == file.map["growth"][0, 0]
    with open(path.with_name("map_critical.csv"), newline="") as table:
        assert [row[:2] for row in csv.reader(table)] == [["speed", "damping"], [repr(float(border)), "24.0"]]
    row = file.other.tolist().index(24.0)
    across = loci_pictures.border(file)[row]
    order = np.argsort(across)
    assert np.interp(0.0, across[order], file.parameter[order]) == pytest.approx(float(border), rel=1e-9)
    assert (np.sign(loci_pictures.border(file)) == np.sign(file.map["growth"])).all()
    ax, bar = sweep_figure(file).axes
    assert (ax.get_xlabel(), ax.get_ylabel()) == ("speed [m/s]", "damping [N m s/rad]")
    low, high = (min(file.map["growth"].flat), max(file.map["growth"].flat))
    ticks = [tick for tick in bar.get_yticks() if low <= tick <= high]
    assert min(ticks) < 0.0 < max(ticks)
    assert [p.name for p in post([path], output=str(tmp_path))] == ["map.png"]
    assert (tmp_path / "map.png").stat().st_size > 20_000


@pytest.mark.parametrize("name", ["map.h5", "map.csv", "map_critical.csv"])
def test_a_file_that_exists_is_refused_before_the_sweep(tmp_path, monkeypatch, name):
    (tmp_path / name).write_text("measured by hand\n")
    monkeypatch.setattr(sweeps, "sweep", lambda *_, **__: pytest.fail("computed in vain"))
    with pytest.raises(ResultsError, match=f"{name} already exists"):
        sweep_into(tmp_path / "map.h5", INPUTS / "caster_shimmy.yaml", (), ["speed=20:60:20"], columns=True)
    assert [path.name for path in tmp_path.iterdir()] == [name]


def test_critical_values_about_a_start_that_is_kicked(tmp_path):
    """The arm turns at 0.1 rad/s: no state is steady, and a mode of about 1e-5 /s even seems to appear."""
    kick = ("initial={velocities: [{nodes: all, velocity: [$speed, 0, 0]}, {nodes: [hub], angular_velocity: "
            "[0, '$speed/0.3', 0]}, {nodes: [arm], angular_velocity: [0, 0, 0.1]}]}")  # fmt: skip
    path = tmp_path / "kicked.h5"
    text, _ = sweep_into(path, INPUTS / "caster_shimmy.yaml", (kick,), ["speed=40:60:20"])
    lines = [line for line in text.splitlines() if line.startswith("critical")]
    assert lines[-1] == (
        "critical speed about 50.4: mode 2 (oscillates at 11.7 Hz) grows below it, for an instant only: the states "
        "there are not steady"
    )
    assert text.count("violate the constraints") == 1  # reported once, not for each speed with its numbers
    file = read_sweep(path)
    assert np.all(file.critical["of_instant"] == 1.0)
    assert [p.name for p in post([path])] == ["kicked.png"]


def test_critical_values_about_a_start_that_is_hardly_kicked(tmp_path):
    """At 1e-5 rad/s the equations change by 3e-8 a radian: more than steady running leaves, 2e-10."""
    kick = ("initial={velocities: [{nodes: all, velocity: [$speed, 0, 0]}, {nodes: [hub], angular_velocity: "
            "[0, '$speed/0.3', 0]}, {nodes: [arm], angular_velocity: [0, 0, 1.0e-5]}]}")  # fmt: skip
    text, _ = sweep_into(tmp_path / "kicked.h5", INPUTS / "caster_shimmy.yaml", (kick,), ["speed=40,60"])
    assert [line[:25] for line in text.splitlines() if line.startswith("critical")] == ["critical speed about 50.4"]
    (locus,) = sweep(INPUTS / "caster_shimmy.yaml", (), ["speed=40,60"]).loci
    assert locus.variation.max() < 1e-9 and not locus.of_instant(locus.critical[0])


def test_a_motion_without_stiffness_has_no_critical_value():
    """The spin of a wheel that swings at 0.3 rad/s: its eigenvalue is between -0.009 and 0.0015 /s, and means nothing.

    Known critical speeds: the header of the deck.
    """
    (locus,) = sweep(INPUTS / "shimmy_freeplay.yaml", (), ["speed=1,20,50,80"]).loci
    places = [c.place for c in locus.critical]
    assert places == pytest.approx([1.56, 73.3], rel=1e-2)
    np.testing.assert_array_equal(locus.count, [0, 1, 1, 0])
    spin = [row for row in locus.values if np.all(np.abs(row) < 0.02)]
    assert len(spin) == 1 and np.any(unstable(spin[0])) and not np.all(unstable(spin[0]))
    np.testing.assert_allclose(locus.least, 0.3, rtol=0.3)


def test_growth_counts_where_it_means_more_than_zero_before_it_ends():
    """Three branches: about zero throughout; slow at first, then fast; a pair that parts into real eigenvalues."""
    values = np.array([[-0.1, 0.1, 0.05, -0.1, -0.1], [-0.1, 0.1, 2.0, 2.0, -3.0], [0.1 + 9j, -0.1 + 9j, -1, 2, 3]])
    spectra = [Spectrum(column, np.eye(3), 1.0) for column in values.T]
    reported = [growing(np.full(5, b), spectra) for b in range(3)]
    np.testing.assert_array_equal(reported, [5 * [False], [0, 1, 1, 1, 0], [1, 0, 0, 1, 1]])
    np.testing.assert_array_equal(growing(np.array([-1, 1, 1, -1, 1]), spectra), [0, 1, 1, 0, 0])


def test_growth_from_a_limit_that_is_a_value_of_the_sweep_is_located_within_its_error():
    """A rotor grows by 0.05 (w - 300): neutral at 300, where a sweep in steps of 50 looks, and seen somewhat above."""

    def spectrum_at(w):
        return Spectrum(np.array([0.05 * (w - 300.0) + 200.0j]), np.eye(1), 0.0)

    ends = [(w, spectrum_at(w).values[0], np.ones(1)) for w in (300.0, 350.0)]
    found = critical(spectrum_at, *ends, 0)
    assert abs(found.place - 300.0) <= found.error < 2e-3


def test_pictures_show_the_modes_near_the_limit_of_stability():
    """A mode that grows by 0.5 /s beside one that decays by 2000 /s: both cannot be seen on one axis."""
    real = np.array([[-0.3, 0.1, 0.5], [-40.0, -60.0, -2000.0], [-1.0, -2.0, -3.0]])
    imaginary = np.array([[10.0, 11.0, 12.0], [0.0, 0.0, 900.0], [30.0, 30.0, 30.0]])
    size = np.hypot(real, imaginary)
    low, high, beyond = real_range({"real_part": real, "imaginary_part": imaginary, "damping_ratio": -real / size})
    assert -10.0 < low < -3.0 and 0.5 < high < 0.8 and beyond == [1]


def test_pictures_of_a_stable_gear_show_its_shimmy_mode_beside_a_slow_decay():
    real, imaginary = np.array([[-0.3, -0.2], [-15.0, -13.0]]), np.array([[0.0, 0.0], [73.0, 80.0]])
    ratio = -real / np.hypot(real, imaginary)
    low, _, beyond = real_range({"real_part": real, "imaginary_part": imaginary, "damping_ratio": ratio})
    assert -20.0 < low < -15.0 and not beyond


def test_pictures_of_a_stable_robot_show_the_modes_that_its_gain_moves():
    """A vibration that decays by 0.05 /s is 600 times nearer to the limit, but is the same at every gain."""
    real, imaginary = np.array([[-0.05] * 3, [-30.0, -31.0, -30.0]]), np.array([[96.0] * 3, [40.0, 100.0, 150.0]])
    ratio = -real / np.hypot(real, imaginary)
    low, high, beyond = real_range({"real_part": real, "imaginary_part": imaginary, "damping_ratio": ratio})
    assert -35.0 < low < -31.0 and high > 0.0 and not beyond


@pytest.mark.parametrize("rounding", [1e-12, -1e-12, 0.0])
def test_damping_that_is_rounding_has_no_sign(rounding):
    assert _numbers(2.0 * np.pi * (1j + rounding)) == ("1", "0.00000")
    assert _numbers(2.0 * np.pi * (1j + 0.02))[1] == "-0.02000"


def test_numbers_of_close_critical_values_do_not_overlap():
    """Measured in the drawn picture, of axes as wide as those of the sheet."""
    speeds = np.array([4.01, 4.2, 4.22, 9.0, 4.6, 4.25, 5.1])
    file = SimpleNamespace(parameter=np.array([0.0, 10.0]), critical={"parameter": speeds, "of_instant": 0.0 * speeds})
    figure = Figure(figsize=(9.6, 7.6))
    ax = figure.subplots(2, 2)[0, 1]
    ax.set_xlim(0.0, 10.0)
    _mark(ax, file)
    figure.draw_without_rendering()
    boxes = [text.get_window_extent() for text in ax.texts]
    assert len(boxes) == len(speeds)
    assert not [(a, b) for i, a in enumerate(boxes) for b in boxes[:i] if a.overlaps(b)]


def test_pictures_leave_out_modes_that_are_much_faster_than_the_growing_ones():
    """Modes of 2 Hz that grows, 5 Hz, 900 Hz with little damping, and one without oscillation."""
    frequency = np.array([[2.0, 2.1], [5.0, 5.5], [900.0, 800.0], [0.0, 0.0]])
    real = np.array([[-0.1, 0.1], [-1.0, -1.0], [-2.0, -2.0], [-3.0, -3.0]])
    imaginary = 2.0 * np.pi * frequency
    modes = {"real_part": real, "imaginary_part": imaginary, "frequency": frequency}
    modes["damping_ratio"] = -real / np.hypot(real, imaginary)
    for below, wanted, left_out, limit in (
        (None, [0, 1, 3], [2], 6.3),
        (3, [0, 3], [1, 2], 3),
        (1e3, range(4), [], None),
    ):
        shown, above, found = shown_modes(modes, below)
        assert list(shown) == list(wanted) and list(above) == left_out and found == (limit and pytest.approx(limit))
    for below, above, wanted in ((None, 3.0, [1]), (None, 1.0, [0, 1]), (1e3, 6.0, [2]), (2.05, 2.0, [0])):
        assert list(shown_modes(modes, below, above)[0]) == wanted
    stable = {name: values[1:] for name, values in modes.items()}  # none grows: the least damped one is the fast one
    assert list(shown_modes(stable)[0]) == [0, 1, 2]


@pytest.mark.parametrize(("ratios", "shown"), [((0.4, 0.1), True), ((0.14, 0.1), False), ((0.9, 0.4), False)])
def test_pictures_show_lightly_damped_modes_that_the_parameter_damps(ratios, shown):
    """The weave of a motorcycle grows at 0.5 Hz; its wobble at 9 Hz only loses most of its damping."""
    frequency, ratio = np.array([[0.5, 0.5], [9.0, 9.0]]), np.array([(-0.1, 0.2), ratios])
    size = 2.0 * np.pi * frequency / np.sqrt(1.0 - ratio**2)
    modes = {"real_part": -ratio * size, "imaginary_part": 2.0 * np.pi * frequency, "frequency": frequency}
    assert list(shown_modes({**modes, "damping_ratio": ratio})[0]) == [0, 1][: 1 + shown]


def test_root_loci_on_the_command_line(tmp_path, monkeypatch, capsys):
    from mecano.cli import commands

    monkeypatch.chdir(tmp_path)
    arguments = ["modes", str(INPUTS / "bicycle.yaml"), "--sweep", "speed=4 m/s:5:1.8 km/h", "--plot", "--csv"]
    commands(arguments, standalone_mode=False)
    out, errors = capsys.readouterr()
    assert "critical speed 4.2923825363: mode " in out and "bicycle_sweep.png" in out and "3 states" in errors
    file = read_sweep("bicycle_sweep.h5")
    assert len(sweep_figure(file, below=0.01).axes[2].lines) < len(sweep_figure(file).axes[2].lines)
    assert len(sweep_figure(file, above=1e5).axes[2].lines) < len(sweep_figure(file).axes[2].lines)
    assert [ax.get_xlabel() for ax in sweep_figure(file).axes] == ["real part [1/s]", *["speed [m/s]"] * 3]
    assert file.title == "Benchmark bicycle" and file.modes["real_part"].shape == (3, 3)
    assert file.modes["damping_ratio"].max() == 1.0 and len(file.motions) == 3
    with h5py.File("bicycle_sweep.h5") as h5:
        assert "$speed" in h5["deck/text"][()].decode() and h5["modes/real_part"].attrs["units"] == "1/s"
    with open("bicycle_sweep.csv", newline="") as table:
        rows = list(csv.reader(table))
    assert rows[0][:2] == ["speed", "mode 1 real_part [1/s]"] and [row[0] for row in rows[1:]] == ["4.0", "4.5", "5.0"]
    with open("bicycle_sweep_critical.csv", newline="") as table:
        heads, *rows = csv.reader(table)
    assert heads[:3] == ["speed", "frequency [Hz]", "mode"] and abs(float(rows[0][0]) - 4.2923825363) < 1e-8
    assert sorted(p.name for p in tmp_path.iterdir()) == [
        f"bicycle_sweep{ending}" for ending in (".csv", ".h5", ".png", "_critical.csv")
    ]


def test_states_that_are_not_found_are_left_out(tmp_path):
    """Towed at 20 m/s: at other speeds there is no steady running."""
    tow = "joints.tow.value={linear: {slope: 20}}"
    found = sweep(INPUTS / "caster_shimmy.yaml", (tow,), ["speed=10,20,30"])
    np.testing.assert_array_equal(found.loci[0].count, [-1, 1, -1])
    [reported] = [text for text in found.warnings if "no straight steady running" in text]
    assert reported.endswith("(in 2 of the states)")
    with pytest.raises(ConvergenceError, match="would be violated over time"):
        sweep(INPUTS / "caster_shimmy.yaml", (tow,), ["speed=10,30"])


def test_motions_of_one_kind_are_one_warning():
    case = sweeps.Case("")
    for value, motion in enumerate(("node 'tip' turns about [0, 1, 0]; node 'a' turns about [0, 1, 0]; and 3 more",
                                    "node 'a' moves along [1, 0, 0]; and 4 more")):  # fmt: skip
        case.warn(f"the equilibrium at load factor 1 is unstable; {value + 1} direction(s): {motion}", value)
        case.warn(f"deck.yaml:{value}:2: node '{'ab'[value]}' has no mass", value)
    assert [text.partition(" ")[0] for text in case.counted_warnings({0, 1})] == [
        "the",
        "deck.yaml:0:2:",
        "deck.yaml:1:2:",
    ]


def test_warnings_count_states_and_not_the_search_for_critical_values(tmp_path, monkeypatch):
    """The oscillator becomes stable at 0: there its mode is computed again and again, with the same warnings."""
    (tmp_path / "o.yaml").write_text(textwrap.dedent(OSCILLATOR))
    searched = []

    def warned(deck):
        damping = deck.values["parameters"]["damping"]
        searched.append(damping)
        texts = ["everywhere"] + ["negative 7"] * (damping < 0.0) + ["small"] * (abs(damping) < 1.0)
        return replace(operating_point(deck), warnings=(*texts, f"at {damping}", f"twice {damping}", "twice 1"))

    def solved(*arguments):
        """Modes that are not converged between the values of the sweep, where no table marks them."""
        found = solve(*arguments)
        return replace(found, residuals=found.residuals + (1.0 if abs(searched[-1]) < 1.0 else 0.0))

    monkeypatch.setattr(sweeps, "operating_point", warned)
    monkeypatch.setattr(sweeps, "solve", solved)
    found = sweep(tmp_path / "o.yaml", (), ["damping=-2,6"])
    assert len(searched) > 2 and len(found.loci[0].critical) == 1
    assert found.warnings == [
        "everywhere", "negative 7 (in 1 of the states)", "at -2.0", "twice -2.0",
        "small (between the states, near critical values)",
    ]  # fmt: skip


OSCILLATOR = """
    mecano: 1
    gravity: none
    parameters: {damping: 1}
    nodes: {b: {position: [1, 0, 0]}}
    elements: {m: {type: rigid_body, node: b, mass: 1, inertia: [1, 1, 1]}}
    joints: {t: {type: prismatic, nodes: [ground, b], axis: [1, 0, 0]}}
    signals: {u: -100*t.displacement - $damping*t.velocity}
    loads: {act: {type: joint_force, joint: t, value: u}}
    time: {end: 1, step: 0.1}
    """


@pytest.mark.parametrize("lost", [True, False])
def test_a_mode_that_becomes_stable_where_no_critical_value_is_found(lost, tmp_path, monkeypatch):
    """The growth changes sign between the values; the refinement finds no state, or loses the mode."""
    (tmp_path / "o.yaml").write_text(textwrap.dedent(OSCILLATOR))

    def failing(deck, *rest):
        if deck.values["parameters"]["damping"] not in (-2.0, 6.0):
            raise ConvergenceError("no rest was found; the worst equations:\n  node m: force x")
        return operating_point(deck, *rest)

    if lost:
        monkeypatch.setattr(sweeps, "critical", lambda *_: None)
        cause = "the mode could not be followed from one to the other"
    else:
        monkeypatch.setattr(sweeps, "operating_point", failing)
        cause = r"no state was found at \S+: no rest was found"
    text, _ = sweep_into(tmp_path / "o.h5", tmp_path / "o.yaml", (), ["damping=-2,6"])
    wanted = "mode 1 becomes stable between damping -2 and 6; the critical value was not refined, because " + cause
    said = next(line for line in text.splitlines() if re.fullmatch(wanted, line))
    assert "\nunstable at damping -2\n" in text and "equations" not in text
    with h5py.File(tmp_path / "o.h5") as file:
        assert said in json.loads(file["deck/warnings"][()])
    monkeypatch.undo()
    text, _ = sweep_into(tmp_path / "o.h5", tmp_path / "o.yaml", (), ["damping=-2,6"], force=True)
    assert "grows below it" in text and "becomes" not in text


@pytest.mark.parametrize(("values", "where"), [("-2,-1,0,1", "ends between damping -1 and 0"), ("0,1", "")])
def test_growth_that_ends_at_a_value_of_the_sweep(values, where, tmp_path):
    """Without stiffness and damping the mass is free: no branch leads from its growth to there."""
    text = OSCILLATOR.replace("-100*", "-$damping*").replace(" - $damping*t.velocity", "")
    (tmp_path / "o.yaml").write_text(textwrap.dedent(text))
    (locus,) = sweep(tmp_path / "o.yaml", (), [f"damping={values}"]).loci
    reason = "; the critical value was not refined, because no mode has a branch at both: shift the values of the sweep"
    assert locus.unrefined == ([f"growth {where}{reason} a little"] if where else [])


def test_values_of_a_sweep():
    names = {"speed": 1.0}
    np.testing.assert_allclose(Axis.parse("speed=10:80:10", names).values, np.arange(10.0, 81.0, 10.0))
    np.testing.assert_allclose(Axis.parse("speed=0:1:0.1", names).values, np.linspace(0.0, 1.0, 11), atol=1e-15)
    np.testing.assert_allclose(Axis.parse("speed=80:10:-35", names).values, [10.0, 45.0, 80.0])
    axis = Axis.parse("tire_laws.rubber.radius=0.4,.3,1e-1", names)
    assert axis.path == axis.name == "tire_laws.rubber.radius" and axis.values.tolist() == [0.1, 0.3, 0.4]
    assert Axis.parse("speed=1,2", names).path == "parameters.speed" and not axis.unit
    axis = Axis.parse("speed=0:72 km/h:18km/h", names)
    assert axis.values.tolist() == [0.0, 5.0, 10.0, 15.0, 20.0] and axis.unit == "m/s"
    axis = Axis.parse("nodes.a.position.0=0.5 m, 1 ft", names)
    assert axis.values.tolist() == [0.3048, 0.5] and axis.unit == "m"


@pytest.mark.parametrize(
    ("texts", "message"),
    [
        (["sped=1:2:1"], "no parameter 'sped' to sweep over; did you mean 'speed'?"),
        (["speed"], "write --sweep speed=10:80:1"),
        (["speed=1:2"], "cannot be understood"),
        (["speed=1:2:-1"], "has no values, or more than"),
        (["speed=1:2:0"], "has no values, or more than"),
        (["speed=0:1:1e-9"], "has no values, or more than"),
        (["speed=a,b"], "cannot be understood"),
        (["speed=1,2:3"], "cannot be understood"),
        (["speed=1 m/s,2 kg"], "'speed=1 m/s,2 kg': 1 m/s and 2 kg are different quantities"),
        (["speed=10 kmh,20 kmh"], "'kmh' is not a unit; did you mean 'km/h'?"),
        (["speed=1,2", "speed=1,2"], "both sweeps are over 'speed'"),
        (["speed=1,2", "swing=0,1", "damping=1,2"], "once, or twice"),
    ],
)
def test_sweeps_that_cannot_be(texts, message):
    with pytest.raises(UsageError) as info:
        sweep(INPUTS / "caster_shimmy.yaml", (), texts)
    assert message in str(info.value)


@pytest.mark.parametrize("values", ["speed=1 m,2 m", "elements.rim.mass=1 m:2 m:0.5 m"])
def test_units_of_a_sweep_are_checked_as_those_of_the_deck(values):
    with pytest.raises(DeckError, match="is expected, and 'm' is a length"):
        sweep(INPUTS / "caster_shimmy.yaml", (), [values])


@pytest.mark.parametrize(("varied", "unit"), [("speed", "m/s"), ("elements.rim.mass", "kg"), ("damping", "N m s/rad")])
def test_units_of_a_sweep_are_those_of_the_deck_and_of_its_files(varied, unit, tmp_path):
    """Of values without a unit, for the table, the file and its picture."""
    text = (INPUTS / "caster_shimmy.yaml").read_text().replace("speed: 20.0 m/s", "speed: 72 km/h")
    (tmp_path / "caster.yaml").write_text(text)
    (tmp_path / "variant.yaml").write_text("include: caster.yaml\n")
    (axis,) = sweep(tmp_path / "variant.yaml", (), [f"{varied}=10,20"]).axes
    assert axis.unit == unit and axis.values.tolist() == [10.0, 20.0]


def test_modes_that_cross_keep_their_shapes():
    """Two eigenvalues that pass one another, and a pair that parts into two real ones."""
    places = np.linspace(0.0, 1.0, 12)
    spectra = []
    for p in places:
        square = 4.0 * (p - 0.55)  # of half the difference of the two of the pair
        root = np.sqrt(complex(square))
        values = np.array([1j * (3.0 + 2.0 * p), 1j * (4.0 - p), -5.0 + root, -5.0 - root])
        values = np.concatenate([values, values[:2].conj()])
        shapes = np.eye(6, 4, dtype=complex)
        shapes[2] = shapes[3] = [0, 0, 1, 1j * square]
        shapes[3, 3] *= -1
        shapes[4:] = shapes[:2].conj()
        order = np.random.default_rng(int(1000 * p)).permutation(6)
        spectra.append(Spectrum(values[order], shapes[order]))
    values, rows, shown = loci(track(spectra, places), spectra)
    assert len(values) == 4 and np.all(rows >= 0)
    is_pair, counts = places < 0.55, np.sum(shown >= 0, axis=0)
    np.testing.assert_array_equal(counts, np.where(is_pair, 3, 4))  # the pair is one mode, the real ones are two
    np.testing.assert_array_equal(np.isfinite(values.real), shown >= 0)
    imaginary = sorted((row for row in values if row[0].real == 0.0), key=lambda row: row[0].imag)
    np.testing.assert_allclose(imaginary[0].imag, 3.0 + 2.0 * places)
    np.testing.assert_allclose(imaginary[1].imag, 4.0 - places)
    ends = sorted(row[-1].real for row in values if row[-1].real)
    np.testing.assert_allclose(ends, -5.0 + np.sqrt(1.8) * np.array([-1.0, 1.0]))


LEANING = """
    mecano: 1
    gravity: [0, 0, -9.81]
    parameters: {lean: 10 deg}
    nodes: {pin: {position: [0, 0, 0]}}
    elements:
      bar: {type: rigid_body, node: pin, mass: 1, center_of_mass: [0, 0, 0.5], inertia: [0.1, 0.1, 1.0e-4]}
    joints:
      hinge:
        {type: hinge, nodes: [ground, pin], axis: [0, cos($lean), sin($lean)], turning_law: {spring: 1, damper: 0.1}}
    time: {end: 1, step: 0.01}
    """


def test_angles_are_in_degrees_for_people_and_in_radians_in_files(tmp_path):
    """A pole of 1 kg and 0.5 m on a spring of 1 N m/rad stands from the lean a on with m g l cos(a)^2 = 1 N m."""
    path, poles = tmp_path / "poles.h5", tmp_path / "poles.yaml"
    poles.write_text(textwrap.dedent(LEANING))
    text, _ = sweep_into(path, poles, (), ["lean=40 deg:80 deg:10 deg"])
    place = math.acos(math.sqrt(1.0 / (9.81 * 0.5)))
    assert "modes over lean, 5 values from 40 to 80 deg\n" in text and "\nlean [deg]  growing" in text
    [found] = re.findall("critical lean ([0-9.]+): mode 1 \\(diverges\\) grows below it", text)
    assert float(found) == pytest.approx(math.degrees(place), rel=1e-7) and "unstable at lean 40 to 60" in text
    file = read_sweep(path)
    np.testing.assert_allclose(file.parameter, np.deg2rad([40.0, 50.0, 60.0, 70.0, 80.0]), rtol=1e-14)
    np.testing.assert_allclose(file.critical["parameter"], place, rtol=1e-7)
    ax = sweep_figure(file).axes[1]
    assert ax.get_xlabel() == "lean [deg]" and [text.get_text() for text in ax.texts] == [f"{math.degrees(place):.5g}"]
