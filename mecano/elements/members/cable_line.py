r"""Division of a cable into elements: straight, or along the chain in which it hangs.

A chain of n equal straight elements, just taut and of the length L in all, hangs in the plane of its ends and of a
direction downwards. The horizontal force is the same in all elements, and the vertical one grows by the weight of an
element from one to the next. With H and V, the components of the force in the first element over that weight, and the
distances h and v of the ends across and against the direction, H and V minimize the convex function

.. math::  \varphi(H, V) = \frac1n \sum_i \sqrt{H^2 + (V + i)^2} - \frac{H h + V v}{L}, \qquad i = 0 \dots n - 1.
"""

import numpy as np

from mecano.constraints.along_coordinate.demand import is_formula
from mecano.constraints.joint_nodes import distance
from mecano.laws.law_table import terms_of
from mecano.schema import DIRECTION, INTEGER, Field, requirement

MOST_ELEMENTS = 10_000
TAUT = 1.0 + 1e-6  # length of an element over its natural length: at 1 it would become taut or slack at once
LONGER = 1.0 + 1e-6  # least natural length over the distance of the ends
FOLDED = 1e-2  # of the length: distance of the ends across 'sag' below which the elements hang in a fold
ITERATIONS, SOLVED = 50, 1e-13  # of the length
LEAST = 1e-6  # of the weight: horizontal force below which an element is slack
ENOUGH, ROUNDING = 1e-4, 1e-15  # share of the expected decrease that a step must reach, within rounding
WHOLE = {"release": None, "activate": None, "payout_tension": None, "at_full_length": "stretch"}
DIVISION = (
    Field("mesh", INTEGER, "-", "number of elements", 1,
          requirement(lambda n: 1 <= n <= MOST_ELEMENTS, f"must be 1 to {MOST_ELEMENTS}")),
    Field("sag", DIRECTION, "-",
          "direction in which a cable with a mesh, longer than the distance of its nodes, hangs at the start; straight "
          "when absent", None),
)  # fmt: skip


def check_division(d, nodes):
    """Return errors of a cable with several elements, which must be alike in the whole run, or with a sag."""
    if d["mesh"] == 1:
        return []
    texts = [f"a cable with a 'mesh' has no {name!r}: give it to a cable of one element, in line with this one"
             for name, absent in WHOLE.items() if d[name] != absent]  # fmt: skip
    natural = d["natural_length"]
    if natural is not None and (is_formula(natural) or {name for name, _ in terms_of(natural)} != {"constant"}):
        texts.append("the 'natural_length' of a cable with a 'mesh' is a number: wind up a cable of one element")
    elif d["sag"] is not None:
        texts += _check_sag(d, nodes)
    return texts


def _check_sag(d, nodes):
    length, apart = _length(d), distance(nodes)
    if length is None or length <= LONGER * apart:
        return [f"a cable with 'sag' needs a 'natural_length' greater than {apart:.6g} m, the distance of its nodes"]
    if _directions(d, nodes)[3] < FOLDED * length:
        return ["'sag' must not point along the line of its nodes, along which the cable would hang in a fold"]
    if _chain(d, nodes) is None:
        return [f"{d['mesh']} elements cannot hang between its nodes, all of them taut: give it a finer 'mesh'"]
    return []


def divide(d, nodes):
    """Return the nodes (x, R) between the elements, turned as the first one, and the values of each element."""
    n, length, (start, R) = d["mesh"], _length(d), nodes[0]
    steps = np.full((n, 3), np.subtract(nodes[1][0], start) / n) if d["sag"] is None else _chain(d, nodes)
    inner = np.asarray(start) + np.cumsum(steps, axis=0)[:-1]
    values = {**d, "mesh": 1, "sag": None, "natural_length": None if length is None else length / n}
    return [(x, R) for x in inner], [values] * n


def without_effect_of_division(d):
    """Return the values that have no effect on a cable of one element."""
    if d["mesh"] == 1 and d["sag"] is not None:
        yield "sag", "an element is straight: give the cable a 'mesh'"


def _length(d):
    """Return the natural length [m], or None."""
    terms = terms_of(d["natural_length"])
    return sum(values["value"] for _, values in terms) if terms else None


def _directions(d, nodes):
    """Return the unit vectors upwards and across, in the plane of the ends, and the distances v, h [m] along them."""
    up = -np.asarray(d["sag"]) / np.linalg.norm(d["sag"])
    line = np.subtract(nodes[1][0], nodes[0][0])
    v = float(line @ up)
    across = line - v * up
    h = float(np.linalg.norm(across))
    return up, across / (h or 1.0), v, h


def _chain(d, nodes):
    """Return the elements (n, 3) [m] of the chain, or None if not all would be taut.

    H and V are found by Newton's method from those of the catenary, with steps that are shortened until phi decreases.
    """
    n, L = d["mesh"], TAUT * _length(d)
    up, across, v, h = _directions(d, nodes)
    i, ends = np.arange(n), np.array([h, v]) / L
    half = _half_width(np.sqrt(L * L - v * v) / h)
    first, last = np.sinh(np.arctanh(v / L) + np.array([-half, half]))
    force = n / (last - first) * np.array([1.0, first]) + [0.0, 0.5]
    for _ in range(ITERATIONS):
        if force[0] <= LEAST * n:
            break
        phi, c, s, r = _forces(force, i, ends)
        slope = np.array([c.mean(), s.mean()]) - ends
        if np.abs(slope).max() <= SOLVED:
            return (np.outer(c, across) + np.outer(s, up)) * L / n
        xx, xy, yy = np.mean(s * s / r), -np.mean(s * c / r), np.mean(c * c / r)
        step = -np.linalg.solve([[xx, xy], [xy, yy]], slope)
        gain, rounding = ENOUGH * (slope @ step), ROUNDING * r.mean()
        while force[0] + step[0] <= 0.0 or _forces(force + step, i, ends)[0] > phi + gain + rounding:
            step, gain = 0.5 * step, 0.5 * gain
        force = force + step
    return None


def _forces(force, i, ends):
    """Return phi for H, V, and the cosines, sines (n,) and sizes (n,) of the forces in the elements."""
    H, V = force[0], force[1] + i
    r = np.hypot(H, V)
    return r.mean() - force @ ends, H / r, V / r, r


def _half_width(ratio):
    """Return u > 0 with sinh(u)/u = ``ratio`` > 1, by Newton's method from above, where the function is convex."""
    u = np.arcsinh(ratio) + np.sqrt(6.0 * (ratio - 1.0))
    for _ in range(ITERATIONS):
        u -= (np.sinh(u) - ratio * u) / (np.cosh(u) - ratio)
    return u
