r"""Superelement: a part of a mechanism given by reduced stiffness and mass, linear in a frame that follows its nodes.

The coordinates are those of Craig & Bampton (1968): displacements and rotations of boundary nodes, then amplitudes of
fixed-boundary modes. They are small relative to a frame that moves with the boundary nodes, through any number of turns
(Cardona & Geradin 1991).

The file gives ``positions`` (one row for each boundary node), ``stiffness``, ``mass``, and optionally ``damping``, with
6 rows for each node in the order of ``nodes`` (displacements, rotations) and one for each mode, in the axes of the
superelement, which are those of its first node at the start. ``mecano reduce`` writes such a file for a part of a deck,
including the shapes that recover the motion of the inner nodes. The nodes of the deck must be arranged like
``positions``.

Exact: rigid motions of the mass distribution (mass, centre, inertia, gyroscopic forces) and its weight, the
balances of momentum and energy, small vibrations about a state of rest. Neglected are: coupling among deformations (no
stiffening by internal forces, no foreshortening by bending), and the velocities of the inner modes due to the rotation
of the frame, that is, their contributions to the centrifugal and Coriolis forces. Divide a part into several
superelements where these matter (docs/superelements.md).
"""

from dataclasses import replace
from functools import cache

import numpy as np

from mecano.constraints.joint_samples import rotation
from mecano.element_interface import Display, Kind, Output, named, record
from mecano.elements.bodies.reduced_matrices import (
    buckling_load,
    first_clamped_frequency,
    mass_moments,
    misplaced,
    problems,
    rigid_motions,
)
from mecano.elements.bodies.superelement_centre import first_moment, relative_motion
from mecano.elements.bodies.superelement_force import add_forces, add_product, state_of
from mecano.elements.bodies.superelement_frame import (
    MOMENTUM,
    ROWS,
    U_RATE,
    U,
    V,
    configuration,
    frame_spin,
    mean,
    put_rates,
)
from mecano.jit.kernel import kernel
from mecano.jit.memory import allocate_items, free
from mecano.maths.dual import number
from mecano.maths.so3 import quaternion
from mecano.maths.vector import dot, mat, put, vec
from mecano.schema import NODES, NUMBER, REDUCED, Field, not_negative

RECORD = record(n_nodes="i", n_modes="i", table="i", damped="i", mass=(), square=(), moment=3, gravity=3)
NOTICED = 0.1  # of the stiffness: terms of second order that are reported
NODE_OUTPUTS = (
    ("displacement", "m", "displacement of boundary node {} from its undeformed position, axes of the frame"),
    ("rotation", "rad", "rotation vector of boundary node {} from its undeformed orientation, axes of the frame"),
    ("force", "N", "force of the rest of the model on boundary node {}, inertial; own inertia included"),
    ("moment", "N m", "moment of the rest of the model on boundary node {}, inertial"),
)

MODE_OUTPUTS = (
    ("amplitude_{}", "m", "amplitude of mode {}; in metres if its shape is dimensionless, as from mecano reduce",
     "amplitude_{}_rate"),
    ("amplitude_{}_rate", "m/s", "rate of the amplitude of mode {}", ""),
)  # fmt: skip


@kernel
def residual(p, at, f):
    """Add elastic forces, damping, weight and inertia; see element_interface for the arguments."""
    work, turns = allocate_items((ROWS, f.shape[0]), f), allocate_items((p.n_nodes, 2, 3, 3), f)
    add_forces(p, at.laws, state_of(p, at, work, turns), f)
    free(work)
    free(turns)


@kernel
def inertia(p, at, m):
    """Write the diagonal of the mass matrix: twice the kinetic energies of unit velocities."""
    n, masses = m.shape[0], p.table + 12 * p.n_nodes + m.shape[0] * (3 + m.shape[0])
    work, turns, v = allocate_items((ROWS, n), m), allocate_items((p.n_nodes, 2, 3, 3), m), allocate_items((n,), m)
    R, _, D_inverse = configuration(p, at.laws, at.q, at.R, work, turns)
    moment = vec(p.moment, 0) + first_moment(p, at.laws, work[U])
    for j in range(n):
        v[j] = 1.0
        spin = frame_spin(p, at.laws, v, R, D_inverse, turns)
        put_rates(p, at.laws, v, v, R, spin, work, turns)
        velocity = mean(work[V], p.n_nodes) + relative_motion(p, at.laws, spin, moment, work)[2]
        m[j] = p.mass * dot(velocity, velocity)
        for i in range(n):
            if work[V, i] != 0.0:
                for k in range(n):
                    m[j] += work[V, i] * at.laws[masses + i * n + k] * work[V, k]
        v[j] = 0.0
    free(work)
    free(turns)
    free(v)


