r"""Bushing: an elastic and viscous connection of two nodes, with 6 x 6 stiffness and damping matrices.

In axes :math:`\mu_i` fixed in a (those of node a, or ``axis`` and ``axis_1``), with :math:`\xi_i` the same initial
axes fixed in b, rows of :math:`\mu` and :math:`\xi`:

.. math::  d = \mu R_a^T (x_b - x_a) - d_0, \qquad \psi = \log(\mu R_a^T R_b \xi^T), \qquad e = (d, \psi) - e_0

.. math::  V = \tfrac12 e^T S e, \qquad (n, m) = S e + D \dot e, \qquad \dot\psi = T^{-1}(\psi)\,\omega

with :math:`\omega = \xi \Omega_b - Q^T \mu \Omega_a, Q = \exp\hat\psi`. The forces are conjugate to :math:`\delta e`,
so the result does not depend on position and orientation of the model, and the elastic forces have a potential for any
rotation up to :math:`|\psi| < \pi`, the limit of the rotation vector, where the moments jump, which a run reports:

.. math::  f_{x_b} = R_a \mu^T n = -f_{x_a}, \qquad f_{\Theta_b} = \xi^T T^{-T} m, \qquad
   f_{\Theta_a} = \mu^T n \times R_a^T (x_b - x_a) - \mu^T T^{-1} m

``laws`` add laws for single axes, with free play and stops: along an axis as a function of d, about an axis as a
function of the sine of the tilt or of the twist. The set points :math:`e_0` (``natural``) of the matrices and laws are
laws of time or formulas of signals; the surroundings give their power :math:`-(n, m) \cdot \dot e_0`. A bushing without
``laws`` may have an ``activate`` (with ``stress_free`` it begins at e = 0) and a ``release``.
"""

from dataclasses import replace

import numpy as np

from mecano.constraints.activation import SHIFT, with_activation
from mecano.constraints.along_coordinate.demand import as_formula, check_alike, is_formula
from mecano.constraints.joint_nodes import check_axis_1
from mecano.constraints.joint_samples import PLAY
from mecano.constraints.pair import AXES, AXIS_1, law_fields, law_outputs, law_parts, triads_together
from mecano.constraints.release import with_release
from mecano.constraints.triads import triad
from mecano.element_interface import Kind, Output, named, record
from mecano.jit.kernel import kernel
from mecano.laws.law_table import evaluate_curve
from mecano.maths.dual import number
from mecano.maths.so3 import log, tangent_inverse
from mecano.maths.vector import ZERO, Vec3, add_vec, cross, dot, mat, put, vec
from mecano.schema import CONTINUOUS_DRIVE, DIRECTION, MATRIX_6, NODE_PAIR, Field, mapping

RECORD = record(natural=6, stiffness=(6, 6), damping=(6, 6), mu=(3, 3), xi=(3, 3), start=3)
ORDER = ("along_1", "along_2", "along_axis", "about_1", "about_2", "about_axis")
INPUT = 12  # local index of the first set point that is a signal
FORCES = tuple(range(6, 12))  # outputs
MOST_ROTATION = 3.0  # [rad] a component of the rotation vector: just before half a turn
ROUNDING = 1e-9  # of the largest eigenvalue: smaller negative eigenvalues count as zero


@kernel
def _blocks(S):
    """Return the four 3 x 3 blocks ((S_dd, S_dp), (S_pd, S_pp)) of a matrix (6, 6)."""
    return (mat(S[:3, :3]), mat(S[:3, 3:])), (mat(S[3:, :3]), mat(S[3:, 3:]))


@kernel
def _strain(p, q, v, R):
    """Return d and psi, their rates, and d_a = R_a^T (x_b - x_a)."""
    A, mu, xi = mat(R[0]), mat(p.mu), mat(p.xi)
    omega_a, omega_b = vec(v, 3), vec(v, 9)
    d_a, w = A.T @ (vec(q, 6) - vec(q, 0)), A.T @ (vec(v, 6) - vec(v, 0))
    Q = mu @ (A.T @ mat(R[1]) @ xi.T)
    psi = log(Q)
    omega = xi @ omega_b - Q.T @ (mu @ omega_a)
    d, d_rate = mu @ d_a - vec(p.start, 0), mu @ (w + cross(d_a, omega_a))
    return d, psi, d_rate, tangent_inverse(psi) @ omega, d_a


@kernel
def _fixed(p, at):
    """Return set points of d and psi that are zero, and their rates."""
    return ZERO, ZERO, ZERO, ZERO


@kernel
def _of_law(p, at, i):
    return evaluate_curve(at.laws, int(p.natural[i]), at.t)[:2]


@kernel
def _of_signal(p, at, i):
    return number(at.q[INPUT + i]), number(at.v[INPUT + i])


