"""A mirrored element exerts the mirrored forces: every kind, in every phase, in random motion.

A mirror Q, det Q = -1, turns polar vectors x into Q x and axial ones w into -Q w, and the axes R of a node into Q R S,
with the mirror S of its own axes: y -> -y. Fields of the deck are polar, except those of AXIAL; coordinates along
mirrored axes that keep their sign, such as an angle about a polar axis, change theirs (FLIPPED).
"""

import re

import numpy as np
import pytest
from instances import KINDS

from mecano.analyses.constraint_tests import is_inactive
from mecano.analyses.invariance_tests import force_on_nodes, set_reactions, turned_values
from mecano.analyses.kind_samples import GRAVITY, Motion, expand, samples, seed_of
from mecano.analyses.power_tests import energies
from mecano.constraints.triads import triad

MIRROR, SHIFT = np.eye(3) - 2.0 * np.outer([0.6, -0.48, 0.64], [0.6, -0.48, 0.64]), np.array([0.3, -0.8, 0.5])
S = np.diag([1.0, -1.0, 1.0])
WHEELS = ("rigid_wheel", "cardona_wheel", "skate", "wheel", "transient_wheel", "flexible_wheel", "adhesive_wheel",
          "wheel_on_body", "mecanum_wheel")  # fmt: skip
AXIAL = {  # kinds: fields that are axes of rotation, or across a force
    ("hinge",): ("axis", "axis_b"), ("universal", "gear_pair"): ("axis_a", "axis_b"), ("pressure",): ("across",),
    ("rack_and_pinion", "prescribed_angle", "torsion_spring_damper", "belt", "reeved_cable", "couple", "brake"):
        ("axis",),
    ("moment", "follower_moment", "line_moment"): ("direction",), ("gravity_gradient",): ("normal",), WHEELS: ("axis",),
}  # fmt: skip
AXIAL = {kind: fields for kinds, fields in AXIAL.items() for kind in kinds}
POLAR_AXIS = "along_2", "about_1", "about_axis", "angle"  # mu_2 = axis x mu_1
FLIPPED = {
    "hinge": ("along_axis", "about_1", "about_2"), "universal": ("along_1", "along_2", "along_axis"),
    "beam": ("curvature_3",), "flexible_wheel": ("y", "psi", "bow"), "adhesive_wheel": ("y", "psi", "bow"),
    "transient_wheel": ("y", "psi"), "joint_moment": ("value",),
    **dict.fromkeys(("cylindrical", "prismatic", "planar", "screw", "fixed", "generic", "bushing"), POLAR_AXIS),
}  # fmt: skip
SIX = "along_1", "along_2", "along_axis", "about_1", "about_2", "about_axis"


def mirrored(kind, d, flipped):
    """The deck values of an element in the mirror."""
    out = turned_values(kind.fields, d, MIRROR, SHIFT)
    for name in AXIAL.get(kind.name, ()):
        out[name] = None if d.get(name) is None else -out[name]
    for field in kind.fields:  # in the axes of the node
        value = d.get(field.name)
        if value is not None and field.type.name == "inertia":
            out[field.name] = S @ value @ S if np.ndim(value) == 2 else value
        if value is not None and field.type.name == "vector" and not field.type.moves:
            out[field.name] = S @ value
    if d.get("wheel"):
        out["wheel"] = {**out["wheel"], "axis": -out["wheel"]["axis"]}
    if "ground" in d and d["ground"].get("motion"):
        motion = out["ground"]["motion"]
        out["ground"]["motion"] = {**motion, "rate": -motion["rate"]}
    if d.get("cam"):
        out["cam"] = {**out["cam"], "axis": -out["cam"]["axis"]}
    if d.get("roller_angle"):
        out["roller_angle"] = np.pi - d["roller_angle"]
    if d.get("pitch"):
        out["pitch"] = -d["pitch"]
    if kind.name == "coupler":
        out["factors"] = [f * (-1.0 if i < len(d["angles"]) else 1.0) for i, f in enumerate(d["factors"])]
    if kind.name == "nonlinear_coupler":
        signs = [1.0 if d.get(field) is None else -1.0 for field in ("angle", "of_angle")]
        out["start"] = signs[1] * d["start"]
        if d.get("formula"):
            reflected = re.sub(r"\bs\b", f"({signs[1]}*s)", d["formula"])
            out["formula"] = f"{signs[0]}*({reflected})"
        else:
            out["function"] = _reflected(d["function"], *signs)
    if kind.name == "beam":
        out |= {"twist": -d["twist"], "section": _section(d["section"])}
    if kind.name == "superelement":
        out["file"] = _reduced(d["file"])
    if kind.name in WHEELS and d.get("tire_law", {}).get("magic_formula"):
        tyre = d["tire_law"]
        law = tyre["magic_formula"]
        out["tire_law"] = {**tyre, "magic_formula": {**law, "mirrored": not law.get("mirrored")}}
    return _opposite(out, flipped)


def _reflected(function, sign, sign_of_argument):
    """The function sign f(sign_of_argument x) of the terms in samples."""
    changed = {
        "polynomial": lambda d: {
            "coefficients": [sign * sign_of_argument**p * c for p, c in enumerate(d["coefficients"])]
        },
        "linear": lambda d: {"slope": sign * sign_of_argument * d["slope"], "offset": sign * d["offset"]},
        "sine": lambda d: {"amplitude": sign * d["amplitude"], "frequency": sign_of_argument * d["frequency"]},
    }
    return tuple((name, {**d, **changed[name](d)}) for name, d in function)


