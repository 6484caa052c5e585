"""Decks of inputs/ with statics and modes against their known answers, from the command line to the file."""

import math

import numpy as np
import pytest
from click.testing import CliRunner
from equilibria import Path
from time_runs import INPUTS, deck, input_deck

import mecano
from mecano.analyses.modal import modes
from mecano.analyses.static import run
from mecano.cli import commands
from mecano.errors import ConvergenceError
from mecano.post.pictures import post
from mecano.results.modes_file import read_modes

BUCKLING = 4.012599343578901  # N, J_{-1/4}(c/2) = 0
FLUTTER = 3.5 - math.sqrt(2.0)  # N


def command(*arguments):
    return CliRunner().invoke(commands, [str(argument) for argument in arguments], catch_exceptions=False)


def test_snap_through(tmp_path, verify):
    path = tmp_path / "s.h5"
    result = command("run", INPUTS / "snap_through.yaml", "-o", path)
    assert result.exit_code == 0 and "load factor 1" in result.output and "1 unstable direction(s)" in result.output
    with mecano.open_results(path) as results:
        assert results.axis.path == "length of the path" and results.status == "complete"
        factor, z = results["static/load_factor"].values, results["top.position.z"].values
        l0, length = np.hypot(1.0, 0.3), np.hypot(1.0, z)
        load = 2000.0 * (l0 - length) / length * z
        verify("Equilibria", "snap-through: load along the path [N]", 20.0 * factor, load, "closed form", absolute=1e-7)
        np.testing.assert_allclose(results["weight.force.z"].values, -20.0 * factor)
        np.testing.assert_allclose(results["left_bar.extension"].values, length - l0, atol=1e-12)
        bars = 2.0 * 0.5 * 1000.0 * (length - l0) ** 2
        np.testing.assert_allclose(results["energy/potential"].values, bars, atol=1e-12)
        assert results["static/unstable_directions"].values.max() == 1
    pictures = [picture.name for picture in post([path])]
    assert "s_path.png" in pictures and "s_overview.png" in pictures
    assert "equilibria, length of the path from 0 to" in command("info", path).stdout


def test_snap_through_by_steps_fails_and_names_the_free_motion(tmp_path):
    path = tmp_path / "s.h5"
    with pytest.raises(ConvergenceError, match=r"node 'top' moves along \[0, 0, 1\]"):
        run(input_deck("snap_through", "static.method=steps"), path)
    with mecano.open_results(path) as results:
        assert results.status == "failed" and "no equilibrium was found" in results.reason
        assert 9.94 < 20.0 * results.time[-1] < 9.949917


def test_hanging_chain(tmp_path, verify):
    result = command("run", INPUTS / "hanging_chain.yaml", "-o", tmp_path / "c.h5")
    assert result.exit_code == 0
    with mecano.open_results(tmp_path / "c.h5") as results:
        sag, exact = results["p2.position.z"].values[-1], -0.30231562972057735
        verify("Equilibria", "hanging chain: its lowest point [m]", sag, exact, "statics of a chain", absolute=1e-12)
        assert results.axis.path == "load factor" and results.time.tolist() == [0.0, 1.0]


def test_check_reports_the_stability_of_the_start():
    text = command("check", INPUTS / "hanging_chain.yaml").stdout
    assert "equilibrium      load factor up to 1 by relaxation" in text
    assert "the start without loads: 5 direction(s) without stiffness" in text


def test_column_flutters(tmp_path, verify):
    path = tmp_path / "z.h5"
    result = command("modes", INPUTS / "ziegler_column.yaml", "-o", path, "--plot")
    assert result.exit_code == 0 and result.stdout.splitlines()[-1] == str(path.with_suffix(".png"))
    found, exact = np.abs(read_modes(path).values), [np.sqrt(0.5), 1.0]
    verify("Equilibria", "column of Ziegler: frequencies [rad/s]", found, exact, "closed form", relative=1e-10)
    for load, kinds in ((FLUTTER - 1e-6, {"oscillation"}), (FLUTTER + 1e-6, {"oscillation", "flutter"})):
        assert set(modes(input_deck("ziegler_column", f"parameters.load={load!r}"), None)[1].kinds) == kinds


def statics_and_modes(elements):
    """Lateral buckling loads [N] found by the stability of the path, and by the frequency that vanishes."""
    mesh = f"elements.blade.mesh={elements}"
    path = Path(input_deck("lateral_buckling", mesh, "static.steps=40"))
    by_statics = 5.0 * float(path.result.warnings[0].split("near ")[1].split(",")[0])
    loads, squares = (0.995 * by_statics, 0.999 * by_statics), []
    for load in loads:
        loaded = input_deck("lateral_buckling", mesh, f"parameters.load={load!r}", "static.steps=4")
        squares.append((modes(loaded, None)[1].values[0] ** 2).real)
    return by_statics, loads[1] + (loads[1] - loads[0]) * squares[1] / (squares[0] - squares[1])


def test_lateral_buckling_by_statics_and_by_modes():
    """Both agree, and the error falls with the square of the number of elements."""
    errors = np.array([np.array(statics_and_modes(n)) / BUCKLING - 1.0 for n in (4, 8)])
    np.testing.assert_allclose(errors[:, 0], errors[:, 1], atol=1e-4)
    np.testing.assert_allclose(errors[0] / errors[1], 4.0, atol=0.3)
    assert np.all(np.abs(errors[1]) < 0.01)


def test_static_deck_needs_no_time():
    assert deck(input_deck("hanging_chain").text).values["time"] is None
