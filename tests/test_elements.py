"""Requirements on every kind of element, joint, load and basic constraint. No kind is named here."""

from pathlib import Path

import numpy as np
import pytest
import yaml
from instances import ALL_KINDS, KINDS

from mecano.analyses import kind_tests
from mecano.analyses.invariance_tests import force_on_nodes
from mecano.analyses.kind_samples import GRAVITY, Motion, expand, samples, seed_of
from mecano.schema import GROUND, WHEEL

every_kind = pytest.mark.parametrize("kind", ALL_KINDS.values(), ids=ALL_KINDS)
deck_kind = pytest.mark.parametrize("kind", KINDS.values(), ids=KINDS)


@pytest.mark.parametrize("check", kind_tests.OF_EVERY_KIND, ids=lambda check: check.__name__)
@every_kind
def test_every_kind(kind, check):
    check(kind)


@deck_kind
def test_forces_turn_with_the_whole_model(kind):
    kind_tests.check_invariance(kind)


def moves_in_axes_of_its_own(kind):
    """True if a kind knows a ground or a fluid, and with it a velocity."""
    return kind.in_fluid or any(field.type in (GROUND, WHEEL) for field in kind.fields)


def holds_to_the_ground(sample):
    """True if a part holds the velocity of one node, relative to the ground."""
    return any(one.kind.of_rates and {slot[1] for slot in one.kind.layout} == {"0"} for one in sample.instances)


@deck_kind
def test_forces_are_the_same_in_axes_that_move_and_fall(kind):
    """Galileo: a uniform velocity of the whole model changes no force; nor does an acceleration that gravity shares."""
    velocity, acceleration = np.array([3.0, -2.0, 1.0]), np.array([0.7, 0.9, -1.3])
    for sample in samples(kind):
        twins = expand(kind, sample.values, sample.nodes, sample.phase, GRAVITY + acceleration, seed_of("unused"))
        for twin, original in zip(twins, sample.instances, strict=True):
            twin.scalars, twin.multipliers = original.scalars, original.multipliers
        here, x = sample.motion, sample.motion.x.copy()
        x[:, 2] += acceleration
        if not (moves_in_axes_of_its_own(kind) or holds_to_the_ground(sample)):
            x[:, 1] += velocity
        there = Motion(here.t, x, here.R, here.turn)
        for one, other in zip(force_on_nodes(twins, there), force_on_nodes(sample.instances, here), strict=True):
            bound = 1e-10 * (1.0 + np.abs(other).max(initial=0.0))
            np.testing.assert_allclose(one, other, rtol=0.0, atol=bound, err_msg=sample.in_phase)


@deck_kind
def test_what_has_no_mass_does_not_feel_that_the_whole_model_turns(kind):
    """Dampers, friction and rolling know velocities relative to one another only."""
    spin = np.array([0.7, 0.9, -1.3])
    for sample in samples(kind):
        here, x, turn = sample.motion, sample.motion.x.copy(), sample.motion.turn.copy()
        heavy = any(np.any(one.force(here.t, one.local(here))[3]) for one in sample.instances if one.kind.acts)
        if heavy or moves_in_axes_of_its_own(kind) or holds_to_the_ground(sample):
            continue
        x[:, 1] += np.cross(spin, x[:, 0])
        turn[:, 1] += np.einsum("nji,j->ni", here.R, spin)
        there = Motion(here.t, x, here.R, turn)
        both = force_on_nodes(sample.instances, there), force_on_nodes(sample.instances, here)
        for one, other in zip(*both, strict=True):
            bound = 1e-10 * (1.0 + np.abs(other).max(initial=0.0))
            np.testing.assert_allclose(one, other, rtol=0.0, atol=bound, err_msg=sample.in_phase)


def kinds_in(node):
    """All values of ``type`` in a deck."""
    if isinstance(node, dict):
        return {node["type"]} & set(KINDS) if "type" in node else set().union(*map(kinds_in, node.values()), set())
    return set().union(*map(kinds_in, node), set()) if isinstance(node, list) else set()


@pytest.fixture(scope="module")
def deck_kinds():
    folder = Path(__file__).parent.parent / "inputs"
    return set().union(*(kinds_in(yaml.safe_load(path.read_text())) for path in folder.rglob("*.yaml")), set())


@deck_kind
def test_a_deck_uses_it(kind, deck_kinds):
    assert kind.name in deck_kinds, f"no deck in inputs/ has an element of the type {kind.name}"