def _section(section):
    """A cross section with axis 2 reversed."""
    signs = np.array([1, -1, 1, -1, 1, -1])
    given = [name for name in ("stiffness", "mass") if section["type"] == "matrix" and section.get(name) is not None]
    return {**section, **{name: section[name] * np.outer(signs, signs) for name in given}}


def _reduced(file):
    """The matrices of a superelement in mirrored axes."""
    nodes = np.tile([1, -1, 1, -1, 1, -1], len(file["positions"]))
    signs = np.concatenate([nodes, np.ones(len(file["stiffness"]) - len(nodes))])
    given = [name for name in ("stiffness", "mass", "damping") if file.get(name) is not None]
    matrices = {name: np.asarray(file[name]) * np.outer(signs, signs) for name in given}
    return {**file, "positions": np.asarray(file["positions"]) @ S, **matrices}


def _opposite(d, flipped):
    """The values with the coordinates ``flipped`` of the other sign: their laws, set points and matrices."""
    out = dict(d)
    for group in ("compliance", "laws", "driven", "driven_rates", "natural", "thermal"):
        if d.get(group):
            out[group] = {axis: _other_way(v) if axis in flipped else v for axis, v in d[group].items()}
    for name, coordinate in (("natural_angle", "angle"), ("value", "value")):
        if coordinate in flipped and d.get(name) is not None:
            out[name] = _other_way(d[name])
    signs = np.array([-1.0 if axis in flipped else 1.0 for axis in SIX])
    for name in ("stiffness", "damping"):
        if np.ndim(d.get(name)) == 2:
            out[name] = d[name] * np.outer(signs, signs)
    return out


def _other_way(value):
    """-f(-x) of the odd laws and dead bands, and -f of the functions of time and numbers in samples."""
    if value is None or isinstance(value, float):
        return value and -value
    if isinstance(value, str):
        return f"-({value})"
    negated = {"sine": ("amplitude", "offset"), "linear": ("slope", "offset"), "dead_band": ("lower", "upper")}
    terms = [(name, {k: -v if k in negated.get(name, ()) else v for k, v in d.items()}) for name, d in value]
    return tuple(
        (name, {**d, "lower": d["upper"], "upper": d["lower"]} if name == "dead_band" else d) for name, d in terms
    )


def with_axes(kind, sample):
    """Give a sample the directions that it would otherwise choose from the inertial axes."""
    values = sample.values
    if "axis_1" in values and values["axis_1"] is None and values["axis"] is not None:
        values["axis_1"] = triad(values["axis"])[0]
    if kind.name == "beam" and values["up"] is None:
        values["up"] = np.array([0.3, 0.5, -0.7])
    sample.instances = expand(kind, values, sample.nodes, sample.phase, GRAVITY, seed_of(kind.name))


def twin_of(kind, sample):
    """The instances of a sample in the mirror, with mirrored unknowns, and the mirrored motion."""
    flipped, here = FLIPPED.get(kind.name, ()), sample.motion
    nodes = [(MIRROR @ x + SHIFT, MIRROR @ R @ S) for x, R in sample.nodes]
    values = mirrored(kind, sample.values, flipped)
    twins = expand(kind, values, nodes, sample.phase, MIRROR @ GRAVITY, seed_of("unused"))
    for twin, original in zip(twins, sample.instances, strict=True):
        if is_inactive(original):
            original.multipliers = 0.0 * original.multipliers
        names = [*original.kind.scalars, *original.kind.inputs]
        of_axes = ("set_point", "rate") if flipped else ("set_point",)
        original.scalars[:, [name in of_axes for name in names]] = 0.0  # of an axis that is not known here
        twin.scalars = original.scalars * [-1.0 if name in flipped else 1.0 for name in names]
    moved = here.moved(MIRROR, SHIFT)
    return twins, Motion(here.t, moved.x, moved.R @ S, -here.turn @ S)


def expected_forces(instances, motion):
    """Forces, moments, magnitudes of the forces of scalars, and norms of the constraints in the mirror."""
    force, moment, scalars, rows = force_on_nodes(instances, motion)
    return force @ MIRROR.T, -moment @ S, np.abs(scalars), rows


@pytest.mark.parametrize("kind", KINDS.values(), ids=KINDS)
def test_forces_and_energies_in_a_mirror(kind):
    for sample in samples(kind) if kind.section != "signals" else ():
        with_axes(kind, sample)
        twins, there = twin_of(kind, sample)
        held = [instance for instance in sample.instances if instance.kind.multipliers]
        force, moment, _, _ = force_on_nodes(held, sample.motion, 0.0)
        set_reactions(twins, there, np.concatenate([force @ MIRROR.T, -moment @ S]).ravel())
        wanted, found = expected_forces(sample.instances, sample.motion), force_on_nodes(twins, there)
        found[2] = np.abs(found[2])
        for one, other in zip(found, wanted, strict=True):
            np.testing.assert_allclose(one, other, rtol=1e-9, atol=1e-9 * (1.0 + np.abs(other).max(initial=0.0)))
        works = energies(sample.instances, sample.motion), energies(twins, there)
        np.testing.assert_allclose(works[1][[0, 2, 3]], works[0][[0, 2, 3]], rtol=1e-9, atol=1e-9)
