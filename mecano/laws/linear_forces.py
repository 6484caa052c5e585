"""Linear force terms: spring, damper, preload."""

from mecano.laws.polynomial import polynomial, polynomial_integral
from mecano.laws.term import Term, of_extension, of_rate
from mecano.schema import NUMBER, Field, not_negative

ELASTIC, VISCOUS = of_extension(polynomial), of_rate(polynomial)

SPRING = Term(
    name="spring",
    doc="F = stiffness s. For a nonlinear spring write 'polynomial' or 'table': they act on the extension.",
    role="force",
    fields=(Field("stiffness", NUMBER, "N/m or N m/rad", "force per extension"),),
    pack=lambda values: [2, 0.0, values["stiffness"]],
    evaluate=ELASTIC, integral=polynomial_integral,
)  # fmt: skip

DAMPER = Term(
    name="damper", doc="F = coefficient v.", role="force",
    fields=(Field("coefficient", NUMBER, "N s/m or N m s/rad", "force per rate", check=not_negative),),
    pack=lambda values: [2, 0.0, values["coefficient"]],
    evaluate=VISCOUS,
)  # fmt: skip

PRELOAD = Term(
    name="preload", doc="F = force, for any extension.", role="force",
    fields=(Field("force", NUMBER, "N or N m", "the force; > 0 pulls the two ends together"),),
    pack=lambda values: [1, values["force"]],
    evaluate=ELASTIC, integral=polynomial_integral,
)  # fmt: skip
