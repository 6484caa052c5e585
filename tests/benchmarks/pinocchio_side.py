"""Compare random mechanisms of rigid bodies with Pinocchio, a library of rigid-body dynamics in minimal coordinates.

    pip install pin
    python tests/benchmarks/pinocchio_side.py 1 300      # the seeds of the first and the last mechanism

A mechanism is a tree of two to seven bodies with hinges, prismatic, cylindrical, planar, spherical, universal joints
and screws, with springs and dampers in joints and between points, and with up to two loops, closed by spherical joints
or rigid rods. It falls from rest for one second. Pinocchio gives the equations of motion, which SciPy solves together
with the constraints of the loops (DOP853, 1e-11). The script compares positions of three points of each body,
velocities, coordinates of joints and all reactions; a difference is relative to the largest component, or to 1 where
that is more.
"""

import sys
import tempfile
from pathlib import Path

import numpy as np
import pinocchio as pin
import yaml
from scipy.integrate import solve_ivp

import mecano

GRAVITY = np.array([0.4, -0.7, -9.5])
FREEDOM = {"hinge": 1, "prismatic": 1, "cylindrical": 2, "spherical": 3, "universal": 2, "planar": 3, "screw": 1}
END = 1.0  # s


class Mechanism:
    """Random bodies, springs and closures; body i >= 1 has its joint at ``points[i]``, 0 is the ground."""

    def __init__(self, seed):
        rng = self.rng = np.random.default_rng(seed)
        self.points, self.bodies = [np.zeros(3)], [None]
        for i in range(1, rng.integers(3, 9)):
            self._add_body(i, int(rng.integers(max(0, i - 3), i)))
        self.springs = [self._line() for _ in range(rng.integers(0, 3))]
        self.closures = []
        for _ in range(rng.integers(0, 3)):
            self._close(str(rng.choice(["spherical", "rigid_rod"])))

    def _add_body(self, i, parent):
        rng = self.rng
        axes = np.linalg.qr(rng.normal(size=(3, 3)))[0]
        axes[:, 0] *= np.linalg.det(axes)
        spread = rng.normal(size=(3, 3))
        self.points.append(self.points[parent] + 0.6 * rng.normal(size=3))
        self.bodies.append({
            "parent": parent, "joint": str(rng.choice(list(FREEDOM))), "axes": axes.T, "mass": rng.uniform(0.5, 3.0),
            "inertia": 0.05 * (np.sum(spread**2) * np.eye(3) - spread @ spread.T), "center": 0.3 * rng.normal(size=3),
            "pitch": rng.uniform(0.3, 1.5), "turning": rng.uniform([0.0, 0.0], [8.0, 0.5]),
            "sliding": rng.uniform([0.0, 0.0], [30.0, 0.8]),
        })  # fmt: skip

    def _line(self):
        """Return two bodies and a point of each."""
        ends = [int(i) for i in self.rng.choice(len(self.bodies), 2, replace=False)]
        return *ends, *(self.points[i] + 0.5 * self.rng.normal(size=3) for i in ends)

    def _close(self, joint):
        """Add a loop that leaves two degrees of freedom, of which one is its own."""
        a, b, p, q = self._line()
        needed = sum(self._held(kind) for kind, *_ in self.closures) + self._held(joint)
        along = self._ancestors(a) ^ self._ancestors(b)
        if self._freedom(range(1, len(self.bodies))) >= needed + 2 and self._freedom(along) > self._held(joint):
            self.closures.append((joint, a, b, p, p if joint == "spherical" else q))

    def _held(self, joint):
        return 3 if joint == "spherical" else 1

    def _freedom(self, bodies):
        return sum(FREEDOM[self.bodies[i]["joint"]] for i in bodies)

    def _ancestors(self, i):
        return {i} | self._ancestors(self.bodies[i]["parent"]) if i else set()


