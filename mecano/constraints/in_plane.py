r"""In plane: :math:`\mu \cdot (x_1 - x_0) - f(t) = 0` for mu carried by the first node.

The multiplier is the force on the second node along mu; f(t) is a constant offset plus, where given, a law of time.
"""

from mecano.compiled.kernel import kernel
from mecano.constraints.augmented import add_constraint, put_levels
from mecano.constraints.slide import add_slide_curvature, slide_gradient, slide_rates
from mecano.constraints.target import TARGET, target
from mecano.contract import Kind, Row, record
from mecano.maths.vector import dot, mat, vec

RECORD = record(mu=3, **TARGET)
MULTIPLIER = 9


@kernel
def hold_slide(sign, mu, wanted, k, penalty, q, R, f, K):
    """Add the constraint sign (mu . d - wanted) = 0, d from the first node to the second in axes of the first."""
    A = mat(R[0])
    b_0, b_R, b_1 = slide_gradient(q, A, mu)
    Phi = sign * (dot(mu, A.T @ (vec(q, 6) - vec(q, 0))) - wanted)
    blocks = ((0, sign * b_0), (3, sign * b_R), (6, sign * b_1))
    g = add_constraint(f, K, MULTIPLIER, k, penalty, Phi, q[MULTIPLIER], blocks)
    add_slide_curvature(K, sign * g, q, A, mu)


@kernel
def slide_levels(sign, mu, wanted, q, v, a, R, g):
    """Write the levels of that constraint; ``wanted`` with its two rates."""
    Phi, rate, second = slide_rates(q, v, a, mat(R[0]), mu)
    put_levels(g, 0, sign * (Phi - wanted[0]), sign * (rate - wanted[1]), sign * (second - wanted[2]))


@kernel
def force(p, at, f, K, C, M):
    """Forces on both nodes and the moment on the first."""
    hold_slide(1.0, vec(p.mu, 0), target(p, at.laws, at.t)[0], at.k, at.penalty, at.q, at.R, f, K)


@kernel
def levels(p, at, g):
    """Value and rates, those of f(t) included."""
    slide_levels(1.0, vec(p.mu, 0), target(p, at.laws, at.t), at.q, at.v, at.a, at.R, g)


def sample(rng):
    """A plane through a point off the first node."""
    return [({"mu": rng.normal(size=3), "offset": rng.normal(), "law": 0}, 2, "")]


IN_PLANE = Kind(
    name="in_plane",
    section="",
    doc=__doc__,
    dtype=RECORD,
    layout=("x0", "R0", "x1"),
    multipliers=(Row("force that holds the node in a plane", "N", "m"),),
    force=force,
    levels=levels,
    sample=sample,
)
