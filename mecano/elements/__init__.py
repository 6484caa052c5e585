"""The registry of kinds: one line for each element, joint and load."""

from mecano.elements.bodies.point_mass import POINT_MASS
from mecano.elements.bodies.rigid_body import RIGID_BODY
from mecano.elements.bodies.rigid_link import RIGID_LINK
from mecano.elements.bodies.superelement import SUPERELEMENT
from mecano.elements.forces.brake import BRAKE
from mecano.elements.forces.couple import COUPLE
from mecano.elements.forces.drag import DRAG
from mecano.elements.forces.gravity_gradient import GRAVITY_GRADIENT
from mecano.elements.forces.joint_load import JOINT_FORCE, JOINT_MOMENT, LINE_FORCE
from mecano.elements.forces.line_load import LINE_LOAD, LINE_MOMENT
from mecano.elements.forces.nodal_load import FOLLOWER_FORCE, FOLLOWER_MOMENT, FORCE, MOMENT
from mecano.elements.forces.pressure import PRESSURE
from mecano.elements.joints.contact import CONTACT
from mecano.elements.joints.coupler import COUPLER
from mecano.elements.joints.cylindrical import CYLINDRICAL
from mecano.elements.joints.fixed import FIXED
from mecano.elements.joints.gear_pair import GEAR_PAIR
from mecano.elements.joints.generic import GENERIC_JOINT
from mecano.elements.joints.grip import GRIP
from mecano.elements.joints.held_rotation import HELD_ROTATION
from mecano.elements.joints.hinge import HINGE
from mecano.elements.joints.planar import PLANAR
from mecano.elements.joints.plane_contact import PLANE_CONTACT
from mecano.elements.joints.point_on_curve import POINT_ON_CURVE
from mecano.elements.joints.prescribed_angle import PRESCRIBED_ANGLE
from mecano.elements.joints.prescribed_length import PRESCRIBED_LENGTH
from mecano.elements.joints.prescribed_position import PRESCRIBED_POSITION
from mecano.elements.joints.prismatic import PRISMATIC
from mecano.elements.joints.rack_and_pinion import RACK_AND_PINION
from mecano.elements.joints.rigid_rod import RIGID_ROD
from mecano.elements.joints.screw import SCREW
from mecano.elements.joints.slider_on_beam import SLIDER_ON_BEAM
from mecano.elements.joints.spherical import SPHERICAL
from mecano.elements.joints.universal import UNIVERSAL
from mecano.elements.members.beam import BEAM
from mecano.elements.members.belt import BELT
from mecano.elements.members.bushing import BUSHING
from mecano.elements.members.cable import BAR, CABLE
from mecano.elements.members.oleo import OLEO
from mecano.elements.members.reeved_cable import REEVED_CABLE
from mecano.elements.members.spring_damper import SPRING_DAMPER
from mecano.elements.members.torsion_spring_damper import TORSION_SPRING_DAMPER
from mecano.elements.signals.curve import CURVE
from mecano.elements.signals.delay import DELAY
from mecano.elements.signals.formula import FORMULA
from mecano.elements.signals.integrator import INTEGRATOR
from mecano.elements.signals.lag import LAG
from mecano.elements.signals.pid import PID
from mecano.elements.signals.sample_and_hold import SAMPLE_AND_HOLD
from mecano.elements.signals.state_space import STATE_SPACE, TRANSFER_FUNCTION
from mecano.elements.signals.switch import SWITCH
from mecano.elements.signals.washout import WASHOUT
from mecano.elements.wheels.adhesive_wheel import ADHESIVE_WHEEL
from mecano.elements.wheels.cardona_wheel import CARDONA_WHEEL
from mecano.elements.wheels.flexible_wheel import FLEXIBLE_WHEEL
from mecano.elements.wheels.rigid_wheel import RIGID_WHEEL
from mecano.elements.wheels.skate import SKATE
from mecano.elements.wheels.transient_wheel import TRANSIENT_WHEEL
from mecano.elements.wheels.wheel import WHEEL
from mecano.elements.wheels.wheel_on_body import WHEEL_ON_BODY

KINDS = {
    kind.name: kind
    for kind in (
        POINT_MASS, RIGID_BODY, RIGID_LINK,
        HINGE, SPHERICAL, UNIVERSAL, CYLINDRICAL, PRISMATIC, PLANAR, SCREW, FIXED, GRIP, GENERIC_JOINT, RIGID_ROD,
        GEAR_PAIR, COUPLER, RACK_AND_PINION, POINT_ON_CURVE, SLIDER_ON_BEAM,
        PRESCRIBED_POSITION, PRESCRIBED_ANGLE, PRESCRIBED_LENGTH, HELD_ROTATION,
        BEAM, SUPERELEMENT, BAR, CABLE, SPRING_DAMPER, OLEO, TORSION_SPRING_DAMPER, BELT, REEVED_CABLE,
        BUSHING, PLANE_CONTACT, CONTACT,
        FORCE, FOLLOWER_FORCE, MOMENT, FOLLOWER_MOMENT, COUPLE, JOINT_MOMENT, JOINT_FORCE, LINE_FORCE,
        LINE_LOAD, LINE_MOMENT, PRESSURE, DRAG, GRAVITY_GRADIENT, BRAKE,
        RIGID_WHEEL, CARDONA_WHEEL, SKATE, WHEEL, TRANSIENT_WHEEL, FLEXIBLE_WHEEL, ADHESIVE_WHEEL,
        WHEEL_ON_BODY,
        FORMULA, CURVE, LAG, INTEGRATOR, WASHOUT, PID, TRANSFER_FUNCTION, STATE_SPACE, SWITCH,
        SAMPLE_AND_HOLD, DELAY,
    )
}  # fmt: skip
