"""Lookup of series by name: wheel.radial_force, joints.knee.angle, axle.position.z."""

import difflib
import re
from collections.abc import Iterable, Mapping
from fnmatch import fnmatchcase
from typing import Any

from mecano.errors import UnknownNameError
from mecano.results.layout import Series
from mecano.results.recorded import Extreme

OF_ATTITUDE = ("acceleration", "specific_force", "yaw", "pitch", "roll", "attitude")  # of a node, by an element


class ByName:
    """Names of outputs, for classes with a ``_lookup`` and ``[name]``."""

    @property
    def _lookup(self) -> "Lookup":
        raise NotImplementedError

    def __getitem__(self, name: str) -> Any:
        raise NotImplementedError

    def names(self, pattern: str = "*") -> list[str]:
        """Return the paths of all series, or of those that match a pattern such as "joints/*" or "wheel.*"."""
        return self._lookup.match(pattern)

    def __iter__(self):
        return iter(self.names())

    def _ipython_key_completions_(self) -> list[str]:
        """Return the names that notebooks complete between brackets."""
        return self._lookup.unique_endings()

    def __contains__(self, name):
        try:
            self[name]
        except UnknownNameError:
            return False
        return True


def require_names(names: Iterable[object]) -> None:
    """Raise TypeError for what is no name of an output, such as a list of names."""
    for name in names:
        if not isinstance(name, str):
            hint = ": write names as separate arguments" if isinstance(name, (list, tuple)) else ""
            raise TypeError(f"an output is named by a text such as 'hinge.angle', not by {name!r}{hint}")


MOST = 8  # outputs of one owner that a message names
NAMED = 3  # similar outputs that a message names


class Lookup:
    """Series by any ending of their paths, with dots or slashes, followed by a component for vectors.

    The name of a signal alone means its value, as in formulas.

    Parameters
    ----------
    series : sequence of Series
    """

    def __init__(self, series: Iterable[Series]):
        self._by_path = {one.path: one for one in series}
        self._by_ending: dict[str, list[Series]] = {}
        for one in series:
            for ending in _endings(one.path):
                self._by_ending.setdefault(ending, []).append(one)

    def unique_endings(self) -> list[str]:
        """Return all names with dots that mean one series."""
        return [ending for ending, of in self._by_ending.items() if len(of) == 1]

    def match(self, pattern: str) -> list[str]:
        """Return the paths that match a pattern with * and ?, as a whole or by an ending; else those of components."""
        dotted = pattern.replace("/", ".")
        components = (path for one in self._by_path.values() for path in one.scalars)
        return _matching(self._by_path, dotted) or _matching(components, dotted)

    def find(self, name: str) -> tuple[Series, int | None]:
        """Return the series of that name, and the index of the component if one is named, otherwise None.

        Raises
        ------
        UnknownNameError
            No series, or more than one, has that name.
        """
        dotted = name.replace("/", ".").replace("[", ".").replace("]", "")
        found = self._exactly(name, dotted)
        if found is not None:
            return found, None
        for parts in (1, 2):  # a matrix has two indices
            stem, component = _split(dotted, parts)
            found = self._exactly(stem, stem)
            if found is not None and found.shape:
                return found, self._component(found, component, name)
        raise UnknownNameError(f"no output '{name}' in this file{self._suggest(dotted)}")

    def _exactly(self, path, dotted):
        if path in self._by_path:
            return self._by_path[path]
        found = self._by_ending.get(dotted, [])
        if len(found) > 1:
            paths = ", ".join(one.path.replace("/", ".") for one in found[:6])
            raise UnknownNameError(f"'{dotted}' is ambiguous, it may be {paths}: write more of the path")
        return found[0] if found else None

    @staticmethod
    def _component(series, component, name):
        if component in series.components:
            return series.components.index(component)
        if component.isdecimal() and int(component) < series.width:
            return int(component)
        raise UnknownNameError(f"no component '{component}' in '{name}': there are {', '.join(series.components)}")

    def _suggest(self, dotted):
        if any(name in dotted for name in self._by_ending if "." in name) and set(dotted) & set("()+-*"):
            return "; for a formula of outputs define a signal in the deck, and draw its value"
        pieces = self._pieces(dotted) or self._pieces(_split(dotted, 1)[0])
        if pieces:
            return f": this member is divided; write {pieces[0]} to {pieces[-1]}, or a * instead of the number for all"
        own = [ending for ending in self._by_ending if ending.rpartition(".")[0] == dotted]
        if own:
            return f", but {_listed(own)}"
        node = dotted.removeprefix("nodes.").partition(".")[0]
        if ".displacement" in dotted and f"{node}.position" in self._by_ending:
            return f": nodes have positions only; write {node}.position"
        if dotted.rpartition(f"{node}.")[2].partition(".")[0] in OF_ATTITUDE and f"{node}.position" in self._by_ending:
            return f": add an element {{type: attitude, node: {node}}} to the deck, which has these outputs of a node"
        same = [ending for ending in self._by_ending if ending.partition(".")[2] == dotted]
        if same:
            return f"; there are {_listed(same)}"
        close = similar_outputs(dotted, self._by_path) or similar_outputs(_split(dotted, 1)[0], self._by_path)
        return f"; did you mean {' or '.join(close)}?" if close else "; `mecano info` lists them"

    def _pieces(self, dotted):
        """Return the endings such as arm.1.moment, in the order of their numbers, for arm.moment."""
        owner, _, last = dotted.rpartition(".")
        piece = re.compile(rf"{re.escape(owner)}\.(\d+)\.{re.escape(last)}")
        found = {int(match[1]): ending for ending in self._by_ending if (match := piece.fullmatch(ending))}
        return [found[number] for number in sorted(found)]


def _listed(names):
    return ", ".join(names[:MOST]) + ", ..." * (len(names) > MOST)


def similar_outputs(name: str, paths: Iterable[str]) -> list[str]:
    """Return at most three endings of different paths that are similar to a name, the most similar first."""
    owner: dict[str, str] = {}
    for path in paths:
        for ending in _endings(path):
            owner.setdefault(ending, path)
    found: dict[str, str] = {}
    for ending in difflib.get_close_matches(name, owner, 3 * NAMED):
        found.setdefault(owner[ending], ending)
    return list(found.values())[:NAMED]


def _matching(paths, pattern):
    return [path for path in paths if any(fnmatchcase(end, pattern) for end in _endings(path))]


def _endings(path):
    """Return the endings of a path with dots, from the whole to the last two parts (the last if it is the only one).

    The value of a signal has also the name of the signal.
    """
    parts = path.split("/")
    alone = [parts[1]] if len(parts) == 3 and parts[0] == "signals" and parts[2] == "value" else []
    return [".".join(parts[i:]) for i in range(max(len(parts) - 1, 1))] + alone


def _split(dotted, parts):
    pieces = dotted.rsplit(".", parts)
    return pieces[0], ".".join(pieces[1:])


class Extremes(dict):
    """Extremes of numbers by path with component; ``[name]`` takes any ending of a path, as ``Results`` does."""

    def __init__(self, extremes: Mapping[str, Extreme], lookup: Lookup):
        super().__init__(extremes)
        self._lookup = lookup

    def __missing__(self, name):
        series, component = self._lookup.find(name)
        if series.shape and component is None:
            raise UnknownNameError(f"'{name}' has several components: write {' or '.join(series.scalars)}")
        return self[series.scalars[component or 0]]
