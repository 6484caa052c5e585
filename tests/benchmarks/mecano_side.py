"""The cases in mecano: decks, solved without a results file."""

import math
import time
from itertools import pairwise

import numpy as np
import yaml
from cases import DISC, GEAR, GRAVITY, LENGTH, MASS, THICKNESS, TOP_SPEED

from mecano.analyses.prepare import integrator_of, prepare
from mecano.deck.read import deck_of_bytes
from mecano.solve.time.interpolate import interpolate

BAR = MASS / 12.0
THIN, LONG = BAR * 2.0 * THICKNESS**2, BAR * (LENGTH**2 + THICKNESS**2)  # moments of inertia of a bar [kg m2]


def _bar(node, along, attached):
    """A uniform bar that begins at its node and goes along the first or second axis of it."""
    center, inertia = [0.0] * 3, [LONG] * 3
    center[along], inertia[along] = 0.5 * LENGTH, THIN
    return {
        "type": "rigid_body", "node": node, "mass": MASS, "center_of_mass": center, "inertia": inertia,
        "attached": attached,
    }  # fmt: skip


def chain(n):
    """n bars on hinges about y, horizontal at rest at the start: (deck, places of the bodies)."""
    nodes, elements, joints, places = {}, {}, {}, []
    for i in range(n):
        nodes[f"a{i}"] = {"position": [i * LENGTH, 0, 0]}
        if i < n - 1:
            nodes[f"b{i}"] = {"position": [(i + 1) * LENGTH, 0, 0]}
        elements[f"link{i}"] = _bar(f"a{i}", 0, [f"b{i}"] if i < n - 1 else [])
        held = "ground" if i == 0 else f"b{i - 1}"
        joints[f"hinge{i}"] = {"type": "hinge", "nodes": [held, f"a{i}"], "axis": [0, 1, 0]}
        places.append((f"a{i}", 0))
    return {"gravity": [0, 0, -GRAVITY], "nodes": nodes, "elements": elements, "joints": joints}, places


def four_bar(n):
    """n windows of bars in the plane x-y, every joint a hinge in space: (deck, places of the bodies)."""
    nodes, elements, joints, moving, places = {}, {}, {}, [], []
    for i in range(n + 1):
        foot, head = f"foot{i}", f"head{i}"
        nodes[foot], nodes[head] = {"position": [i * LENGTH, 0, 0]}, {"position": [i * LENGTH, LENGTH, 0]}
        elements[f"crank{i}"] = _bar(foot, 1, [head])
        joints[f"base{i}"] = {"type": "hinge", "nodes": ["ground", foot], "axis": [0, 0, 1]}
        turning = {"angular_velocity": [0, 0, -TOP_SPEED / LENGTH], "about": [i * LENGTH, 0, 0]}
        moving.append({"nodes": [foot, head], **turning})
        places.append((foot, 1))
    for i in range(n):
        left, right = f"left{i}", f"right{i}"
        nodes[left] = {"position": [i * LENGTH, LENGTH, 0]}
        nodes[right] = {"position": [(i + 1) * LENGTH, LENGTH, 0]}
        elements[f"bar{i}"] = _bar(left, 0, [right])
        joints[f"pin{i}"] = {"type": "hinge", "nodes": [f"head{i}", left], "axis": [0, 0, 1]}
        joints[f"knee{i}"] = {"type": "hinge", "nodes": [right, f"head{i + 1}"], "axis": [0, 0, 1]}
        moving.append({"nodes": [left, right], "velocity": [TOP_SPEED, 0, 0]})
        places.append((left, 0))
    deck = {"gravity": [0, -GRAVITY, 0], "nodes": nodes, "elements": elements, "joints": joints}
    return {**deck, "initial": {"velocities": moving}}, places


