"""Generic tests of a kind of element, joint, load or basic constraint: functions that raise AssertionError.

Each takes a Kind and evaluates it in the states of its samples, as plain Python. tests/test_elements.py calls them for
all kinds of mecano, `mecano check-kind` for those of a plugin, which prints the first lines of their docstrings.
"""

from collections.abc import Callable, Iterable

import numpy as np
from scipy.spatial.transform import Rotation

from mecano.analyses.declaration_tests import check_declarations, check_outputs_of_parts, check_samples
from mecano.analyses.kind_trial import (
    GRAVITY,
    SENSED,
    Instance,
    Local,
    Motion,
    Sample,
    expand,
    moved_along,
    samples,
    seed_of,
    sensor_of,
    turned_values,
)
from mecano.element_interface import Kind
from mecano.maths.dual import value as number_in

K_SCALE, PENALTY = 1.7, 2.3  # k and penalty of the constraints
STEP = 1e-4  # of differences


def difference(function: Callable[[float], np.ndarray | float], h: float) -> np.ndarray:
    """Return the central difference of fourth order of function(step) at 0."""
    return (4.0 * simple_difference(function, h) - simple_difference(function, 2.0 * h)) / 3.0


def simple_difference(function: Callable[[float], np.ndarray | float], h: float) -> np.ndarray:
    """Return the central difference of second order of function(step) at 0."""
    return (np.asarray(function(h)) - np.asarray(function(-h))) / (2.0 * h)


def elements(kind: Kind) -> list[tuple[Sample, Instance]]:
    """Return [(sample, instance)] of all instances with a force in the samples of a kind."""
    return [(s, i) for s in samples(kind) for i in s.instances if i.kind.acts]


def displaced(instance: Instance, state: Local, column: int, h: float, array: int) -> Local:
    """Return the local state with one unknown of q, v or a (``array`` 0, 1, 2) displaced, rotations materially."""
    q, v, a, R = (part.copy() for part in state)
    slot = column // 3
    layout = instance.kind.layout
    if array == 0 and slot < len(layout) and layout[slot][0] == "R":
        r = sum(name[0] == "R" for name in layout[:slot])
        increment = np.zeros(3)
        increment[column % 3] = h
        R[r] = R[r] @ Rotation.from_rotvec(increment).as_matrix()
    else:
        (q, v, a)[array][column] += h
    return q, v, a, R


def close(actual: np.ndarray, expected: np.ndarray, rtol: float, **labels: str) -> None:
    """Compare row by row, as the rows of a tangent have different units and magnitudes."""
    error = _excess(actual, expected, rtol)
    worst = np.unravel_index(np.argmax(error), error.shape)
    assert np.all(error <= 0.0), f"{labels} {worst}: {actual[worst]} instead of {expected[worst]}"


def _excess(actual, expected, rtol):
    """Return by how much each difference is larger than it may be; negative where they are close."""
    size = np.abs(expected).max(axis=-1, keepdims=True)
    return np.abs(actual - expected) - rtol * np.maximum(size, 1e-6 * size.max(initial=0.0)) - 1e-9


def slope(
    instance: Instance, t: float, state: Local, array: int, column: int, by: Callable[..., np.ndarray] = difference
) -> np.ndarray:
    """Return df/dq, df/dv or df/da for one unknown, (n_local,), ``by`` one of the differences above.

    Forces are affine in the accelerations, for which that of second order is exact.
    """

    def force(h):
        return instance.residual(t, displaced(instance, state, column, h, array), K_SCALE, PENALTY)

    return (simple_difference if array == 2 else by)(force, STEP)


def check_tangents(kind: Kind) -> None:
    """Tangents are the derivatives of the force, which is the same where it is computed alone.

    Differences of second order are close enough for most; elsewhere the fourth order decides.
    """
    for sample, instance in elements(kind):
        t, state = sample.motion.t, instance.local(sample.motion)
        f, *tangents = instance.force(t, state, K_SCALE, PENALTY)
        np.testing.assert_array_equal(instance.residual(t, state, K_SCALE, PENALTY), f)
        n = instance.kind.n_local
        end = n - len(instance.kind.multipliers) - len(instance.kind.coupled_multipliers)
        for array, tangent in enumerate(tangents):
            expected = np.zeros((n, n))
            for by in (simple_difference, difference):
                for column in range(n if array == 0 else end):
                    expected[:, column] = slope(instance, t, state, array, column, by)
                expected[:, end:] *= K_SCALE  # the multiplier in q is k lambda, that of the tangent lambda
                if np.all(_excess(tangent, expected, 1e-7) <= 0.0):
                    break
            close(tangent, expected, 1e-7, phase=sample.phase, of=instance.kind.name, tangent="KCM"[array])
        if instance.kind.residual is not None:
            masses, own = instance.inertia(t, state), np.diag(tangents[2])
            np.testing.assert_allclose(masses, own, 1e-12, err_msg="'inertia' must write the diagonal of the masses")


