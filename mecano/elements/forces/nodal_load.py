r"""Loads at a node, as functions of time: forces and moments, dead (fixed direction) or following the node.

With the unit direction d, inertial for dead loads and fixed in the node for followers, a force F(t) gives

.. math::  f_x = -F d \quad\text{(dead)}, \qquad f_x = -F R d \quad\text{(follower)}

and a moment M(t), in material axes,

.. math::  f_\Theta = -M R^T d \quad\text{(dead)}, \qquad f_\Theta = -M d \quad\text{(follower)}

The tangents of the follower force and of the dead moment are not symmetric: these loads have no potential.
"""

from dataclasses import dataclass

import numpy as np

from mecano.compiled.kernel import kernel
from mecano.contract import Kind, Output, record
from mecano.laws.table import evaluate_curve
from mecano.maths.vector import add_vec, dot, mat, put, vec
from mecano.schema import CURVE, DIRECTION, NODE, Field

RECORD = record(law="i", direction=3)
EQUATIONS = __doc__.partition("\n\n")[2]


@kernel
def _load(p, laws, t):
    """Return magnitude and unit direction."""
    return evaluate_curve(laws, p.law, t)[0], vec(p.direction, 0)


@kernel
def _report(size, inertial, direction, v, y, e):
    """Write load, inertial, and its power; ``direction`` is in the axes of the velocity v."""
    put(y, 0, size * inertial)
    y[3] = size * dot(direction, vec(v, 0))
    e[3] = y[3]


@kernel
def force(p, at, f):
    """Add the dead force."""
    size, d = _load(p, at.laws, at.t)
    add_vec(f, 0, -size, d)


@kernel
def observe_force(p, at, F, y, e):
    """Write force and power."""
    size, d = _load(p, at.laws, at.t)
    _report(size, d, d, at.v, y, e)


@kernel
def follower_force(p, at, f):
    """Add the follower force."""
    size, d = _load(p, at.laws, at.t)
    add_vec(f, 0, -size, mat(at.R[0]) @ d)


@kernel
def observe_follower_force(p, at, F, y, e):
    """Write force and power."""
    size, d = _load(p, at.laws, at.t)
    inertial = mat(at.R[0]) @ d
    _report(size, inertial, inertial, at.v, y, e)


@kernel
def moment(p, at, f):
    """Add the dead moment."""
    size, d = _load(p, at.laws, at.t)
    add_vec(f, 0, -size, mat(at.R[0]).T @ d)


@kernel
def observe_moment(p, at, F, y, e):
    """Write moment and power."""
    size, d = _load(p, at.laws, at.t)
    _report(size, d, mat(at.R[0]).T @ d, at.v, y, e)


@kernel
def follower_moment(p, at, f):
    """Add the follower moment."""
    size, d = _load(p, at.laws, at.t)
    add_vec(f, 0, -size, d)


@kernel
def observe_follower_moment(p, at, F, y, e):
    """Write moment and power."""
    size, d = _load(p, at.laws, at.t)
    _report(size, mat(at.R[0]) @ d, d, at.v, y, e)


def prepare(d, nodes, context):
    """Return the record of a dead load."""
    direction = np.asarray(d["direction"], float)
    return {"law": context.laws.add(d["value"]), "direction": direction / np.linalg.norm(direction)}


def prepare_follower(d, nodes, context):
    """Return the record of a follower: the direction in the axes of the node."""
    values = prepare(d, nodes, context)
    return {**values, "direction": nodes[0][1].T @ values["direction"]}


def sample(rng):
    """Return a growing sine and a smooth step, in random directions."""
    sine = (
        ("sine", {"amplitude": 2.0, "frequency": 0.3, "phase": 0.4, "offset": 0.0}),
        ("linear", {"slope": 0.5, "offset": rng.uniform(3, 4)}),
    )
    step = (
        ("step", {"time": -5.0, "rise": 10.0, "from": 1.0, "to": 3.0}),
        ("constant", {"value": rng.uniform(1, 2)}),
    )
    return [({"direction": rng.normal(size=3), "value": value}, 1, "") for value in (sine, step)]


@dataclass(frozen=True)
class _Quantity:
    """A quantity, force or moment, that a load applies."""

    name: str
    unit: str

    def kind(self, name, layout, follows, residual, observe):
        """Return a kind of load of this quantity."""
        carries = " and that carries its direction" if follows else ""
        given = "direction at the start, inertial" if follows else "direction, inertial"
        what = "that follows its node" if follows else "with a fixed direction"
        return Kind(
            name=name,
            section="loads",
            doc=f"{self.name.capitalize()} at a node, a function of time, {what}.\n\n{EQUATIONS}",
            dtype=RECORD,
            layout=layout,
            fields=(
                Field("node", NODE, "-", f"node that it acts on{carries}"),
                Field("direction", DIRECTION, "-", f"{given}, made a unit vector"),
                Field("value", CURVE, self.unit, f"{self.name} as a function of time [s]"),
            ),
            outputs=(
                Output(self.name, self.unit, f"{self.name} on the node, inertial", (3,)),
                Output("power", "W", "power given to the node"),
            ),
            prepare=prepare_follower if follows else prepare,
            residual=residual,
            observe=observe,
            sample=sample,
        )


_FORCE, _MOMENT = _Quantity("force", "N"), _Quantity("moment", "N m")
FORCE = _FORCE.kind("force", ("x0",), False, force, observe_force)
FOLLOWER_FORCE = _FORCE.kind("follower_force", ("x0", "R0"), True, follower_force, observe_follower_force)
MOMENT = _MOMENT.kind("moment", ("R0",), False, moment, observe_moment)
FOLLOWER_MOMENT = _MOMENT.kind("follower_moment", ("R0",), True, follower_moment, observe_follower_moment)
