"""Momentum, mass and centre of mass of a run: closed forms, balances, and the identities of a rigid motion."""

import csv

import numpy as np
import pytest
from click.testing import CliRunner
from time_runs import input_deck

import mecano
from mecano.analyses.momentum import _momentum
from mecano.analyses.prepare import prepare
from mecano.cli import commands
from mecano.errors import UsageError

FALLING = {
    "mecano": 1, "gravity": [0.0, 0.0, -10.0],
    "nodes": {"a": {"position": [0.0, 0.0, 0.0]}, "b": {"position": [2.0, 0.0, 0.0]}},
    "sections": {"rod": {"type": "circle", "diameter": 0.02, "E": 2e11, "nu": 0.3, "density": 8000.0}},
    "elements": {"bar": {"type": "beam", "nodes": ["a", "b"], "section": "rod"}},
    "initial": {"velocities": [{"nodes": ["a", "b"], "velocity": [3.0, 0.0, 0.0], "angular_velocity": [0, 0, 0.5],
                                "about": [1.0, 0.0, 0.0]}]},
    "time": {"end": 0.2, "step": 1e-3}, "output": {"every": 0.01},
}  # fmt: skip


def test_a_thrown_bar_has_the_momentum_of_a_rigid_one(tmp_path):
    """Closed forms: m = rho A L, p = m (v_0 + g t), L about the centre = m (L^2/12 + r^2/4) omega."""
    path = tmp_path / "bar.h5"
    with mecano.run(FALLING, path, quiet=True) as results:
        found = mecano.momentum(FALLING, results, about=(1.0, 0.0, 0.0))
    np.testing.assert_array_equal(mecano.momentum(FALLING, path, about=(1.0, 0.0, 0.0)).angular, found.angular)
    mass = 8000.0 * np.pi * 1e-4 * 2.0
    inertia = mass * (2.0**2 / 12.0 + 0.01**2 / 4.0)
    t = found.time
    assert found.mass == pytest.approx(mass, rel=1e-12)
    path_of_center = np.outer(t, [3.0, 0.0, 0.0]) + np.outer(t**2, [0.0, 0.0, -5.0]) + [1.0, 0.0, 0.0]
    assert found.center_of_mass == pytest.approx(path_of_center, abs=1e-5)  # the error of the steps, h^2
    assert found.linear == pytest.approx(mass * (np.array([3.0, 0.0, 0.0]) + np.outer(t, [0.0, 0.0, -10.0])), abs=1e-6)
    about_center = found.angular_about_center
    assert about_center == pytest.approx(np.tile([0.0, 0.0, 0.5 * inertia], (len(t), 1)), abs=1e-6)
    assert found.angular == pytest.approx(
        about_center + np.cross(found.center_of_mass - [1.0, 0.0, 0.0], found.linear), abs=1e-12
    )


@pytest.mark.parametrize("about", ["tip", (1.0, 0.0), [0.0, 0.0, np.nan], None])
def test_what_is_no_point_is_refused(about):
    with pytest.raises(UsageError, match="write an inertial point, such as"):
        mecano.momentum(FALLING, "none.h5", about=about)


def test_docking_keeps_momentum_and_the_command_says_so(tmp_path, monkeypatch):
    """600 kg at 0.1 m/s and 900 kg at rest grip one another and part: p_x = 60 N s, L_z is constant."""
    monkeypatch.chdir(tmp_path)
    assert CliRunner().invoke(commands, ["example", "docking"]).exit_code == 0
    assert CliRunner().invoke(commands, ["run", "docking.yaml", "-q"]).exit_code == 0
    found = CliRunner().invoke(commands, ["momentum", "docking.yaml", "docking.h5", "--csv", "momentum.csv"])
    assert found.exit_code == 0, found.output
    assert found.output.startswith("mass 1500 kg; 201 saved times; angular momentum about (0, 0, 0) m\n")
    with open("momentum.csv", newline="", encoding="utf-8") as file:
        lines = list(csv.DictReader(file))
    p = np.array([[float(line[f"linear_momentum.{axis} [N s]"]) for axis in "xyz"] for line in lines])
    L = np.array([float(line["angular_momentum.z [N m s]"]) for line in lines])
    assert p == pytest.approx(np.tile([60.0, 0.0, 0.0], (201, 1)), abs=1e-9)
    assert pytest.approx(np.full(201, 300 * 0.02 - 0.3 * 60.0), abs=1e-6) == L  # turn of the chaser, path of its centre


@pytest.mark.parametrize("name", ["nose_gear_rigid", "solar_array", "superelement_arm", "mecanum", "gear_stages"])
def test_a_rigid_motion_of_all_nodes_has_the_momentum_of_a_rigid_body(name):
    """T = p V/2 and p = m V for a translation; T = L w/2 and p = m w x (c - o) for a rotation about o."""
    prepared, rng = prepare(input_deck(name)), np.random.default_rng(0)
    system, s = prepared.system, prepared.state.copy()
    of, (V, w, o) = system.numbering, rng.normal(size=(3, 3))
    x = of.x[:, None] + np.arange(3)
    s.v[:] = s.a[:] = 0.0
    s.v[x] = V
    m, c, p, L = _momentum(system, s, o)
    assert p == pytest.approx(m * V, rel=1e-9)
    assert system.observe(s).energy[0] == pytest.approx(0.5 * p @ V, rel=1e-9)
    assert pytest.approx(np.cross(c - o, p), rel=1e-9) == L
    s.v[x] = np.cross(w, s.z[x] - o)
    for r, i in zip(of.r, of.rotation, strict=True):
        s.v[r : r + 3] = s.R[i].T @ w
    _, _, p, L = _momentum(system, s, o)
    assert p == pytest.approx(m * np.cross(w, c - o), rel=1e-9)
    assert system.observe(s).energy[0] == pytest.approx(0.5 * L @ w, rel=1e-9)


@pytest.mark.parametrize(
    ("deck", "text"), [("pendulum", "it has no node 'pin'"), ("hanging_chain", "nothing moves in statics")]
)
def test_results_of_another_deck_are_refused(deck, text, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    mecano.run(FALLING, "bar.h5", quiet=True, set={"time.end": 0.01}).close()
    CliRunner().invoke(commands, ["example", deck])
    with pytest.raises(mecano.MecanoError, match=text):
        mecano.momentum(f"{deck}.yaml", "bar.h5")


def test_results_of_other_masses_are_refused(tmp_path):
    """Nothing but the deck has them: the momentum would be that of another model. Times of the run do not matter."""
    path = tmp_path / "bar.h5"
    mecano.run(FALLING, path, quiet=True, set={"time.end": 0.01}).close()
    assert mecano.momentum(FALLING, path).mass > 0.0
    with pytest.raises(mecano.MecanoError, match="it has sections.rod.density: 8000.0 instead of 800.0; give the deck"):
        mecano.momentum(FALLING, path, set={"sections.rod.density": 800})
