r"""Slide law: a force from a law of the sliding of one node along an axis that the other carries.

P > 0 pulls the second node back along the axis; the first node receives the opposite force at the place of the second.
"""

from mecano.compiled.kernel import kernel
from mecano.constraints.axis_law import LAW_RECORD, add_along, axis_law_record, law_kind
from mecano.constraints.slide import add_slide_curvature, slide, slide_gradient, slide_rate_gradient
from mecano.contract import Part, record
from mecano.laws.table import evaluate_force
from mecano.maths.vector import mat, vec
from mecano.schema import LAW, NUMBER, Field

RECORD = record(mu=3, **LAW_RECORD)


@kernel
def force(p, at, f, K, C, M):
    """Opposite forces on both nodes, and the moment on the first."""
    mu, A = vec(p.mu, 0), mat(at.R[0])
    displacement, rate = slide(at.q, at.v, A, mu)
    P, P_s, P_rate = evaluate_force(at.laws, p.law, displacement - p.natural, rate)
    b, r = slide_gradient(at.q, A, mu), slide_rate_gradient(at.q, at.v, A, mu)
    add_along(f, K, C, P, P_s, P_rate, ((0, b[0], r[0]), (3, b[1], r[1]), (6, b[2], r[2])))
    add_slide_curvature(K, P, at.q, A, mu)


@kernel
def _slid(p, m, q, v, R):
    return slide(q, v, mat(R[0]), vec(p.mu, 0))


def slide_law_record(mu, law, natural, context):
    """Record: axis (3,) in the axes of the first node, value of mu . R_0^T (x_1 - x_0) where the extension is zero."""
    return {"mu": mu, **axis_law_record(law, natural, context)}


SLIDING_FIELDS = (
    Field("sliding_law", LAW, "-", "force [N] from displacement [m] and velocity [m/s]; > 0 drives b back", None),
    Field("natural_displacement", NUMBER, "m", "displacement at which the extension of the sliding law is zero", 0.0),
)


def sliding_parts(d, place, context):
    """[Part] of the fields ``SLIDING_FIELDS`` of a joint at ``place`` (pair.py)."""
    if d["sliding_law"] is None:
        return []
    natural = place["start"][2] + d["natural_displacement"]
    return [Part(SLIDE_LAW, (0, 1), slide_law_record(place["mu"][2], d["sliding_law"], natural, context))]


SLIDE_LAW = law_kind("slide_law", __doc__, RECORD, ("x0", "R0", "x1"), force, _slid)