def check_force(kind: Kind) -> None:
    """The force is not zero everywhere."""
    found = elements(kind)
    for of in {id(i.kind): i.kind for _, i in found}.values():
        assert any(_exerts_or_resists(i, s.motion) for s, i in found if i.kind is of)


def _exerts_or_resists(instance, motion):
    """Return whether the force, or one of its tangents, which take longer, is not zero."""
    at = motion.t, instance.local(motion), 1.0, 1.0
    return np.any(instance.residual(*at)) or any(map(np.any, instance.force(*at)))


def check_purity(kind: Kind) -> None:
    """Functions depend on their arguments only, are finite and have no side effects."""
    for sample in samples(kind):
        for instance in sample.instances:
            t, state = sample.motion.t, instance.local(sample.motion)
            F = seed_of("F").normal(size=3 * len(instance.kind.layout))
            inputs = (*state, F, instance.p, instance.memory, instance.laws)
            before = [array.copy() for array in inputs]

            def results(i=instance, t=t, state=state, F=F):
                """Return all that the functions of the instance write."""
                found = [i.constraint_derivatives(t, state), *i.observe(t, state, F)]
                if i.kind.residual is not None:  # check_tangents evaluates it with Duals, many times
                    found.append(i.residual(t, state, K_SCALE, PENALTY))
                elif i.kind.acts:
                    found += i.force(t, state, K_SCALE, PENALTY)
                for name, size in (("event_values", len(i.kind.events)), ("commit", len(i.kind.memory))):
                    if getattr(i.kind, name) is not None:
                        found.append(i.written(name, size, t, state))
                return found

            for first, second in zip(results(), results(), strict=True):
                assert first.tobytes() == second.tobytes(), f"a second call has another result{_in_phase(sample)}"
                assert np.all(np.isfinite(first)), f"a result is not finite{_in_phase(sample)}"
            for array, old in zip(inputs, before, strict=True):
                assert array.tobytes() == old.tobytes(), f"an argument has been changed{_in_phase(sample)}"


FREE = {  # phases in which constraints do not hold
    "air", "open", "released", "inactive", "overlapping", "free", "between", "slack", "taut", "relaxing", "paying out",
}  # fmt: skip


def is_inactive(instance: Instance) -> bool:
    """Return whether the constraints are inactive in the phase of an instance."""
    return instance.kind.phases[instance.phase] in FREE


def check_constraint_derivatives(kind: Kind) -> None:
    """Rates of constraints are their time derivatives."""
    for sample, instance in elements(kind):
        if not instance.kind.multipliers:
            continue

        def constraint_derivatives(h, sample=sample, instance=instance):
            later = sample.motion.after(h)
            return instance.constraint_derivatives(later.t, instance.after(h).local(later))

        rates = difference(constraint_derivatives, 1e-4)
        value, rate, second = constraint_derivatives(0.0).T
        position = value != 0.0  # a constraint on velocities has no value, its rate is the constraint
        np.testing.assert_allclose(rate[position], rates[position, 0], rtol=1e-7, atol=1e-8)
        np.testing.assert_allclose(second, rates[:, 1], rtol=1e-7, atol=1e-8)
        let_go = not np.any((value, rate, second))
        assert let_go == is_inactive(instance), (
            f"the constraints are {'' if let_go else 'not '}zero in the phase '{sample.phase}'; they are in the phases "
            f"with these names, and no others: {', '.join(sorted(FREE))}"
        )
        assert let_go or np.all(rate != 0.0), f"a constraint has no rate{_in_phase(sample)}"
        _, v, a, _ = state = instance.local(sample.motion)
        np.testing.assert_array_equal(
            instance.constraint_derivatives(sample.motion.t, (state[0], v, 0.0 * a, state[3]))[:, 1], rate
        )


