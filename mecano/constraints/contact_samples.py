"""Samples of contacts of two bodies for the generic tests: all shapes, open and closed, with and without friction."""

import numpy as np

AXIS = np.array([0.0, 0.0, 1.0])
PHASES = ("open", "closed")
DRY = {"friction": {"coefficient": (("constant", {"value": 0.4}),), "regularization": 0.5}}
ELASTIC = {"nodes": ["a", "b"], "law": (("power", {"coefficient": 3e2, "exponent": 2.0}),), "damping": 0.1}
ROUGH = {**ELASTIC, **DRY}


def samples(rng):
    """Return (deck values, nodes, phase) of rigid and elastic contacts, those of balls first."""
    x = rng.normal(size=3)
    nodes = [(x - [0.0, 0.1, 0.0], np.eye(3)), (x + [0.3, 0.4, 0.6], np.eye(3))]
    found = [*_balls(x), *_rods(x), *_balls_on_revolutions(x), *_ellipsoids(x), *_balls_on_cams(x), *_faces(x)]
    return [(values, nodes, phase) for values, phase in found]


def _balls(x):
    plane, _, cylinder, _ = surfaces = (
        {"plane": {"normal": AXIS, "point": x}, "radius": 0.9}, {"sphere": {"radius": 0.5, "center": x}, "radius": 0.5},
        {"cylinder": {"axis": AXIS, "radius": 0.55, "inside": True, "center": x}, "radius": 0.25},
        {"capsule": {"axis": AXIS, "length": 0.4, "radius": 0.4, "center": x}, "radius": 0.4},
    )  # fmt: skip
    small = {"nodes": ["a", "b"], "radius": 0.04}
    return [
        *(({**surface, **ROUGH}, "closed") for surface in surfaces),
        *(({**surface, **small}, phase) for surface in surfaces for phase in PHASES),
        *(({**cylinder, **small, **DRY}, phase) for phase in PHASES),
        ({**cylinder, **ELASTIC}, "closed"),
        ({**plane, **ROUGH}, "open"),
    ]


def _rods(x):
    line = {"axis": AXIS, "radius": 0.4, "center": x}
    capsule, cylinder = {"capsule": {**line, "length": 0.8}}, {"cylinder": {**line, "inside": False}}
    thick = {"rod": {"axis": np.array([1.0, -2.0, 0.5]), "length": 0.9, "center": None}, "radius": 0.15}
    thin = {**thick, "nodes": ["a", "b"], "radius": 0.02}
    return [
        *(({**surface, **thick, **ELASTIC}, "closed") for surface in (capsule, cylinder)),
        *(({**capsule, **thick, **ROUGH}, phase) for phase in PHASES),
        *(({**surface, **thin}, phase) for surface in (capsule, cylinder) for phase in PHASES),
        ({**capsule, **thin, **DRY}, "closed"),
    ]


def _balls_on_revolutions(x):
    barrel = {"axis": AXIS, "center": x, "inside": False, "profile": _barrel(0.44)}
    surfaces = [{"revolution": one} for one in (barrel, {**barrel, "inside": True, "profile": _barrel(0.5)})]
    small = {"nodes": ["a", "b"], "radius": 0.01}
    return [
        *(({**surface, **of, "radius": 0.15}, "closed") for surface in surfaces for of in (ROUGH, ELASTIC)),
        *(({**surface, **small}, phase) for surface in surfaces for phase in PHASES),
        *(({**surface, **small, **DRY}, "closed") for surface in surfaces),
    ]


def _balls_on_cams(x):
    cam = {"axis": AXIS, "zero": np.array([0.6, -0.8, 0.0]), "center": x}
    surfaces = [{"cam": {**cam, "profile": _lobes(number)}} for number in (2, 3, 5)]
    small = {"nodes": ["a", "b"], "radius": 0.01}
    return [
        *(({**surfaces[1], **of, "radius": 0.15}, "closed") for of in (ROUGH, ELASTIC)),
        *(({**surfaces[1], **small}, phase) for phase in PHASES),
        *(({**surface, **small, **DRY}, phase) for surface in surfaces for phase in PHASES),
    ]


def _faces(x):
    cam = {"axis": AXIS, "zero": np.array([0.6, -0.8, 0.0]), "center": x, "profile": _lobes(3, 0.04)}
    face = {"normal": -np.array([0.6, 0.8, 0.2]), "center": None}
    deep, apart, farther = ({**face, "center": x + [0.3 * away, 0.4 * away, 0.6]} for away in (0.4, 0.8, 0.9))
    surface = {"cam": cam, "radius": 0.0, "nodes": ["a", "b"]}
    return [
        *(({**surface, "face": deep, **of}, "closed") for of in (ROUGH, ELASTIC)),
        *(({**surface, "face": apart}, phase) for phase in PHASES),
        *(({**surface, "face": one, **DRY}, "closed") for one in (apart, farther)),
    ]


def _lobes(number, amplitude=0.08):
    """Return the profile of a cam with this number of lobes."""
    return (("sine", {"amplitude": amplitude, "frequency": number / (2.0 * np.pi), "phase": 0.4, "offset": 0.45}),)


def _barrel(radius):
    """Return the profile of a barrel with this radius [m] at its origin."""
    return (("polynomial", {"coefficients": [radius, 0.1, -0.05]}),)


def _ellipsoids(x):
    plane = {"plane": {"normal": AXIS, "point": x}, "radius": 0.0}
    large = {**plane, "ellipsoid": {"semi_axes": np.array([0.5, 0.7, 0.9]), "center": None}}
    small = {**plane, "nodes": ["a", "b"], "ellipsoid": {"semi_axes": np.array([0.3, 0.4, 0.5]), "center": None}}
    return [
        *(({**large, **of}, "closed") for of in (ROUGH, ELASTIC)),
        *((small, phase) for phase in PHASES),
        ({**small, **DRY}, "closed"),
    ]
