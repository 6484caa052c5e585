"""Warnings about wheels with a tyre law at the start: gravity, backward or sideward motion, tyres in the ground."""

import numpy as np

from mecano.constraints.carried_surface import contact_at_start
from mecano.constraints.ground import lies_flat
from mecano.constraints.tread import tread_above
from mecano.constraints.triads import unit
from mecano.elements.wheels.crown import crown_of
from mecano.elements.wheels.enveloping import ground_of
from mecano.laws.probe import curve_at

BACKWARD = 1.0  # m/s: slower motions have no direction of their own
SIDEWARD = 5.0  # times the speed ahead or back: an angle of drift of 79 degrees
DEEP = 0.2  # of the radius; tyres stand at 0.05 to 0.12
LOADED = 0.005  # of the radius: a tyre that touches down is deformed less at the start
PRESSING = 0.5  # of gravity, along the normal of the ground: less on slopes of more than 60 degrees


def start_warnings(d, nodes):
    """Return warnings about the motion and the deformation of a wheel at the start, from its deck values and node."""
    (node,) = nodes
    axis, ground = node.R @ node.orientation.T @ unit(d["axis"]), d["ground"]
    normal = unit(ground["plane"]["normal"])
    if lies_flat(normal, axis):
        return []
    above = tread_above(ground_of(d), d["tire_law"]["radius"], crown_of(d), node.x, axis)
    moving = []
    if not ground.get("motion"):
        moving = _astray(d, normal, axis, node.v) or _spinning(d, normal, axis, node, above[0])
    return [*_falls_off(node.gravity, normal), *moving, *_deep(d, *above)]


def start_warnings_on_body(d, nodes):
    """Return the same warnings about a wheel on the surface of a body, from its deck values and both nodes.

    The body counts as moving without turning: a wheel at rest on a drum that turns is not warned of.
    """
    body, hub = nodes
    axis, places = hub.R @ hub.orientation.T @ unit(d["axis"]), [(node.x, node.R) for node in nodes]
    g = contact_at_start(d, places, axis)
    above = g.r - d["tire_law"]["radius"]
    return [*_astray(d, np.array(g.n), axis, hub.v - body.v), *_deep(d, above, above * g.q)]


def _falls_off(gravity, normal):
    """Yield a warning about gravity that points away from the ground, or along it."""
    ground = f"its ground, whose normal {_vector(normal)} points to the side of the wheel; is"
    if gravity @ normal > 0.0:
        yield f"'gravity' {_vector(gravity)} pulls it off {ground} a sign wrong?"
    elif -gravity @ normal < PRESSING * np.linalg.norm(gravity):
        yield f"'gravity' {_vector(gravity)} hardly presses it onto {ground} another axis meant?"


def _spinning(d, normal, axis, node, gap):
    """Return warnings about a wheel that rolls forward, and spins backward, or does not spin under its load.

    Wheels that do not spin without load are those of an aircraft that lands. ``gap`` [m] is that below the rim.
    """
    along, spin = node.v @ unit(np.cross(axis, normal)), node.w @ axis
    rolling = along / d["tire_law"]["radius"]
    if along < BACKWARD or not spin <= 0.5 * rolling:  # nan if the spin is not known yet
        return []
    if spin > -0.5 * rolling:
        text = (
            f"it starts at {along:.4g} m/s on its tyre deformed by {-1e3 * gap:.4g} mm, and spins at {spin:.3g} rad/s: "
            f"it slides until it is spun up to {rolling:.4g} rad/s; give its node this 'angular_velocity', or write "
            "'initial: {steady: ...}'"
        )
        return [text] if LOADED < -gap / d["tire_law"]["radius"] <= DEEP else []
    return [
        f"it starts forward, at {along:.4g} m/s, but spins backward, at {-spin:.4g} rad/s about {_vector(-axis)}: "
        f"it rolls at {rolling:.4g} rad/s about {_vector(axis)}; is a sign wrong?"
    ]


def _astray(d, normal, axis, velocity):
    """Return warnings about a wheel that moves mainly against or across its driving direction t = a x n/|a x n|."""
    ahead = unit(np.cross(axis, normal))
    along, across = velocity @ ahead, velocity @ np.cross(normal, ahead)
    if abs(across) > max(BACKWARD, SIDEWARD * abs(along)):
        return [
            f"it starts sideways, at {abs(across):.4g} m/s across its forward direction {_vector(ahead)}, which is "
            "'axis' x normal of the ground: it slides"
        ]
    if along > -max(BACKWARD, abs(across)):
        return []
    turned = "[" + ", ".join(f"{-component + 0.0:g}" for component in d["axis"]) + "]"
    return [
        f"it starts backward, at {-along:.4g} m/s against its forward direction {_vector(ahead)}, which is 'axis' x "
        "normal of the ground: slip, spin rate and drag have the signs of a wheel in reverse"
        f"{_one_way(d['tire_law'])}; with 'axis: {turned}' it rolls forward"
    ]


def _one_way(law):
    """Return a clause on the error in reverse of a tyre law that holds for rolling forward only; "" for others."""
    if any((law.get("lateral") or {}).get(form) for form in ("string", "matrices")):
        return ", and the lateral force grows until the patch slides, as 'tire_law.lateral' holds for rolling forward"
    return ""


def _deep(d, gap, along_normal):
    """Yield a warning about a tyre that is deformed much more than a standing one."""
    law = d["tire_law"]
    if -gap <= DEEP * law["radius"]:
        return
    yield (
        f"its tyre starts {-1e3 * gap:.4g} mm deep in the ground, {-gap / law['radius']:.2g} of its radius, which "
        f"pushes with {curve_at(law['radial'], -gap)[0]:.4g} N; it just touches with its node "
        f"{-1e3 * along_normal:.4g} mm higher along the normal of the ground"
    )


def _vector(v):
    return "[" + ", ".join(f"{component + 0.0:.3g}" for component in np.round(v, 6)) + "]"
