"""Results files shown together, each with a label that distinguishes it."""

import os
from collections.abc import Iterable, Iterator, Sequence
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from mecano.deck.scalar import number
from mecano.deck.units import ANY, QUANTITY, converted, factor_of, is_quantity
from mecano.element_interface import SECTIONS, Display
from mecano.model.mesh import piece_names
from mecano.results.reader import Results, open_results
from mecano.schema import Values

LONGEST = 80  # characters of a label: the width of the narrowest picture
ROUNDING = 1e-12  # of the largest energy: work of a force of rounding errors over the size of the mechanism
NOISE = 10.0  # times its tolerance: residual forces of Newton's iteration and of step errors
HEADED = ("title",)  # overrides shown in the heading of pictures


@dataclass(frozen=True)
class Run:
    """One of the results files shown; ``label`` is empty if it is the only one."""

    results: Results
    label: str = ""

    @cached_property
    def deck(self) -> dict[str, Any]:
        """The resolved deck: section -> name -> values."""
        return self.results.resolved

    @cached_property
    def paths(self) -> frozenset[str]:
        """Paths of all outputs in the file."""
        return frozenset(self.results.names())

    @cached_property
    def things(self) -> dict[str, Values]:
        """Elements, joints and loads: path in the file ("joints/knee") -> deck values, in the order of the deck."""
        return {f"{section}/{name}": d for section in SECTIONS for name, d in self.deck.get(section, {}).items()}

    @cached_property
    def pieces(self) -> dict[str, Values]:
        """The same as ``things``, with the elements of a divided member in place of the member."""
        found: dict[str, Values] = {}
        for path, d in self.things.items():
            section, _, name = path.partition("/")
            found |= {f"{section}/{piece}": d for piece in piece_names(name, d)}
        return found

    @cached_property
    def places(self) -> dict[str, np.ndarray]:
        """Positions (3,) [m] of the nodes in the deck."""
        return {name: np.array(values["position"], float) for name, values in self.deck["nodes"].items()}

    @cached_property
    def extent(self) -> np.ndarray:
        """Extent (3,) [m] of the nodes in the deck along the inertial axes."""
        return np.ptp(np.stack(list(self.places.values())), axis=0)

    @cached_property
    def contacts_in_planes(self) -> dict[int, list[Values]]:
        """Deck values of all contacts with one plane, by the ``id`` of those of each of them."""
        from mecano.post.contact_outlines import contacts_in_planes  # few models have contacts

        return contacts_in_planes(self.deck)

    def display(self, d: Values) -> Display:
        """Return the Display of the kind of an element, joint or load with the deck values ``d``."""
        return self.results.displays.get(d["type"], Display())

    @cached_property
    def ranges(self) -> dict[str, float]:
        """Range over all accepted steps of each number, and the largest range of a component of each vector."""
        ranges = {}
        for name, extreme in self.results.extremes.items():
            span = extreme.maximum - extreme.minimum
            vector = name.rpartition(".")[0]
            ranges[name] = span
            ranges[vector] = max(ranges.get(vector, 0.0), span)
        return ranges

    @cached_property
    def with_events(self) -> frozenset[tuple[str, str]]:
        """(kind, name) of the elements, joints, loads and signals of which the file has events."""
        return frozenset(map(self.results.subject, self.results.events))

    @cached_property
    def scales(self) -> dict[str, float]:
        """Scales of the whole motion by unit; values many orders smaller are numerical noise."""
        lengths = [max(abs(e.minimum), abs(e.maximum)) for e in self.results.extremes.values() if e.unit == "m"]
        length = max(filter(np.isfinite, lengths), default=0.0)
        duration = float(np.ptp(self.results.time)) or 1.0
        angles = {"rad": 1.0, "deg": float(np.degrees(1.0)), "rad/s": 1.0 / duration}
        return {"m": length, "m/s": length / duration, **angles}

    @cached_property
    def force_noise(self) -> float:
        """Share of the largest force or moment below which a force is noise of Newton's iteration."""
        newton = (self.deck.get("time") or self.deck.get("static") or {}).get("newton", {})
        return NOISE * newton.get("force_tolerance", 0.0)

    @cached_property
    def rounding(self) -> dict[str, float]:
        """Forces and moments by unit that are rounding errors beside the energy of the motion."""
        energies = [max(abs(e.minimum), abs(e.maximum)) for e in self.results.extremes.values() if e.unit == "J"]
        moment = ROUNDING * max(filter(np.isfinite, energies), default=0.0)
        return {"N m": moment, "N": moment / self.scales["m"] if self.scales["m"] else 0.0}

    @property
    def title(self) -> str:
        """Title of the deck, or the name of the file."""
        return self.results.metadata.get("title") or self.results.path.stem