def deck(mechanism):
    """Return the deck, in which each body has nodes for its joints, springs and two marks."""
    nodes, elements, joints, attached = {}, {}, {}, [[] for _ in mechanism.bodies]

    def place(i, name, point):
        nodes[name] = {"position": point.tolist()} | ({} if i else {"fixed": True})
        attached[i] += [name] * (i > 0)
        return name

    for i, body in enumerate(mechanism.bodies[1:], 1):
        nodes[f"body_{i}"] = {"position": mechanism.points[i].tolist()}
        for k in (0, 1):
            place(i, f"mark_{i}_{k}", mechanism.points[i] + body["axes"][k])
        socket = place(body["parent"], f"socket_{i}", mechanism.points[i])
        joints[f"joint_{i}"] = {"type": body["joint"], "nodes": [socket, f"body_{i}"]} | options(body)
    lines = [("spring", a, b, p, q) for a, b, p, q in mechanism.springs] + mechanism.closures
    for k, (kind, a, b, p, q) in enumerate(lines):
        ends = [place(a, f"end_{k}_a", p), place(b, f"end_{k}_b", q)]
        if kind == "spring":
            elements[f"line_{k}"] = {"type": "spring_damper", "nodes": ends, "law": {"spring": 20.0, "damper": 0.5}}
        else:
            joints[f"line_{k}"] = {"type": kind, "nodes": ends}
    for i, body in enumerate(mechanism.bodies[1:], 1):
        elements[f"part_{i}"] = {
            "type": "rigid_body", "node": f"body_{i}", "mass": body["mass"], "inertia": body["inertia"].tolist(),
            "center_of_mass": body["center"].tolist(), "attached": attached[i],
        }  # fmt: skip
    time = {"end": END, "step": 1e-3, "method": "radau", "adaptive": {"tolerance": 1e-9}}
    return {"mecano": 1, "gravity": GRAVITY.tolist(), "nodes": nodes, "elements": elements, "joints": joints,
            "time": time, "output": {"every": END}}  # fmt: skip


def options(body):
    """Return the axes and laws of a joint."""
    turning, sliding = ({"spring": float(k), "damper": float(c)} for k, c in (body["turning"], body["sliding"]))
    joint, (first, second, axis) = body["joint"], body["axes"].tolist()
    if joint == "spherical":
        return {}
    if joint == "universal":
        return {"axis_a": first, "axis_b": second, "turning_law_a": turning, "turning_law_b": sliding}
    return (
        {"axis": axis, "axis_1": first}
        | ({"turning_law": turning} if joint != "prismatic" else {})
        | ({"sliding_law": sliding} if joint in ("prismatic", "cylindrical") else {})
        | ({"pitch": float(body["pitch"])} if joint == "screw" else {})
    )


