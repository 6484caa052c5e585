"""Random trees of rigid bodies, joints and springs, against their equations in minimal coordinates."""

import json

import numpy as np
import pytest
from minimal_coordinates import Body, Spring, Tree
from time_runs import RecordedRun, deck

END = 0.25  # s
JOINTS = ("hinge", "prismatic", "cylindrical", "screw", "planar", "universal", "spherical")
WITH_MOMENT = ("hinge", "prismatic", "cylindrical", "planar", "universal")


def unit(v):
    return v / np.linalg.norm(v)


def random_tree(rng):
    """Return a tree of three bodies with two springs, in motion."""
    bodies, springs = [], []
    for i in range(3):
        parent, joint = int(rng.integers(-1, i)), str(rng.choice(JOINTS))
        point = 0.5 * rng.normal(size=3) + (bodies[parent].point if parent >= 0 else 0.0)
        A = rng.normal(size=(3, 3))
        inertia = 0.1 * (np.sum(A * A) * np.eye(3) - A @ A.T)
        a = unit(rng.normal(size=3))
        b = unit(np.cross(a, rng.normal(size=3)))
        body = Body(
            parent, joint, point, 0.7 * rng.normal(size=3), rng.uniform(0.3, 3.0), inertia, 0.3 * rng.normal(size=3),
            np.array([a, b, np.cross(a, b)]), np.zeros(0), rng.uniform(0.1, 0.6),
        )  # fmt: skip
        body.rates = 1.5 * rng.normal(size=body.coordinates)
        bodies.append(body)
    for i in (1, 2):
        points = np.array([bodies[i].point + 0.4 * rng.normal(size=3), 1.5 * rng.normal(size=3)])
        springs.append(Spring((i, i - 2), points, rng.uniform(0.3, 1.5), rng.uniform(5.0, 40.0), rng.uniform(0.0, 3.0)))
    return Tree(bodies, springs)


def deck_of(tree):
    """Return the deck of a tree, in which each body has nodes at its joints and springs."""
    nodes, elements, joints, velocities = {}, {}, {}, []
    attached = [[] for _ in tree.bodies]
    rates = np.concatenate([body.rates for body in tree.bodies])
    frames = tree.frames(np.concatenate([0.0 * rates, rates]))

    def add(name, i, point, **more):
        nodes[name] = {"position": list(point), **more} | ({"fixed": True} if i < 0 else {})
        if i >= 0:
            attached[i].append(name)
        return name

    for i, body in enumerate(tree.bodies):
        nodes[f"body_{i}"] = {"position": list(body.point), "orientation": list(body.rotation)}
        socket = add(f"socket_{i}", body.parent, body.point, orientation=list(body.rotation))
        joint = joints[f"joint_{i}"] = {"type": body.joint, "nodes": [socket, f"body_{i}"]}
        names = {"universal": ("axis_a", "axis_b"), "spherical": (), "planar": ("axis", "axis_1")}
        for name, axis in zip(names.get(body.joint, ("axis",)), body.axes, strict=False):
            joint[name] = list(axis)
        if body.joint == "screw":
            joint["pitch"] = body.pitch
    for k, spring in enumerate(tree.springs):
        ends = [add(f"end_{k}{j}", i, x) for j, (i, x) in enumerate(zip(spring.bodies, spring.points, strict=True))]
        law = {"spring": spring.stiffness, "damper": spring.damping}
        elements[f"spring_{k}"] = {
            "type": "spring_damper", "nodes": ends, "natural_length": spring.length, "law": law,
        }  # fmt: skip
    for i, (body, frame) in enumerate(zip(tree.bodies, frames, strict=True)):
        elements[f"body_{i}"] = {
            "type": "rigid_body", "node": f"body_{i}", "mass": body.mass, "center_of_mass": list(body.center),
            "inertia": body.inertia.tolist(), "attached": attached[i],
        }  # fmt: skip
        moving = {"velocity": list(frame.v), "angular_velocity": list(frame.w), "about": list(body.point)}
        velocities.append({"nodes": [f"body_{i}", *attached[i]], **moving})
    time = {"end": END, "step": 0.01, "method": "radau", "adaptive": {"tolerance": 1e-9}}
    return deck(
        json.dumps(
            {
                "mecano": 1,
                "gravity": [0, 0, -9.81],
                "nodes": nodes,
                "elements": elements,
                "joints": joints,
                "initial": {"velocities": velocities},
                "time": time,
            }  # fmt: skip
        )
    )


@pytest.mark.parametrize("seed", [0, 2, 3])  # with all of the joints
def test_motions_and_reactions(seed, verify):
    """Positions, velocities, and the magnitudes of forces and moments in the joints, of three bodies."""
    tree = random_tree(np.random.default_rng([seed, 1]))
    recorded, y = RecordedRun(deck_of(tree)), tree.motion(END)
    found, exact = [], []
    for i, (body, frame) in enumerate(zip(tree.bodies, tree.frames(y), strict=True)):
        force, moment = map(np.linalg.norm, tree.reaction(y, i))
        found += [*recorded[f"nodes/body_{i}/position"][-1], *recorded[f"nodes/body_{i}/velocity"][-1]]
        exact += [*frame.x, *frame.v]
        if body.joint != "screw":
            found.append(np.linalg.norm(recorded[f"joints/joint_{i}/force"][-1]))
            exact.append(force)
        if body.joint in WITH_MOMENT:
            found.append(np.linalg.norm(recorded[f"joints/joint_{i}/moment"][-1]))
            exact.append(moment)
    assert np.abs(exact).max() > 5.0
    names = ", ".join(body.joint for body in tree.bodies)
    source = "equations of Newton, Euler and Kane in minimal coordinates, by DOP853"
    what = f"{names}, springs: motion and reactions after {END} s [SI units]"
    verify("Mechanisms", what, found, exact, source, absolute=1e-8)
