"""Compare random space frames with OpenSees, a finite element program of structural engineering.

    pip install openseespy
    python tests/benchmarks/opensees_side.py 1 40      # the seeds of the first and the last frame

A frame has two to ten straight members between three to eight joints, with sections that bend, shear, twist and
stretch, one or two clamped joints and joints on springs; a force acts on each free joint. Both programs find

* the joints' displacements and the members' end forces under loads so small that statics is linear,
* displacements of 0.3 m, about a third of a member, under loads that turn the members far,
* the first eight frequencies about that state,
* the displacements while the loads grow to it within two periods of the first frequency.

OpenSees uses corotational members with their masses in the nodes, so that members here have next to no rotary inertia.
But for the small loads, values of both programs are extrapolated from two meshes, and from two time steps in motion:
the script prints the difference of the extrapolated values and what the finer meshes leave, relative to the largest
component. A frame is passed over where a program does not find the equilibrium, as beyond a limit point.
"""

import contextlib
import io
import sys
import tempfile
from pathlib import Path

import numpy as np
import openseespy.opensees as ops

import mecano

E, G, DENSITY = 70e9, 27e9, 2700.0
SIZE = 0.3  # m, of the large displacements that linear statics predicts
MESHES = {"mecano": (12, 24), "OpenSees": (20, 40)}
STEPS = (400, 800)
FREQUENCIES = 8
ROTARY_INERTIA = 1e-7  # kg m, instead of none


class Frame:
    """Random joints, members, springs and forces; joint 0 is clamped."""

    def __init__(self, seed):
        rng = self.rng = np.random.default_rng(seed)
        self.joints, self.members = [np.zeros(3)], []
        for i in range(1, int(rng.integers(3, 9))):
            j = int(rng.integers(max(0, i - 3), i))
            away = rng.normal(size=3)
            self.joints.append(self.joints[j] + away * rng.uniform(0.6, 2.0) / np.linalg.norm(away))
            self._add_member(j, i)
        for _ in range(rng.integers(0, 4)):
            self._add_brace(*(int(i) for i in rng.choice(len(self.joints), 2, replace=False)))
        last = len(self.joints) - 1
        self.clamped = {0, last} if last > 3 and rng.random() < 0.5 else {0}
        free = [i for i in range(last + 1) if i not in self.clamped]
        self.springs = {i: 10 ** rng.uniform(3, 6, 3) for i in free if rng.random() < 0.25}
        self.forces = {i: rng.normal(size=3) for i in free}

    def _add_brace(self, a, b):
        joined = any({a, b} == {m["a"], m["b"]} for m in self.members)
        if not joined and np.linalg.norm(self.joints[a] - self.joints[b]) > 0.4:
            self._add_member(a, b)

    def _add_member(self, a, b):
        width, height = self.rng.uniform(0.01, 0.05, 2)
        up = np.cross(self.joints[b] - self.joints[a], self.rng.normal(size=3))
        area, i_2, i_3 = width * height, width * height**3 / 12, height * width**3 / 12
        shear_2, shear_3 = area * self.rng.uniform(0.5, 0.9, 2)
        self.members.append({"a": a, "b": b, "up": up / np.linalg.norm(up), "A": area, "I2": i_2, "I3": i_3,
                             "J": i_2 + i_3, "A2": shear_2, "A3": shear_3})  # fmt: skip


def deck(frame, load, mesh, motion=None):
    """Return the deck of statics, or of ``motion``, (end [s], steps); forces grow to ``load`` times the frame's."""
    sections, elements = {}, {}
    for k, m in enumerate(frame.members):
        sections[f"section_{k}"] = {
            "type": "stiffness", "EA": E * m["A"], "GA2": G * m["A2"], "GA3": G * m["A3"], "GJ": G * m["J"],
            "EI2": E * m["I2"], "EI3": E * m["I3"], "mass_per_length": DENSITY * m["A"],
            "rotary_inertia": [ROTARY_INERTIA] * 3,
        }  # fmt: skip
        elements[f"member_{k}"] = {"type": "beam", "nodes": [f"joint_{m['a']}", f"joint_{m['b']}"],
                                   "section": f"section_{k}", "up": m["up"].tolist(), "mesh": mesh}  # fmt: skip
    for i, stiffness in frame.springs.items():
        elements[f"spring_{i}"] = {"type": "bushing", "nodes": ["ground", f"joint_{i}"], "axis": [0, 0, 1],
                                   "axis_1": [1, 0, 0], "stiffness": [*stiffness, 1e-9, 1e-9, 1e-9]}  # fmt: skip
    values = {i: float(load * np.linalg.norm(force)) for i, force in frame.forces.items()}
    analysis = {"static": {"newton": {"force_tolerance": 1e-12}}}
    if motion:
        end, steps = motion
        values = {i: f"{float(value / end)!r} * time" for i, value in values.items()}
        analysis = {"time": {"end": end, "step": end / steps, "rho_inf": 1.0, "newton": {"force_tolerance": 1e-9}}}
    return mecano.Deck({
        "gravity": "none", "sections": sections, "elements": elements,
        "nodes": {f"joint_{i}": {"position": x.tolist(), "fixed": i in frame.clamped}
                  for i, x in enumerate(frame.joints)},
        "loads": {f"force_{i}": {"type": "force", "node": f"joint_{i}", "direction": force.tolist(), "value": values[i]}
                  for i, force in frame.forces.items()},
    } | analysis)  # fmt: skip


