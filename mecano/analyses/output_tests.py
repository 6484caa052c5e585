"""Generic tests of the outputs of a kind, and of the signals that measure them; see kind_tests.py."""

from dataclasses import replace

import numpy as np
from scipy.spatial.transform import Rotation

from mecano.analyses.differences import STEP, difference
from mecano.analyses.kind_samples import SENSED, Instance, Local, samples, seed_of
from mecano.constraints.output_sensor import output_sensor
from mecano.element_interface import POWERS, Kind, Output
from mecano.maths.dual import value as number_in

ENERGIES = ("kinetic energy", "potential energy", *POWERS)  # written by ``observe`` after the outputs


def check_output_rates(kind: Kind) -> None:
    """Outputs that are declared as rates are those of the outputs that name them."""
    for sample in samples(kind):
        for instance in sample.instances:
            names = [output.name for output in output_of_numbers(instance.kind)]
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
            is_geometric = [output.geometric for output in output_of_numbers(instance.kind)]
            if any(is_geometric):
                first, second = (instance.observe(sample.motion.t, *where)[0] for where in _alike(instance, sample))
                np.testing.assert_array_equal(first[is_geometric], second[is_geometric])


def _alike(instance, sample):
    """Return two (local state, forces F) that have the same positions, rotations, and scalars."""
    rng, (q, v, a, R) = seed_of("geometric"), instance.local(sample.motion)
    n, n_reactions = len(q), len(instance.multipliers) + sum(len(other.multipliers) for other in instance.coupled)
    changed = q + np.where(np.arange(n) < n - n_reactions, 0.0, rng.normal(size=n))
    return ((q, v, a, R), rng.normal(size=n)), ((changed, *rng.normal(size=(2, n)), R), rng.normal(size=n))


def check_measures(kind: Kind) -> None:
    """Signals that measure outputs and powers have their values, and exact derivatives; hidden ones are declared."""
    for sample in samples(kind):
        for instance in sample.instances:
            names = [output.name for output in output_of_numbers(instance.kind)]
            measured = [i for i, name in enumerate(names) if name not in instance.kind.hidden]
            if instance.kind.observe:
                measured += [len(names) + i for name, i in POWERS.items() if name not in kind.hidden]
            if measured and not instance.kind.of_signals:
                _check_sensors(instance, sample.motion, measured, [*names, *ENERGIES])


def _check_sensors(instance, motion, measured, names):
    """Compare sensors with ``observe``, and their slopes along a random direction with differences."""
    t, state = motion.t, instance.local(motion)
    n, unknown = len(state[0]), np.full(3 * len(instance.kind.layout), np.nan)  # the forces F
    rates = n - len(instance.multipliers) - sum(len(other.multipliers) for other in instance.coupled)
    direction = seed_of("direction").normal(size=(2, n))
    direction[1, rates:] = 0.0

    def outputs(h):
        return np.concatenate(instance.observe(t, moved_along(instance, state, h * direction), unknown))

    values, slopes = outputs(0.0), difference(outputs, STEP)
    largest = np.abs(values[measured]).max()
    rounding = max(1e-8, 16 * np.finfo(float).eps / STEP * largest)  # an output may be a vanishing sum of others
    for i in measured:
        residual = sensor_of(instance, i).along(t, state, direction)
        assert np.isfinite(values[i]), f"{names[i]} depends on F, and is not hidden"
        assert not any(x.value or x.slope for x in residual[:-1]), names[i]
        np.testing.assert_allclose(number_in(residual[-1]), SENSED - values[i], rtol=1e-12, err_msg=names[i])
        np.testing.assert_allclose(-residual[-1].slope, slopes[i], rtol=1e-6, atol=rounding, err_msg=names[i])


def output_of_numbers(kind: Kind) -> list[Output]:
    """Return, for each number that ``observe`` writes, the output to which it belongs."""
    return [output for output in kind.outputs for _ in range(output.size)]


def sensor_of(instance: Instance, index: int) -> Instance:
    """Return the sensor of output ``index`` of an instance; its energies follow its outputs."""
    coupled = [instance, *instance.coupled]
    kind = output_sensor(instance.kind, sum(len(other.multipliers) for other in coupled))
    p = np.zeros(1, kind.dtype)
    for name in instance.p.dtype.names or ():
        p[name] = instance.p[name]
    p["sensed"] = index
    return replace(instance, kind=kind, p=p)


def moved_along(instance: Instance, state: Local, by: np.ndarray) -> Local:
    """Return the local ``state`` displaced by ``by`` (2, n) in q and v, rotations materially."""
    q, v, a, R = state
    turns = [Rotation.from_rotvec(by[0, c : c + 3]).as_matrix() for c in instance.rotation_columns()]
    angles = np.zeros(len(q), bool)
    for c in instance.rotation_columns():
        angles[c : c + 3] = True
    turned = np.array([R_r @ turn for R_r, turn in zip(R, turns, strict=True)]).reshape(R.shape)
    return q + np.where(angles, 0.0, by[0]), v + by[1], a, turned
