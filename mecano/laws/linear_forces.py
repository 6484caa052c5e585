"""Linear force terms: spring, damper, preload."""

from mecano.jit.kernel import kernel
from mecano.laws.term import Term
from mecano.schema import NUMBER, Field, not_negative


@kernel
def spring(a, i, s, v):
    """Return stiffness times extension, and the derivatives."""
    return a[i] * s, a[i], 0.0


@kernel
def spring_energy(a, i, s):
    """Return half the stiffness times the extension squared."""
    return 0.5 * a[i] * s * s


@kernel
def damper(a, i, s, v):
    """Return coefficient times rate, and the derivatives."""
    return a[i] * v, 0.0, a[i]


@kernel
def preload(a, i, s, v):
    """Return the constant force."""
    return a[i], 0.0, 0.0


@kernel
def preload_energy(a, i, s):
    """Return the force times the extension."""
    return a[i] * s


SPRING = Term(
    name="spring",
    doc="F = stiffness s. For a nonlinear spring write 'polynomial' or 'table': they act on the extension.",
    role="force",
    fields=(Field("stiffness", NUMBER, "N/m or N m/rad", "force per extension"),),
    evaluate=spring,
    integral=spring_energy,
)

DAMPER = Term(
    name="damper",
    doc="F = coefficient v.",
    role="force",
    fields=(Field("coefficient", NUMBER, "N s/m or N m s/rad", "force per rate", check=not_negative),),
    evaluate=damper,
)

PRELOAD = Term(
    name="preload",
    doc="F = force, for any extension.",
    role="force",
    fields=(Field("force", NUMBER, "N or N m", "the force; > 0 pulls the two ends together"),),
    evaluate=preload,
    integral=preload_energy,
)
