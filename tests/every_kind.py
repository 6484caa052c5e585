"""A results file with every registered kind, but only one wheel, with smooth artificial values."""

import numpy as np

from mecano.elements import KINDS
from mecano.model.sampler import ENERGIES, NODE_OUTPUTS
from mecano.results.layout import Layout, Series
from mecano.results.provenance import Source
from mecano.results.recorded import Event
from mecano.results.writer import Writer

WAVE = 0.4
DECK = {
    "title": "One of each",
    "gravity": [0.0, 0.0, -9.81],
    "parameters": {"wave": WAVE},
    "nodes": {
        "base": {"position": [0.0, 0.0, 0.0], "fixed": True},
        "tip": {"position": [1.0, 0.0, 0.3], "fixed": False},
    },
    "laws": {"wavy": {"sine": {"amplitude": WAVE, "frequency": 0.5, "phase": 0.0, "offset": 0.0}}},
    "tire_laws": {"tyre": {"radius": 0.3}},
    "grounds": {
        "runway": {
            "plane": {"point": [0.0, 0.0, 0.0], "normal": [0.0, 0.0, 1.0]},
            "profile": {"direction": [1.0, 0.0, 0.0], "height": "wavy"},
        }
    },
}
VALUES = {
    "node": "tip",
    "nodes": ["base", "tip"],
    "attached": [],
    "axis": [0.0, 1.0, 0.0],
    "radius": 0.3,
    "plane": {"normal": [0.0, 0.0, 1.0]},
    "radii": [0.1, 0.0],
    "line": ["base", "tip"],
    "center": [0.0, 0.0, 0.0],
    "semi_axis_1": [0.3, 0.0, 0.0],
    "semi_axis_2": [0.0, 0.3, 0.0],
    "file": {"positions": [[0.0, 0.0, 0.0], [1.0, 0.0, 0.3]]},  # a superelement without nodes inside
    "tire_law": "tyre",
    "ground": "runway",
}
OTHER_WHEELS = (
    "wheel_on_body", "transient_wheel", "flexible_wheel", "adhesive_wheel", "rigid_wheel", "cardona_wheel",
    "mecanum_wheel",
)  # fmt: skip
ONE_WHEEL = {name: kind for name, kind in KINDS.items() if name not in OTHER_WHEELS}
DECK_TEXT = "mecano: 1\n"
TIMES = np.linspace(0.0, 2.0, 41)


def deck(kinds):
    """The resolved deck: of each kind one, named "one_<kind>"."""
    sections = {"elements": {}, "joints": {}, "loads": {}, "signals": {}}
    for kind in kinds.values():
        fields = {field.name for field in kind.fields}
        given = {key: value for key, value in VALUES.items() if key in fields}
        sections[kind.section][f"one_{kind.name}"] = {"type": kind.name, **given}
    return DECK | sections


def layout(kinds=ONE_WHEEL):
    """The outputs as a run declares them."""
    series = [Series(f"nodes/{node}/{n}", u, d, s) for node in DECK["nodes"] for n, u, d, s in NODE_OUTPUTS]
    series += [
        Series(f"{kind.section}/one_{kind.name}/{o.name}", o.unit, o.doc, o.shape)
        for kind in kinds.values()
        for o in kind.outputs
    ]
    return Layout([*series, *(Series(f"energy/{name}", unit, doc) for name, unit, doc in ENERGIES)])


def row(declared, t):
    """The numbers at the time t: sine waves, the nodes apart and turning about y, loaded radii that are not zero."""
    values = np.sin(3.0 * t + 0.1 * np.arange(declared.size)) + 0.2
    for node, x in (("base", (0.0, 0.0, 0.0)), ("tip", (1.0 + 0.5 * t, 0.0, 0.3 + 0.1 * np.sin(3.0 * t)))):
        values[declared.slices[f"nodes/{node}/position"]] = x
        values[declared.slices[f"nodes/{node}/rotation"]] = (np.cos(0.5 * t), 0.0, np.sin(0.5 * t), 0.0)
    for path, place in declared.slices.items():
        if path.endswith("/loaded_radius"):
            values[place] = 0.3 - 0.02 * np.sin(t) ** 2
    return values


def write(path, overrides=(), events=((0.5, "touch_down"), (0.9, "lift_off")), kinds=ONE_WHEEL):
    """Write the file."""
    declared = layout(kinds)
    source = Source(DECK_TEXT, deck(kinds), "each.yaml", "One of each", overrides)
    with Writer.create(path, declared, source) as writer:
        for i, t in enumerate(TIMES):
            values = row(declared, t)
            writer.extremes.take(t, values)
            writer.append(t, values)
            if i:
                writer.append_step(t, np.array([0.05, 1.0 + i % 3, 0.1, 0.5, i % 2, 0.1, 0.2, 0.3]))
        for t, name in events:
            writer.append_event(Event(t, "wheel 'one_wheel'", name, "air", "contact"))
    return path
