"""`mecano import`: matrices of a part from a punch file of Nastran to a file for superelements.

The file is that of an external superelement, EXTSEOUT(EXTBULK, DMIGPCH): its boundary nodes (GRID), their coordinate
systems (CORD2R), and the matrices KAAX, MAAX and, if there is damping, BAAX (DMIG; another suffix than AAX is chosen by
DMIGSFIX). Degrees of freedom are the six of each boundary node, in the system of its displacements, and scalars
(SPOINT): the amplitudes of modes with the boundary held.
"""

from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import NamedTuple

import numpy as np

from mecano.analyses.nastran_cards import Card, read_cards
from mecano.analyses.reduction import boundary_held, new_file, write
from mecano.elements.bodies.reduced_matrices import mass_moments, problems
from mecano.errors import ResultsError, UsageError

MATRICES = {"K": "stiffness", "M": "mass", "B": "damping"}  # by the first letter of their names
SYMMETRIC = 6  # form of a matrix of which one triangle is given


class Units(NamedTuple):
    """Sizes of the units of length [m] and mass [kg] of a file; that of time is a second."""

    length: float = 1.0
    mass: float = 1.0


def import_matrices(source: "str | Path", path: "str | Path", units: Units, *, force: bool = False) -> str:
    """Write the matrices of the punch file ``source`` in SI units to ``path`` (.npz or .h5); return a summary.

    Raises UsageError for a file that does not describe a part, ResultsError for one that cannot be read or written.
    """
    path = new_file(path, force)
    try:
        cards = list(read_cards(Path(source).read_text(encoding="latin-1")))
    except OSError as error:
        raise ResultsError(f"cannot read {source}: {error.strerror or error}") from None
    try:
        content, names = matrices_of(cards, units)
    except UsageError as error:
        raise UsageError(f"{source}: {error}") from None
    write(path, content)
    return _summary(path, content, names)


def matrices_of(cards: Iterable[Card], units: Units) -> tuple[dict[str, np.ndarray], list[int]]:
    """Return the content of a file of reduced matrices in SI units, and the numbers of its boundary nodes.

    Axes are those of the basic system. Amplitudes are scaled to modes with the mass of the part, so they are in metres.
    Raises UsageError.
    """
    cards = list(cards)
    entries, forms = _entries(cards)
    systems, grids = _systems(cards), {card.integer(0): card for card in cards if card.name == "GRID"}
    used = {place for matrix in entries.values() for pair in matrix for place in pair}
    nodes = [number for number in grids if any((number, c) in used for c in range(1, 7))]
    _refuse_strays(used, nodes, cards)
    amplitudes = sorted(number for number, component in used if component == 0)
    index = {place: i for i, place in enumerate([(n, c) for n in nodes for c in range(1, 7)])}
    index |= {(number, 0): len(index) + i for i, number in enumerate(amplitudes)}
    placed = [_placed(grids[number], systems) for number in nodes]
    turn = np.eye(len(index))
    for i, (_, R) in enumerate(placed):
        turn[6 * i : 6 * i + 3, 6 * i : 6 * i + 3] = turn[6 * i + 3 : 6 * i + 6, 6 * i + 3 : 6 * i + 6] = R
    content = {"positions": units.length * np.array([x for x, _ in placed]).reshape(-1, 3)}
    for name, matrix in entries.items():
        content[name] = turn @ _dense(matrix, index, forms.get(name, SYMMETRIC)) @ turn.T
    _in_si(content, 6 * len(nodes), units)
    found = problems({key: value.tolist() for key, value in content.items()})
    if found:
        raise UsageError(found[0])
    _scale_modes(content, 6 * len(nodes))
    return content, nodes


def _entries(cards):
    """Return {matrix: {(row, column): value}}, rows and columns as (node, component), and {matrix: form}."""
    columns = [card for card in cards if card.name == "DMIG"]
    suffix = _suffix({card.field(0) for card in columns})
    entries: dict[str, dict] = {}
    forms: dict[str, int] = {}
    for card in columns:
        name = MATRICES.get(card.field(0)[:1])
        if name is None or card.field(0)[1:] != suffix:
            continue
        if card.field(1) == "0":
            forms[name] = card.integer(2)
            continue
        column, of_matrix = (card.integer(1), card.integer(2)), entries.setdefault(name, {})
        for i in range(4, len(card.fields), 4):
            if card.field(i):
                of_matrix[(card.integer(i), card.integer(i + 1)), column] = card.number(i + 2)
    return entries, forms