def check_multiplier_rows(kind: Kind) -> None:
    """Rows of multipliers are the constraints."""
    for sample, instance in elements(kind):
        n = len(instance.kind.multipliers)
        if n == 0:
            continue
        t, state = sample.motion.t, instance.local(sample.motion)
        value, rate, _ = instance.constraint_derivatives(t, state).T
        f = instance.residual(t, state, K_SCALE, 0.0)
        held = -K_SCALE * np.where(value != 0.0, value, rate)
        expected = -instance.multipliers if is_inactive(instance) else held
        np.testing.assert_allclose(f[-n:], expected, rtol=1e-12, atol=1e-14)


def energies(instances: Iterable[Instance], motion: Motion, h: float = 0.0) -> np.ndarray:
    """Return energies and powers (4,) of an element and its parts, h seconds later."""
    later, total = motion.after(h), np.zeros(4)
    for instance in instances:
        F = np.zeros(3 * len(instance.kind.layout))
        total += instance.observe(later.t, instance.after(h).local(later), F)[1]
    return total


def check_power(kind: Kind) -> None:
    """The power of the forces is the change of energy, f.v = d(T + V)/dt + dissipated - given; dissipated >= 0.

    Less (k lambda) dPhi/dt, which vanishes on the constraints. Where an event is due the sign is not tested.
    """
    for sample in samples(kind):
        motion = sample.motion

        def energy(h, sample=sample):
            return energies(sample.instances, sample.motion, h)[:2].sum()

        kinetic, potential, dissipated, given = energies(sample.instances, motion)
        power, size = -dissipated + given, 1.0
        for instance in sample.instances:
            if not instance.kind.acts:
                continue
            state, n = instance.local(motion), len(instance.kind.multipliers)
            f = instance.residual(motion.t, state)
            terms = (f * state[1])[: len(f) - n]
            of_states = [3 * len(instance.kind.layout) + instance.kind.scalars.index(x) for x in instance.kind.states]
            terms[of_states] = 0.0  # their equations are no forces
            if instance.kind.of_signals:
                continue  # signals are no coordinates
            power += terms.sum() + instance.multipliers @ instance.constraint_derivatives(motion.t, state)[:, 1]
            size += np.abs(terms).sum()
        size += abs(kinetic) + abs(potential)
        rate = float(difference(energy, 1e-3))
        assert abs(power - rate) <= 1e-8 * size, (
            f"f.v = {power + dissipated - given:.6g} W, but d(T + V)/dt = {rate:.6g} W, dissipated = e[2] = "
            f"{dissipated:.6g} W, given = e[3] = {given:.6g} W{_in_phase(sample)}"
        )
        if dissipated < -1e-12 * size:
            leaves = any(leaves_at_once(instance, motion) for instance in sample.instances)
            assert leaves, f"dissipated = e[2] = {dissipated:.6g} W < 0{_in_phase(sample)}"


def _in_phase(sample):
    """Return the phase of a sample as the end of a text; "" for a kind without phases."""
    return f", in the phase '{sample.phase}'" if sample.phase else ""


def leaves_at_once(instance: Instance, motion: Motion) -> bool:
    """Return whether an event of an instance leads out of its phase at this motion."""
    events = instance.kind.events
    if instance.kind.event_values is None:
        return False
    values = instance.written("event_values", len(events), motion.t, instance.local(motion))
    phase = instance.kind.phases[instance.phase]
    return any(event.before == phase and value > 0.0 for event, value in zip(events, values, strict=True))


def check_output_rates(kind: Kind) -> None:
    """Outputs that are declared as rates are those of the outputs that name them."""
    for sample in samples(kind):
        for instance in sample.instances:
            names = [
                output.name for output in instance.kind.outputs for _ in range(int(np.prod(output.shape, dtype=int)))
            ]
            starts = {name: names.index(name) for name in names}
            for output in instance.kind.outputs:
                if output.rate:
                    _check_rate(sample, instance, starts[output.name], starts[output.rate], names.count(output.name))


def _check_rate(sample, instance, first, rate, size):
    def outputs(h):
        later = sample.motion.after(h)
        return instance.observe(later.t, instance.after(h).local(later), np.zeros(3 * len(instance.kind.layout)))[0]

    found = difference(lambda h: outputs(h)[first : first + size], 1e-4)
    np.testing.assert_allclose(outputs(0.0)[rate : rate + size], found, rtol=1e-7, atol=1e-7)


