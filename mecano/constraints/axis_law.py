"""A law along a coordinate between two nodes (sliding, twist, tilt, angle of a pin): force, energies, record.

The coordinate c has gradients b_i by local unknowns of the element and a rate, whose gradients are r_i; the law gives
P(c - natural, dc/dt), which adds P b_i to the forces: P > 0 drives the coordinate back.
"""

from mecano.compiled.kernel import kernel
from mecano.constraints.carried import add_blocks
from mecano.constraints.stop_modes import EVENTS, MODES, law_record, put_stop_events
from mecano.contract import Kind, Output
from mecano.laws.table import evaluate_force, potential
from mecano.maths.vector import add_mat, add_vec, outer

LAW_RECORD = {"law": "i", "natural": (), "low": (), "high": ()}


@kernel
def add_along(f, K, C, P, P_c, P_rate, blocks):
    """Add the force P [N, N m] along a coordinate, with its derivatives by coordinate and rate.

    ``blocks`` is a tuple of (local index, b (3,), r (3,)). The derivative of b itself is left to the caller.
    """
    for i, b, _ in blocks:
        add_vec(f, i, P, b)
        for j, c, r in blocks:
            add_mat(K, i, j, 1.0, outer(b, P_c * c + P_rate * r))
            add_mat(C, i, j, P_rate, outer(b, c))


@kernel
def turning_blocks(i, j, gradient, H, omega_0, omega_1):
    """Blocks for ``add_along`` of a coordinate of two rotations at i, j, given its gradients and their derivatives."""
    r_0 = H[0][0].T @ omega_0 + H[1][0].T @ omega_1
    r_1 = H[0][1].T @ omega_0 + H[1][1].T @ omega_1
    return (i, gradient[0], r_0), (j, gradient[1], r_1)


@kernel
def add_turning(f, K, C, P, P_c, P_rate, gradient, H, omega_0, omega_1):
    """``add_along`` with the derivative of b, for a coordinate of the rotations of two nodes, local unknowns R0, R1."""
    add_along(f, K, C, P, P_c, P_rate, turning_blocks(0, 3, gradient, H, omega_0, omega_1))
    add_blocks(K, 0, 3, P, H)


@kernel
def report(p, laws, coordinate, rate, y, e):
    """Write the force of the law to y[0], potential energy and dissipated power to e."""
    P, _, _ = evaluate_force(laws, p.law, coordinate - p.natural, rate)
    elastic, _, _ = evaluate_force(laws, p.law, coordinate - p.natural, 0.0)
    y[0] = P
    e[1] = potential(laws, p.law, coordinate - p.natural)
    e[2] = (P - elastic) * rate


def law_kind(name, doc, dtype, layout, force, coordinate, memory=()):
    """The Kind of a law along ``coordinate(p, m, q, v, R)`` -> (value, rate), a compiled function.

    Its unit is that of a force when the layout has positions; with ``memory`` the value is followed.
    """

    @kernel
    def observe(p, at, F, y, e):
        c, rate = coordinate(p, at.m, at.q, at.v, at.R)
        report(p, at.laws, c, rate, y, e)

    @kernel
    def event_values(p, at, g):
        put_stop_events(g, p.low, p.high, coordinate(p, at.m, at.q, at.v, at.R)[0] - p.natural)

    @kernel
    def commit(p, at, m_out):
        m_out[0] = coordinate(p, at.m, at.q, at.v, at.R)[0]

    what, unit = ("force", "N") if layout[0][0] == "x" else ("moment", "N m")
    return Kind(
        name=name, section="", doc=doc, dtype=dtype, layout=layout,
        outputs=(Output(f"law_{what}", unit, f"{what} of the law; > 0 drives the coordinate back"),),
        modes=MODES, events=EVENTS, memory=memory,
        force=force, observe=observe, event_values=event_values, commit=commit if memory else None,
    )  # fmt: skip


def axis_law_record(law, natural, context):
    """Values of ``LAW_RECORD``."""
    return {"natural": natural, **law_record(law, context)}
