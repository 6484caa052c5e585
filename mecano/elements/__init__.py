"""The registry of kinds: the module of each element, joint, load and signal, imported when the kind is first needed."""

from collections.abc import MutableMapping
from importlib import import_module

MODULES = {
    "point_mass": "bodies.point_mass",
    "rigid_body": "bodies.rigid_body",
    "rigid_link": "bodies.rigid_link",
    "attitude": "bodies.attitude",
    "hinge": "joints.hinge",
    "spherical": "joints.spherical",
    "universal": "joints.universal",
    "constant_velocity": "joints.constant_velocity",
    "cylindrical": "joints.cylindrical",
    "prismatic": "joints.prismatic",
    "planar": "joints.planar",
    "screw": "joints.screw",
    "fixed": "joints.fixed",
    "grip": "joints.grip",
    "generic": "joints.generic",
    "rigid_rod": "joints.rigid_rod",
    "gear_pair": "joints.gear_pair",
    "coupler": "joints.coupler",
    "nonlinear_coupler": "joints.nonlinear_coupler",
    "rack_and_pinion": "joints.rack_and_pinion",
    "point_on_curve": "joints.point_on_curve",
    "slider_on_beam": "joints.slider_on_beam",
    "prescribed_position": "joints.prescribed_motion",
    "prescribed_angle": "joints.prescribed_motion",
    "prescribed_length": "joints.prescribed_motion",
    "held_rotation": "joints.held_rotation",
    "beam": "members.beam",
    "superelement": "bodies.superelement",
    "bar": "members.cable",
    "cable": "members.cable",
    "spring_damper": "members.spring_damper",
    "oleo": "members.oleo",
    "torsion_spring_damper": "members.torsion_spring_damper",
    "belt": "members.belt",
    "reeved_cable": "members.reeved_cable",
    "bushing": "members.bushing",
    "plane_contact": "joints.plane_contact",
    "contact": "joints.contact",
    "force": "forces.nodal_load",
    "follower_force": "forces.nodal_load",
    "moment": "forces.nodal_load",
    "follower_moment": "forces.nodal_load",
    "couple": "forces.couple",
    "joint_moment": "forces.joint_load",
    "joint_force": "forces.joint_load",
    "line_force": "forces.joint_load",
    "internal_force": "forces.joint_load",
    "line_load": "forces.line_load",
    "line_moment": "forces.line_load",
    "pressure": "forces.pressure",
    "drag": "forces.drag",
    "gravity_gradient": "forces.gravity_gradient",
    "brake": "forces.brake",
    "rigid_wheel": "wheels.rigid_wheel",
    "cardona_wheel": "wheels.cardona_wheel",
    "mecanum_wheel": "wheels.mecanum_wheel",
    "skate": "wheels.skate",
    "wheel": "wheels.wheel",
    "transient_wheel": "wheels.transient_wheel",
    "flexible_wheel": "wheels.flexible_wheel",
    "adhesive_wheel": "wheels.adhesive_wheel",
    "wheel_on_body": "wheels.wheel_on_body",
    "formula": "signals.formula",
    "curve": "signals.curve",
    "lag": "signals.lag",
    "integrator": "signals.integrator",
    "washout": "signals.washout",
    "pid": "signals.pid",
    "transfer_function": "signals.state_space",
    "state_space": "signals.state_space",
    "limit": "signals.limit",
    "switch": "signals.switch",
    "sample_and_hold": "signals.sample_and_hold",
    "delay": "signals.delay",
    "external": "signals.external",
}  # in mecano/elements; each holds the kind under its name in capitals


class Kinds(MutableMapping):
    """Kinds by name; those of mecano are imported when they are first used, since a deck needs few."""

    def __init__(self, modules):
        self._found = dict.fromkeys(modules)

    def __getitem__(self, name):
        if self._found[name] is None:
            self._found[name] = getattr(import_module(f"{__name__}.{MODULES[name]}"), name.upper())
        return self._found[name]

    def __setitem__(self, name, kind):
        self._found[name] = kind

    def __delitem__(self, name):
        del self._found[name]

    def __iter__(self):
        return iter(self._found)

    def __len__(self):
        return len(self._found)

    def __contains__(self, name):
        return name in self._found


KINDS = Kinds(MODULES)