class Mecano:
    """The frame in mecano, with its results in the file ``path``."""

    def __init__(self, frame, path):
        self.frame, self.path = frame, path

    def run(self, load, mesh, motion=None):
        """Return the results."""
        return mecano.run(deck(self.frame, load, mesh, motion), self.path, quiet=True, force=True)

    def displacements(self, load, mesh, motion=None):
        """Return the displacements (joints, 3) [m] at the end."""
        return self._moved(self.run(load, mesh, motion))

    def deformed(self, load, mesh):
        """Return the displacements (joints, 3) [m] and the frequencies [Hz] about the equilibrium."""
        results = self.run(load, mesh)
        modes = mecano.modes(deck(self.frame, load, mesh), at=self.path)
        return self._moved(results), np.sort(np.asarray(modes.frequency))[:FREQUENCIES]

    def small(self, load):
        """Return the displacements and end forces (members, 9) of one element a member, odd in the load."""
        there, back = (self._linear(scale * load) for scale in (1.0, -1.0))
        return [0.5 * (a - b) for a, b in zip(there, back, strict=True)]

    def _linear(self, load):
        results = self.run(load, 1)
        names = ("force", "moment_start", "moment_end")
        ends = [np.concatenate([results[f"elements.member_{k}.{name}"][-1] for name in names])
                for k in range(len(self.frame.members))]  # fmt: skip
        return self._moved(results), np.array(ends)

    def _moved(self, results):
        joints = self.frame.joints
        return np.array([results[f"nodes.joint_{i}.position"][-1] - x for i, x in enumerate(joints)])


class OpenSees:
    """The frame in OpenSees."""

    def __init__(self, frame):
        self.frame = frame

    def build(self, load, mesh, kind, end=1.0):
        """Make the model: members of one ``kind``, springs, and forces that reach ``load`` times theirs at ``end``."""
        frame = self.frame
        ops.wipe()
        ops.model("basic", "-ndm", 3, "-ndf", 6)
        for i, x in enumerate(frame.joints):
            ops.node(i, *x.tolist())
        for i in frame.clamped:
            ops.fix(i, 1, 1, 1, 1, 1, 1)
        for k, m in enumerate(frame.members):
            self._member(k, m, mesh, kind)
        for i, stiffness in frame.springs.items():
            self._spring(i, stiffness)
        ops.timeSeries("Linear", 1, "-factor", 1.0 / end)
        ops.pattern("Plain", 1, 1)
        for i, force in frame.forces.items():
            ops.load(i, *(load * force).tolist(), 0.0, 0.0, 0.0)

    def _member(self, k, m, mesh, kind):
        a, b = self.frame.joints[m["a"]], self.frame.joints[m["b"]]
        inner = [1000 * (k + 1) + j for j in range(1, mesh)]
        for j, node in enumerate(inner, start=1):
            ops.node(node, *(a + (b - a) * j / mesh).tolist())
        ends, mass = [m["a"], *inner, m["b"]], ("-mass", DENSITY * m["A"])
        ops.geomTransf("Linear" if kind == "linear" else "Corotational", k, *m["up"].tolist())
        ops.section("Elastic", k, E, m["A"], m["I3"], m["I2"], G, m["J"], m["A2"] / m["A"], m["A3"] / m["A"])
        ops.beamIntegration("Lobatto", k, k, 4)
        for j, pair in enumerate(zip(ends, ends[1:], strict=False)):
            element = 1000 * (k + 1) + j
            if kind == "linear":
                stiff = (E, G, m["A"], m["J"], m["I2"], m["I3"], m["A2"], m["A3"])
                ops.element("ElasticTimoshenkoBeam", element, *pair, *stiff, k, *mass)
            else:
                ops.element("forceBeamColumn", element, *pair, k, k, "-iter", 20, 1e-14, *mass)

    def _spring(self, i, stiffness):
        ground, first = 500 + i, 100 + 3 * i
        ops.node(ground, *self.frame.joints[i].tolist())
        ops.fix(ground, 1, 1, 1, 1, 1, 1)
        for j in range(3):
            ops.uniaxialMaterial("Elastic", first + j, float(stiffness[j]))
        ops.element("zeroLength", ground, ground, i, "-mat", first, first + 1, first + 2, "-dir", 1, 2, 3)

    def _solve(self, analysis, integrator, steps, *step, tolerance):
        ops.constraints("Plain")
        ops.numberer("RCM")
        ops.system("UmfPack")
        ops.test("NormUnbalance", tolerance, 50)
        ops.algorithm("Newton")
        ops.integrator(*integrator)
        ops.analysis(analysis)
        if ops.analyze(steps, *step) != 0:
            raise ArithmeticError("OpenSees does not converge")

    def displacements(self, load, mesh, motion):
        """Return the displacements (joints, 3) [m] at the end of a motion."""
        end, steps = motion
        self.build(load, mesh, "corotational", end)
        self._solve("Transient", ("Newmark", 0.5, 0.25), steps, end / steps, tolerance=1e-8 * load)
        return self._moved()

    def deformed(self, load, mesh):
        """Return the displacements (joints, 3) [m] and the frequencies [Hz] about the equilibrium."""
        self.build(load, mesh, "corotational")
        self._solve("Static", ("LoadControl", 0.025), 40, tolerance=1e-8 * load)
        moved = self._moved()
        return moved, np.sqrt(np.sort(ops.eigen(FREQUENCIES + 2))[:FREQUENCIES]) / (2.0 * np.pi)

    def small(self, load):
        """Return the displacements and end forces (members, 9) of one element a member."""
        self.build(load, 1, "linear")
        self._solve("Static", ("LoadControl", 1.0), 1, tolerance=1e-9 * load)
        forces = [np.array(ops.eleResponse(1000 * (k + 1), "localForce")) for k in range(len(self.frame.members))]
        return self._moved(), np.array([np.concatenate([q[6:9], -q[3:6], q[9:12]]) for q in forces])

    def _moved(self):
        return np.array([ops.nodeDisp(i)[:3] for i in range(len(self.frame.joints))])


