"""Outlines of a contact as lines in space: the ball or other shape, and the surface on which it may lie."""

from typing import TYPE_CHECKING

import numpy as np

from mecano.constraints.touching import named_surface
from mecano.constraints.triads import triad, unit
from mecano.deck.physics import rotations
from mecano.post.curve_values import checked_law, curve_values

if TYPE_CHECKING:
    from mecano.post.shapes import AnyMotion
    from mecano.schema import Values

POINTS = 49  # of a circle
BEYOND, LARGE = 2.0, 0.08  # radii of the ball, sizes of the mechanism: how far a plane is drawn beyond the contact
NEAR = 0.1  # sizes of the mechanism: where node b is closer to the plane than this, the plane is drawn below it
SECTIONS = "elements", "joints"  # with contacts
SAME = 1e-9  # of normals, and m: planes that differ by less are one
FLAT = 1e-3  # of the size: of a mechanism that extends less across the lines, a plane is a line
PREFERRED = np.array([1e-6, 0.0, 1e-6])  # of axes along which a mechanism has no extent: pictures are viewed along y


def outlines(motion: "AnyMotion", d: "Values") -> list[np.ndarray]:
    """Return lines [(instants, n, 3)] of the contact with the deck values ``d`` in a Motion (shapes.py).

    The lines at an instant do not depend on the other instants.
    """
    if d["nodes"][1] not in motion.nodes:
        return []
    places = motion.run.places
    _, (_, across, along) = _directions(motion, d)
    if d.get("ellipsoid"):
        return [*surface_outlines(motion, d, max(d["ellipsoid"]["semi_axes"])), *_ellipsoid(motion, d, places)]
    if d.get("face"):
        return [*surface_outlines(motion, d, 0.0), _face(motion, d, places)]
    ball = _on_b(motion, d, places, np.cross(along, across), along)
    return [*surface_outlines(motion, d, d["radius"]), ball]


def surface_outlines(motion: "AnyMotion", d: "Values", radius: float) -> list[np.ndarray]:
    """Return lines [(instants, n, 3)] of the surface in the deck values ``d``; ``radius`` [m]: of b."""
    (a, b), (name, surface), places = d["nodes"], named_surface(d), motion.run.places
    middle, (main, across, along) = _directions(motion, d)
    if name == "revolution":
        lines = _turned(motion.run.deck, surface, places[b] - middle, np.stack([main, along, across]))
    elif name == "cam":
        lines = [_cam(motion.run.deck, surface)]
    elif name == "plane":
        alike = motion.run.contacts_in_planes.get(id(d), [d])
        if alike[0] is not d:
            return []  # the first of these contacts draws the plane of all
        nodes = dict.fromkeys(other["nodes"][1] for other in alike)
        paths = [_path(motion, a, node, places) - middle for node in nodes]
        lines = [_plane(paths, np.stack([main, across, along]), radius, np.stack(list(places.values())))]
    else:
        lines = [_stadium(surface["radius"], surface.get("length", 0.0), np.cross(along, across), along)]
    return [_carried(motion, a, middle + line) for line in lines]


def _path(motion, a, b, places):
    """Return the positions (n, 3) of node b at all times, as seen from a node a that is not the ground."""
    if b not in motion.nodes:
        return places[b][None]
    return motion.path(b) if a not in motion.nodes else motion.path_from(a, b) + places[a]


def contacts_in_planes(deck: "Values") -> dict[int, list["Values"]]:
    """Return the deck values of all contacts with the same plane on the same node a, by the ``id`` of each of them."""
    groups: dict[str, list[tuple[np.ndarray, list[Values]]]] = {}
    for d in (d for section in SECTIONS for d in deck.get(section, {}).values() if d.get("plane")):
        a, point = d["nodes"][0], d["plane"].get("point")
        normal = unit(d["plane"]["normal"])
        plane = np.append(normal, normal @ np.array(deck["nodes"][a]["position"] if point is None else point, float))
        alike = groups.setdefault(a, [])
        contacts = next((contacts for other, contacts in alike if np.abs(other - plane).max() <= SAME), None)
        if contacts is None:
            alike.append((plane, [d]))
        else:
            contacts.append(d)
    return {id(d): contacts for alike in groups.values() for _, contacts in alike for d in contacts}


def _plane(paths, axes, radius, places):
    """Return the part of a plane near the ``paths`` [(n, 3)] of nodes b, as a line or the outline of a rectangle.

    ``paths`` are relative to a point of the plane, ``axes`` are its normal and the directions across and along.
    """
    whole = np.concatenate(paths)
    reach = [np.abs(path @ axes[0]).min() for path in paths]
    size = float(np.linalg.norm(np.ptp(np.concatenate([whole, places - places[0] + whole[0]]), axis=0)))
    size = size or 2.0 * max(reach)
    room = max(BEYOND * radius, LARGE * size) or 1.0
    near = [path[np.abs(path @ axes[0]) <= least + NEAR * size] for path, least in zip(paths, reach, strict=True)]
    inside = np.concatenate(near) @ axes[1:].T
    (c, e), (d, f) = inside.min(axis=0) - room, inside.max(axis=0) + room
    if np.ptp(places @ axes[1]) <= FLAT * size and np.ptp(whole @ axes[1]) <= FLAT * size:
        middle = 0.5 * (c + d) * axes[1]
        return middle + np.outer([e, f], axes[2])
    return np.array([(c, e), (d, e), (d, f), (c, f), (c, e)]) @ axes[1:]