@kernel
def observe(p, at, F, y, e):
    """Write frame, amplitudes, coordinates, resultants, energies."""
    n = 6 * p.n_nodes + p.n_modes
    work, turns, total = allocate_items((ROWS, n), y), allocate_items((p.n_nodes, 2, 3, 3), y), allocate_items((n,), y)
    s = state_of(p, at, work, turns)
    y[0], kinetic, dissipated = _energies(p, at.laws, work)
    about = s.centre_of_mass
    kinetic += 0.5 * p.mass * dot(about.velocity, about.velocity)
    y[1] = kinetic
    put(y, 2, s.centre)
    w = quaternion(s.R)
    for i in range(4):
        y[5 + i] = w[i]
    put(y, 9, s.R @ s.spin)
    add_forces(p, at.laws, s, total)
    for i in range(p.n_nodes):
        j = 12 + 12 * i
        put(y, j, vec(work[U], 6 * i))
        put(y, j + 3, vec(work[U], 6 * i + 3))
        put(y, j + 6, vec(total, 6 * i))
        put(y, j + 9, mat(at.R[i]) @ vec(total, 6 * i + 3))
    for i in range(p.n_modes):
        y[12 + 12 * p.n_nodes + 2 * i] = number(at.q[6 * p.n_nodes + i])
        y[13 + 12 * p.n_nodes + 2 * i] = number(at.v[6 * p.n_nodes + i])
    e[0] = kinetic
    e[1] = y[0] - p.mass * dot(vec(p.gravity, 0), s.centre) - dot(s.load + about.acceleration, s.moment)
    e[2] = dissipated
    free(work)
    free(turns)
    free(total)


@kernel
def _energies(p, laws, work):
    """Return elastic energy, kinetic energy about the centre of mass, dissipated power."""
    n = work.shape[1]
    stiffness = p.table + 12 * p.n_nodes + 3 * n
    zero = 0.0 * number(work[U, 0])
    elastic, kinetic, dissipated = zero, zero, zero
    scratch = allocate_items((2, n), work)
    add_product(laws, stiffness, work[U], scratch[0])
    if p.damped > 0:
        add_product(laws, stiffness + 2 * n * n, work[U_RATE], scratch[1])
    for i in range(n):
        elastic = elastic + 0.5 * number(work[U, i]) * number(scratch[0, i])
        dissipated = dissipated + number(work[U_RATE, i]) * number(scratch[1, i])
        kinetic = kinetic + 0.5 * number(work[V, i]) * number(work[MOMENTUM, i])
    free(scratch)
    return elastic, kinetic, dissipated


def prepare(d, nodes, context):
    """Return the record of one element; its matrices are stored in the flat table."""
    reduced = d["file"]
    K, M = (_symmetric(reduced[key]) for key in ("stiffness", "mass"))
    mass, moment, _, loads = mass_moments(M, reduced["positions"])
    X = np.array(reduced["positions"], float)
    X -= X.mean(axis=0)
    table = context.laws.append([])
    for place, (_, R) in zip(X, nodes, strict=True):
        context.laws.append(place)
        context.laws.append(R.T @ nodes[0][1])
    for block in (loads, K, M - loads @ loads.T / mass, _damping(d, K, M)):
        context.laws.append(block)
    return {
        "n_nodes": len(X), "n_modes": len(K) - 6 * len(X), "table": table, "damped": int(_is_damped(d)),
        "mass": mass, "square": np.mean(np.sum(X * X, axis=1)) or 1.0, "moment": moment, "gravity": context.gravity,
    }  # fmt: skip


def _symmetric(rows):
    A = np.array(rows, float)
    return 0.5 * (A + A.T)


def _is_damped(d):
    return d["file"].get("damping") is not None or d["mass_damping"] > 0.0 or d["stiffness_damping"] > 0.0


def _damping(d, K, M):
    """Return the damping matrix (n, n), or an empty array."""
    if not _is_damped(d):
        return np.zeros(0)
    given = d["file"].get("damping")
    own = 0.0 * K if given is None else _symmetric(given)
    return own + d["mass_damping"] * M + d["stiffness_damping"] * K


def check(d, nodes):
    """Check the matrices, and that the nodes are arranged like those of the superelement."""
    reduced = d["file"]
    if len(nodes) != len(reduced["positions"]):
        return [f"'nodes' has {len(nodes)} names, but the superelement has {len(reduced['positions'])} boundary nodes"]
    found = [f"'file': {text}" for text in problems(reduced)]
    off = misplaced(reduced, nodes)
    return found or ([off] if off else [])


def limits(d):
    """Return the spin and the forces above which what is neglected is a tenth of the stiffness."""
    reduced = d["file"]
    frequency, load = first_clamped_frequency(reduced), buckling_load(reduced)
    spins = "its first frequency with held boundary nodes is {:.3g} rad/s: the centrifugal forces of its inner "
    spins += "motions, which it neglects, are more than a tenth of its stiffness; divide it into several superelements"
    presses = "its buckling load is of the order of {:.3g} N: forces in it would change its stiffness by more than a "
    presses += "tenth, which it neglects; divide it into several superelements"
    found = [("frame_spin", np.sqrt(NOTICED) * frequency, spins.format(frequency))] if frequency < np.inf else []
    forces = [f"force_{i}" for i in (1, 2)] if load < np.inf else []
    return found + [(output, NOTICED * load, presses.format(load)) for output in forces]


