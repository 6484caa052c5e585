"""The registry: one line for each kind of element, joint and load, nothing else."""

from mecano.elements.adhesive_wheel import ADHESIVE_WHEEL
from mecano.elements.beam import BEAM
from mecano.elements.brake import BRAKE
from mecano.elements.bushing import BUSHING
from mecano.elements.cable import BAR, CABLE
from mecano.elements.couple import COUPLE
from mecano.elements.cylindrical import CYLINDRICAL
from mecano.elements.fixed import FIXED
from mecano.elements.flexible_wheel import FLEXIBLE_WHEEL
from mecano.elements.gear_pair import GEAR_PAIR
from mecano.elements.generic_joint import GENERIC_JOINT
from mecano.elements.held_rotation import HELD_ROTATION
from mecano.elements.hinge import HINGE
from mecano.elements.nodal_load import FOLLOWER_FORCE, FOLLOWER_MOMENT, FORCE, MOMENT
from mecano.elements.paper_wheel import PAPER_WHEEL
from mecano.elements.planar import PLANAR
from mecano.elements.plane_contact import PLANE_CONTACT
from mecano.elements.point_mass import POINT_MASS
from mecano.elements.point_on_curve import POINT_ON_CURVE
from mecano.elements.prescribed_angle import PRESCRIBED_ANGLE
from mecano.elements.prescribed_length import PRESCRIBED_LENGTH
from mecano.elements.prescribed_position import PRESCRIBED_POSITION
from mecano.elements.prismatic import PRISMATIC
from mecano.elements.rack_and_pinion import RACK_AND_PINION
from mecano.elements.rigid_body import RIGID_BODY
from mecano.elements.rigid_link import RIGID_LINK
from mecano.elements.rigid_rod import RIGID_ROD
from mecano.elements.rigid_wheel import RIGID_WHEEL
from mecano.elements.screw import SCREW
from mecano.elements.skate import SKATE
from mecano.elements.slider_on_beam import SLIDER_ON_BEAM
from mecano.elements.spherical import SPHERICAL
from mecano.elements.spring_damper import SPRING_DAMPER
from mecano.elements.superelement import SUPERELEMENT
from mecano.elements.torsion_spring_damper import TORSION_SPRING_DAMPER
from mecano.elements.universal import UNIVERSAL
from mecano.elements.wheel import WHEEL

KINDS = {
    kind.name: kind
    for kind in (
        POINT_MASS, RIGID_BODY, RIGID_LINK,
        HINGE, SPHERICAL, UNIVERSAL, CYLINDRICAL, PRISMATIC, PLANAR, SCREW, FIXED, GENERIC_JOINT, RIGID_ROD,
        GEAR_PAIR, RACK_AND_PINION, POINT_ON_CURVE, SLIDER_ON_BEAM,
        PRESCRIBED_POSITION, PRESCRIBED_ANGLE, PRESCRIBED_LENGTH, HELD_ROTATION,
        BEAM, SUPERELEMENT, BAR, CABLE, SPRING_DAMPER, TORSION_SPRING_DAMPER, BUSHING, PLANE_CONTACT,
        FORCE, FOLLOWER_FORCE, MOMENT, FOLLOWER_MOMENT, COUPLE, BRAKE,
        RIGID_WHEEL, PAPER_WHEEL, SKATE, WHEEL, FLEXIBLE_WHEEL, ADHESIVE_WHEEL,
    )
}  # fmt: skip
