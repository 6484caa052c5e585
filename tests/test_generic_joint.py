"""Generic joint: its deck of inputs/ against closed forms, equivalent joints, and refused input."""

import numpy as np
import pytest
from time_runs import RecordedRun, input_deck

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
    free = "[along_1, along_2, along_axis, about_1, about_2, about_axis]"
    with pytest.raises(DeckError, match="nothing would join the nodes"):
        input_deck(
            "shaker_table", f"joints.table={{type: generic, nodes: [ground, body], axis: [0, 0, 1], free: {free}}}"
        )
