"""Generic joint: its deck of inputs/ against closed forms, equivalent joints, and refused input."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from time_runs import RecordedRun, deck, input_deck

from mecano.errors import DeckError

TABLE = "joints/table"


def test_shaker_table_moves_as_driven_and_swings_on_its_spring():
    """A constant acceleration, a free oscillation of 20 rad/s (steps of 0.02 rad: phase error 3e-5), a free turning."""
    recorded = RecordedRun(input_deck("shaker_table"))
    t, z = recorded.time, -9.81 / 400.0 * (1.0 - np.cos(20.0 * recorded.time))
    np.testing.assert_allclose(recorded[f"{TABLE}/displacement"][:, 0], 0.5 * t**2, atol=1e-9)
    np.testing.assert_allclose(recorded[f"{TABLE}/displacement"][:, 2], z, atol=1e-3 * 0.049)
    np.testing.assert_allclose(recorded[f"{TABLE}/force"][:, 0], 3.0, rtol=1e-6)
    np.testing.assert_allclose(recorded[f"{TABLE}/force"][:, 2], -1200.0 * z, atol=1e-3 * 59.0)
    np.testing.assert_allclose(recorded[f"{TABLE}/angle"], (4.0 * t + np.pi) % (2.0 * np.pi) - np.pi, atol=1e-6)
    np.testing.assert_allclose(recorded[f"{TABLE}/moment"], 0.0, atol=1e-6)


@pytest.mark.parametrize(
    ("deck", "joint", "free"),
    [
        ("pendulum", "hinge", "[about_axis]"),
        ("planar_slide", "slope", "[along_1, along_2, about_axis]"),
    ],
)
def test_it_moves_as_the_joint_with_the_same_free_axes(deck, joint, free):
    """A hinge and a planar joint, written as generic ones: the same motion, force and moment."""
    own = RecordedRun(input_deck(deck))
    values = {
        "pendulum": "nodes: [ground, pin], axis: [0, 1, 0]",
        "planar_slide": "nodes: [ground, puck], axis: [0, 0, 1], axis_1: [1, 0, 0]",
    }
    generic = RecordedRun(input_deck(deck, f"joints.{joint}={{type: generic, {values[deck]}, free: {free}}}"))
    for name in ("rate", "force", "moment"):
        ours, theirs = own[f"joints/{joint}/{name}"], generic[f"joints/{joint}/{name}"]
        theirs = theirs[:, 2] if theirs.ndim > ours.ndim else theirs
        np.testing.assert_allclose(theirs, ours, atol=1e-5 * max(np.abs(ours).max(), 1.0))


def test_an_axis_is_given_once():
    """Free and driven exclude one another; six free axes are no joint."""
    with pytest.raises(DeckError, match="'along_1' is given in 'free' and 'driven'; only one of them is allowed"):
        input_deck("shaker_table", "joints.table.free=[along_1]")
    with pytest.raises(DeckError, match="'about_1' is given twice in 'free'"):
        input_deck("shaker_table", "joints.table.free=[about_1, about_1]")
    free = "[along_1, along_2, along_axis, about_1, about_2, about_axis]"
    with pytest.raises(DeckError, match="nothing would join the nodes"):
        input_deck(
            "shaker_table", f"joints.table={{type: generic, nodes: [ground, body], axis: [0, 0, 1], free: {free}}}"
        )


@pytest.mark.parametrize(
    "joint",
    [
        "type: generic, free: [about_1, about_2]",
        "type: generic, free: [about_1, along_1], compliance: {about_2: {spring: {stiffness: 3}}}",
        "type: hinge, compliance: {about_1: {spring: {stiffness: 3}}, about_2: {spring: {stiffness: 2}}}",
    ],
)
def test_the_moment_is_the_rate_of_angular_momentum_of_a_tilted_body(joint):
    """The body tilts by more than 23 degrees, where the reactions have moments about other axes than their own."""
    m = RecordedRun(deck(f"""
        mecano: 1
        gravity: none
        nodes: {{b: {{position: [0, 0, 0]}}}}
        elements: {{body: {{type: rigid_body, node: b, mass: 1, inertia: [1, 2, 2.5]}}}}
        joints: {{held: {{nodes: [ground, b], axis: [0, 0, 1], axis_1: [1, 0, 0], {joint}}}}}
        initial: {{velocities: [{{nodes: [b], angular_velocity: [1, 0.7, 0]}}]}}
        time: {{end: 1, step: 2 ms}}
        """))  # fmt: skip
    R = Rotation.from_quat(np.roll(m["nodes/b/rotation"], -1, axis=1)).as_matrix()
    momentum = np.einsum("nij,j,nkj,nk->ni", R, (1.0, 2.0, 2.5), R, m["nodes/b/angular_velocity"])
    rate = np.gradient(momentum, m.time, axis=0, edge_order=2)
    assert np.arccos(R[:, 2, 2]).max() > 0.4
    assert m["joints/held/moment"][2:-2] == pytest.approx(rate[2:-2], abs=2e-5)  # differences of 2 ms: 1e-5
