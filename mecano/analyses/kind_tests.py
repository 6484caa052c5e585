"""Generic tests of a kind of element, joint, load or basic constraint: functions that raise AssertionError.

Each takes a Kind and evaluates it in the states of its samples, as plain Python. tests/test_elements.py calls them for
all kinds of mecano, `mecano check-kind` for those of a plugin, which prints the first lines of their docstrings.
"""

import numpy as np

from mecano.analyses.constraint_tests import check_constraint_derivatives, check_multiplier_rows
from mecano.analyses.declaration_tests import check_declarations, check_outputs_of_parts, check_samples
from mecano.analyses.invariance_tests import check_invariance
from mecano.analyses.kind_samples import K_SCALE, PENALTY, elements, samples, seed_of
from mecano.analyses.output_tests import check_geometric_outputs, check_measures, check_output_rates
from mecano.analyses.power_tests import check_power
from mecano.analyses.tangent_tests import check_tangents
from mecano.element_interface import Kind


def check_force(kind: Kind) -> None:
    """The force is not zero everywhere."""
    found = elements(kind)
    for of in {id(i.kind): i.kind for _, i in found}.values():
        assert any(_exerts_or_resists(i, s.motion) for s, i in found if i.kind is of)


def _exerts_or_resists(instance, motion):
    """Return whether the force, or a tangent, which takes longer, is not zero for reactions of one of both signs."""
    q, *others = instance.local(motion)
    opposite = np.concatenate([q[: instance.kind.first_reaction], -q[instance.kind.first_reaction :]])
    places = [(motion.t, (reactions, *others), 1.0, 1.0) for reactions in (q, opposite)]
    return any(np.any(instance.residual(*at)) or any(map(np.any, instance.force(*at))) for at in places)


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
                assert first.tobytes() == second.tobytes(), f"a second call has another result{sample.in_phase}"
                assert np.all(np.isfinite(first)), f"a result is not finite{sample.in_phase}"
            for array, old in zip(inputs, before, strict=True):
                assert array.tobytes() == old.tobytes(), f"an argument has been changed{sample.in_phase}"


OF_EVERY_KIND = (
    check_declarations, check_samples, check_force, check_tangents, check_power, check_purity,
    check_constraint_derivatives, check_multiplier_rows, check_output_rates, check_geometric_outputs,
    check_outputs_of_parts, check_measures,
)  # fmt: skip
OF_DECK_KINDS = (*OF_EVERY_KIND, check_invariance)
