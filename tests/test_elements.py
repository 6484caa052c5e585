"""Requirements on every kind of element, joint, load and basic constraint. No kind is named here."""

from pathlib import Path

import pytest
import yaml
from instances import ALL_KINDS, KINDS

from mecano.analyses import kind_tests

every_kind = pytest.mark.parametrize("kind", ALL_KINDS.values(), ids=ALL_KINDS)
deck_kind = pytest.mark.parametrize("kind", KINDS.values(), ids=KINDS)


@pytest.mark.parametrize("check", kind_tests.OF_EVERY_KIND, ids=lambda check: check.__name__)
@every_kind
def test_every_kind(kind, check):
    check(kind)


@deck_kind
def test_forces_turn_with_the_whole_model(kind):
    kind_tests.check_invariance(kind)


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