class Reference:
    """Equations of motion by Pinocchio; a state is configuration and velocity."""

    def __init__(self, mechanism):
        self.mechanism, self.model = mechanism, pin.Model()
        self.model.gravity.linear = GRAVITY
        for i, body in enumerate(mechanism.bodies[1:], 1):
            place = pin.SE3(np.eye(3), mechanism.points[i] - mechanism.points[body["parent"]])
            self.model.addJoint(body["parent"], joint_model(body), place, f"joint_{i}")
            inertia = pin.Inertia(body["mass"], body["center"], body["inertia"])
            self.model.appendBodyToJoint(i, inertia, pin.SE3.Identity())
        self.data = self.model.createData()

    def end(self):
        """Return configuration and velocity at the end."""
        start = np.concatenate([pin.neutral(self.model), np.zeros(self.model.nv)])
        solution = solve_ivp(self._rate, (0.0, END), start, method="DOP853", rtol=1e-11, atol=1e-12)
        return self._split(solution.y[:, -1])

    def _split(self, y):
        q, v = y[: self.model.nq].copy(), y[self.model.nq :]
        return pin.normalize(self.model, q), v

    def _rate(self, t, y):
        q, v = self._split(y)
        return np.concatenate([self._configuration_rate(q, v), self.accelerations(q, v)[0]])

    def _configuration_rate(self, q, v):
        rate = np.empty(self.model.nq)
        for joint, body in zip(list(self.model.joints)[1:], self.mechanism.bodies[1:], strict=True):
            u = v[joint.idx_v : joint.idx_v + joint.nv]
            if body["joint"] == "spherical":
                x, y = q[joint.idx_q : joint.idx_q + 3], q[joint.idx_q + 3]
                u = 0.5 * np.append(y * u + np.cross(x, u), -x @ u)
            rate[joint.idx_q : joint.idx_q + joint.nq] = u
        return rate

    def accelerations(self, q, v):
        """Return accelerations, torques of laws, forces on bodies in their frames, multipliers of closures."""
        model, none = self.model, np.zeros(self.model.nv)
        pin.forwardKinematics(model, self.data, q, v, none)
        pin.computeJointJacobians(model, self.data, q)
        torques, forces = self._laws(q, v), [pin.Force.Zero() for _ in range(model.njoints)]
        for a, b, p, r in self.mechanism.springs:
            span, rate, _, _ = self._relative(a, b, p, r)
            length = np.linalg.norm(span)
            pull = 20.0 * (length - np.linalg.norm(r - p)) + 0.5 * (span @ rate) / length
            self._apply(forces, a, b, p, r, -pull * span / length)
        data = model.createData()
        bias = pin.rnea(model, data, q, v, none, forces).copy()
        mass = np.array([pin.rnea(model, data, q, v, unit, forces) - bias for unit in np.eye(model.nv)])
        rows, drifts = self._closures()
        m = len(drifts)
        matrix = np.block([[mass, -rows.T], [rows, np.zeros((m, m))]])
        solved = np.linalg.solve(matrix, np.concatenate([torques - bias, -drifts]))
        acceleration, multipliers = np.split(solved, [model.nv])
        reactions = self._reactions(multipliers)
        for (_, a, b, p, r), reaction in zip(self.mechanism.closures, reactions, strict=True):
            self._apply(forces, a, b, p, r, reaction)
        return acceleration, torques, forces, reactions

    def _laws(self, q, v):
        torques = np.zeros(self.model.nv)
        for joint, body in zip(list(self.model.joints)[1:], self.mechanism.bodies[1:], strict=True):
            for k, law in laws(body).items():
                torques[joint.idx_v + k] = -law @ [q[joint.idx_q + k], v[joint.idx_v + k]]
        return torques

    def _relative(self, a, b, p, r):
        """Return distance, velocity, acceleration of joints at rest, and Jacobian of point r of b from p of a."""
        return [after - before for before, after in zip(self._motion(a, p), self._motion(b, r), strict=True)]

    def _motion(self, i, start):
        arm, place = start - self.mechanism.points[i], self.data.oMi[i]
        spin, turning = self.data.v[i].angular, self.data.a[i].angular
        velocity = self.data.v[i].linear + np.cross(spin, arm)
        acceleration = self.data.a[i].linear + np.cross(turning, arm) + np.cross(spin, velocity)
        jacobian = np.zeros((6, self.model.nv))
        if i:
            jacobian = pin.getJointJacobian(self.model, self.data, i, pin.ReferenceFrame.LOCAL)
        local = (arm, velocity, acceleration, jacobian[:3] - pin.skew(arm) @ jacobian[3:])
        inertial = [place.rotation @ vector for vector in local]
        return [place.translation + inertial[0], *inertial[1:]]

    def _closures(self):
        """Return the Jacobian of the closures and their accelerations without those of the joints."""
        rows, drifts = [np.zeros((0, self.model.nv))], [np.zeros(0)]
        for kind, a, b, p, r in self.mechanism.closures:
            span, rate, drift, jacobian = self._relative(a, b, p, r)
            if kind == "rigid_rod":
                length = np.linalg.norm(span)
                drift = np.atleast_1d((span @ drift + rate @ rate) / length)
                jacobian = (span @ jacobian / length)[None]
            rows.append(jacobian)
            drifts.append(drift)
        return np.vstack(rows), np.concatenate(drifts)

    def _reactions(self, multipliers):
        """Return the force of each closure on its second body, inertial."""
        found, taken = [], 0
        for kind, a, b, p, r in self.mechanism.closures:
            count = 1 if kind == "rigid_rod" else 3
            force, taken = multipliers[taken : taken + count], taken + count
            if kind == "rigid_rod":
                span = self._relative(a, b, p, r)[0]
                force = force * span / np.linalg.norm(span)
            found.append(force)
        return found

    def _apply(self, forces, a, b, p, r, force):
        """Add a force on r of b, and its opposite on p of a."""
        for i, point, inertial in ((a, p, -force), (b, r, force)):
            local = self.data.oMi[i].rotation.T @ inertial
            forces[i] += pin.Force(local, np.cross(point - self.mechanism.points[i], local))

    def values(self):
        """Return the outputs of mecano at the end, by name."""
        q, v = self.end()
        acceleration, torques, forces, reactions = self.accelerations(q, v)
        data = self.model.createData()
        pin.rnea(self.model, data, q, v, acceleration, forces)
        pin.forwardKinematics(self.model, data, q, v)
        found = {}
        for i, body in enumerate(self.mechanism.bodies[1:], 1):
            R, x, joint = data.oMi[i].rotation, data.oMi[i].translation, self.model.joints[i]
            found[f"nodes.body_{i}.position"] = x
            for k in (0, 1):
                found[f"nodes.mark_{i}_{k}.position"] = x + R @ body["axes"][k]
            velocity = data.v[i].linear + np.cross(data.v[i].angular, body["center"])
            found[f"elements.part_{i}.velocity"] = R @ velocity
            frame = body["axes"] @ data.oMi[body["parent"]].rotation.T
            force, moment = R @ data.f[i].linear, R @ data.f[i].angular
            coordinates = q[joint.idx_q : joint.idx_q + joint.nq], torques[joint.idx_v : joint.idx_v + joint.nv]
            outputs = joint_outputs(body, frame, body["axes"] @ R.T, force, moment, *coordinates)
            found |= {f"joints.joint_{i}.{name}": value for name, value in outputs.items()}
        for k, (kind, a, b, p, r) in enumerate(self.mechanism.closures, len(self.mechanism.springs)):
            force = reactions[k - len(self.mechanism.springs)]
            span = self._relative(a, b, p, r)[0]
            output = ("tension", -force @ span / np.linalg.norm(span)) if kind == "rigid_rod" else ("force", force)
            found[f"joints.line_{k}.{output[0]}"] = output[1]
        return found