def _moving(one):
    """Return the compiled function (p, at) -> set points of d and psi, and their rates, of one(p, at, i)."""

    @kernel
    def moving(p, at):
        (x, u), (y, v), (z, w) = one(p, at, 0), one(p, at, 1), one(p, at, 2)
        (a, i), (b, j), (c, k) = one(p, at, 3), one(p, at, 4), one(p, at, 5)
        return Vec3(x, y, z), Vec3(a, b, c), Vec3(u, v, w), Vec3(i, j, k)

    return moving


@kernel
def _product(S, d, psi):
    """Return S (d, psi) for a matrix in blocks."""
    return S[0][0] @ d + S[0][1] @ psi, S[1][0] @ d + S[1][1] @ psi


def _functions(set_points):
    """Return ``residual`` and ``observe`` for set points (p, at) -> values of d and psi, their rates."""

    @kernel
    def loads(p, at):
        d, psi, d_rate, psi_rate, d_a = _strain(p, at.q, at.v, at.R)
        d_0, psi_0, d_0_rate, psi_0_rate = set_points(p, at)
        e, e_rate = (d - d_0, psi - psi_0), (d_rate - d_0_rate, psi_rate - psi_0_rate)
        elastic, viscous = _product(_blocks(p.stiffness), *e), _product(_blocks(p.damping), *e_rate)
        return (d, psi, d_a), e, e_rate, elastic, viscous

    @kernel
    def residual(p, at, f):
        A, mu = mat(at.R[0]), mat(p.mu)
        (_, psi, d_a), _, _, elastic, viscous = loads(p, at)
        n_a, couple, J = mu.T @ (elastic[0] + viscous[0]), elastic[1] + viscous[1], tangent_inverse(psi)
        add_vec(f, 0, -1.0, A @ n_a)
        add_vec(f, 3, 1.0, cross(n_a, d_a) - mu.T @ (J @ couple))
        add_vec(f, 6, 1.0, A @ n_a)
        add_vec(f, 9, 1.0, mat(p.xi).T @ (J.T @ couple))

    @kernel
    def observe(p, at, F, y, e):
        """Write y = (d [m], psi [rad], force [N], moment [N m] on node b), each (3,) along mu, and energies.

        With the strain s = (d - d_0, psi - psi_0): e[1] = s.K s/2 [J], e[2] = s'.D s' [W] is dissipated, e[3] =
        -(n.d_0' + m.psi_0') [W] is given by moving set points.
        """
        (d, psi, _), strain, rate, elastic, viscous = loads(p, at)
        _, _, d_0_rate, psi_0_rate = set_points(p, at)
        n, m = elastic[0] + viscous[0], elastic[1] + viscous[1]
        put(y, 0, d)
        put(y, 3, psi)
        put(y, 6, -n)
        put(y, 9, -(tangent_inverse(psi) @ m))
        e[1] = 0.5 * (dot(strain[0], elastic[0]) + dot(strain[1], elastic[1]))
        e[2] = dot(rate[0], viscous[0]) + dot(rate[1], viscous[1])
        e[3] = -(dot(n, d_0_rate) + dot(m, psi_0_rate))

    return named(residual, observe)


def matrix(values):
    """Return (6, 6) from six diagonal numbers, a 6 x 6 matrix, or None (zero)."""
    if values is None:
        return np.zeros((6, 6))
    S = np.asarray(values, float)
    return np.diag(S) if S.ndim == 1 else S


def _place(d, nodes):
    """Return the axes of both nodes (pair.py), by default those of node a."""
    return triads_together(nodes, nodes[0][1].T if d["axis"] is None else triad(d["axis"], d["axis_1"]))


def prepare(d, nodes, context):
    """Return the record of one bushing."""
    laws = [law for law in _set_points(d) if not is_formula(law)]
    natural = [context.laws.add(law) for law in laws] if len(laws) == len(ORDER) else np.zeros(len(ORDER))
    return {
        "natural": natural,
        "stiffness": matrix(d["stiffness"]),
        "damping": matrix(d["damping"]),
        **_place(d, nodes),
    }


def _set_points(d):
    """Return the set points of all axes in their order."""
    return [(d["natural"] or {}).get(axis) for axis in ORDER]


def check(d, nodes):
    """Check that stiffness is symmetric, that neither matrix generates energy, and that some property is given."""
    texts = [] if d["axis"] is None else check_axis_1(d, nodes)
    if d["axis"] is None and d["axis_1"] is not None:
        texts.append("'axis_1' is given without 'axis'")
    if all(d[name] is None for name in ("stiffness", "damping", "laws")):
        texts.append("give 'stiffness', 'damping' or 'laws'")
    texts += check_alike("natural", _set_points(d))
    texts += [
        f"{name!r} and 'laws' exclude one another"
        for name in ("activate", "release")
        if d[name] is not None and d["laws"] is not None
    ]
    S = matrix(d["stiffness"])
    if not np.allclose(S, S.T, rtol=1e-9, atol=0.0):
        texts.append(
            "'stiffness' must be symmetric: it has a potential; the skew part of that of an oil film is two loads with "
            "formulas of the position of the node (docs/modes.md)"
        )
    for name in ("stiffness", "damping"):
        found = matrix(d[name])
        values = np.linalg.eigvalsh(0.5 * (found + found.T))
        if values[0] < -ROUNDING * max(values[-1], 0.0):
            texts.append(f"{name!r} must not generate energy: its symmetric part has the eigenvalue {values[0]:.6g}")
    return texts


