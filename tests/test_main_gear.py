"""A main landing gear, and the study of its load cases with names, picture and report."""

import csv

import numpy as np
import pytest
from click.testing import CliRunner
from time_runs import INPUTS, RecordedRun, input_deck

from mecano.cli import commands
from mecano.study.read import read_study, try_deck

STUDY = INPUTS / "studies" / "main_gear_loads.yaml"
SHORT = """
study: 1
title: Sink speeds
deck: {deck}
set: {{time.end: 0.05}}
list:
  - {{case: hard <landing>, parameters.sink: 3}}
  - {{case: soft landing, parameters.sink: 1}}
  - {{parameters.sink: 0.02, elements.airframe.mass: -1}}
outputs:
  vertical: {{of: wheel.normal_force, take: max}}
"""


def impulse(time, force):
    return np.sum(0.5 * (force[1:] + force[:-1]) * np.diff(time))


def test_momentum_is_the_impulse_of_the_ground():
    """Trapezoids over the accepted steps; half the steps change both impulses by less than the tolerance."""
    m = RecordedRun(input_deck("main_gear", "time.adaptive.tolerance=1e-3"))
    masses = {"airframe": 8200.0, "cylinder": 79.8, "piston": 60.9, "rim": 69.3}
    momentum = sum(mass * m[f"elements/{name}/velocity"][:, 2] for name, mass in masses.items())
    ground = impulse(m.time, m["elements/wheel/normal_force"])  # the lift carries the weight
    assert momentum[-1] - momentum[0] == pytest.approx(ground, rel=2e-5)
    moment = -m["elements/wheel/longitudinal_force"] * m["elements/wheel/loaded_radius"]
    assert 5.0 * m["elements/wheel/spin_rate"][-1] == pytest.approx(impulse(m.time, moment), rel=2e-4)


def test_the_load_cases_can_be_run():
    study = read_study(STUDY)
    assert [case.name for case in study.cases][:2] == ["level landing", "level landing, wet"]
    assert try_deck(study).file.endswith("main_gear.yaml") and "case" not in study.paths


@pytest.fixture(scope="module")
def table(tmp_path_factory):
    folder = tmp_path_factory.mktemp("loads")
    (folder / "short.yaml").write_text(SHORT.format(deck=INPUTS / "main_gear.yaml"))
    result = CliRunner().invoke(commands, ["sweep", str(folder / "short.yaml"), "-o", str(folder / "runs"), "--plot"])
    assert "2 complete, 1 failed" in result.output
    return folder / "runs" / "table.h5"


def test_the_table_names_the_cases(table):
    with open(table.with_suffix(".csv"), newline="") as file:
        rows = list(csv.DictReader(file))
    assert [row["name"] for row in rows] == ["hard <landing>", "soft landing", ""]
    assert table.with_suffix(".png").stat().st_size > 10_000


def test_the_report_names_the_governing_cases(table):
    page = table.with_name("loads.html")
    result = CliRunner().invoke(commands, ["post", str(table), "--report", str(page)])
    text = page.read_text()
    governing = text.partition("Governing cases</h2>")[2].partition("</table>")[0]
    assert result.exit_code == 0 and governing.index("soft landing") < governing.index("hard &lt;landing&gt;")
    assert "3 cases: 2 complete, 1 failed" in text and "<landing>" not in text and "data:image/svg" in text
    assert "mass" in text.partition("Cases that are not complete</h2>")[2].partition("</table>")[0]


def test_a_report_on_a_study_has_no_plots(table):
    result = CliRunner().invoke(commands, ["post", str(table), "--report", "r.html", "--plot", "wheel.normal_force"])
    assert "not of the table of a study" in str(result.exception)


@pytest.mark.parametrize(("given", "found"), [("pic", "pic.png"), ("some.svg", "some.svg"), ("new/", "new/table.png")])
def test_names_of_the_picture_of_a_study(table, given, found, tmp_path):
    result = CliRunner().invoke(commands, ["post", str(table), "-o", f"{tmp_path}/{given}"], catch_exceptions=False)
    assert result.exit_code == 0 and (tmp_path / found).stat().st_size > 1000


def test_a_picture_of_a_study_has_a_known_format(table):
    result = CliRunner().invoke(commands, ["post", str(table), "-o", "table.pdf"])
    assert "pictures are written as png or svg" in str(result.exception)
