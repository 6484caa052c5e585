"""Campbell diagrams: frequencies of a rotor over its speed, whirl, and critical speeds."""

import csv

import numpy as np
import pytest
from click import BadParameter

from mecano.analyses.sweep import sweep
from mecano.cli import commands
from mecano.errors import UsageError
from mecano.post.loci import sweep_figure
from mecano.results.sweep_file import read_sweep, whirl_word

S = "Campbell diagrams"
MASS, POLAR, ACROSS = 10.0, 0.2, 0.7  # kg, kg m2
PLACES, STIFFNESS = np.array([-0.2, 0.3]), np.array([2e6, 1e6])  # m, N/m
ROTOR = """
mecano: 1
gravity: none
parameters: {speed: 100}
nodes: {disc: {position: [0, 0, 0]}, left: {position: [-0.2, 0, 0]}, right: {position: [0.3, 0, 0]}}
elements:
  disc: {type: rigid_body, node: disc, mass: 10, inertia: [0.2, 0.7, 0.7], attached: [left, right]}
  bearing_1: {type: bushing, nodes: [ground, left], stiffness: [4.0e5, 2.0e6, 2.0e6, 0, 0, 0]}
  bearing_2: {type: bushing, nodes: [ground, right], stiffness: [0, 1.0e6, 1.0e6, 0, 0, 0]}
initial: {steady: {angular_velocity: [$speed, 0, 0], about: [0, 0, 0]}}
time: {end: 1, step: 1 ms}
"""


def stiffness():
    """Matrix of the displacement and the slope of the rotor, complex in both planes."""
    arm = np.vstack([np.ones(2), PLACES])
    return arm @ np.diag(STIFFNESS) @ arm.T


def criticals(sense):
    """Speeds [rad/s] at which an unbalance (1), or a load that turns against the rotor (-1), meets a mode."""
    inertia = np.diag([MASS, ACROSS - sense * POLAR])
    return np.sqrt(np.sort(np.linalg.eigvals(np.linalg.solve(inertia, stiffness())).real))


def whirl_rates(speed):
    """Angular velocities [rad/s] of the free whirls, positive forward: M z'' - i w G z' + K z = 0."""
    M, G = np.diag([MASS, ACROSS]), np.diag([0.0, POLAR])
    lower = np.hstack([-np.linalg.solve(M, stiffness()), 1j * speed * np.linalg.solve(M, G)])
    return np.sort(np.linalg.eigvals(np.vstack([np.hstack([np.zeros((2, 2)), np.eye(2)]), lower])).imag)


@pytest.fixture
def rotor(tmp_path):
    (tmp_path / "rotor.yaml").write_text(ROTOR)
    return tmp_path / "rotor.yaml"


def test_critical_speeds_of_a_rigid_rotor(rotor, verify):
    """Rotor in two elastic bearings: K x = w^2 diag(m, A - C) x forward, A + C backward (Genta 2005, section 2.6)."""
    (locus,) = sweep(rotor, (), ["speed=250:750:250"], rotor="disc").loci
    assert [one.order for one in locus.resonances] == [1.0] * 4
    for word, sense in (("forward", 1), ("backward", -1)):
        found = [one.speed for one in locus.resonances if whirl_word(one.whirl) == word]
        verify(S, f"rigid rotor: {word} critical speeds [rad/s]", found, criticals(sense), "closed form", relative=1e-9)
    for i, speed in enumerate(locus.axis.values):
        signed = locus.values[:, i].imag * np.sign(locus.whirl[:, i])
        lateral = np.sort(signed[np.abs(locus.whirl[:, i]) > 0.9])
        np.testing.assert_allclose(lateral, whirl_rates(speed), rtol=1e-9)
    np.testing.assert_allclose(locus.speed, locus.axis.values, rtol=1e-12)
    followed = np.abs(locus.whirl) > 0.9
    assert np.all(np.sign(locus.whirl[followed].reshape(-1, 3)) == np.sign(locus.whirl[followed].reshape(-1, 3)[:, :1]))


