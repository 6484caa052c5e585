"""Generic test of the invariance of a kind under a rigid motion of the whole model; see kind_tests.py."""

from collections.abc import Iterable

import numpy as np
from scipy.spatial.transform import Rotation

from mecano.analyses.constraint_tests import is_inactive
from mecano.analyses.kind_samples import GRAVITY, PENALTY, Instance, Motion, expand, samples, seed_of
from mecano.analyses.power_tests import energies
from mecano.element_interface import Kind
from mecano.schema import DIRECTION, GROUND, POINT, VECTOR, WHEEL, Field, Values


def check_invariance(kind: Kind) -> None:
    """Forces rotate with the whole model, energies do not change."""
    rng, hint = seed_of("turn"), _inertial_fields(kind)
    Q, shift = Rotation.random(None, rng).as_matrix(), rng.normal(size=3)
    for sample in samples(kind):
        values = turned_values(kind.fields, sample.values, Q, shift)
        nodes = [(Q @ x + shift, Q @ R) for x, R in sample.nodes]
        twins = expand(kind, values, nodes, sample.phase, Q @ GRAVITY, seed_of("unused"))
        here, there = sample.motion, sample.motion.moved(Q, shift)
        for instance in sample.instances:
            if is_inactive(instance):
                instance.multipliers = 0.0 * instance.multipliers  # rows without forces
        for twin, original in zip(twins, sample.instances, strict=True):
            twin.scalars = original.scalars
        set_reactions(twins, there, on_all_nodes(sample.instances, here, Q))
        forces, works = [], []
        for instances, motion in ((sample.instances, here), (twins, there)):
            forces.append(force_on_nodes(instances, motion))
            works.append(energies(instances, motion))
        text = "energy and powers" + sample.in_phase + hint
        np.testing.assert_allclose(works[1][[0, 2, 3]], works[0][[0, 2, 3]], rtol=1e-9, atol=1e-9, err_msg=text)
        expected, actual = forces
        expected[0] = expected[0] @ Q.T
        parts = "forces on the nodes", "moments on the nodes", "equations of the scalars", "size of the constraints"
        for one, other, part in zip(actual, expected, parts, strict=True):
            bound = 1e-9 * (1.0 + np.abs(other).max(initial=0.0))
            text = part + sample.in_phase + hint
            np.testing.assert_allclose(one, other, rtol=1e-9, atol=bound, err_msg=text)


def _inertial_fields(kind):
    """Return a hint at the type of vectors of a kind that may be fixed in a node."""
    names = ", ".join(f"'{field.name}'" for field in kind.fields if field.type == VECTOR)
    if not names or not any(slot[0] == "R" for slot in kind.layout):
        return ""
    return f": {names} is VECTOR, in inertial axes; NODE_VECTOR is a vector in the axes of the node"


def on_all_nodes(instances: Iterable[Instance], motion: Motion, Q: np.ndarray) -> np.ndarray:
    """Return forces, rotated by Q, and moments of the multipliers on all nodes as one vector."""
    held = [instance for instance in instances if instance.kind.multipliers]
    force, moment, _, _ = force_on_nodes(held, motion, 0.0)
    return np.concatenate([force @ Q.T, moment]).ravel()


def set_reactions(instances: Iterable[Instance], motion: Motion, wanted: np.ndarray) -> None:
    """Set multipliers that exert the forces ``wanted``: a rotated model may write its constraints in other axes."""
    held = [instance for instance in instances if instance.kind.multipliers]
    sizes = [len(instance.multipliers) for instance in held]

    def exerted(multipliers):
        for instance, part in zip(held, np.split(multipliers, np.cumsum(sizes)[:-1]), strict=True):
            instance.multipliers = part
        return on_all_nodes(held, motion, np.eye(3))

    if held:
        without = exerted(np.zeros(sum(sizes)))  # a kind with constraints may also exert other forces
        columns = np.array([exerted(unit) - without for unit in np.eye(sum(sizes))]).T
        found = np.linalg.lstsq(columns, wanted - without, rcond=None)[0]
        np.testing.assert_allclose(exerted(found), wanted, rtol=1e-9, atol=1e-9)


def force_on_nodes(instances: Iterable[Instance], motion: Motion, penalty: float = PENALTY) -> list[np.ndarray]:
    """Return forces (n, 3), material moments (n, 3), forces of the scalars, and the norm of all constraint rows.

    The rows themselves may be different combinations of the same constraints in a rotated model.
    """
    force, moment, scalars, size = np.zeros_like(motion.x[:, 0]), np.zeros_like(motion.x[:, 0]), [], 0.0
    for instance in instances:
        if not instance.kind.acts:
            continue
        f = instance.residual(motion.t, instance.local(motion), 1.0, penalty)
        for i, slot in enumerate(instance.kind.layout):
            (force if slot[0] == "x" else moment)[instance.nodes[int(slot[1:])]] += f[3 * i : 3 * i + 3]
        end = len(f) - len(instance.kind.multipliers) - len(instance.kind.coupled_multipliers)
        scalars.append(f[3 * len(instance.kind.layout) : end])
        size += f[end:] @ f[end:]
    return [force, moment, np.concatenate([*scalars, np.zeros(0)]), np.sqrt(size)]


def turned_values(fields: Iterable[Field], values: Values, Q: np.ndarray, shift: np.ndarray) -> Values:
    """Return deck values of these ``fields`` with all inertial quantities rotated by Q and shifted."""
    out = dict(values)
    for field in fields:
        value = values.get(field.name)
        if value is not None and field.type.name == "mapping":
            out[field.name] = turned_values(field.type.options, value, Q, shift)
        if value is not None and field.type in (VECTOR, DIRECTION):
            out[field.name] = Q @ np.asarray(value, float)
        if value is not None and field.type == POINT:
            out[field.name] = Q @ np.asarray(value, float) + shift
        if value is not None and field.type.name == "list" and field.type.options[0] is POINT:
            out[field.name] = [list(Q @ point + shift) for point in value]
        if value is not None and field.type == GROUND:
            out[field.name] = _turned_ground(value, Q, shift)
        if value is not None and field.type.name == "joint":
            out[field.name] = {**value, "axis": Q @ value["axis"]}
        if value is not None and field.type.name == "list" and field.type.options[0].name == "joint":
            out[field.name] = [{**joint, "axis": Q @ joint["axis"]} for joint in value]
        if value is not None and field.type == WHEEL:
            ground = _turned_ground(value["ground"], Q, shift)
            out[field.name] = {**value, "axis": Q @ value["axis"], "ground": ground}
    return out


def _turned_ground(ground, Q, shift):
    plane, profile = ground["plane"], ground.get("profile")
    turned = {"point": Q @ plane["point"] + shift, "normal": Q @ plane["normal"]}
    found = {"plane": turned, "profile": profile and {**profile, "direction": Q @ profile["direction"]}}
    for name in ("friction", "motion"):
        if ground.get(name):
            found[name] = {**ground[name], "direction": Q @ ground[name]["direction"]}
    if ground.get("motion"):
        found["motion"]["centre"] = Q @ ground["motion"]["centre"] + shift
    return found
