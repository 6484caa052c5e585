"""Generic test of the power identity of a kind; see kind_tests.py."""

from collections.abc import Iterable

import numpy as np

from mecano.analyses.differences import difference
from mecano.analyses.kind_samples import Instance, Motion, samples
from mecano.element_interface import Kind


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
            terms[of_states] = 0.0  # their equations are not forces
            if instance.kind.of_signals:
                continue  # signals are not coordinates
            power += terms.sum() + instance.multipliers @ instance.constraint_derivatives(motion.t, state)[:, 1]
            size += np.abs(terms).sum()
        size += abs(kinetic) + abs(potential)
        rate = float(difference(energy, 1e-3))
        assert abs(power - rate) <= 1e-8 * size, (
            f"f.v = {power + dissipated - given:.6g} W, but d(T + V)/dt = {rate:.6g} W, dissipated = e[2] = "
            f"{dissipated:.6g} W, given = e[3] = {given:.6g} W{sample.in_phase}"
        )
        if dissipated < -1e-12 * size:
            leaves = any(leaves_at_once(instance, motion) for instance in sample.instances)
            assert leaves, f"dissipated = e[2] = {dissipated:.6g} W < 0{sample.in_phase}"


def energies(instances: Iterable[Instance], motion: Motion, h: float = 0.0) -> np.ndarray:
    """Return energies and powers (4,) of an element and its parts, h seconds later."""
    later, total = motion.after(h), np.zeros(4)
    for instance in instances:
        F = np.zeros(3 * len(instance.kind.layout))
        total += instance.observe(later.t, instance.after(h).local(later), F)[1]
    return total


def leaves_at_once(instance: Instance, motion: Motion) -> bool:
    """Return whether an event of an instance leads out of its phase at this motion."""
    events = instance.kind.events
    if instance.kind.event_values is None:
        return False
    values = instance.written("event_values", len(events), motion.t, instance.local(motion))
    phase = instance.kind.phases[instance.phase]
    return any(event.before == phase and value > 0.0 for event, value in zip(events, values, strict=True))