def test_whirl_of_equal_modes(rotor):
    """The centre of mass between two equal bearings: the forward and the backward circle have one frequency."""
    rotor.write_text(ROTOR.replace("-0.2, 0, 0", "-0.3, 0, 0").replace("1.0e6", "2.0e6"))
    (locus,) = sweep(rotor, (), ["speed=600,700"], rotor="disc", orders=(1.0, 0.5)).loci
    circles = np.abs(locus.values[:, 0].imag - np.sqrt(4e6 / MASS)) < 1e-6
    np.testing.assert_allclose(sorted(locus.whirl[circles, 0]), [-1.0, 1.0], rtol=1e-9)
    found = [one.speed for one in locus.resonances if one.order == 1.0 and abs(one.whirl) > 0.9]
    tilt = np.sqrt(4e6 * 0.09 / (ACROSS + POLAR * np.array([-1.0, 1.0])))
    expected = [*[np.sqrt(4e6 / MASS)] * 2, *tilt[(tilt > 600) & (tilt < 700)]]
    np.testing.assert_allclose(found, sorted(expected), rtol=1e-9)


def test_files_and_picture_of_a_campbell_diagram(rotor, monkeypatch, capsys):
    monkeypatch.chdir(rotor.parent)
    command = "modes rotor.yaml --sweep speed=500,600 --campbell disc --order 1 --order 2 --csv -q"
    commands(command.split(), standalone_mode=False)
    assert "modes with 1, 2 times the speed of 'disc':" in capsys.readouterr().out
    file = read_sweep("rotor_sweep.h5")
    assert file.rotor == "disc" and file.orders == (1.0, 2.0) and len(file.resonances["speed"]) > 1
    with open("rotor_sweep_resonances.csv", newline="") as table:
        rows = list(csv.reader(table))
    assert rows[0][:4] == ["speed", "order", "speed [rad/s]", "frequency [Hz]"]
    assert [float(row[2]) for row in rows[1:]] == list(file.resonances["speed"])
    with open("rotor_sweep.csv", newline="") as table:
        assert next(csv.reader(table))[:2] == ["speed", "speed [rad/s]"]
    over = sweep_figure(file).axes[0]
    texts = [text.get_text() for text in over.texts]
    assert {"1x", "2x"} <= set(texts) and f"{criticals(1)[0] * 30 / np.pi:.4g}" in texts


@pytest.mark.parametrize(
    ("options", "said"),
    [
        ("--sweep speed=1,2 --campbell disk", "--campbell: the deck has no node 'disk'; did you mean 'disc'?"),
        ("--sweep speed=1,2 --sweep elements.disc.mass=1,2 --campbell disc", "--campbell takes one --sweep"),
        ("--campbell disc", "belongs to --sweep"),
        ("--sweep speed=1,2 --order 2", "belongs to --campbell"),
    ],
)
def test_errors_of_a_campbell_diagram(rotor, monkeypatch, options, said):
    monkeypatch.chdir(rotor.parent)
    with pytest.raises((UsageError, BadParameter)) as info:
        commands(["modes", "rotor.yaml", *options.split()], standalone_mode=False)
    assert said in str(info.value)


def test_a_mode_that_does_not_oscillate_has_no_resonance_at_rest(rotor):
    """Axial motion with more than critical damping, 2 sqrt(k m): two real modes, 0 Hz as the rotor at rest."""
    rotor.write_text(ROTOR.replace("2.0e6, 0, 0, 0]}", "2.0e6, 0, 0, 0], damping: [5.0e3, 0, 0, 0, 0, 0]}"))
    (locus,) = sweep(rotor, (), ["speed=0,100"], rotor="disc").loci
    assert np.sum(np.all(np.abs(locus.values.imag) == 0.0, axis=1)) == 2
    assert not locus.resonances and not locus.unrefined
