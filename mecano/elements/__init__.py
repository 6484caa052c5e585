"""The registry of kinds: the module of each element, joint, load and signal, imported when the kind is first needed."""

from collections import UserDict
from importlib import import_module

FOLDERS = {
    "bodies": "point_mass rigid_body rigid_link attitude superelement",
    "joints": "hinge spherical universal constant_velocity cylindrical prismatic planar screw fixed grip generic "
    "rigid_rod gear_pair coupler nonlinear_coupler rack_and_pinion point_on_curve slider_on_beam prescribed_position "
    "prescribed_angle prescribed_length held_rotation plane_contact contact",
    "members": "beam bar cable spring_damper oleo torsion_spring_damper belt reeved_cable bushing",
    "forces": "force follower_force moment follower_moment couple joint_moment joint_force line_force internal_force "
    "line_load line_moment pressure drag gravity_gradient brake",
    "wheels": "rigid_wheel cardona_wheel mecanum_wheel skate wheel transient_wheel flexible_wheel adhesive_wheel "
    "wheel_on_body",
    "signals": "formula curve lag integrator washout pid transfer_function state_space limit switch sample_and_hold "
    "delay external",
}
"""Names of kinds by folder. Each kind is in the module of its name, or in one of these, under its name in capitals."""
MODULE_OF = {
    "bar": "cable", "line_moment": "line_load", "transfer_function": "state_space",
    **dict.fromkeys(("prescribed_position", "prescribed_angle", "prescribed_length"), "prescribed_motion"),
    **dict.fromkeys(("force", "follower_force", "moment", "follower_moment"), "nodal_load"),
    **dict.fromkeys(("couple", "joint_moment", "joint_force", "line_force", "internal_force"), "joint_load"),
}  # fmt: skip
MODULES = {name: f"{folder}.{MODULE_OF.get(name, name)}" for folder, names in FOLDERS.items() for name in names.split()}


class Kinds(UserDict):
    """Kinds by name; those of mecano are imported when they are first used, since a deck needs few."""

    def __getitem__(self, name):
        if self.data[name] is None:
            self.data[name] = getattr(import_module(f"{__name__}.{MODULES[name]}"), name.upper())
        return self.data[name]


KINDS = Kinds(dict.fromkeys(MODULES))
