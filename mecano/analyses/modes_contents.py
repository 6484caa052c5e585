"""The arrays of modes as their file contains them, with the motions of nodes inside superelements."""

from collections.abc import Mapping
from typing import Any

import numpy as np

from mecano.deck.deck import Deck
from mecano.element_interface import RELEASES
from mecano.model.state import State
from mecano.model.system import System
from mecano.post.recovered import nodes_inside, recovered
from mecano.solve.modal.modes import Modes
from mecano.solve.time.increments import displaced

NUDGE = 1e-5  # of a shape, whose largest displacement is 1: error of the differences about 1e-10


def contents(
    system: System,
    s: State,
    found: Modes,
    words_: str,
    turning: np.ndarray,
    inner: Mapping[str, tuple[np.ndarray, np.ndarray]],
) -> dict[str, Any]:
    """Return the content of the file as plain arrays; see docs/results-file.md."""
    of, zero = system.numbering, np.zeros((len(found.values), 3), complex)
    nodes = {}
    for i, node in enumerate(system.nodes):
        if " " in node.name:
            continue
        x, r = of.x[i], of.r[i]
        nodes[node.name] = {
            "position": s.z[x : x + 3].copy(),
            "orientation": s.R[of.rotation[i]].copy(),
            "translation": found.shapes[:, x : x + 3] if x < of.n_q else zero,
            "rotation": found.shapes[:, r : r + 3] if r < of.n_q else zero,
        }
    return {
        "modes": found, "nodes": nodes, "inner": inner, "about": words_, "time": s.t, "frame": turning,
        "released": list(_released(system, s)),
    }  # fmt: skip


def _released(system, s):
    """Yield the names of the joints and elements that have been released in state ``s``: "hinge 'pin'"."""
    for b in system.batches:
        after = {b.kind.phases.index(event.after) for event in b.kind.events if event.name == RELEASES}
        yield from (name for name, phase in zip(b.names, s.phases[b.phases], strict=True) if phase in after)


def inner_motions(deck: Deck, system: System, s: State, shapes: np.ndarray) -> dict[str, tuple[np.ndarray, np.ndarray]]:
    """Return the motions of nodes inside superelements: {name: (positions (k, 3) [m], translations (m, k, 3))}.

    ``shapes`` (m, n_q) as in Modes. The motions are central differences of the outputs of the displaced elements.
    """
    elements = deck.values["elements"]
    if not any(nodes_inside(d) for d in elements.values()):
        return {}
    at = _inside(elements, system, s)
    moves = []
    for shape in shapes:
        dq = _material(system, s, shape)
        parts = []
        for part in (dq.real, dq.imag):
            ends = [
                _inside(elements, system, displaced(s, sign * NUDGE * part, system.numbering)) for sign in (1.0, -1.0)
            ]
            parts.append({name: (ends[0][name] - ends[1][name]) / (2.0 * NUDGE) for name in at})
        moves.append({name: parts[0][name] + 1j * parts[1][name] for name in at})
    return {name: (x, np.array([move[name] for move in moves]).reshape(-1, *x.shape)) for name, x in at.items()}


def _material(system, s, shape):
    """Return a shape (n_q,) with rotations in the material axes of the nodes."""
    of, out = system.numbering, shape.astype(complex)
    for r, rotation in set(zip(of.r.tolist(), of.rotation.tolist(), strict=True)):
        if r < system.n_q:
            out[r : r + 3] = s.R[rotation].T @ shape[r : r + 3]
    return out


def _inside(elements, system, s):
    """Return the positions (k, 3) [m] of the nodes inside each superelement in state ``s``."""
    found, outputs = {}, system.observe(s).outputs
    for b in system.batches:
        ends = np.cumsum([output.size for output in b.kind.outputs])
        places = {o.name: (slice(end - o.size, end), o.shape) for o, end in zip(b.kind.outputs, ends, strict=True)}
        for (path, _), y in zip(b.paths, b.outputs(outputs), strict=True):
            section, _, name = path.partition("/")
            if section == "elements" and nodes_inside(elements.get(name, {})):
                found[name] = recovered(elements[name], _reading(y, places)).positions[0]
    return found


def _reading(y, places):
    """Return a function that gives an output by name, with a time axis of length 1, from the row ``y``.

    ``places`` are the slices and shapes of the outputs by name.
    """
    return lambda output: y[places[output][0]].reshape(1, *places[output][1])