def gear_drop(n):
    """A mass on a strut and a wheel that touches down: (deck, places of the bodies)."""
    g = GEAR
    axle = [0, 0, g.radius + g.clearance]
    nodes = {
        "top": {"position": [0, 0, axle[2] + g.strut]}, "slider": {"position": axle}, "axle": {"position": axle},
    }  # fmt: skip

    def body(node, mass, inertia):
        return {"type": "rigid_body", "node": node, "mass": mass, "inertia": inertia}

    strut = {"spring": {"stiffness": g.stiffness}, "damper": {"coefficient": g.damping}}
    elements = {
        "top_mass": body("top", g.top_mass, [g.top_inertia] * 3),
        "slider_mass": body("slider", g.slider_mass, list(g.slider_inertia)),
        "wheel_mass": body("axle", g.wheel_mass, list(g.wheel_inertia)),
        "strut": {"type": "spring_damper", "nodes": ["top", "slider"], "law": strut, "natural_length": g.strut},
        "wheel": {"type": "wheel", "node": "axle", "axis": [0, 1, 0], "tire_law": "tyre", "ground": "runway"},
    }
    joints = {
        "upright": {"type": "held_rotation", "nodes": ["ground", "top"]},
        "straight": {"type": "prescribed_position", "node": "top", "direction": [0, 1, 0], "value": 0.0},
        "slide": {"type": "prismatic", "nodes": ["top", "slider"], "axis": [0, 0, 1]},
        "bearing": {"type": "hinge", "nodes": ["slider", "axle"], "axis": [0, 1, 0]},
    }
    tyre = {
        "radius": g.radius, "radial": {"linear": {"slope": g.tyre}}, "friction": g.friction,
        "slip_regularization": g.slip,
    }  # fmt: skip
    deck = {
        "gravity": [0, 0, -GRAVITY], "nodes": nodes, "elements": elements, "joints": joints,
        "tire_laws": {"tyre": tyre}, "grounds": {"runway": {"plane": {"point": [0, 0, 0], "normal": [0, 0, 1]}}},
        "initial": {"velocities": [{"nodes": "all", "velocity": [g.speed, 0, -g.sink]}]},
    }  # fmt: skip
    return deck, [("top", 0), ("slider", 0), ("axle", 0)]


def rolling_disc(n):
    """A disc that rolls without slip: (deck, places of the bodies)."""
    d = DISC
    c, s = math.cos(d.lean), math.sin(d.lean)
    centre, turning = d.radius * np.array([0, -s, c]), np.array([0, d.spin * c, d.spin * s + d.turning])
    deck = {
        "gravity": [0, 0, -GRAVITY],
        "nodes": {"centre": {"position": centre.tolist(), "orientation": [d.lean, 0, 0]}},
        "elements": {
            "disc": {"type": "rigid_body", "node": "centre", "mass": d.mass, "inertia": d.inertia},
            "rim": {"type": "rigid_wheel", "node": "centre", "radius": d.radius, "axis": [0, c, s], "ground": "floor"},
        },
        "grounds": {"floor": {"plane": {"point": [0, 0, 0], "normal": [0, 0, 1]}}},
    }
    velocity = np.cross(turning, centre).tolist()
    moving = [{"nodes": ["centre"], "velocity": velocity, "angular_velocity": turning.tolist()}]
    return {**deck, "initial": {"velocities": moving}}, [("centre", 0)]


MODELS = {"chain": chain, "four_bar": four_bar, "gear_drop": gear_drop, "rolling_disc": rolling_disc}


def deck_of(case, step):
    """The whole deck of a case with steps of this size [s]."""
    deck, _ = MODELS[case.model](case.size)
    return {"mecano": 1, **deck, "time": {"end": case.duration, "step": step, "rho_inf": case.rho}}


class Mecano:
    """A case ready to be integrated repeatedly, with steps of one size."""

    def __init__(self, case, step=None):
        self.case, self.step = case, step or case.step
        deck, places = deck_of(case, self.step), MODELS[case.model](case.size)[1]
        self.prepared = prepare(deck_of_bytes(yaml.safe_dump(deck, sort_keys=False).encode(), case.name))
        self.index = {node.name: i for i, node in enumerate(self.prepared.system.nodes)}
        self.places = places
        self.counts = None  # (accepted steps, Newton iterations) of the last run

    def integrate(self, *observers):
        """Integrate over the whole duration; CPU time [s]."""
        integrator = integrator_of(self.prepared, observers)
        start = time.process_time()
        run = integrator.to(self.case.duration, integrator.begin(self.prepared.state, self.step))
        spent = time.process_time() - start
        self.counts = run.steps, run.iterations
        return spent

    def trace(self):
        """The probes (n_samples, n_probes) at every ``case.every`` steps of the case, the start left out."""
        wanted = self.case.step * self.case.every * np.arange(1, self.case.steps // self.case.every + 1)
        states = [self.prepared.state]

        def keep(accepted):
            states.append(accepted.run.motion)

        self.integrate(keep)
        rows = []
        for before, after in pairwise(states):
            sliver = 1e-6 * self.step
            while len(rows) < len(wanted) and wanted[len(rows)] <= after.t + sliver:
                t = min(wanted[len(rows)], after.t)
                rows.append(self._probe(interpolate(before, after, t, self.prepared.system.numbering)))
        return np.array(rows)

    def _probe(self, s):
        of, values = self.prepared.system.numbering, []
        for probe in self.case.probes:
            node, along = self.places[probe.body]
            i = self.index[node]
            R = s.R[of.rotation[i]]
            if probe.what == "turning":
                values.append(R[probe.axis] @ s.v[of.r[i] : of.r[i] + 3])
            else:
                offset = 0.5 * LENGTH + probe.point if self.case.model in ("chain", "four_bar") else 0.0
                values.append(s.z[of.x[i] + probe.axis] + offset * R[probe.axis, along])
        return values
