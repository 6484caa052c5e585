"""Pictures follow from what kinds declare, and from results files alone."""

import json
from pathlib import Path
from types import SimpleNamespace

import h5py
import numpy as np
import pytest
from process import mecano_process
from time_runs import INPUTS

import mecano.post
from mecano.elements import KINDS
from mecano.post.plans import _PLANS, plans
from mecano.post.runs import open_runs, opened_runs
from mecano.post.shapes import SHAPES, Motion, shapes
from mecano.post.sheets import default_sheets

NO_PLAN = {"drop_test"}  # a picture that is computed, not planned


@pytest.fixture(scope="module")
def drop(tmp_path_factory):
    path = tmp_path_factory.mktemp("display") / "drop.h5"
    command = ("run", INPUTS / "wheel_drop.yaml", "-q", "-o", path, "--set", "time.end=0.1")
    assert mecano_process(*command)[0] == 0
    return path


@pytest.mark.parametrize("kind", KINDS.values(), ids=KINDS)
def test_displays_name_existing_shapes_pictures_and_outputs(kind):
    """Shapes that can be drawn, pictures that are made, outputs that it has with the units that they need."""
    display, outputs = kind.display, {output.name: output for output in kind.outputs}
    assert not display.shape or display.shape in SHAPES
    assert set(display.pictures) <= {plan.name for plan in _PLANS} | NO_PLAN
    for name, unit, shape in ((display.force, "N", [(3,)]), (display.force_at, "m", [(3,)]),
                              (display.axial, "N", [(), (3,)])):  # fmt: skip
        assert not name or (outputs[name].unit == unit and outputs[name].shape in shape), name


def test_post_names_no_kind():
    """No string of a file of post is the name of a kind, unless it is a shape, an output or a field besides."""
    words = {*SHAPES, "force", "moment", "fixed"}
    named = [
        (file.name, kind)
        for file in Path(mecano.post.__file__).parent.glob("*.py")
        for kind in set(KINDS) - words
        if f'"{kind}"' in file.read_text()
    ]
    assert named == []


def test_directions_have_no_panel(tmp_path):
    """The magnitude of a direction is 1; angles and velocities of an attitude have theirs."""
    command = ("run", INPUTS / "gimbal.yaml", "-q", "-o", tmp_path / "gimbal.h5", "--set", "time.end=0.1")
    assert mecano_process(*command)[0] == 0
    with opened_runs([tmp_path / "gimbal.h5"]) as runs:
        (plan,) = [plan for plan in plans(runs) if plan.name == "attitude"]
        names = {name for view in plan.views for name in view.outputs}
    assert {"yaw", "velocity.magnitude"} < names and not any("axis" in name for name in names)


def test_the_results_file_determines_how_its_kinds_are_drawn(drop, tmp_path):
    """A wheel whose file declares it a dot is a dot, and belongs to the picture that the file names."""
    changed = tmp_path / "changed.h5"
    changed.write_bytes(drop.read_bytes())
    with h5py.File(changed, "a") as file:
        displays = json.loads(file["deck/displays"][()])
        kind = next(name for name, display in displays.items() if display["shape"] == "wheel")
        displays[kind] |= {"shape": "mass", "pictures": ["bodies"]}
        del file["deck/displays"]
        file["deck/displays"] = json.dumps(displays)
    [before], [after] = open_runs([drop]), open_runs([changed])
    styles = [{shape.style for shape in shapes(Motion(run, np.arange(2)))} for run in (before, after)]
    assert "wheel" in styles[0] and "wheel" not in styles[1]
    names = [{sheet.name for sheet in default_sheets([run])} for run in (before, after)]
    assert "wheels" in names[0] and "wheels" not in names[1]


@pytest.mark.parametrize(
    ("law", "drawn"),
    [
        ({"spring": {"stiffness": 0.0}}, False),
        ({"spring": {"stiffness": 2.0}}, True),
        ({"spring": {"stiffness": 0.0}, "damper": {"coefficient": 3.0}}, True),
    ],
)
def test_a_spring_without_force_is_a_gauge_and_not_drawn(law, drawn):
    points = {"a": np.zeros((1, 3)), "b": np.ones((1, 3))}
    motion = SimpleNamespace(
        nodes=list(points), position=points.__getitem__, apart=lambda nodes, points: True, run=SimpleNamespace(deck={})
    )
    assert bool(SHAPES["spring"](motion, "gauge", {"nodes": ["a", "b"], "law": law})) == drawn


@pytest.mark.parametrize(("centre", "drawn"), [([0.4, 0.0, 0.0], 2), ([0.0, 0.4, 0.0], 3), ([0.0, 0.1, 0.0], 2)])
def test_a_body_reaches_to_a_centre_of_mass_far_from_its_nodes(centre, drawn):
    """The nodes are 0.2 m apart, the centre 0.2 m, 0.4 m and 0.1 m from the nearest."""
    points = {"a": np.zeros((1, 3)), "b": np.array([[0.2, 0.0, 0.0]])}
    run = SimpleNamespace(paths={"elements/blade/center_of_mass"})
    motion = SimpleNamespace(
        nodes=list(points), position=points.__getitem__, vector=lambda path: np.array([centre]), run=run
    )
    (shape,) = SHAPES["body"](motion, "blade", {"node": "a", "attached": ["b"]})
    assert shape.points.shape[1] == drawn


@pytest.mark.parametrize("joints", [{}, {"pin": {"type": "hinge"}}])
def test_a_force_along_a_line_is_an_actuator_of_a_mechanism_and_not_the_attraction_of_free_bodies(joints):
    points = {"a": np.zeros((1, 3)), "b": np.ones((1, 3))}
    run = SimpleNamespace(deck={"joints": joints})
    motion = SimpleNamespace(nodes=list(points), position=points.__getitem__, apart=lambda nodes, points: True, run=run)
    drawn = SHAPES[KINDS["line_force"].display.shape](motion, "jack", {"nodes": ["a", "b"]})
    assert [shape.name for shape in drawn] == (["jack"] if joints else [])
