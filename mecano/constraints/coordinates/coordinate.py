"""A coordinate c of some nodes: its value, gradient, curvature and rates, as compiled functions.

All functions take the record p of an element, which has the ``axes`` of the coordinate, and its ``Place``. The uses of
a coordinate (held, driven, locked, stopped, loaded by a law, subject to friction) are implemented once for all
coordinates, in along_coordinate/.
"""

from collections.abc import Callable

from mecano.immutable import immutable
from mecano.jit.kernel import kernel
from mecano.maths.dual import constant, number
from mecano.maths.vector import add_vec, dot, vec


@immutable
class Coordinate:
    """A scalar function of the positions and rotations of nodes."""

    layout: tuple  # slots of its nodes, like those of a Kind
    unit: str  # m or rad
    axes: dict  # fields of the record that it uses: {name: shape}
    value: Callable  # (p, at) -> c
    gradient: Callable
    """(p, at) -> ((local index, b (3,)), ...): derivatives of c by position and material rotation of its slots"""
    add_curvature: Callable | None = None
    """(p, at, g, K): add g times the derivative of the gradient to K; None if nothing holds the coordinate"""
    periodic: bool = False  # an angle, in (-pi, pi]
    inputs: int = 0  # number of inputs of the elements that hold it

    @property
    def sliding(self):
        """True for a length, False for an angle or the sine of one."""
        return self.unit == "m"

    @property
    def load(self):
        """("force", "N") or ("moment", "N m"): name and unit of the load along the coordinate."""
        return ("force", "N") if self.sliding else ("moment", "N m")

    @property
    def row(self):
        """Local index of the multiplier of an element that holds the coordinate, after its inputs."""
        return 3 * len(self.layout) + self.inputs


@kernel
def rate_of(gradient, v):
    """Return the rate of a coordinate from its gradient and the velocities (n_local,)."""
    rate = constant(0.0, number(v[0]))
    for i, b in gradient:
        rate = rate + dot(b, vec(v, i))
    return rate


@kernel
def add_along(f, P, gradient):
    """Add the force P [N, N m] along a coordinate to the residual."""
    for i, b in gradient:
        add_vec(f, i, P, b)
