r"""Loads at a node, as functions of time or signals: forces and moments, dead (fixed direction) or following the node.

With the unit direction d, inertial for dead loads and fixed in the node for followers, a force F(t) gives

.. math::  f_x = -F d \quad\text{(dead)}, \qquad f_x = -F R d \quad\text{(follower)}

and a moment M, in material axes,

.. math::  f_\Theta = -M R^T d \quad\text{(dead)}, \qquad f_\Theta = -M d \quad\text{(follower)}

The tangents of the follower force and of the dead moment are not symmetric: these loads have no potential.
"""

from functools import partial

from mecano.constraints.along_coordinate.demand import law_of, on_demand
from mecano.constraints.triads import unit
from mecano.element_interface import Display, Kind, Output, named, record
from mecano.jit.kernel import kernel
from mecano.maths.vector import add_vec, dot, mat, put, vec
from mecano.schema import DIRECTION, DRIVE, NODE, Field

RECORD = record(direction=3, law="i")
EQUATIONS = __doc__.partition("\n\n")[2]


@kernel
def _dead_force(p, at):
    d = vec(p.direction, 0)
    return d, d


@kernel
def _follower_force(p, at):
    d = mat(at.R[0]) @ vec(p.direction, 0)
    return d, d


@kernel
def _dead_moment(p, at):
    d = vec(p.direction, 0)
    return mat(at.R[0]).T @ d, d


@kernel
def _follower_moment(p, at):
    d = vec(p.direction, 0)
    return d, mat(at.R[0]) @ d


def _functions(directions, demand):
    """Return ``residual`` and ``observe`` of a load of the size ``demand``.

    ``directions(p, at)`` returns its direction in the axes of the velocity on which it acts, and in inertial ones.
    """

    @kernel
    def residual(p, at, f):
        add_vec(f, 0, -demand(p, at), directions(p, at)[0])

    @kernel
    def observe(p, at, F, y, e):
        size, (own, inertial) = demand(p, at), directions(p, at)
        put(y, 0, size * inertial)
        y[3] = size * dot(own, vec(at.v, 0))
        e[3] = y[3]

    return named(residual, observe)


def _load(quantity, unit_of_load, name, layout, directions, follows):
    """Return the Kind of a load, a ``quantity`` at a node, with these ``directions`` (``_functions``)."""
    carries = " and that carries its direction" if follows else ""
    given = "direction at the start, inertial" if follows else "direction, inertial"
    what = "that follows its node" if follows else "with a fixed direction"

    def prepare(d, nodes, context):
        direction = unit(d["direction"])
        return {"law": law_of(d["value"], context), "direction": nodes[0][1].T @ direction if follows else direction}

    kind = Kind(
        name=name, section="loads",
        doc=f"{quantity.capitalize()} at a node, a function of time or a signal, {what}.\n\n{EQUATIONS}",
        display=Display(force=quantity if unit_of_load == "N" else ""), dtype=RECORD, layout=layout,
        fields=(
            Field("node", NODE, "-", f"node that it acts on{carries}"),
            Field("direction", DIRECTION, "-", f"{given}, made a unit vector"),
            Field("value", DRIVE, unit_of_load, f"size of the {quantity}"),
        ),
        outputs=(
            Output(quantity, unit_of_load, f"{quantity} on the node, inertial", (3,)),
            Output("power", "W", "power given to the node"),
        ),
        prepare=prepare,
    )  # fmt: skip
    return on_demand(kind, partial(_functions, directions), "value")


FORCE = _load("force", "N", "force", ("x0",), _dead_force, follows=False)
FOLLOWER_FORCE = _load("force", "N", "follower_force", ("x0", "R0"), _follower_force, follows=True)
MOMENT = _load("moment", "N m", "moment", ("R0",), _dead_moment, follows=False)
FOLLOWER_MOMENT = _load("moment", "N m", "follower_moment", ("R0",), _follower_moment, follows=True)
