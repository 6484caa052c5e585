r"""Joint friction that a shock neglects.

A shock has no impulse of the friction of joints: the reactions of a joint change by impulses :math:`\Lambda`, and its
friction, :math:`f(\Lambda, v)`, would have the impulse :math:`f(\Lambda, v^+)`, which brakes the joint. It is computed
here, for a warning, from the outputs of the element with impulses in place of reactions.
"""

from typing import TYPE_CHECKING

import numpy as np

from mecano.element_interface import Output

if TYPE_CHECKING:
    from mecano.model.system import System
    from mecano.solve.events.shocks import Shock

FRICTION = "friction_"  # start of the names of outputs that are the force or moment of friction
NOTED = 1e-6  # of the largest impulse of the shock: smaller ones are rounding errors


def missing_friction(system: "System", shock: "Shock") -> list[tuple[str, float, str]]:
    """Return the impulses of friction that a ``shock`` neglects, as (title of the joint, impulse, unit), sorted."""
    if not len(system.coupled_multipliers):
        return []
    s, n_q, found = shock.state.copy(), system.n_q, []
    s.z[n_q : system.n] = shock.impulses
    outputs, least = system.observe(s).outputs, NOTED * np.abs(shock.impulses).max(initial=0.0)
    for batch in system.batches:
        if not batch.kind.coupled_multipliers or batch.kind.impact_friction is not None:
            continue
        at = [i for i, output in enumerate(batch.kind.outputs) if _is_friction(output)]
        for title, row in zip(batch.names, np.abs(batch.outputs(outputs)), strict=True):
            found += [(title, float(row[i]), f"{batch.kind.outputs[i].unit} s") for i in at if row[i] > least]
    return sorted(found, key=lambda one: -one[1])


def _is_friction(output: Output):
    """Return whether a scalar output is a force or moment of friction."""
    return output.name.startswith(FRICTION) and not output.shape


def omission_warning(t: float, shock: "Shock", title: str, impulse: float, unit: str) -> str:
    """Return the warning on the friction of a joint that a ``shock`` at ``t`` [s] is the first to neglect."""
    event = max(shock.event_records, key=lambda one: abs(one.impulse))
    return (
        f"the friction of {title} has no impulse in shocks: at t = {t:.4g} s ({event.element} {event.name}, "
        f"{event.impulse:.3g} {event.unit}) the impulses of its reactions would brake it by {impulse:.3g} {unit}; "
        "where this matters, give the contact or stop a law, so that the shock takes time"
    )