def variant(d):
    """Return the kind of a superelement with the numbers of nodes and modes of these values."""
    n_nodes = len(d["file"]["positions"])
    return _of_size(n_nodes, len(d["file"]["stiffness"]) - 6 * n_nodes)


@cache
def _of_size(n_nodes, n_modes):
    """Return the kind with these numbers of nodes and modes."""
    outputs = _outputs(n_nodes, n_modes)
    return replace(
        SUPERELEMENT, variant=None, outputs=outputs, hidden=_hidden(outputs),
        layout=tuple(f"{slot}{i}" for i in range(n_nodes) for slot in "xR"),
        scalars=tuple(f"amplitude_{i}" for i in range(1, n_modes + 1)),
    )  # fmt: skip


def _outputs(n_nodes, n_modes, more=""):
    """Return the outputs with these numbers of nodes and modes; ``more`` ends the descriptions of numbered ones."""
    numbers, modes = range(1, n_nodes + 1), range(1, n_modes + 1)
    return (
        *OUTPUTS,
        *(Output(f"{name}_{i}", unit, doc.format(i) + more, (3,)) for i in numbers for name, unit, doc in NODE_OUTPUTS),
        *(
            Output(name.format(i), unit, doc.format(i) + more, rate=rate.format(i))
            for i in modes
            for name, unit, doc, rate in MODE_OUTPUTS
        ),
    )


def _hidden(outputs):
    """Return {output: what to do instead} of those that depend on accelerations."""
    names = [output.name for output in outputs if output.name.startswith(("force", "moment"))]
    return dict.fromkeys(names, "measure a reaction of a joint")


def sample(rng):
    """Return one node alone, and two and three nodes with modes, with and without damping, in random orientations."""
    found = []
    for n_nodes, n_modes, damping in ((1, 2, {}), (2, 3, {"stiffness_damping": 0.1}), (3, 0, {"mass_damping": 0.3})):
        X, n = rng.normal(size=(n_nodes, 3)), 6 * n_nodes + n_modes
        rigid = np.hstack(rigid_motions(X, n))
        free = np.eye(n) - rigid @ np.linalg.pinv(rigid)
        stiff, heavy = rng.normal(size=(2, n, n))
        K = free @ stiff @ stiff.T @ free
        M = _body_like(heavy @ heavy.T, rigid, rng)
        reduced = {"positions": X.tolist(), "stiffness": K.tolist(), "mass": M.tolist()}
        if n_nodes == 2:
            reduced["damping"] = (0.5 * free @ heavy @ heavy.T @ free).tolist()
        turns = [rotation(rng) for _ in range(n_nodes)]
        nodes = [(x @ turns[0].T + 0.3, A) for x, A in zip(X, turns, strict=True)]
        found.append(({"file": reduced, **damping}, nodes, ""))
    return found


def _body_like(M, rigid, rng):
    """Return M, modified so that its rigid motions are those of a body: mass 2, random first moment, some inertia."""
    first = -np.cross(np.eye(3), 0.3 * rng.normal(size=3))
    body = np.block([[2.0 * np.eye(3), first], [first.T, 2.0 * np.eye(3)]])
    inverse = np.linalg.pinv(rigid)
    free = np.eye(len(M)) - rigid @ inverse
    return free @ M @ free + inverse.T @ body @ inverse


OUTPUTS = (
    Output("strain_energy", "J", "elastic energy"),
    Output("kinetic_energy", "J", "kinetic energy"),
    Output("frame_origin", "m", "mean of the boundary nodes, the origin of the frame, inertial", (3,), geometric=True),
    Output("frame_rotation", "-", "unit quaternion (w, x, y, z) from the axes of the frame to inertial axes", (4,)),
    Output("frame_spin", "rad/s", "angular velocity of the frame, inertial axes", (3,)),
)
DECLARED = _outputs(1, 1, "; and so on")
SUPERELEMENT = Kind(
    name="superelement", section="elements", doc=__doc__, display=Display("superelement"), dtype=RECORD,
    fields=(
        Field("nodes", NODES, "-", "its boundary nodes, in the order of the matrices"),
        Field("file", REDUCED, "-", "its matrices: a file in the folder of the deck, or its contents"),
        Field("mass_damping", NUMBER, "1/s", "damping per mass, of deformations only", 0.0, not_negative),
        Field("stiffness_damping", NUMBER, "s", "damping per stiffness", 0.0, not_negative),
    ),
    flexible=True,
    **named(prepare, check, residual, inertia, observe, sample, variant, limits),
    outputs=DECLARED,
    hidden=_hidden(DECLARED),
)  # fmt: skip
