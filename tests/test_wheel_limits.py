"""Where wheels can go no further, or must not start: what the user is told, in the words of the deck."""

import numpy as np
import pytest
from marching import deck, input_deck

import mecano
from mecano.errors import ConvergenceError, DeckError
from mecano.run import run

WHEEL = """
    mecano: 1
    nodes:
      hub: {{position: [0, 0.1, {height}], orientation: [-0.5, 0, 0]}}
    elements:
      rim: {{type: rigid_body, node: hub, mass: 5.0, inertia: [0.1, 0.2, 0.1]}}
      tire: {{type: {kind}, node: hub, axis: [0, 0.877583, -0.479426], tire_law: rubber, ground: road}}
    tire_laws:
      rubber:
        radius: 0.3
        radial: {radial}
        radial_damping: 0.2
        friction: 0.9
        slip_regularization: 0.05
        lateral: {{moreland: {{lateral_stiffness: 1.0e5, lateral_damping: 200, yaw_coefficient: 3e-5, yaw_time: 1e-3}}}}
    grounds:
      road: {{plane: {{point: [0, 0, 0], normal: [0, 0, 1]}}, profile: {profile}}}
    time: {{end: 2.0, step: 1.0e-3}}
"""


def leaning(kind="wheel", height=0.2625, radial="{linear: {slope: 1.0e5}}", profile="null"):
    return deck(WHEEL.format(kind=kind, height=height, radial=radial, profile=profile))


@pytest.mark.parametrize("kind", ["rigid_wheel", "wheel", "flexible_wheel"])
def test_a_wheel_that_falls_over_ends_the_run(kind, tmp_path):
    """It lies flat where |n x a| falls to 0.1, as at the start; every step up to then is in the file."""
    fallen = input_deck("rolling_disc", "initial.velocities=[]") if kind == "rigid_wheel" else leaning(kind)
    name, path = "rim" if kind == "rigid_wheel" else "tire", tmp_path / "flat.h5"
    with pytest.raises(ConvergenceError, match=f"{kind} '{name}' lies flat: its axis has come along the normal"):
        run(fallen, path)
    results = mecano.open_results(path)
    lean = np.abs(results[f"elements/{name}/lean"].values)
    assert results.status == "failed" and "lies flat" in results.reason
    assert lean[:-1].max() < np.arccos(0.1) and len(lean) > 20


@pytest.mark.parametrize(
    ("values", "text"),
    [
        ({"height": -0.01}, "the wheel's centre is 0.01 m below the ground"),
        ({"height": 0.3, "profile": "{direction: [0, 1, 0], height: 0.5}"}, "the wheel's centre is 0.2 m below"),
        ({"radial": "{polynomial: {coefficients: [0, 1.0e5, -1.0e6]}}"}, "'tire_law.radial' falls to -"),
    ],
)
def test_what_a_wheel_may_not_start_with(values, text):
    with pytest.raises(DeckError) as error:
        leaning(**values)
    assert "wheel 'tire'" in str(error.value) and text in str(error.value)


def test_a_law_that_softens_beyond_its_validity_may_be_used():
    soft = WHEEL.replace("radial_damping: 0.2", "valid_deformation: 0.09")
    values = {"kind": "wheel", "height": 0.2625, "radial": "{polynomial: {coefficients: [0, 1.0e5, -1.0e6]}}"}
    assert deck(soft.format(profile="null", **values)).values["tire_laws"]["rubber"]["valid_deformation"] == 0.09


def test_errors_of_a_tire_law_stand_at_the_law():
    radial = "{polynomial: {coefficients: [0, 1.0e5, -1.0e6]}}"
    with pytest.raises(DeckError) as error:
        leaning(radial=radial)
    [problem] = error.value.problems
    assert problem.message.startswith("wheel 'tire': 'tire_law.radial' falls to -")
    assert problem.mark.text[problem.mark.column - 1 :].startswith(radial)
    with pytest.raises(DeckError) as error:
        deck(WHEEL.format(kind="flexible_wheel", height=0.2625, radial="{linear: {slope: 1.0e5}}", profile="null")
             .partition("        lateral:")[0] + "    time: {end: 1, step: 0.1}\n    grounds:\n      road: {plane: "
             "{point: [0, 0, 0], normal: [0, 0, 1]}}\n")  # fmt: skip
    [problem] = error.value.problems
    assert "flexible_wheel 'tire': 'tire_law.lateral' is missing" in problem.message
    assert problem.mark.text.strip() == "rubber:"