def limits(d):
    """Return the limit of the rotation vector, if the matrices have moments."""
    if not any(matrix(d[name])[:, 3:].any() for name in ("stiffness", "damping")):
        return []
    text = (
        "the moments of the matrices jump at half a turn; a 'torsion_spring_damper', the 'turning_law' of a hinge and "
        "the 'laws' of a bushing count turns"
    )
    return [("rotation_vector", MOST_ROTATION, text)]


X = np.sin(np.arange(36.0) ** 2).reshape(6, 6)  # some matrix, for samples, as all that follows
FULL = {"stiffness": X @ X.T, "damping": 3.0 * np.eye(6) + X - X.T}
DIAGONAL = {"stiffness": [1, 2, 3, 4, 5, 6], "axis": (0.6, 0.2, 1.0), "axis_1": (0.3, -1.0, 0.5)}
MOVED = (("linear", {"slope": 0.2, "offset": 0.1}),)


NATURAL = (
    Field(axis, CONTINUOUS_DRIVE, "m" if axis.startswith("along") else "rad", f"{axis.split('_')[0]} this axis", None)
    for axis in ORDER
)


def _bushing(set_points):
    return Kind(
        name="bushing", section="elements", doc=__doc__, dtype=RECORD, layout=("x0", "R0", "x1", "R1"),
        fields=(
            Field("nodes", NODE_PAIR, "-", "nodes a (with the axes) and b; either may be ground"),
            Field("stiffness", MATRIX_6, "N/m, N, N m/rad", "forces (1, 2, 3), moments (1, 2, 3) by d and psi", None),
            Field("damping", MATRIX_6, "N s/m, N s, N m s/rad", "the same by their rates", None),
            Field("axis", DIRECTION, "-", "third axis at the start, inertial; the axes of node a when absent", None),
            AXIS_1,
            Field("laws", mapping(*law_fields(AXES)), "-", "laws of single axes, added to the matrices", None),
            Field("natural", mapping(*NATURAL), "-", "set points e_0 of the axes; zero when absent", None),
        ),
        outputs=(
            Output("displacement", "m", "d, displacement of b from the start, along the axes", (3,)),
            Output("rotation_vector", "rad", "psi, rotation vector of b relative to a, in the axes", (3,)),
            Output("force", "N", "force of the matrices on b, along the axes", (3,)),
            Output("moment", "N m", "moment of the matrices on b, about the axes", (3,)),
        ),
        optional=law_outputs("laws", AXES),
        parts=lambda d, nodes, context: law_parts(_place(d, nodes), AXES, d["laws"], d["natural"], context),
        cases=(
            FULL,
            {**DIAGONAL, "damping": X.T @ X, "laws": {"along_2": PLAY, "about_axis": PLAY}},
            {**FULL, "natural": {"along_1": MOVED, "about_2": MOVED}},
            {**FULL, "natural": {"along_2": "command", "about_axis": "2*command"}},
            {**DIAGONAL, "laws": {"along_1": PLAY, "about_1": PLAY}, "natural": {"about_1": "command"}},
        ),
        **named(prepare, check, limits),
        **_functions(set_points),
    )  # fmt: skip


def _stress_free(set_points):
    """Return the Kind of a bushing with these ``set_points``, whose strain is that since its activation."""

    @kernel
    def shifted(p, at):
        d_0, psi_0, d_0_rate, psi_0_rate = set_points(p, at)
        return d_0 + vec(at.m, 0), psi_0 + vec(at.m, 3), d_0_rate, psi_0_rate

    @kernel
    def commit(p, at, m_out):
        d, psi, _, _, _ = _strain(p, at.q, at.v, at.R)
        d_0, psi_0, _, _ = set_points(p, at)
        put(m_out, 0, d - d_0)
        put(m_out, 3, psi - psi_0)

    return replace(_bushing(shifted), memory=tuple(f"{SHIFT}_{axis}" for axis in ORDER), commit=commit)


def _released(make):
    """Return the Kind ``make(set_points)`` with a release; its variants have set points by laws of time, or signals."""
    still, by_laws = make(_fixed), make(_moving(_of_law))
    by_signals = replace(make(_moving(_of_signal)), inputs=ORDER, reads=lambda d: list(map(as_formula, _set_points(d))))

    def variant(d):
        given = [value for value in _set_points(d) if value is not None]
        return by_signals if any(map(is_formula, given)) else by_laws if given else still

    return with_release(replace(still, variant=variant), "bushing", FORCES)


BUSHING = with_activation(_released(_bushing), "bushing", FORCES, (_released(_stress_free), FORCES))