@contextmanager
def opened_runs(paths: Iterable[str | os.PathLike[str]]) -> Iterator[list[Run]]:
    """Open results files as ``open_runs`` does, and close them at the end of the block."""
    runs = open_runs(paths)
    try:
        yield runs
    finally:
        for run in runs:
            run.results.close()


def open_runs(paths: Iterable[str | os.PathLike[str]]) -> list[Run]:
    """Open results files and label them. Raises ResultsError, with all files closed."""
    with ExitStack() as until_all_are_open:
        opened = [until_all_are_open.enter_context(open_results(path)) for path in paths]
        until_all_are_open.pop_all()
    return [Run(results, label) for results, label in zip(opened, labels(opened), strict=True)]


def labels(opened: Sequence[Results]) -> list[str]:
    """Return labels that distinguish files: parameters and overrides that differ, or the names of the files."""
    if len(opened) == 1:
        return [""]
    schemes = [_stems(opened), [str(results.path) for results in opened]]
    if len({results.deck_text for results in opened}) == 1:
        schemes.insert(0, _overrides(opened))
    else:
        alike = len({frozenset(results.resolved.get("parameters", {})) for results in opened}) == 1
        schemes.insert(0 if alike else 1, _parameters(opened))
    for scheme in schemes:
        short = [_short(text) for text in scheme]
        if len(set(short)) == len(short):
            return short
    return [f"{i}: {text}" for i, text in enumerate(short, start=1)]


def _short(text):
    return text if len(text) <= LONGEST else text[: LONGEST - 4].rstrip() + " ..."


def _overrides(opened):
    """Return texts with the values of overrides that differ, taken from the deck where a run has no override."""
    given = [_override_values(results) for results in opened]
    paths = list(dict.fromkeys(path for some in given for path in some if path not in HEADED))
    pairs = list(zip(given, [results.resolved for results in opened], strict=True))
    values = {
        path: _in_one_unit([_in_words(some[path] if path in some else _at(deck, path)) for some, deck in pairs])
        for path in paths
    }
    short = [path.removeprefix("parameters.") if path.startswith("parameters.") else _ending(path) for path in paths]
    names = dict(zip(paths, short if len(set(short)) == len(paths) else paths, strict=True))
    return _differences([{names[path]: texts[i] for path, texts in values.items()} for i in range(len(opened))])


def _in_one_unit(texts):
    """Convert texts of one value to the first of their units; numbers without a unit are in SI units."""
    units = [match[2] for text in texts if is_quantity(text) and (match := QUANTITY.fullmatch(text))]
    plain = [number(text) for text in texts]  # None for a quantity
    if not units or not all(is_quantity(text) or value is not None for text, value in zip(texts, plain, strict=True)):
        return texts
    values = [converted(text, ANY) if value is None else value for text, value in zip(texts, plain, strict=True)]
    return [f"{value / factor_of(units[0], ANY):.6g} {units[0]}" for value in values]


def _override_values(results):
    """Return {path: value} of all overrides, with mappings replaced by their entries."""
    found: dict[str, Any] = {}
    for path, text in (override.split("=", 1) for override in results.metadata["overrides"]):
        value = _at(results.resolved, path)
        found |= dict(_leaves(path, value)) if isinstance(value, dict) else {path: text}
    return found


def _leaves(path, value):
    """Yield (path, value) of all leaves of nested mappings."""
    if not isinstance(value, dict):
        yield path, value
        return
    for key, inner in value.items():
        yield from _leaves(f"{path}.{key}", inner)


def _ending(path):
    return ".".join(path.split(".")[-2:])


def _parameters(opened):
    given = [results.resolved.get("parameters", {}) for results in opened]
    return _differences([{name: _in_words(value) for name, value in some.items()} for some in given])


def _differences(given):
    """Return texts "name = value, ..." of the values that differ; ``given``: {name: text} of each file."""
    names = [name for name in dict.fromkeys(n for some in given for n in some) if len({g.get(name) for g in given}) > 1]
    nothing = ", ".join(f"no {name}" for name in names)
    return [", ".join(f"{name} = {some[name]}" for name in names if some.get(name)) or nothing for some in given]


def _at(deck, path):
    """Return the value of a resolved deck at the path of an override, or None."""
    for key in path.split("."):
        if isinstance(deck, list) and key.isdecimal() and int(key) < len(deck):
            deck = deck[int(key)]
        elif isinstance(deck, dict) and key in deck:
            deck = deck[key]
        else:
            return None
    return deck


def _in_words(value):
    """Return a value as text, with numbers normalized (0.50 equals 5e-1) and "" for None."""
    if isinstance(value, bool):
        return str(value).lower()
    try:
        return f"{float(value):g}"
    except (TypeError, ValueError):
        return "" if value is None else str(value)


def _stems(opened):
    return [results.path.stem for results in opened]