def _directions(motion, d):
    """Return the middle of the surface, and its normal or axis with the directions across and along the lines."""
    (a, b), (name, surface), places = d["nodes"], named_surface(d), motion.run.places
    middle = surface.get("point", surface.get("center"))
    middle = places[a] if middle is None else np.array(middle, float)
    main = unit(surface.get("normal", surface.get("axis", places[b] - middle)))
    extent = motion.run.extent
    round_it = name in ("cylinder", "cam")  # seen along its axis
    across = main if round_it else _across(main, extent)
    return middle, (main, across, np.cross(across, _across(main, extent) if round_it else main))


def _turned(deck, surface, b, axes):
    """Return the meridian, on both sides, and the circles at the ends of a surface of revolution around node b.

    ``b`` (3,) and the lines (n, 3) are relative to its 'center'; ``axes`` are its axis and two directions across.
    """
    from mecano.laws.probe import shape_of_curve

    profile, along = surface["profile"], float(axes[0] @ b)
    beside = abs(curve_values(deck, profile, [along])[0])
    bounded = shape_of_curve(checked_law(deck, profile), along - beside, along + beside)[0]
    ends = np.append(bounded, [along - beside, along + beside])
    z = np.linspace(ends.min(), ends.max(), POINTS)
    radius = curve_values(deck, profile, z)
    z, radius = z[radius > 0.0], radius[radius > 0.0]
    sides = [z[:, None] * axes[0] + side * radius[:, None] * axes[1] for side in (1.0, -1.0)]
    circles = [z[i] * axes[0] + _stadium(radius[i], 0.0, axes[1], axes[2]) for i in (0, -1)]
    return [*sides, *circles]


def _cam(deck, surface):
    """Return the closed curve (n, 3) of a cam, relative to its 'center'."""
    zero, other, _ = triad(surface["axis"], surface["zero"])
    angle = np.linspace(0.0, 2.0 * np.pi, 2 * POINTS)
    radius = curve_values(deck, surface["profile"], angle)
    return (radius * np.cos(angle))[:, None] * zero + (radius * np.sin(angle))[:, None] * other


def _on_b(motion, d, places, across, along):
    """Return the lines of the ball around node b, or of the rod that it carries."""
    b, rod = d["nodes"][1], d.get("rod")
    if rod is None:
        return motion.position(b)[:, None] + _stadium(d["radius"], 0.0, across, along)
    _, side, axis = triad(rod["axis"])
    outline = _stadium(d["radius"], rod["length"], axis, side)
    return _carried(motion, b, _middle(rod, places[b]) + outline)


def _face(motion, d, places):
    """Return the line of the face on node b, across the axis of the cam, as wide as the cam."""
    face, cam = d["face"], _cam(motion.run.deck, d["cam"])
    along = np.cross(d["cam"]["axis"], face["normal"])
    line = np.outer([-1.0, 1.0], along / np.linalg.norm(along)) * np.linalg.norm(cam, axis=1).max()
    return _carried(motion, d["nodes"][1], _middle(face, places[d["nodes"][1]]) + line)


def _ellipsoid(motion, d, places):
    """Return the lines of the three sections of the ellipsoid on node b that contain two of its axes."""
    b, ellipsoid = d["nodes"][1], d["ellipsoid"]
    (R,) = rotations(np.array([motion.run.deck["nodes"][b]["orientation"]], float))
    axes = np.diag(ellipsoid["semi_axes"]) @ R.T
    angle = np.linspace(0.0, 2.0 * np.pi, POINTS)[:, None]
    sections = [np.cos(angle) * axes[i] + np.sin(angle) * axes[i - 1] for i in range(3)]
    return [_carried(motion, b, _middle(ellipsoid, places[b]) + section) for section in sections]


def _middle(shape, otherwise):
    """Return the 'center' (3,) of a shape at the start; ``otherwise`` (3,) if the deck has none."""
    return otherwise if shape.get("center") is None else np.array(shape["center"], float)


def _across(main, extent):
    """Return the unit vector, normal to ``main``, along which the ``extent`` (3,) of the mechanism is least."""
    free = np.abs(main) < 0.9
    axis = np.eye(3)[np.flatnonzero(free)[np.argmin((extent + PREFERRED * (1.0 + extent.max()))[free])]]
    return triad(main, axis)[0]


def _stadium(radius, length, axis, side):
    """Return the outline (n, 3) of two half circles that are ``length`` apart along an axis; a circle if it is zero."""
    angle = np.linspace(0.0, 2.0 * np.pi, POINTS)[:, None]
    shift = np.where(np.cos(angle) > 0.0, length, 0.0)
    return (shift + radius * np.cos(angle)) * axis + radius * np.sin(angle) * side


def _carried(motion, node, points):
    """Return points (n, 3) of the start, fixed in a node or the ground, at all instants."""
    if node not in motion.nodes:
        return np.broadcast_to(points, (len(motion.position(motion.nodes[0])), *points.shape))
    start = np.array(motion.run.deck["nodes"][node]["position"], float)
    return motion.position(node)[:, None] + np.stack([motion.turned(node, p - start) for p in points], axis=1)