def limit(coarse, fine):
    """Return the value without the error of second order, and that error of the ``fine`` one."""
    value = (4.0 * fine - coarse) / 3.0
    return value, np.abs(fine - value).max()


def compare(pairs):
    """Return the difference of two programs' limits and the larger error of the fine values, relative."""
    (a, error_a), (b, error_b) = (limit(*pair) for pair in pairs)
    return np.array([np.abs(a - b).max(), max(error_a, error_b)]) / np.abs(a).max()


def differences(seed, folder):
    """Return {subject: (difference, what the meshes leave)}, relative."""
    frame = Frame(seed)
    programs = {"mecano": Mecano(frame, Path(folder) / "frame.h5"), "OpenSees": OpenSees(frame)}
    (u, forces), (u_o, forces_o) = (program.small(1e-2) for program in programs.values())
    found = {f"small {name}": (np.abs(a - b).max() / np.abs(b).max(), 0.0)
             for name, a, b in (("displacements", u, u_o), ("forces", forces[:, :3], forces_o[:, :3]),
                                ("moments", forces[:, 3:], forces_o[:, 3:]))}  # fmt: skip
    load = 1e-2 * SIZE / np.abs(u_o).max()
    states = [[program.deformed(load, mesh) for mesh in MESHES[name]] for name, program in programs.items()]
    found["large displacements"] = compare([[moved for moved, _ in pair] for pair in states])
    found["frequencies"] = max((compare([[f[i : i + 1] for _, f in pair] for pair in states])
                                for i in range(FREQUENCIES)), key=lambda pair: pair[0])  # fmt: skip
    end = 2.0 / states[0][1][1][0]
    found["motion"] = compare(
        [[program.displacements(load, mesh, (end, steps)) for mesh, steps in zip(MESHES[name], STEPS, strict=True)]
         for name, program in programs.items()])  # fmt: skip
    return found


def main(first, last):
    """Print the differences of each frame, and the largest of all."""
    worst, passed = {}, 0
    with tempfile.TemporaryDirectory() as folder:
        for seed in range(first, last + 1):
            try:
                with contextlib.redirect_stderr(io.StringIO()):
                    found = differences(seed, folder)
            except (ArithmeticError, mecano.MecanoError) as failure:
                print(f"{seed}: passed over: {str(failure).splitlines()[0]}", flush=True)
                passed += 1
                continue
            print(f"{seed}: " + ", ".join(f"{name} {d:.0e} ({h:.0e})" for name, (d, h) in found.items()), flush=True)
            worst = {name: max(worst.get(name, 0.0), difference) for name, (difference, _) in found.items()}
    print(f"{last + 1 - first - passed} frames, at most: " + ", ".join(f"{name} {d:.1e}" for name, d in worst.items()))


if __name__ == "__main__":
    main(*map(int, sys.argv[1:]))
