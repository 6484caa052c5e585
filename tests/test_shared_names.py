"""A joint and an element with the same name: their paths differ; an ambiguous name is answered with both paths."""

from types import SimpleNamespace

import pytest
from test_more_joints import PLANET
from time_runs import deck

from mecano.analyses.prepare import prepare
from mecano.errors import UnknownNameError
from mecano.results.lookup import Lookup

SHARED = PLANET.replace("STEP", "4.0e-3").replace("pivot:", "beam:").replace("bearing:", "disc:")


def test_a_joint_and_an_element_may_share_a_name():
    prepared = prepare(deck(SHARED))
    paths = {path for batch in prepared.system.batches for path, _ in batch.paths}
    assert {"elements/beam", "joints/beam", "elements/disc", "joints/disc"} <= paths


def test_grounds_of_a_joint_and_a_load_of_one_name():
    """Each has a fixed node of its own, where its other node is."""
    text = SHARED.replace("mesh:", "motor:").replace("nodes: [sun, arm]", "nodes: [ground, arm]")
    names = [node.name for node in prepare(deck(text)).system.nodes]
    assert len(names) == len(set(names)) and "ground of hinge beam" in names and "ground of couple motor" in names


def test_a_name_that_means_both_is_answered_with_both():
    paths = ["joints/leg/force", "elements/leg/force", "joints/leg/angle"]
    lookup = Lookup([SimpleNamespace(path=path, shape=()) for path in paths])
    assert lookup.find("leg.angle")[0].path == "joints/leg/angle"
    assert lookup.find("elements.leg.force")[0].path == "elements/leg/force"
    with pytest.raises(UnknownNameError, match=r"may be joints\.leg\.force, elements\.leg\.force: write more"):
        lookup.find("leg.force")
