"""Generic tests of the declarations of a kind: functions that raise AssertionError; see kind_tests.py."""

import re

from mecano.analyses.kind_samples import GRAVITY, samples
from mecano.deck.units import UnitError, written_in_si
from mecano.element_interface import Context, Kind, Output
from mecano.elements import KINDS
from mecano.laws.law_table import LawTable
from mecano.schema import Field


def check_declarations(kind: Kind) -> None:
    """Fields, outputs, rows and events are declared, with units and meanings."""
    assert kind.doc and kind.doc.strip(), "'doc' is missing"
    declared: list[Field | Output] = [*kind.fields, *kind.outputs]
    for item in declared:
        given = item.name.strip() and item.unit.strip() and item.doc.strip()
        assert given, f"'{item.name}' needs a name, a unit ('-' for none) and a meaning"
        _check_unit(item)
    for row in kind.multipliers:
        assert row.name.strip() and row.unit.strip() and row.constraint_unit.strip(), f"{row} needs a name and units"
    for event in kind.events:
        assert event.name.strip() and event.doc.strip(), f"the event '{event.name}' needs a name and a meaning"
        assert {event.before, event.after} <= {*kind.phases}, (
            f"the event '{event.name}' joins phases that 'phases' lacks"
        )
    _check_unique([field.name for field in kind.fields], "fields")
    _check_unique([output.name for output in kind.outputs], "outputs")
    _check_pair(kind.multipliers, kind.constraints, "'multipliers'", "'constraints'")
    _check_pair(kind.memory, kind.commit, "'memory'", "'commit'")
    watched = any(not event.command for event in kind.events)
    _check_pair(watched, kind.event_values, "'events' without a command", "'event_values'")
    assert kind.observe or not kind.outputs, "'outputs' need 'observe'"
    assert kind.acts or kind.observe or kind.optional, "'residual', 'force' or 'parts' with outputs are missing"


def _check_unit(item):
    """Raise AssertionError for an invalid unit, or for an output that is not in SI units."""
    for unit in re.split(", | or ", item.unit):
        if unit in ("-", "SI") or unit.startswith("unit of"):
            continue
        try:
            si = written_in_si(unit)
        except UnitError as error:
            raise AssertionError(f"'{item.name}': {error} ('-' for none)") from None
        assert isinstance(item, Field) or si == unit, f"'{item.name}': outputs are in SI units: '{si}', not '{unit}'"


def _check_unique(names, of):
    assert len({*names}) == len(names), f"two {of} have the same name: {sorted(names)}"


def _check_pair(declared, function, name, of):
    assert bool(declared) == (function is not None), f"{name} and {of} belong together: one of them is missing"


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
    reached = {sample.phase for sample in found}
    assert reached == phases | set(kind.phases), f"the samples reach the phases {reached} of {phases | {*kind.phases}}"
    for sample in found:
        assert kind.check(sample.values, sample.nodes) == [], "'check' rejects a sample"
        for name in set(sample.values) - {field.name for field in kind.fields}:
            assert not kind.section, f"{name} is not a field of {kind.name}"
