"""Plans of the standard plots: outputs shown for each kind of element, joint and load.

A kind without a plan gets a sheet of its own with all its outputs.
"""

from dataclasses import dataclass

from mecano.elements import KINDS

ON_GROUND = ("longitudinal_slip", "lateral_slip", "rolling_rate")  # meaningful only while a wheel is on the ground


@dataclass(frozen=True)
class View:
    """One panel of every sheet: outputs of each element over the time or over another output.

    Outputs are written as in ``--plot`` without the element; "node.position.x" is an output of the element's node.
    Outputs that an element does not have are left out; of "one|other" the first existing one is used.
    """

    label: str
    outputs: tuple
    against: str = "time"
    reference: str = ""  # output shown for comparison


@dataclass(frozen=True)
class Plan:
    """A sheet for all elements of some kinds, views by importance; the first ``lead`` views are equally important."""

    name: str
    heading: str
    kinds: tuple
    views: tuple
    lead: int = 1


WHEELS = Plan(
    "wheels", "Wheels", ("wheel", "flexible_wheel", "adhesive_wheel", "rigid_wheel", "paper_wheel", "skate"),
    (
        View("height of the centre", ("height",)),
        View("radial force", ("radial_force|normal_force",)),
        View("spin rate", ("spin_rate",), reference="rolling_rate"),
        View("slip velocity", ("longitudinal_slip", "lateral_slip")),
        View("radial deformation", ("deformation",)),
        View("force in the ground", ("longitudinal_force", "lateral_force")),
        View("lateral displacement of the patch", ("y",)),
        View("torsion of the patch", ("psi",)),
    ),
    lead=4,
)  # fmt: skip
BEAMS = Plan(
    "beams", "Beams", ("beam",),
    (
        View("equivalent stress", ("stress",)),
        View("axial force", ("force.x",)),
        View("shear force", ("force.y", "force.z")),
        View("torque", ("moment.x",)),
        View("bending moment at the start", ("moment_start.y", "moment_start.z")),
    ),
)  # fmt: skip
STRUTS = Plan(
    "struts", "Springs and struts", ("spring_damper",),
    (
        View("compression force", ("compression_force",), against="stroke"),
        View("stroke", ("stroke",)),
        View("compression force", ("compression_force",)),
        View("rate of extension", ("rate",)),
    ),
    lead=2,
)  # fmt: skip
TORSION_SPRINGS = Plan(
    "torsion_springs", "Torsion springs", ("torsion_spring_damper",),
    (
        View("moment", ("moment",), against="angle"),
        View("angle", ("angle",)),
        View("moment", ("moment",)),
        View("rate", ("rate",)),
    ),
)  # fmt: skip
ANGLES = Plan(
    "angles", "Angles of joints", ("hinge", "universal", "cylindrical", "prescribed_angle"),
    (View("angle", ("angle", "angle_a", "angle_b")), View("angular velocity", ("rate", "rate_a", "rate_b"))),
    lead=2,
)  # fmt: skip
SLIDES = Plan(
    "slides", "Displacements of joints", ("prismatic", "cylindrical", "prescribed_position"),
    (View("displacement", ("displacement",)), View("velocity", ("velocity",))),
)  # fmt: skip
GEARS = Plan(
    "gears", "Gears, racks, screws", ("gear_pair", "rack_and_pinion", "screw"),
    (
        View("angle", ("angle", "angle_a", "angle_b")),
        View("angular velocity", ("rate", "rate_a", "rate_b")),
        View("displacement", ("displacement",)),
        View("force", ("force.magnitude",)),
    ),
)  # fmt: skip
PLANES = Plan(
    "planes", "Sliding in planes", ("planar",),
    (
        View("displacement along mu_2", ("displacement.y",), against="displacement.x"),
        View("displacement", ("displacement.x", "displacement.y")),
        View("velocity", ("velocity.x", "velocity.y")),
        View("angle", ("angle",)),
    ),
)  # fmt: skip
CURVES = Plan(
    "curves", "Points on curves and beams", ("point_on_curve", "slider_on_beam"),
    (
        View("place on the curve", ("position",)),
        View("normal force", ("normal_force",)),
        View("speed along the curve", ("speed",)),
        View("pressure angle", ("pressure_angle",)),
    ),
    lead=2,
)  # fmt: skip
BODIES = Plan(
    "bodies", "Bodies: centres of mass, rotation", ("rigid_body", "point_mass"),
    (
        View("speed", ("velocity.magnitude|node.velocity.magnitude",)),
        View("angular velocity", ("node.angular_velocity.magnitude",)),
        View("position x", ("center_of_mass.x|node.position.x",)),
        View("position y", ("center_of_mass.y|node.position.y",)),
        View("position z", ("center_of_mass.z|node.position.z",)),
    ),
)  # fmt: skip
REACTIONS = Plan(
    "reactions", "Reactions",
    (*(kind.name for kind in KINDS.values() if kind.section == "joints"), "rigid_link"),
    (
        View("force", ("force.magnitude", "tension")),
        View("moment", ("moment.magnitude",)),
    ),
)  # fmt: skip
LOADS = Plan(
    "loads", "Loads", tuple(kind.name for kind in KINDS.values() if kind.section == "loads"),
    (
        View("power", ("power",)),
        View("force", ("force.magnitude",)),
        View("moment", ("moment.magnitude",)),
    ),
)  # fmt: skip

_PLANS = (WHEELS, STRUTS, TORSION_SPRINGS, ANGLES, BEAMS, SLIDES, GEARS, PLANES, CURVES, BODIES, REACTIONS, LOADS)


def plans(kinds):
    """Return the plans for a model with these kinds; a kind without a plan gets one of its own."""
    named = {kind for plan in _PLANS for kind in plan.kinds}
    own = [_own_plan(KINDS[name]) for name in kinds if name not in named and name in KINDS and KINDS[name].outputs]
    return [plan for plan in _PLANS if set(plan.kinds) & set(kinds)] + own


def _own_plan(kind):
    views = [
        View(output.name.replace("_", " "), (f"{output.name}.magnitude" if output.shape else output.name,))
        for output in kind.outputs
    ]
    return Plan(kind.name, kind.name.replace("_", " ").capitalize(), (kind.name,), tuple(views))
