"""Generic tests of the constraints of a kind and of the rows of their multipliers; see kind_tests.py."""

import numpy as np

from mecano.analyses.differences import difference
from mecano.analyses.kind_samples import K_SCALE, Instance, elements
from mecano.element_interface import Kind

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
        assert let_go or np.all(rate != 0.0), f"a constraint has no rate{sample.in_phase}"
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
