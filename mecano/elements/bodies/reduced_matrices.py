"""Input of a superelement: stiffness, mass and damping for boundary nodes and modes, and the checks on them.

The matrices are plain lists, as written in a deck, with 6 rows for each boundary node (3 displacements, 3 rotations),
in the order of ``positions``, then one row for each mode.
"""

import numpy as np

SYMMETRY = 1e-8  # of the largest entry
RIGID = 1e-6  # forces of a rigid motion, relative to those that it would cause in springs to the ground
NEGATIVE = 1e-8  # of the largest eigenvalue
PLACE = 1e-6  # of the size of the superelement
CLAMPED = 22.373  # square of the first root of cos(x) cosh(x) = 1: frequency of a clamped bar
IN_MM = 500.0, 2000.0  # ratio of the sizes of a part in mm and of its nodes


def rigid_motions(positions, n):
    """Return translations (n, 3) and rotations (n, 3) for n coordinates, about the mean of the boundary nodes."""
    X = np.asarray(positions, float)
    X = X - X.mean(axis=0)
    translations, rotations = np.zeros((n, 3)), np.zeros((n, 3))
    for i, (x, y, z) in enumerate(X):
        translations[6 * i : 6 * i + 3] = np.eye(3)
        rotations[6 * i : 6 * i + 3] = [[0.0, z, -y], [-z, 0.0, x], [y, -x, 0.0]]
        rotations[6 * i + 3 : 6 * i + 6] = np.eye(3)
    return translations, rotations


def resistance(K, r, stiffness=0.0):
    """Return the largest force of K (n, n) on a rigid motion r (n,), relative to that of springs with K's diagonal.

    ``stiffness`` (n,): stiffnesses of which K is a difference, used where they are larger than the diagonal.
    """
    diagonal = np.maximum(np.abs(np.diag(K)), stiffness)
    size = np.sqrt(diagonal * (r @ (diagonal * r)))
    forces = np.abs(K @ r)
    return float(np.max(forces[size > 0.0] / size[size > 0.0], initial=0.0))


def mass_moments(mass, positions):
    """Return mass [kg]; first moment [kg m] (3,), inertia [kg m2] (3, 3) about the nodes' mean; loads M r (n, 3)."""
    M = np.asarray(mass, float)
    translations, rotations = rigid_motions(positions, len(M))
    loads = M @ translations
    C = translations.T @ M @ rotations  # -hat(S)
    S = 0.5 * np.array([C[1, 2] - C[2, 1], C[2, 0] - C[0, 2], C[0, 1] - C[1, 0]])
    return np.trace(translations.T @ loads) / 3.0, S, rotations.T @ M @ rotations, loads


def first_clamped_frequency(reduced):
    """Return the lowest circular frequency [rad/s] with held boundary nodes; infinite without modes."""
    inner = slice(6 * len(reduced["positions"]), None)
    K, M = (np.array(reduced[key], float)[inner, inner] for key in ("stiffness", "mass"))
    slowest = np.linalg.eigvals(np.linalg.pinv(K) @ M).real.max(initial=0.0)
    return float(1.0 / np.sqrt(slowest)) if slowest > 0.0 else np.inf


def buckling_load(reduced):
    r"""Return the buckling load [N] of a part between two boundary nodes, hinged at both; infinite for others.

    That of a uniform bar with its mass m, the distance L of its nodes and its first frequency with clamped ends:

    .. math::  \frac{\pi^2 EI}{L^2}, \qquad \omega = 22.373 \sqrt{\frac{EI}{m L^3}}
    """
    X, frequency = np.array(reduced["positions"], float), first_clamped_frequency(reduced)
    if len(X) != 2 or frequency == np.inf:
        return np.inf
    mass = mass_moments(reduced["mass"], X)[0]
    return np.pi**2 * mass * np.linalg.norm(X[1] - X[0]) * (frequency / CLAMPED) ** 2


def problems(reduced):
    """Return the errors in the values of a file, as texts that continue a sentence after its name."""
    n_nodes = len(reduced["positions"])
    matrices = {key: reduced[key] for key in ("stiffness", "mass", "damping") if reduced.get(key) is not None}
    sizes = {key: (len(rows), *{len(row) for row in rows}) for key, rows in matrices.items()}
    n = sizes["stiffness"][0]
    for key, size in sizes.items():
        if len(size) != 2 or size[0] != size[1]:
            return [f"'{key}' is not square"]
        if size[0] != n:
            return [f"'{key}' has {size[0]} rows, 'stiffness' {n}"]
    if n < 6 * n_nodes:
        return [f"the matrices have {n} rows, but {n_nodes} boundary nodes alone need {6 * n_nodes}"]
    inner = _interior(reduced, n)
    if inner:
        return [inner]
    arrays = {key: np.array(rows, float) for key, rows in matrices.items()}
    found = [text for key, A in arrays.items() for text in _quadratic_form(key, A)]
    return found or _rigid(arrays, reduced["positions"], n)