def check_geometric_outputs(kind: Kind) -> None:
    """Outputs that are declared as geometric do not change with velocities, accelerations, reactions and forces."""
    for sample in samples(kind):
        for instance in sample.instances:
            is_geometric = [o.geometric for o in instance.kind.outputs for _ in range(int(np.prod(o.shape, dtype=int)))]
            if any(is_geometric):
                first, second = (instance.observe(sample.motion.t, *where)[0] for where in _alike(instance, sample))
                np.testing.assert_array_equal(first[is_geometric], second[is_geometric])


def _alike(instance, sample):
    """Return two (local state, forces F) that have the same positions, rotations, and scalars."""
    rng, (q, v, a, R) = seed_of("geometric"), instance.local(sample.motion)
    n, n_reactions = len(q), len(instance.multipliers) + sum(len(other.multipliers) for other in instance.coupled)
    changed = q + np.where(np.arange(n) < n - n_reactions, 0.0, rng.normal(size=n))
    return ((q, v, a, R), rng.normal(size=n)), ((changed, *rng.normal(size=(2, n)), R), rng.normal(size=n))


def check_invariance(kind: Kind) -> None:
    """Forces rotate with the whole model, energies do not change."""
    rng = seed_of("turn")
    Q, shift = Rotation.random(None, rng).as_matrix(), rng.normal(size=3)
    for sample in samples(kind):
        values = turned_values(kind, sample.values, Q, shift)
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
        np.testing.assert_allclose(works[1][[0, 2, 3]], works[0][[0, 2, 3]], rtol=1e-9, atol=1e-9)
        expected, actual = forces
        expected[0] = expected[0] @ Q.T
        parts = "forces on the nodes", "moments on the nodes", "equations of the scalars", "size of the constraints"
        for one, other, part in zip(actual, expected, parts, strict=True):
            bound = 1e-9 * (1.0 + np.abs(other).max(initial=0.0))
            np.testing.assert_allclose(one, other, rtol=1e-9, atol=bound, err_msg=part + _in_phase(sample))


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
        without = exerted(np.zeros(sum(sizes)))  # a kind with constraints may exert forces besides
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


def check_measures(kind: Kind) -> None:
    """Signals that measure outputs have their values, and exact derivatives; hidden outputs are declared."""
    for sample in samples(kind):
        for instance in sample.instances:
            outputs = [o for o in instance.kind.outputs for _ in range(int(np.prod(o.shape, dtype=int)))]
            measured = [i for i, output in enumerate(outputs) if output.name not in instance.kind.hidden]
            if measured and not instance.kind.of_signals:
                _check_sensors(instance, sample.motion, measured, [output.name for output in outputs])


def _check_sensors(instance, motion, measured, names):
    """Compare sensors with ``observe``, and their slopes along a random direction with differences."""
    t, state = motion.t, instance.local(motion)
    n, unknown = len(state[0]), np.full(3 * len(instance.kind.layout), np.nan)  # the forces F
    rates = n - len(instance.multipliers) - sum(len(other.multipliers) for other in instance.coupled)
    direction = seed_of("direction").normal(size=(2, n))
    direction[1, rates:] = 0.0

    def outputs(h):
        return instance.observe(t, moved_along(instance, state, h * direction), unknown)[0]

    values, slopes = outputs(0.0), difference(outputs, STEP)
    rounding = max(
        1e-8, 16 * np.finfo(float).eps / STEP * np.abs(values[measured]).max()
    )  # of vanishing sums of others
    for i in measured:
        residual = sensor_of(instance, i).along(t, state, direction)
        assert np.isfinite(values[i]), f"{names[i]} depends on F, and is not hidden"
        assert not any(x.value or x.slope for x in residual[:-1]), names[i]
        np.testing.assert_allclose(number_in(residual[-1]), SENSED - values[i], rtol=1e-12, err_msg=names[i])
        np.testing.assert_allclose(-residual[-1].slope, slopes[i], rtol=1e-6, atol=rounding, err_msg=names[i])


OF_EVERY_KIND = (
    check_declarations, check_samples, check_force, check_tangents, check_power, check_purity,
    check_constraint_derivatives, check_multiplier_rows, check_output_rates, check_geometric_outputs,
    check_outputs_of_parts, check_measures,
)  # fmt: skip
OF_DECK_KINDS = (*OF_EVERY_KIND, check_invariance)
