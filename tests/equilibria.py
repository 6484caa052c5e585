"""Decks in equilibrium, for tests of statics and modes: paths in memory, and models with closed forms."""

import numpy as np
import scipy.sparse as sp
from time_runs import deck

from mecano.analyses.equilibria import follow
from mecano.analyses.prepare import prepare
from mecano.model.sampler import Sampler, StaticSample

G = 9.81


class Path:
    """The path of a deck with ``static``: its points, and how it ended."""

    def __init__(self, given):
        """Follow the path of a checked deck, or of the text of one."""
        self.points = []
        self.prepared = prepare(deck(given) if isinstance(given, str) else given)
        self.system = self.prepared.system
        self.result = follow(self.prepared, (self.points.append,))

    @property
    def factors(self):
        """Load factors (or times) of all points."""
        return np.array([point.parameter for point in self.points])

    @property
    def unstable(self):
        """Number of unstable directions of all points."""
        return np.array([point.stability.unstable for point in self.points])

    def node(self, name):
        """Number of a node."""
        return [node.name for node in self.system.nodes].index(name)

    def positions(self, name):
        """Positions (points, 3) of a node [m]."""
        first = self.system.numbering.x[self.node(name)]
        return np.array([point.state.z[first : first + 3] for point in self.points])

    def rotations(self, name):
        """Rotations (points, 3, 3) of a node."""
        return np.array([p.state.R[self.system.numbering.rotation[self.node(name)]] for p in self.points])

    def turns_about_y(self, name):
        """Angles about the y axis [rad]."""
        R = self.rotations(name)
        return np.arctan2(R[:, 0, 2], R[:, 0, 0])


def truss(static, height=0.3, load=30.0):
    """Von Mises truss: two springs of 1000 N/m from (-1, 0, 0) and (1, 0, 0) to (0, 0, height), loaded downwards."""
    return f"""
        mecano: 1
        gravity: [0, 0, 0]
        nodes:
          left: {{position: [-1, 0, 0], fixed: true}}
          right: {{position: [1, 0, 0], fixed: true}}
          top: {{position: [0, 0, {height}]}}
        elements:
          mass: {{type: point_mass, node: top, mass: 1.0}}
          a: {{type: spring_damper, nodes: [left, top], law: {{spring: {{stiffness: 1000.0}}}}}}
          b: {{type: spring_damper, nodes: [right, top], law: {{spring: {{stiffness: 1000.0}}}}}}
        loads:
          push: {{type: force, node: top, direction: [0, 0, -1], value: {load}}}
        joints:
          plane: {{type: prescribed_position, node: top, direction: [0, 1, 0], value: 0}}
        static: {static}
        """


def truss_force(z, height=0.3, stiffness=1000.0):
    """Force that presses the top of the truss down to z [N]."""
    length = np.hypot(1.0, z)
    return 2.0 * stiffness * (np.hypot(1.0, height) - length) / length * z


def arm(process, *, centre="[0.5, 0, 0]", stiffness=6.0, gravity=G, more=""):
    """A bar of 2 kg on a hinge about y at the origin, with a torsion spring."""
    return f"""
        mecano: 1
        gravity: [0, 0, -{gravity}]
        nodes:
          pin: {{position: [0, 0, 0]}}
        elements:
          bar: {{type: rigid_body, node: pin, mass: 2.0, center_of_mass: {centre}, inertia: [0.1, 0.1, 0.1]}}
          spring: {{type: torsion_spring_damper, nodes: [ground, pin], axis: [0, 1, 0], law: {{spring: {{stiffness: {stiffness}}}}}}}
        joints:
          hinge: {{type: hinge, nodes: [ground, pin], axis: [0, 1, 0]}}
        {more}
        {process}
        """  # noqa: E501


def chain(process, links=8, span=1.0, length=1.2, mass=0.5):
    """Rigid rods in a zigzag between supports at the same height, a mass at each of the joints between them."""
    dx, link = span / links, length / links
    dz = float(np.sqrt(link**2 - dx**2))
    places = [(i * dx, -dz if i % 2 else 0.0) for i in range(links + 1)]
    ends = (0, links)
    lines = ["mecano: 1", "gravity: [0, 0, -9.81]", "nodes:"]
    lines += [
        f"  p{i}: {{position: [{x!r}, 0, {z!r}]{', fixed: true' if i in ends else ''}}}"
        for i, (x, z) in enumerate(places)
    ]
    lines += ["elements:"] + [f"  m{i}: {{type: point_mass, node: p{i}, mass: {mass}}}" for i in range(1, links)]
    lines += ["joints:"] + [f"  r{i}: {{type: rigid_rod, nodes: [p{i}, p{i + 1}]}}" for i in range(links)]
    return "\n".join([*lines, process])


class Equilibrium:
    """A deck with ``static`` at the end of its path; without loads and laws of time, at its start."""

    def __init__(self, text):
        checked = deck(text)
        prepared = prepare(checked)
        self.system, self.state = prepared.system, prepared.state
        if checked.values["loads"] or checked.values["static"]["over"] == "time":
            self.state = follow(prepared).point.state

    def tangent(self, cK=1.0, cM=0.0):
        """cK K + cM M (n, n), by material variations."""
        system, n = self.system, self.system.n
        data = system.assemble(self.state, cK=cK, cM=cM).data
        return sp.csr_matrix((data[: system.nnz], (system.rows, system.cols)), shape=(n, n))

    def position(self, name):
        """Position (3,) of a node."""
        i = [node.name for node in self.system.nodes].index(name)
        first = self.system.numbering.x[i]
        return self.state.z[first : first + 3].copy()

    def output(self, path):
        """An output."""
        sampler = Sampler(self.system)
        row = sampler.take(StaticSample(self.state), self.system.observe(self.state))
        c = next(column for column in sampler.columns if column.path == path)
        return row[c.start : c.start + c.size].copy()