def _interior(reduced, n):
    """Return an error in the values of inner nodes and lines, or ""."""
    count = len(reduced["positions"]) + len(reduced.get("interior_names") or ())
    lines = np.array(reduced.get("lines") or np.zeros((0, 2)))
    if lines.shape[1:] != (2,) or np.any((lines < 0) | (lines >= count) | (lines != np.round(lines))):
        return f"'lines' must be pairs of node numbers, 0 to {count - 1}"
    given = [reduced.get(f"interior_{key}") for key in ("names", "positions", "basis")]
    if all(value is None for value in given):
        return ""
    if any(value is None for value in given):
        return "'interior_names', 'interior_positions' and 'interior_basis' belong together"
    names, positions, basis = given
    sizes = (len(positions), len(positions[0]), len(basis), len(basis[0]))
    if sizes != (len(names), 3, 3 * len(names), n):
        return (
            f"{len(names)} inner nodes need 'interior_positions' of 3 columns and 'interior_basis' of {3 * len(names)} "
            f"rows and {n} columns; these are {sizes[0]} x {sizes[1]} and {sizes[2]} x {sizes[3]}"
        )
    return ""


def _quadratic_form(key, A):
    largest = np.abs(A).max(initial=0.0)
    gap = np.abs(A - A.T)
    if gap.max(initial=0.0) > SYMMETRY * largest:
        i, j = np.unravel_index(np.argmax(gap), A.shape)
        pair = f"({i + 1}, {j + 1}) and ({j + 1}, {i + 1}) are {A[i, j]:.6g} and {A[j, i]:.6g}"
        yield f"'{key}' is not symmetric: entries {pair}"
        return
    # rotations and amplitudes have other units than displacements: scaling to equal diagonals removes this
    scale = np.sqrt(np.maximum(np.diag(A), 1e-30 * largest + 1e-300))
    lowest, *_, highest = np.linalg.eigvalsh(A / np.outer(scale, scale)) if len(A) > 1 else (A[0, 0], A[0, 0])
    if lowest < -NEGATIVE * max(highest, 1.0):
        yield f"'{key}' is not positive semi-definite: with unit diagonal its lowest eigenvalue is {lowest:.3g}"


def _rigid(arrays, positions, n):
    translations, rotations = rigid_motions(positions, n)
    K, M = arrays["stiffness"], arrays["mass"]
    mass = mass_moments(M, positions)[0]
    if mass <= 0.0:
        return [f"'mass' has no mass in rigid translations; {EXPECTED}"]
    found = []
    for name, motions in (("translation", translations), ("rotation", rotations)):
        for axis, r in zip("xyz", motions.T, strict=True):
            if resistance(K, r) > RIGID:
                found.append(f"'stiffness' resists a rigid {name} along {axis}; {EXPECTED}")
    block = translations.T @ M @ translations
    if np.abs(block - mass * np.eye(3)).max() > RIGID * mass:
        found.append(
            f"'mass' is not the same along x, y and z: {', '.join(f'{m:.6g}' for m in np.diag(block))}; {EXPECTED}"
        )
    C = translations.T @ M @ rotations
    if np.abs(C + C.T).max() > RIGID * max(np.abs(C).max(), np.sqrt(mass * np.abs(rotations.T @ M @ rotations).max())):
        found.append(f"'mass' is not the mass of one body in rigid rotations; {EXPECTED}")
    return found[:1]


EXPECTED = (
    "expected are displacements x, y, z and rotations x, y, z of each node in the order of 'positions', then the "
    "modes, in SI units"
)


def misplaced(reduced, nodes):
    """Return an error for a node misplaced relative to the superelement, or ""; ``nodes`` are (x (3,), R (3, 3))."""
    X = np.array(reduced["positions"], float)
    x = np.array([place for place, _ in nodes])
    off = np.linalg.norm((x - x[0]) - (X - X[0]) @ nodes[0][1].T, axis=1)
    worst, size = int(np.argmax(off)), np.ptp(X, axis=0).max(initial=0.0)
    if off[worst] <= PLACE * size:
        return ""
    return (
        f"'nodes': number {worst + 1} is {off[worst]:.3g} m from its position in the superelement, whose axes are "
        f"those of the first node{_larger(np.ptp(x, axis=0).max(initial=0.0), size)}"
    )


def _larger(model, part):
    """Return a clause if the ``part`` is a thousand times as large as its nodes in the ``model`` [m] are apart."""
    if not model or not IN_MM[0] < part / model < IN_MM[1]:
        return ""
    return f"; it is {part / model:.4g} times as large as the model: are its file and matrices in mm, not in SI units?"