def _suffix(names):
    """Return what the names of stiffness and mass have after their first letters. Raises UsageError."""
    found = {name[1:] for name in names if name[:1] == "K"} & {name[1:] for name in names if name[:1] == "M"}
    if len(found) == 1:
        return found.pop()
    has = f"it has {', '.join(sorted(names))}" if names else "it has none"
    raise UsageError(
        "a part has one pair of matrices DMIG of stiffness and mass, such as KAAX and MAAX, of an external "
        f"superelement written by EXTSEOUT(EXTBULK,EXTID=1,DMIGPCH); {has}"
    )


def _dense(matrix, index, form):
    A = np.zeros((len(index), len(index)))
    for (row, column), value in matrix.items():
        A[index[row], index[column]] = value
        if form == SYMMETRIC:
            A[index[column], index[row]] = value
    return A


def _refuse_strays(used, nodes, cards):
    """Raise UsageError for rows of no boundary node, and for nodes without all six components."""
    strays = sorted({number for number, component in used if component and number not in nodes})
    if strays:
        raise UsageError(f"no GRID {strays[0]}, of which the matrices have rows: use EXTBULK, which writes the nodes")
    if not nodes:
        raise UsageError("the matrices have no row of a node")
    for card in cards:
        pairs = zip(card.fields[::2], card.fields[1::2], strict=False) if card.name in ("EXTRN", "ASET") else ()
        for number, components in pairs:
            if number.isdecimal() and int(number) in nodes and set(components) != set("123456"):
                raise UsageError(
                    f"line {card.line}: node {number} has the components {components}; a superelement needs 123456"
                )


def _systems(cards):
    """Return {number: (origin (3,), axes (3, 3))} of the rectangular systems in the basic one."""
    given = {card.integer(0): card for card in cards if card.name == "CORD2R"}
    found = {0: (np.zeros(3), np.eye(3))}
    while given:
        known = [number for number, card in given.items() if card.integer(1) in found]
        if not known:
            raise UsageError(f"the systems {', '.join(map(str, given))} refer to others that the file does not have")
        for number in known:
            card = given.pop(number)
            origin, axes = found[card.integer(1)]
            a, b, c = (np.array([card.number(2 + 3 * i + j) for j in range(3)]) for i in range(3))
            z = (b - a) / np.linalg.norm(b - a)
            y = np.cross(z, c - a)
            y /= np.linalg.norm(y)
            found[number] = origin + axes @ a, axes @ np.column_stack([np.cross(y, z), y, z])
    return found


def _placed(card, systems):
    """Return position (3,) of a node in the basic system, and the axes (3, 3) of its displacements there."""
    place, own = card.integer(1), card.integer(5)
    for number in (place, own):
        if number not in systems:
            raise UsageError(
                f"line {card.line}: GRID {card.field(0)} refers to the system {number}, which is not a CORD2R of the "
                "file; systems of boundary nodes must be rectangular"
            )
    origin, axes = systems[place]
    return origin + axes @ [card.number(i) for i in (2, 3, 4)], systems[own][1]


def _in_si(content, n, units):
    """Convert matrices whose first n rows are displacements and rotations, and whose energies are mass length2/s2."""
    size = np.ones(len(content["stiffness"]))
    for i in range(0, n, 6):
        size[i : i + 3] = units.length
    for name in MATRICES.values():
        if name in content:
            content[name] = units.mass * units.length**2 * content[name] / np.outer(size, size)


def _scale_modes(content, n):
    """Scale the amplitudes, from row n on, to modes with the mass of the part."""
    size = np.ones(len(content["mass"]))
    size[n:] = np.sqrt(mass_moments(content["mass"], content["positions"])[0] / np.diag(content["mass"])[n:])
    for name in MATRICES.values():
        if name in content:
            content[name] = content[name] * np.outer(size, size)


def _summary(path: Path, content: Mapping[str, np.ndarray], nodes: list[int]) -> str:
    """Return a summary for a terminal, to be compared with that of the finite element program."""
    from scipy.linalg import eigh

    M, n = content["mass"], 6 * len(nodes)
    mass, moment, inertia, _ = mass_moments(M, content["positions"])
    centre = content["positions"].mean(axis=0) + moment / mass
    own = inertia - (moment @ moment * np.eye(3) - np.outer(moment, moment)) / mass
    lines = [
        f"{path}: {n} coordinates of the boundary nodes {', '.join(map(str, nodes))}; {len(M) - n} modes",
        f"mass             {mass:.6g} kg",
        f"centre of mass   {', '.join(f'{x:.6g}' for x in centre)} m",
        f"inertia about it {', '.join(f'{x:.6g}' for x in np.diag(own))} kg m2 (xx, yy, zz)",
    ]
    if len(M) > n:
        squares = eigh(content["stiffness"][n:, n:], M[n:, n:], eigvals_only=True)
        lines.append(boundary_held(np.sqrt(np.maximum(squares, 0.0)) / (2.0 * np.pi)))
    return "\n".join(lines)