def joint_model(body):
    """Return Pinocchio's joint; those of several coordinates are chains of slides and turns."""
    first, second, axis = body["axes"]
    slide, turn = pin.JointModelPrismaticUnaligned, pin.JointModelRevoluteUnaligned
    simple = {
        "hinge": lambda: turn(axis),
        "prismatic": lambda: slide(axis),
        "spherical": pin.JointModelSpherical,
        "screw": lambda: pin.JointModelHelicalUnaligned(axis, body["pitch"] / (2.0 * np.pi)),
    }
    if body["joint"] in simple:
        return simple[body["joint"]]()
    joint = pin.JointModelComposite()
    parts = {
        "cylindrical": [slide(axis), turn(axis)],
        "universal": [turn(first), turn(second)],
        "planar": [slide(first), slide(second), turn(axis)],
    }
    for part in parts[body["joint"]]:
        joint.addJoint(part)
    return joint


def laws(body):
    """Return stiffness and damping of the coordinates of a joint, by number."""
    turning, sliding = body["turning"], body["sliding"]
    return {
        "hinge": {0: turning},
        "screw": {0: turning},
        "prismatic": {0: sliding},
        "spherical": {},
        "planar": {2: turning},
        "cylindrical": {0: sliding, 1: turning},
        "universal": {0: turning, 1: sliding},
    }[body["joint"]]


def joint_outputs(body, frame, carried, force, moment, q, torques):
    """Return the outputs of a joint from its whole force and moment on b: components in a, without those of laws."""
    f, m = frame @ force, frame @ moment
    match body["joint"]:
        case "spherical":
            return {"force": force}
        case "universal":
            reaction = moment @ np.cross(carried[1], frame[0])
            return {"force": force, "moment": reaction, "angle_a": q[0], "angle_b": q[1]}
        case "planar":
            moment = m - [0.0, 0.0, torques[2]]
            return {"force": f[2], "moment": moment, "angle": q[2], "displacement": np.append(q[:2], 0.0)}
        case "prismatic":
            return {"force": f - [0.0, 0.0, torques[0]], "moment": m, "displacement": q[0]}
        case "cylindrical":
            force, moment = f - [0.0, 0.0, torques[0]], m - [0.0, 0.0, torques[1]]
            return {"force": force, "moment": moment, "displacement": q[0], "angle": q[1]}
    return {"force": f, "moment": m - [0.0, 0.0, torques[0]], "angle": q[0]}


def differences(seed, folder):
    """Return the relative difference of each output at the end."""
    mechanism, path = Mechanism(seed), Path(folder) / f"{seed}.yaml"
    path.write_text(yaml.safe_dump(deck(mechanism), sort_keys=False))
    results = mecano.run(path, path.with_suffix(".h5"), quiet=True, force=True)
    expected = Reference(mechanism).values()
    return {name: np.abs(results[name][-1] - value).max() / max(np.abs(value).max(), 1.0)
            for name, value in expected.items()}  # fmt: skip


def main(first, last):
    """Print the largest difference of each mechanism, and of all."""
    worst = 0.0
    with tempfile.TemporaryDirectory() as folder:
        for seed in range(first, last + 1):
            found = differences(seed, folder)
            name = max(found, key=lambda name: found[name])
            print(f"{seed}: {len(found)} outputs, at most {found[name]:.1e} ({name})", flush=True)
            worst = max(worst, found[name])
    print(f"at most {worst:.1e}")


if __name__ == "__main__":
    main(*map(int, sys.argv[1:]))
