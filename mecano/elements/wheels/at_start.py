"""Warnings about wheels with a tyre law at the start: backward rolling, and tyres that start deep in the ground."""

import numpy as np

from mecano.constraints.ground import rim_above, unit
from mecano.laws.probe import curve_at

BACKWARD = 1.0  # m/s: slower motions have no direction of their own
DEEP = 0.2  # of the radius; tyres stand at 0.05 to 0.12


def odd_start(d, nodes):
    """Return warnings about the motion and the deformation of a wheel at the start, from its deck values and node."""
    (node,) = nodes
    axis = node.R @ node.orientation.T @ unit(d["axis"])
    return [*_backward(d, node, axis), *_deep(d, node, axis)]


def _backward(d, node, axis):
    """Yield a warning about a wheel that moves mainly against its driving direction t = a x n/|a x n|."""
    normal, motion = unit(d["ground"]["plane"]["normal"]), d["ground"].get("motion")
    ahead = unit(np.cross(axis, normal))
    along, across = node.v @ ahead, node.v @ np.cross(normal, ahead)
    if motion or along > -max(BACKWARD, abs(across)):
        return
    turned = "[" + ", ".join(f"{-component + 0.0:g}" for component in d["axis"]) + "]"
    yield (
        f"it starts backward, at {-along:.4g} m/s against its forward direction {_vector(ahead)}, which is 'axis' x "
        f"normal of the ground: slip, spin rate and drag have the signs of a wheel in reverse; with 'axis: {turned}' "
        "it rolls forward"
    )


def _deep(d, node, axis):
    """Yield a warning about a tyre that is deformed much more than a standing one."""
    law = d["tire_law"]
    gap, along_normal = rim_above(d["ground"], law["radius"], node.x, axis)
    if -gap <= DEEP * law["radius"]:
        return
    yield (
        f"its tyre starts {-1e3 * gap:.4g} mm deep in the ground, {-gap / law['radius']:.2g} of its radius, which "
        f"pushes with {curve_at(law['radial'], -gap)[0]:.4g} N; it just touches with its node "
        f"{-1e3 * along_normal:.4g} mm higher along the normal of the ground"
    )


def _vector(v):
    return "[" + ", ".join(f"{component + 0.0:.3g}" for component in np.round(v, 6)) + "]"
