"""Plans of the standard plots: outputs shown for each kind of element, joint and load.

A kind without a plan gets a sheet of its own with all its outputs.
"""

from collections.abc import Sequence
from dataclasses import dataclass

from mecano.post.runs import Run

ON_GROUND = ("longitudinal_slip", "lateral_slip", "rolling_rate")  # meaningful only while a wheel is in contact


@dataclass(frozen=True)
class View:
    """One panel of every sheet: outputs of each element over the time or over another output.

    Outputs are written as in ``--plot`` without the element; "node.position.x" is an output of the element's node.
    Outputs that an element does not have are omitted; of "one|other" the first that exists is used.
    """

    label: str
    outputs: tuple[str, ...]
    against: str = "time"
    reference: str = ""  # output shown for comparison


@dataclass(frozen=True)
class Plan:
    """A sheet for all elements of some kinds, views by importance; the first ``lead`` views are equally important."""

    name: str
    heading: str
    views: tuple[View, ...]
    lead: int = 1


WHEELS = Plan(
    "wheels", "Wheels",
    (
        View("radial force", ("radial_force|normal_force",)),
        View("force in the ground", ("longitudinal_force", "lateral_force")),
        View("spin rate", ("spin_rate",), reference="rolling_rate"),
        View("height of the centre", ("height",)),
        View("slip velocity", ("longitudinal_slip", "lateral_slip")),
        View("radial deformation", ("deformation",)),
        View("slip ratio", ("slip_ratio",)),
        View("slip angle", ("slip_angle",)),
        View("lateral displacement of the patch", ("y",)),
        View("torsion of the patch", ("psi",)),
    ),
    lead=3,
)  # fmt: skip
BEAMS = Plan(
    "beams", "Beams",
    (
        View("equivalent stress", ("stress",)),
        View("axial force", ("force.x",)),
        View("shear force", ("force.y", "force.z")),
        View("torque", ("moment.x",)),
        View("bending moment at the start", ("moment_start.y", "moment_start.z")),
    ),
)  # fmt: skip
STRUTS = Plan(
    "struts", "Springs and struts",
    (
        View("compression force", ("compression_force",), against="stroke"),
        View("stroke", ("stroke",)),
        View("compression force", ("compression_force",)),
        View("rate of extension", ("extension_rate",)),
    ),
    lead=2,
)  # fmt: skip
CABLES = Plan(
    "cables", "Cables",
    (
        View("tension", ("tension",)),
        View("length", ("length",), reference="natural_length"),
        View("strain", ("strain",)),
        View("strain rate", ("strain_rate",)),
        View("stress", ("stress",)),
        View("state", ("state",)),
        View("inclination", ("inclination",)),
        View("lift-off", ("lift_off",)),
    ),
)  # fmt: skip
TORSION_SPRINGS = Plan(
    "torsion_springs", "Torsion springs",
    (
        View("moment", ("moment",), against="angle"),
        View("angle", ("angle",)),
        View("moment", ("moment",)),
        View("rate", ("rate",)),
    ),
)  # fmt: skip
ANGLES = Plan(
    "angles", "Angles of joints",
    (View("angle", ("angle", "angle_a", "angle_b")), View("angular velocity", ("rate", "rate_a", "rate_b"))),
)  # fmt: skip
SLIDES = Plan(
    "slides", "Displacements of joints",
    (View("displacement", ("displacement",)), View("velocity", ("velocity",))),
)  # fmt: skip
GEARS = Plan(
    "gears", "Gears, racks, screws",
    (
        View("angle", ("angle", "angle_a", "angle_b")),
        View("angular velocity", ("rate", "rate_a", "rate_b")),
        View("displacement", ("displacement",)),
        View("force", ("force.magnitude",)),
        View("transmission error", ("transmission_error",)),
        View("dissipated power", ("dissipated_power",)),
    ),
)  # fmt: skip
PLANES = Plan(
    "planes", "Sliding in planes",
    (
        View("displacement along mu_2", ("displacement.y",), against="displacement.x"),
        View("displacement", ("displacement.x", "displacement.y")),
        View("velocity", ("velocity.x", "velocity.y")),
        View("angle", ("angle",)),
    ),
)  # fmt: skip
CURVES = Plan(
    "curves", "Points on curves and beams",
    (
        View("place on the curve", ("position",)),
        View("normal force", ("normal_force",)),
        View("speed along the curve", ("speed",)),
        View("pressure angle", ("pressure_angle",)),
    ),
    lead=2,
)  # fmt: skip
BODIES = Plan(
    "bodies", "Bodies: centres of mass, rotation",
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
    (
        View("force", ("force.magnitude", "tension")),
        View("moment", ("moment.magnitude",)),
        View("load", ("load_a", "load_b")),
    ),
)  # fmt: skip
LOADS = Plan(
    "loads", "Loads",
    (
        View("power", ("power",)),
        View("force", ("force.magnitude",)),
        View("moment", ("moment.magnitude",)),
    ),
)  # fmt: skip
SIGNALS = Plan(
    "signals", "Signals",
    (View("signal", ("value",)), View("integral", ("integral",)), View("filtered error", ("filtered",))),
    lead=3,
)  # fmt: skip

_PLANS = (WHEELS, STRUTS, CABLES, TORSION_SPRINGS, ANGLES, BEAMS, SLIDES, GEARS, PLANES, CURVES, BODIES, REACTIONS,
          LOADS, SIGNALS)  # fmt: skip


def plans(runs: Sequence[Run]) -> list[Plan]:
    """Return the plans for the kinds in the runs, with an additional one for each kind that belongs to none."""
    belonging = {path: (run, d["type"], pictures_of(run, path)) for run in runs for path, d in run.pieces.items()}
    used = {name for _, _, pictures in belonging.values() for name in pictures}
    standard = [plan for plan in _PLANS if plan.name in used]
    known = {plan.name for plan in _PLANS}
    own = {kind: (run, path) for path, (run, kind, pictures) in belonging.items() if not known & set(pictures)}
    return standard + [plan for kind, (run, path) in own.items() if (plan := _own_plan(kind, run, path)).views]


def pictures_of(run: Run, path: str) -> tuple[str, ...]:
    """Return the names of the pictures to which the element, joint or load of a path belongs."""
    d, section = run.pieces[path], path.partition("/")[0]
    by_section = {"joints": ("reactions",), "loads": ("loads",), "signals": ("signals",)}.get(section, ())
    return (*run.display(d).pictures, *by_section, d["type"])


def _own_plan(kind, run, path):
    """Return a Plan with a View of each output of the kind, from the element, joint or load of a path.

    The point at which its force acts has none, nor has a direction: their magnitudes say nothing.
    """
    place = run.display(run.pieces[path]).force_at
    outputs = {name.rpartition("/")[2]: series for name, series in run.results.series.items()
               if name.rpartition("/")[0] == path}  # fmt: skip
    views = [
        View(name.replace("_", " "), (f"{name}.magnitude" if series.shape else name,))
        for name, series in outputs.items()
        if name != place and not (series.shape and series.unit == "-")
    ]
    return Plan(kind, kind.replace("_", " ").capitalize(), tuple(views))
