"""Motion of the nodes inside superelements, from their generalized coordinates and the shapes in the resolved deck.

A quantity of an inner node is named after its superelement: ``arm.inner.position``, ``arm.inner.displacement.z``.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from mecano.results.reader import Results
from mecano.schema import Values


@dataclass(frozen=True)
class Inner:
    """Nodes inside a superelement at some saved times."""

    names: list[str]
    positions: np.ndarray  # (times, n, 3) [m], inertial
    displacements: np.ndarray  # (times, n, 3) [m], relative to the frame, in its axes


def nodes_inside(d: Values) -> list[str]:
    """Return the names of the nodes inside a superelement with these deck values; [] if its file has no shapes."""
    file = d.get("file")
    return file.get("interior_names") or [] if isinstance(file, dict) else []


def recover(results: Results, name: str, d: Values) -> Inner:
    """Return the Inner of the superelement ``name`` with deck values ``d`` at all saved times."""
    return recovered(d, lambda output: results.find(f"elements/{name}/{output}").values)


def recovered(d: Values, value: Callable[[str], np.ndarray]) -> Inner:
    """Return the Inner of a superelement with deck values ``d``; ``value(output)`` gives its outputs (times, ...)."""
    from scipy.spatial.transform import Rotation  # takes 0.2 s to import, and few models have superelements

    reduced = d["file"]
    X = np.array(reduced["positions"], float)
    places = np.array(reduced["interior_positions"], float).reshape(-1, 3) - X.mean(axis=0)
    basis = np.array(reduced["interior_basis"], float)
    n_nodes = len(X)
    pairs = [value(f"{what}_{i}") for i in range(1, n_nodes + 1) for what in ("displacement", "rotation")]
    amplitudes = [value(f"amplitude_{i}")[:, None] for i in range(1, basis.shape[1] - 6 * n_nodes + 1)]
    displacements = (np.hstack([*pairs, *amplitudes]) @ basis.T).reshape(-1, *places.shape)
    origin, turn = value("frame_origin"), Rotation.from_quat(np.roll(value("frame_rotation"), -1, axis=1)).as_matrix()
    positions = origin[:, None] + np.einsum("tij,tnj->tni", turn, places + displacements)
    return Inner(nodes_inside(d), positions, displacements)


MOTIONS = {
    "position": ("position of an inner node, inertial", "positions"),
    "displacement": ("displacement of an inner node relative to the frame, axes of the frame", "displacements"),
}


def named(results: Results, name: str) -> tuple[str, str, np.ndarray, str] | None:
    """Return (path, doc, values (times, 3), component or "") of a name such as arm.inner.position.z, or None."""
    text, component = name.replace("/", ".").removeprefix("elements."), ""
    if text.endswith((".x", ".y", ".z", ".magnitude")):
        text, _, component = text.rpartition(".")
    stem, _, what = text.rpartition(".")
    if what not in MOTIONS:
        return None
    for element, d in results.resolved.get("elements", {}).items():
        node = stem.removeprefix(f"{element}.")
        if node != stem and node in nodes_inside(d):
            found = recover(results, element, d)
            doc, field = MOTIONS[what]
            return (
                f"elements/{element}/{node}/{what}",
                doc,
                getattr(found, field)[:, found.names.index(node)],
                component,
            )
    return None


def lines(d: Values) -> list[list[int]]:
    """Return chains of indices of nodes, boundary nodes first, that are connected in pictures."""
    pairs = d["file"].get("lines")
    if not pairs:
        return [[0, i] for i in range(1, len(d["file"]["positions"]))]
    chains: list[list[int]] = []
    for first, last in pairs:
        if chains and chains[-1][-1] == int(first):
            chains[-1].append(int(last))
        else:
            chains.append([int(first), int(last)])
    return chains
