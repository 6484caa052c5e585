"""`mecano reduce`: reduction of a part of a deck to a file of matrices for superelements."""

from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from mecano.deck.build import build
from mecano.deck.physics import element_nodes
from mecano.elements import KINDS
from mecano.errors import UsageError
from mecano.model.mesh import divided, inner_names
from mecano.model.model import Model, Node, length_scale
from mecano.model.quantity_names import UnknownQuantity
from mecano.model.system import System
from mecano.results.whole_file import atomic_file, refuse_present
from mecano.solve.modal.reduction import Reduction, reduce

if TYPE_CHECKING:
    import os

    from mecano.deck.deck import Deck

SHOWN = 5  # frequencies printed
SAME = 1e-6  # relative difference of two frequencies that counts as none


def reduce_part(
    deck: "Deck",
    path: "str | os.PathLike[str]",
    *,
    elements: Sequence[str] = (),
    nodes: Sequence[str] = (),
    number: int | None = None,
    force: bool = False,
) -> tuple[str, Reduction]:
    """Reduce a part of a checked deck, write the file ``path`` (.npz or .h5), and return (text, Reduction).

    ``elements`` names the elements and joints of the part (empty: all), ``nodes`` its boundary nodes; ``number`` of
    modes kept (None: all). Raises UsageError, AssemblyError, ResultsError.
    """
    path = new_file(path, force)
    part = part_of(deck, elements, nodes)
    system = _system(part)
    result = reduce(system, list(nodes), number, length_scale(system.nodes))
    result.content.update(lines_of(part, [*nodes, *result.content.get("interior_names", ())]))
    write(path, result.content)
    return text(path, nodes, result), result


def new_file(path: "str | os.PathLike[str]", force: bool) -> Path:
    """Return the path of a file of reduced matrices to be written. Raises UsageError, ResultsError."""
    path = Path(path)
    if path.suffix not in (".npz", ".h5"):
        raise UsageError(f"reduced matrices are written to .npz or .h5 files, not '{path.name}'")
    refuse_present(path, force)
    return path


def part_of(deck: "Deck", elements: Sequence[str], boundary: Sequence[str]) -> Model:
    """Return the Model of the chosen elements and joints, without loads, signals and gravity, with free boundary nodes.

    Raises UsageError for unknown elements or nodes, and for a fixed node that is not on the boundary.
    """
    whole = build(deck)
    parts = [element for element in whole.elements if element.kind.section in ("elements", "joints")]
    known = [element.name for element in parts]
    unknown = [name for name in elements if name not in known]
    if unknown:
        raise UsageError(f"the deck has no element or joint '{unknown[0]}'; it has {', '.join(known[:12])}")
    parts = [element for element in parts if not elements or element.name in elements]
    used = {name for element in parts for name in element_nodes(KINDS[element.values["type"]], element.values)}
    used.discard("ground")
    inside = {
        name for element in parts if "mesh" in element.values for name in inner_names(element.name, element.values)
    }
    for name in boundary:
        if name not in used | inside:
            raise UsageError(f"node '{name}' does not belong to the part; it has {', '.join(sorted(used)[:12])}")
    held = [node.name for node in whole.nodes if node.name in used and node.fixed and node.name not in boundary]
    if held:
        raise UsageError(f"node '{held[0]}' is fixed: it can only be a boundary node of the part")
    free = [Node(node.name, node.x, node.R) for node in whole.nodes if node.name in used]
    return Model(free, parts, whole.laws, np.zeros(3))


def _system(part):
    """Return the System of a part. Raises UsageError if an element of it depends on a formula."""
    try:
        system = System(part)
    except UnknownQuantity as error:
        text = f"an element of the part reads '{error.word}', which the part does not contain: remove the formula"
        raise UsageError(text) from None
    for b in system.batches:
        if b.kind.inputs and not b.kind.of_signals:
            raise UsageError(f"{b.names[0]} has a formula or a release; the matrices of a part are constant: remove it")
    return system


def lines_of(part: Model, names: Iterable[str]) -> dict[str, np.ndarray]:
    """Return {"lines": (n, 2)}, the pairs of indices into ``names`` of nodes joined by an element; {} if none."""
    index = {name: i for i, name in enumerate(names)}
    pairs = [
        (index[element.nodes[0]], index[node])
        for element in divided(part).elements
        if element.kind.section == "elements"
        for node in element.nodes[1:]
        if element.nodes[0] in index and node in index
    ]
    return {"lines": np.array(pairs, float)} if pairs else {}


def write(path: Path, content: Mapping[str, np.ndarray]) -> None:
    """Write a file of reduced matrices, which appears only when complete. Raises ResultsError."""
    if path.suffix == ".npz":
        with atomic_file(path) as hidden:
            np.savez_compressed(hidden, **content)  # type: ignore[arg-type]  # none is named as its option
        return
    from mecano.results.disk import atomic_hdf5_file  # imports h5py, which .npz does not need

    with atomic_hdf5_file(path) as file:
        for key, value in content.items():
            file[key] = [name.encode() for name in value] if value.dtype.kind == "U" else value


def text(path: Path, nodes: Sequence[str], result: Reduction) -> str:
    """Return a summary of the reduction for a terminal."""
    kept, of = len(result.frequencies), f" of {result.found}" if result.found >= 0 else ""
    lines = [
        f"{path}: {6 * len(nodes)} coordinates of the boundary nodes {', '.join(nodes)}; {kept}{of} modes",
        f"mass             {result.mass:.6g} kg",
        f"inside           {result.inner} degrees of freedom besides the boundary",
    ]
    if kept:
        lines.append(boundary_held(result.frequencies))
        if result.next_frequency <= (1.0 + SAME) * result.frequencies[-1]:
            lines.append(
                f"note             mode {kept + 1}, left out, has the frequency of mode {kept}: keep both "
                f"(--modes {kept + 1}) or neither, otherwise a symmetric part loses its symmetry"
            )
    return "\n".join(lines)


def boundary_held(frequencies: np.ndarray) -> str:
    """Return the line of a summary with the ``frequencies`` [Hz] of modes with the boundary nodes held."""
    lowest = ", ".join(f"{f:.6g}" for f in frequencies[:SHOWN])
    return f"boundary held    {lowest}{', ...' if len(frequencies) > SHOWN else ''} Hz, up to {frequencies[-1]:.6g} Hz"
