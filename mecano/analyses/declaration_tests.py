"""Generic tests of the declarations of a kind: functions that raise AssertionError; see kind_tests.py."""

import re

from mecano.analyses.kind_trial import GRAVITY, samples
from mecano.element_interface import Context, Kind, Output
from mecano.elements import KINDS
from mecano.laws.table import LawTable
from mecano.schema import Field


def check_declarations(kind: Kind) -> None:
    """Fields, outputs, rows and events are declared, with units and meanings."""
    assert kind.doc and kind.doc.strip()
    declared: list[Field | Output] = [*kind.fields, *kind.outputs]
    texts = [text for item in declared for text in (item.name, item.unit, item.doc)]
    texts += [text for row in kind.multipliers for text in (row.name, row.unit, row.constraint_unit)]
    texts += [text for event in kind.events for text in (event.name, event.doc)]
    assert all(text.strip() for text in texts)
    names = [field.name for field in kind.fields], [output.name for output in kind.outputs]
    assert all(len(set(group)) == len(group) for group in names)
    assert bool(kind.multipliers) == ((kind.constraint_derivatives or kind.constraints) is not None)
    assert bool(kind.outputs) <= (kind.observe is not None)
    assert bool(kind.memory) == (kind.commit is not None)
    assert any(not event.command for event in kind.events) == (kind.event_values is not None)
    assert kind.acts or kind.observe is not None or kind.optional  # or all is in its parts
    if kind.by_lanes:
        assert kind.force and kind.observe and len(kind.phases) == 1
        assert not (kind.multipliers or kind.coupled_multipliers or kind.memory)
    for event in kind.events:
        assert event.before in kind.phases and event.after in kind.phases


def first_of(name: str) -> str:
    """Return the name of the first of numbered outputs: force_1 for force_7, amplitude_1_rate for amplitude_2_rate."""
    return re.sub(r"_\d+", "_1", name)


def check_outputs_of_parts(kind: Kind) -> None:
    """Outputs that options add are declared, with unique names."""
    found: dict[tuple[str, str], Kind] = {}
    for sample in samples(kind):
        chosen = kind.chosen(sample.values)
        own, declared = ([output.name for output in one.outputs] for one in (chosen, kind))
        assert [first_of(name) for name in own if first_of(name) == name] == declared[: len(set(map(first_of, own)))]
        assert set(map(first_of, own)) <= set(declared)
        parts = chosen.parts(sample.values, sample.nodes, Context(LawTable(), GRAVITY, KINDS))
        named = [o.name + part.label for part in parts for o in part.kind.outputs]
        assert len({*named, *(output.name for output in kind.outputs)}) == len(named) + len(kind.outputs)
        found |= {(part.kind.name, first_of(part.label)): part.kind for part in parts if part.kind.outputs}
    undeclared = set(found) - {(part.name, first_of(label)) for _, part, label in kind.optional}
    assert not undeclared, f"Kind.optional does not declare the outputs of {undeclared}"
    assert {field for field, _, _ in kind.optional} <= {field.name for field in kind.fields}
    for part in found.values():
        assert part.doc.strip() and all(o.name and o.unit and o.doc for o in part.outputs)


def check_samples(kind: Kind) -> None:
    """Samples pass the check of the kind and reach all its phases."""
    found = samples(kind)
    phases = set().union(*(kind.chosen(sample.values).phases for sample in found))
    assert {sample.phase for sample in found} == phases | set(kind.phases)
    for sample in found:
        assert kind.check(sample.values, sample.nodes) == []
        for name in set(sample.values) - {field.name for field in kind.fields}:
            assert not kind.section, f"{name} is not a field of {kind.name}"
