r"""Flexible wheel with a patch that does not slip at any force: the limit of ``flexible_wheel`` without creep.

The unknowns y and psi, the forces and the tyre law (47)-(51) are the same, but the two components of the patch velocity
v_C vanish as constraints on velocities (Cardona, Geradin and Doan, CMAME 89 (1991), section 3.4):

    v_C.t = 0,   v_C.l = 0          reactions: the driving and the lateral force on the wheel

The friction law of the tyre is not used; the friction coefficient that would be needed is an output. In the phase
"air" the constraints are inactive. At touch-down the wheel spins up instantaneously: the velocities jump to the nearest
ones, in the norm of the kinetic energy, that do not slip. The impulse of this shock is that of the driving force, and
its energy is lost (docs/shocks.md). There is no lateral shock, since y has no inertia.
"""

from dataclasses import replace

from mecano.constraints.rolling import ROWS
from mecano.constraints.tire_patch import FLAT_PATCH, ROUND_PATCH
from mecano.element_interface import GRIP, Event, named
from mecano.elements.wheels.crown import crown_of, with_crown
from mecano.elements.wheels.lateral_law import relax
from mecano.elements.wheels.patch_wheel import (
    PatchFriction,
    add_load,
    check,
    load_of,
    patch_wheel,
    put_patch,
    sample,
    with_round_tread,
)
from mecano.elements.wheels.rolling_tyre import FIELDS as ROLLING_FIELDS
from mecano.elements.wheels.tire_wheel import AIR, LIFT_OFF
from mecano.jit.kernel import kernel
from mecano.maths.surface import directions
from mecano.maths.vector import dot

MULTIPLIERS = 9  # driving, lateral


def compiled(patch):
    """Return ``residual``, ``constraints`` and ``observe`` of a wheel whose ``patch`` is that of its tread."""

    @kernel
    def residual(p, at, f):
        """Add the forces of ground and tyre law, and the constraints; see element_interface."""
        if at.phase == AIR:
            relax(p, at, f)
            for row in range(MULTIPLIERS, MULTIPLIERS + 2):
                f[row] -= at.q[row]
            return
        k = patch(p, at)
        t, l = directions(k.a, k.g)
        along, across = dot(t, k.v_C), dot(l, k.v_C)
        f[MULTIPLIERS] -= at.k * along
        f[MULTIPLIERS + 1] -= at.k * across
        driving, lateral = at.penalty * along - at.q[MULTIPLIERS], at.penalty * across - at.q[MULTIPLIERS + 1]
        add_load(f, at, k, load_of(p, at, k), driving * t + lateral * l)

    @kernel
    def constraints(p, at, g):
        """Write the velocity of the patch along t and l."""
        if at.phase == AIR:
            return
        k = patch(p, at)
        t, l = directions(k.a, k.g)
        g[0, 1], g[1, 1] = dot(t, k.v_C), dot(l, k.v_C)

    @kernel
    def observe(p, at, F, y, e):
        """Write outputs and energies; see OUTPUTS and element_interface."""
        k = patch(p, at)
        load = load_of(p, at, k)
        t, l = directions(k.a, k.g)
        reaction = at.q[MULTIPLIERS] * t + at.q[MULTIPLIERS + 1] * l
        put_patch(p, at, k, load, PatchFriction(k.v_C, reaction, 0.0), y, e)

    return named(residual, observe, constraints)


def check_adhesive(d, nodes):
    """Return errors of any wheel with a patch, and for values that only a slipping wheel has."""
    given = [field.name for field in ROLLING_FIELDS if d["tire_law"].get(field.name) is not None]
    return [f"'tire_law.{name}' is not available for an adhesive_wheel" for name in given] + check(d, nodes)


def samples(rng):
    """Return samples of any wheel with a patch, and some with a rounded tread."""
    found = sample(rng)
    return [*found, *map(with_crown, (found[1], found[2]))]


ADHESIVE_WHEEL = replace(
    patch_wheel(
        "adhesive_wheel", __doc__, ("psi", "bow"),
        events=(
            Event("touch_down", "air", "contact", "the undeformed rim reaches the ground; a shock", GRIP, brief=True),
            LIFT_OFF,
        ),
        multipliers=ROWS,
        **compiled(FLAT_PATCH),
    ),
    check=check_adhesive,
    variant=lambda d: ROUND if crown_of(d) else ADHESIVE_WHEEL,
    sample=samples,
)  # fmt: skip
ROUND = with_round_tread(ADHESIVE_WHEEL, name="adhesive_wheel_crowned", **compiled(ROUND_PATCH))
