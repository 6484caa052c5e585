"""Words of other programs and books, with their equivalents in mecano: targets of `mecano explain`, commands."""

import re

TABLE = """\
motor, actuator, drive, servo, angle driver, rheonomic -> joint_moment joint_force line_force prescribed_angle
    prescribed_position prescribed_length
motion, imposed motion, prescribed motion, imposed displacement -> prescribed_angle prescribed_length
    prescribed_position generic | along the axis of a joint between moving bodies: a generic joint with that axis
    'driven'
inverse dynamics, inverse kinematics, leg -> prescribed_position prescribed_angle prescribed_length | prescribe the
    motion and read the reactions; drive legs by tables of their lengths, with interpolation: spline
linear actuator, hydraulic cylinder, piston, jack, ram -> line_force joint_force prescribed_length bar | a bar whose
    natural_length is a law of time pushes and pulls with an elasticity
pulley, sheave, block, tackle, reeving -> reeved_cable belt | a reeved_cable slides over the pulleys, with or without
    friction; a belt turns them
timing belt, belt drive -> belt
creep, belt creep, belt slip, v belt, flat belt -> belt | a belt does not slip; with 'creep: true' it creeps on its
    pulleys as its strain changes on them
motorcycle, motorbike, weave, wobble, capsize -> transient_wheel rigid_wheel | `mecano modes --sweep` follows the modes
    over the speed; see docs/tyres.md
crown, rounded tread, round tyre, tyre contour, toroidal tyre -> wheel transient_wheel flexible_wheel rigid_wheel |
    'crown_radius' in the tyre law, or of the rigid_wheel
drum -> belt wheel_on_body | a rope runs on a drum, or a wheel
capstan, bollard, rope brake, band brake -> reeved_cable | a reeved_cable with 'friction'
chain, chain drive, sprocket -> belt gear_pair coupler | a belt, a gear_pair with a 'ratio', or a coupler of the angles
    of two hinges
synchronisation, synchronization, synchronisation cable, synchronization cable, differential, transmission, linear
    relation -> coupler
non circular gear, noncircular gear, elliptical gear, transmission function, position function, indexing, indexing
    drive, function generator -> nonlinear_coupler | one coordinate of a joint as a function of that of another one
rack, pinion -> rack_and_pinion
gear, gear train, gear wheel, planetary, ideal planetary, planetary gear, epicyclic, sun gear, ring gear -> gear_pair
    rack_and_pinion
cvt, variator, continuously variable, variable ratio -> coupler | a coupler with a 'ratio', a law of time or a signal
oldham, oldham coupling -> prismatic hinge | two prismatic joints across one another, and a disc between them, join
    shafts on hinges
swash plate, swashplate, wobble plate -> hinge spherical prismatic | a body on an inclined hinge, which pushes rods
    on spherical joints
gearbox, gear motor, geared motor -> coupler gear_pair joint_moment | a coupler of two hinges is any gear, with an
    efficiency by its 'friction'
gear mesh, tooth stiffness, mesh stiffness, gear loss, lossy gear -> gear_pair rack_and_pinion | with 'teeth' they are
    elastic, with 'friction' they have an efficiency
lead screw, ball screw, nut, helical, helical joint -> screw
worm, worm gear, self locking -> gear_pair screw | 'friction' with a 'backdriving_efficiency' of 0 or less locks
revolute, revolute joint, pin, pin joint, pivot, axle -> hinge
bearing, journal -> hinge bushing | an elastic one is a hinge with 'compliance', or a bushing; an oil film is a bushing
    and two loads (docs/modes.md)
ball, ball joint, ball and socket, globe joint -> spherical
slider, slide, translational, translational joint, sliding joint, sleeve -> prismatic cylindrical slider_on_beam
rail, guide, track, guide way, curve joint, slot -> prismatic point_on_curve slider_on_beam
cam, follower, valve train, tappet, flat tappet, flat follower, valve float -> contact point_on_curve | a 'contact' with
    a 'cam' may open, its follower is a roller or a flat 'face'; a point_on_curve is guided from both sides
trailer, semitrailer, caravan, hitch, snaking -> spherical hinge wheel | a hitch is a spherical joint or a hinge;
    `mecano modes --sweep` finds its limit
catenary, mooring line, hanging rope -> cable beam | a rope is a cable with 'mesh' and 'sag', or a beam with a mesh
boom, antenna, spar -> beam superelement
wire boom, radial wire -> cable beam | a wire that is paid out is a cable, its natural_length a law of time
domino, rocking block -> contact
skid, landing skid -> beam contact | skids are beams with a contact at every node that may touch the ground
gripper, grab, hook, magnet, suction cup, docking, berthing, capture, attach, engage -> grip latch | a grip closes and
    is released by command; a latch locks a joint when it is reached; springs, bushings, cables, belts and contacts have
    an 'activate'
jettison, separation, detach, unlatch, pyro, burn wire, cut, break, deactivate -> release grip | 'release' of joints,
    latches, cables, belts, springs and bushings; loads end by a switch
set point, setpoint, series elastic actuator, elastic actuator -> spring_damper torsion_spring_damper hinge signals |
    their set points are laws of time or formulas of signals
weld, rigid, rigid joint, clamp, fixed joint, glue -> fixed rigid_link | to fix a node in space write 'fixed:
    true'
gimbal, cardan, cardan joint, hooke, hooke joint, u joint, universal joint -> universal
constant velocity, cv, convel, homokinetic, rzeppa, tripod, half shaft, drive shaft -> constant_velocity universal
plane joint, planar joint -> planar
roller, roller support, inplane, in plane, point on plane, point in plane -> prescribed_position generic planar | a node
    stays in a plane with a prescribed_position along its normal and 'value: 0', or with a generic joint
inline, in line, point on line, pin in slot, slotted link, scotch yoke -> point_on_curve prismatic generic | a point of
    one body slides along a curve of another; in a straight slot it is a generic joint with all axes free but one of the
    translations
geneva, geneva wheel, geneva drive, maltese cross -> contact hinge nonlinear_coupler | a pin that enters and leaves a
    slot touches its walls, capsules, by a contact with a 'law'; without play, the wheel is a function of the crank
speed motor, given speed, velocity motion, prescribed velocity, prescribed speed -> prescribed_angle prescribed_length
    generic | a drive of given speed has a 'rate', a law of time or a signal
support, ground joint, fixation, boundary condition, constraint -> nodes fixed prescribed_position held_rotation | a
    node with 'fixed: true' is held; 'ground' may be one of two nodes
body, link, inertia, lumped mass body -> rigid_body
mass, lumped mass, concentrated mass -> point_mass rigid_body
rod, massless rod, distance joint, distance constraint -> rigid_rod bar | a bar is elastic
strut, truss, truss element -> bar rigid_rod spring_damper
rope, wire, tendon, string, winch, hoist, winder -> cable reeved_cable belt | a winch is the 'payout' of a reeved_cable,
    also by the angle of a drum (docs/pulleys.md), or a cable with 'payout_tension'
eyelet, fairlead, ring on a rope, guided cable, via point, seat belt, lanyard -> reeved_cable rigid_rod | an eyelet is a
    node of the radius zero between the ends of a reeved_cable, which slides through it
flexible body, fem, finite element, reduced model, craig bampton, substructure, component mode -> superelement beam |
    `mecano reduce` makes the matrices of a superelement
shell, plate, membrane, solid, volume -> superelement | not available; a superelement takes their reduced matrices from
    another program
profile, cross section -> sections circle tube rectangle stiffness matrix
spring -> spring_damper torsion_spring_damper bushing
damper, dashpot, viscous damper -> spring_damper torsion_spring_damper damper
torsion spring, rotational spring, torsional spring, rotational damper -> torsion_spring_damper hinge
bush, rubber mount, silent block, mount, vibration isolator, isolator, six dof spring -> bushing
shock absorber, shock strut, oleo strut, oleopneumatic, landing gear strut, damper strut, two stage strut, recoil valve
    -> oleo spring_damper gas_spring oil_damper metering_pin | oleo takes pressures, volumes and areas; a spring_damper
    a law: gas spring, oil damper, stop
gas, air spring, nitrogen -> gas_spring
landing gear, undercarriage, bogie, drag brace, side brace, side stay, spin up, spring back, trunnion, drop test,
    crosswind -> oleo wheel drag steady place | see docs/struts.md; a brace is a bar or a rigid_rod; a bogie is a beam
    or a body with a wheel at each axle; in a crosswind give a lateral velocity in 'initial', and a drag to the airframe
retraction, extension actuator, over centre, overcentre, toggle, down lock, downlock, up lock, uplock -> hinge.stops
    hinge.latch hinge.lock line_force | an over-centre brace rests on the stop of its knee, pressed by a 'preload' in
    its 'turning_law', or has a 'lock' while the gear is down; a 'latch' holds the retracted leg
load case, certification loads, ground loads -> study | the cases of a study are runs with names; its report gives the
    governing case of each output
torque link, torque arm, scissors -> cylindrical torsion_spring_damper | its stiffness is the 'turning_law' of the
    cylindrical joint of piston and cylinder, or two bodies with hinges
shimmy damper -> hinge torsion_spring_damper damper | a 'turning_law' of the hinge at the apex of the links
shimmy, caster, castor, drift -> wheel tire_laws | `mecano modes` finds shimmy as flutter; a tyre law with 'lateral'
    gives the side force of a drifting wheel
hold down, tie down, deployment, deploy, deployable, unfold, panel, solar array, solar panel, yoke, latch up ->
    hinge.latch release turning_law coupler rigid_body beam superelement | hinges with a 'turning_law' and a 'latch'; a
    'release' ends the hold-down; see docs/shocks.md
closed cable loop, cable loop -> belt coupler reeved_cable | a belt is a closed loop; a coupler relates two angles
car, vehicle, truck, understeer, handling, cornering, lane change, driver, cruise control, vehicle dynamics -> wheel
    transient_wheel tire_laws signals initial study | `mecano example car`: suspension, rack, a driver and a speed
    controller; docs/tyres.md, 'A car'; `mecano sweep` varies the speed
wishbone, suspension, control arm, trailing arm, knuckle, kingpin, tie rod, track rod, macpherson, macpherson strut ->
    rigid_body hinge spherical rigid_rod spring_damper place | an arm is a body on a hinge, with a spherical joint at
    the upright; a tie rod is a rigid_rod between nodes 'attached' to bodies; a template describes one corner
anti roll bar, antiroll bar, sway bar, stabilizer, stabilizer bar -> torsion_spring_damper rigid_rod | two arms on
    hinges, a torsion_spring_damper between them, a rod from each
steering, ackermann, steering rack, rack and pinion steering -> prismatic rack_and_pinion rigid_rod | a rack is a body
    on a prismatic joint, whose 'natural_displacement' is the command; tie rods are rigid_rods
toe, camber, kinematics and compliance -> rigid_rod hinge signals | they follow from the points of the suspension; a
    signal computes them
leaf spring -> beam spring_damper
elastic foundation, foundation, winkler -> spring_damper bushing repeat | one from each node of a member to a fixed node
buoyancy -> force drag | a force that is a formula of the depth of its node
timoshenko, euler bernoulli, shear factor, shear coefficient -> beam circle tube rectangle stiffness | a section of the
    type 'stiffness' takes any GA2 and GA3
rayleigh damping, proportional damping, structural damping, modal damping -> sections superelement | 'damping' of a
    section; 'mass_damping' and 'stiffness_damping' of a superelement
observer, kalman, kalman filter, lqr, pole placement -> state_space | its inputs are the measured outputs; gains follow
    from the matrices of `mecano response --state-space`
voltage, electric current, back emf, armature -> integrator joint_moment | a current is an integrator of a formula,
    without a unit: electric units are not available
torsion bar -> torsion_spring_damper beam
spring hinge, damper hinge, spring loaded hinge -> turning_law natural_angle hinge.latch | a hinge with a 'turning_law'
    of spring, damper and dry friction; its 'natural_angle' is the unloaded position
mast, deployable mast, deployable boom -> prismatic beam superelement turning_law | a telescope is prismatic, with a
    'natural_displacement' that grows; segments unfold on hinges
tape spring, tape hinge, carpenter tape -> turning_law table hinge.latch | the moment of a hinge over its angle is a
    table, whose peak lies off the straight position
reaction wheel, momentum wheel, control moment gyro, cmg, flywheel, gyroscope -> rigid_body hinge joint_moment | a rotor
    on a hinge; a joint_moment is its motor, whose value is a signal
turn slip, parking moment, parking torque, scrub moment, scrub torque, pivot turn, turning on the spot, towing -> fiala
    yawed_rolling magic_formula | 'contact_width' of a brush tyre, 'turn_slip' of a file; docs/tyres.md, 'Turning on the
    spot, tight turns'
slip ratio, slip angle -> wheel transient_wheel | outputs of every wheel with a tyre law: tyre.slip_angle
yaw rate, lateral acceleration, sideslip, sideslip angle -> signals | formulas of the motion of the body:
    chassis.angular_velocity.z; chassis.velocity.magnitude times it, in a steady turn (docs/tyres.md, A car)
yaw, roll, heading, pitch, euler, euler angles, gyro, imu, quaternion, attitude control, direction cosines -> attitude
    signals orientation held_rotation | an attitude gives yaw, pitch, roll and the directions of the axes of a node as
    outputs, which signals read; so are the angles of joints
harmonic drive, strain wave gear, gear ratio, reducer, speed reducer -> coupler torsion_spring_damper gear_pair | a
    coupler relates the angles of the motor and of its output, a torsion_spring_damper makes the output elastic
tool path, trajectory -> prescribed_position curve table | a formula or a table of time of each coordinate of the tool;
    a curve of time is a command of a controller
helicopter, rotor blade, rotordynamics, flap, lag, lead lag, campbell, campbell diagram, critical speed, ground
    resonance, whirl, rotor, jeffcott, shaft, spindle, turbine, blade flapping, southwell -> beam hinge bushing
    rigid_body | `mecano modes --sweep speed=... --campbell NODE`; 'initial: {steady: {angular_velocity: ...}}',
    docs/modes.md
disc, disk, unbalance, imbalance, eccentricity, eccentric mass -> rigid_body | an unbalance is its 'center_of_mass' off
    the axis
run up, runup, coast down -> prescribed_angle joint_moment | an angle that is a polynomial of the time: [0, 0, half the
    acceleration]
hexapod, stewart, stewart platform, gough platform -> line_force prescribed_length pid universal spherical | `mecano
    example stewart` copies a deck
length sensor, displacement sensor -> spring_damper signals | a spring_damper without stiffness, law: {spring: 0},
    outputs 'length', which formulas of signals can read
hinge friction, coulomb friction, bearing friction, sliding friction -> dry_friction hinge | a constant moment is
    'dry_friction' in the turning_law of a hinge; 'friction' of joints follows reactions
orifice, oil, hydraulic damper -> oil_damper metering_pin
accelerometer, acceleration of a node, specific force -> attitude | its outputs acceleration and specific_force
earthquake, base excitation, base acceleration, accelerogram, ground motion, vibration test -> acceleration
    prescribed_position prescribed_angle | the law acceleration as 'value' of a prescribed motion
thermal strain, temperature, heating, thermal expansion, thermal load, thermal snap, thermal flutter, eclipse -> beam
    cable | a beam has 'thermal', a cable or bar a 'natural_length' that is a law of time
bump stop, end stop, limit stop, limit, buffer -> stop hinge.stops | joints have 'stops', laws the term stop
backlash, elasto backlash, free play, freeplay, gap, play -> dead_band
clearance, clearance joint, joint clearance, journal clearance, radial clearance, loose pin -> contact dead_band | a pin
    that strikes its hole is a contact inside a cylinder (docs/shocks.md, `mecano example snap_pin`); play along a
    coordinate is a dead_band
free motion, free joint, freejoint, six dof joint, floating joint -> rigid_body | a body without joints is free
fixed translation, fixed rotation, rigid transform, body shape -> rigid_body rigid_link | a node elsewhere on a body is
    in its list 'attached'
latch, catch, locking -> hinge.latch
pwm, pulse width modulation, duty cycle, square wave, sawtooth, triangle wave, modulo, mod, periodic, periodic function
    -> switch curve | docs/signals.md (Periodic signals) writes the phase, and a switch or a curve of it
holding brake, parking brake, joint lock, interlock, locked, dog clutch -> hinge.lock brake | a 'lock' holds a joint
    while a condition is true; a brake has a torque
snap ring, circlip, snap fit, detent, ball plunger, snap -> hinge.latch contact | a latch locks; a ball on a spring and
    a grooved 'revolution' also give the force
drum contact, pin in hole, pin in a hole, surface of revolution, cone, funnel, groove -> contact | a 'cylinder' or a
    'revolution' with a profile, touched from outside, or with 'inside: true'
contact, collision, impact, unilateral -> contact plane_contact rigid_wheel stop
capsule, capsule contact, line contact, rod contact, beam contact, cylinder contact -> contact | a 'rod' in place of the
    ball touches a capsule or a cylinder
ellipsoid, spheroid, egg, rattleback, celt -> contact | an 'ellipsoid' in place of the ball touches a plane
coulomb, stick slip, dry friction, frictionloss -> friction dry_friction
friction -> dry_friction
brake disc, disc brake, anti skid, antiskid, abs -> brake
clutch, friction clutch, slip clutch, torque limiter -> torsion_spring_damper dry_friction brake hinge.lock | between
    two shafts, a torsion_spring_damper whose law is dry_friction, or a brake if its torque varies; a dog clutch is a
    lock
walker, walking robot, gait, leg with foot, stance -> grip switch contact | a foot that does not slip is held by a grip
    'while' a condition is true; `mecano example compass_walker` walks
freewheel, overrunning clutch, one way clutch, sprag clutch, backstop, ratchet -> torsion_spring_damper damper_table
    latch | a torsion_spring_damper between two shafts, whose damper_table is zero in one sense of rotation and steep in
    the other; a latch locks for good
escapement, pawl, pallet -> contact rigid_body hinge | a tooth is a node 'attached' to its wheel, and touches a capsule
    of the other body
mecanum, omni wheel, omnidirectional wheel, swedish wheel, holonomic drive, kiwi drive, mobile robot -> mecanum_wheel |
    'roller_angle: 45 deg' or '90 deg'; `mecano example mecanum` is a platform on four
tracked vehicle, crawler, caterpillar, track chain -> belt wheel contact | wheels that a belt joins turn and skid
    like those of a track; or shoes on hinges, each with a contact with every wheel, without teeth
railway, rail vehicle, train, wheelset, kalker, conicity, hunting, creep force, creepage -> force moment formula |
    contact of wheel and rail is not available; linear creep forces are loads that are formulas of the velocities
variable mass, rocket, propellant, propeller -> follower_force | a thrust; bodies whose mass varies are not available
box contact, polyhedron, stacked boxes -> contact | corners are balls of radius 0 that touch planes of other bodies;
    edges that touch are not available
stribeck, stribeck curve, stiction -> hinge.friction contact.friction formula | the 'coefficient' of friction may be a
    curve of the sliding speed; a formula of a velocity is any other force
axially moving beam, ale, arbitrary lagrangian eulerian, moving support -> slider_on_beam | the beam slides over a
    support: a slider_on_beam whose node is fixed or attached to a body
lugre, dahl, bristle, presliding -> integrator dry_friction | the state is an integrator whose input is its rate:
    docs/signals.md, States of your own
hydraulics, hydraulic actuator, hydraulic accumulator, pneumatic cylinder, winding -> integrator line_force joint_force
    joint_moment | pressures and currents are integrators whose inputs are their rates; see servo_valve.yaml and
    docs/signals.md
aircraft tyre, aircraft tire, smiley, horne, tire size, tyre size, inflation pressure -> smiley_horne yawed_rolling |
    docs/tyres.md, 'An aircraft tyre by size and pressure'
tyre, tire, pneumatic, pacejka, brush, tir, tir file -> wheel transient_wheel flexible_wheel adhesive_wheel tire_laws
    fiala magic_formula yawed_rolling
treadmill, test rig, dynamometer, ship, moving deck, carrier -> wheel_on_body | the surface, a plane or a cylinder, is
    carried by a node
rolling resistance, rolling radius, effective radius, rolling drag -> tire_laws | 'rolling_radius_coefficient' and
    'rolling_resistance' of a tyre law
lift, spoiler, lift dumper, dynamic pressure, aerodynamic force, aerodynamic drag -> force signals drag | a force by a
    law of time, or a formula of the speed: docs/tyres.md, Lift
wheel -> wheel_on_body flexible_wheel adhesive_wheel rigid_wheel cardona_wheel tire_laws
knife edge, blade, nonholonomic, sled -> skate
runway, road, terrain, track surface, ground plane, floor -> grounds
bump road, obstacle, roughness, unevenness -> grounds bump random | the 'profile' of a ground
cleat, short obstacle, kerb, curb, pothole, speed bump, arresting cable, cable crossing, runway cable -> tire_laws
    grounds | 'enveloping' of a tyre law; docs/tyres.md, 'Cleats, cables, kerbs'
orbit, tidal force, libration, clohessy wiltshire, hill equations, satellite -> gravity_gradient
tether -> gravity_gradient cable
load, nodal load, point load, concentrated load, external force, world force, weight -> force moment gravity
torque -> moment couple joint_moment
sforce, vforce, gforce, action reaction, force between two bodies, magnetic bearing -> internal_force line_force couple
    | an internal_force or a couple for each axis of the first body
thrust, thruster, following force -> follower_force
hydrostatic pressure, fluid pressure, water pressure -> pressure
distributed load, line force, uniformly distributed load -> line_load pressure line_moment
distributed moment, distributed torque -> line_moment
wind, wind load, gust, current, morison -> drag line_load | a 'drag' on each node of a member (docs/beams.md); a
    'line_load' for a given force
flutter, aeroelasticity, typical section, wagner, theodorsen -> formula transfer_function joint_force joint_moment |
    lift and moment are loads that are formulas of the motion, the lag of the wake is a transfer_function; `mecano modes
    --sweep` finds the critical speed
trolley, luffing, slewing, tower crane -> reeved_cable prismatic prescribed_angle | the trolley is an eyelet (radius 0)
    or a pulley of the rope, the winch its 'payout'; see docs/pulleys.md
spring surge, surge, coil clash -> spring_damper point_mass | a chain of masses and springs by
    'repeat'; see docs/decks.md
aerodynamics, air resistance, parachute, fluid -> drag follower_force | a lift is a follower_force whose value is a
    formula of signals
function, time series, spline, curve -> laws formula table polynomial
ramp up, smooth step, step5, havsin -> step ramp | there and back: a law that is a list of two steps
akispl, cubspl -> table | 'interpolation: spline' for motions
bistop, bumpstop -> stop hinge.stops | a term of a law is elastic, the stops of a joint are rigid
if, arithmetic if -> switch | one of two formulas, selected by two levels of its input
gstiff, wstiff, bdf -> time | `method: radau` for tight tolerances; dampings of index reduction are not needed
baumgarte, index reduction, lagrange multiplier, lagrange multipliers -> time | constraints hold in position and
    velocity without parameters: docs/theory.md
ptcv, point curve -> point_on_curve
cvcv, curve curve -> contact nonlinear_coupler | a 'cam' and a 'face' or ball
jprim, joint primitive, inplane primitive -> generic held_rotation | each of six axes held, free, driven or elastic
field -> bushing
lse, gse, tfsiso -> state_space transfer_function formula
wheel alignment, roll centre, roll center, instant centre, instant center -> attitude signals static | prescribe the
    travel of the wheel over the time of `static: {over: time}`; toe and camber are those of an 'attitude' of the
    upright, the height of the roll centre is the slope dy/dz of the contact point times its distance from the middle
    plane
iso 8608, road class, road roughness -> random | a term of the 'height' of a ground
ftire, swift, mf swift, contact patch -> transient_wheel tire_laws | rigid-ring and flexible-ring tyres are not
    available; 'enveloping' of a tyre law meets short obstacles
hertz, hertzian, hertzian contact -> contact power | a law with the term power and the exponent 1.5
inerter -> coupler rack_and_pinion screw | a body that turns by a rack or a screw between both ends, as it is built
torque converter, fluid coupling -> couple formula | a formula of the speeds of both shafts
redundant, redundancy, overconstrained, gruebler, gruebler count, degrees of freedom -> | `mecano check` lists the free
    motions and the redundant constraints
mass properties, total mass -> | `mecano check` gives the mass, `mecano momentum` the centre of mass over a run
state event, zero crossing, event -> switch until | events of elements are always located; `until` in 'time' ends a run
    by a condition
harmonic, excitation, vibration, sinusoidal -> sine prescribed_position
chirp, swept sine, sine sweep, frequency sweep -> signals formula prescribed_position | a formula of the time,
    sin(2*pi*turns) with turns: 1*time + 3*time**2/2 (docs/signals.md, Prescribed motions)
frequency response, transfer function of a mechanism, transmissibility, receptance, mobility, bode, bode plot, gain and
    phase, bandwidth, linear model, state matrices, pinput, poutput, statemat -> signals | `mecano response` finds
    transfer functions of small motions, and matrices A, B, C, D (docs/response.md); for large motions run a swept sine
gain margin, phase margin, delay margin, stability margin, loop transfer function, open loop, nyquist, nyquist plot,
    sensitivity, loop gain, crossover -> signals pid delay | `mecano margins` opens a loop at a signal (docs/margins.md)
noise, stochastic -> random
sensor, probe, request, measure, encoder -> output formula | all outputs of all elements are in the results; `mecano
    post --plot` draws them
controller, feedback, control, pd, regulator -> pid formula signals joint_moment joint_force
lookup table, characteristic, map, command profile, nonlinear gain -> curve table | a curve is a signal: a law of its
    input, which may be the time
saturation, saturate, clip, limiter, torque limit, force limit, current limit -> limit pid | a signal between two
    limits; a pid has limits, too
input shaping, input shaper, zero vibration, command shaping -> delay formula step laws | half of a command, and half
    of it delayed by half a period, leave no vibration of a mode with little damping; as a prescribed motion, a law that
    is a list of two steps
robot, robot arm, manipulator, serial robot -> hinge joint_moment pid sample_and_hold grip | links on hinges with a
    joint_moment each; prescribed_angle for inverse dynamics; `mecano new --list`
stress, stresses, von mises, bending stress, strain gauge -> beam bar | outputs of beams and bars with a section;
    `mecano post` draws them, a page colours them
work, work done, consumed energy, electric energy -> integrator | of NAME.given_power of a load, a motor or a driven
    joint; energy.given sums all of them
spectrum, psd, power spectral density, fft, fourier -> | `mecano post` with --spectrum or --density draws that of an
    output; saved times must be equidistant
rebound, rebound stop, bump, jounce -> stop | the upper and the lower stop of a law or a joint
filter, low pass, high pass, derivative -> lag washout transfer_function state_space
integral, accumulator -> integrator
initial conditions, initial condition, initial velocity, start -> initial
equilibrium, static equilibrium -> static initial
statics, statics solver, arc length, riks, buckling, snap through -> static
momentum, angular momentum, center of mass, centre of mass, center of gravity, centre of gravity -> | `mecano momentum
    deck.yaml results.h5` computes them over a run; no section of a deck is needed
results, result, sampling, save -> output | `mecano info`, `mecano post` and `mecano export` read the results
dissipation, power loss, losses, energy, energy balance -> output | the results contain energy.dissipated, energy.given,
    energy.balance; of one element, an integrator of its given_power or dissipated_power
outputs, reaction, reactions -> output study | `mecano explain KIND` lists the outputs of a kind, `mecano info RESULTS
    --names` those of a run, all of which are saved; the outputs of a study are numbers of each of its cases
unit, si, dimensions -> units
parameter, variable, constant value -> parameters
sweep, doe, optimization, optimisation, monte carlo, parameter study -> study | `mecano sweep` runs the cases of a study
    file: 'latin_hypercube' and 'seeds' make random ones, 'csv' reads values of any distribution; docs/python.md has
    many runs in one process
modes, mode, eigenvalues, eigenvalue, eigenfrequency, eigenmodes, frequency, frequencies, modal, linearize, natural
    frequency, stability, root locus -> | `mecano modes` finds frequencies, damping and shapes of small motions; no
    section of a deck is needed
integrator, integration, solver, time step, timestep, newmark, alpha -> time
tolerance, newton, convergence -> time static
penalty, augmented lagrangian -> time
g, acceleration of gravity -> gravity
marker, site, frame, node, point, coordinate system, body frame -> nodes
group, assembly, subsystem, macro -> templates place include
loop, copies, pattern, array -> repeat templates
import, file -> include
variant, overlay, override, inherit, base deck -> include set | a variant includes a deck, adds entries and replaces
    values by 'set'
python, notebook, jupyter, pandas, xarray, matlab -> | mecano.run, modes, response and sweep; results become arrays,
    pandas or xarray: see docs/python.md
report -> | `mecano post` with --report writes a page of a run, or of the table of a study
steady turn, steady cornering, skid pad, skidpad, constant radius -> steady | 'initial: {steady: {angular_velocity: ...,
    about: ...}}' with wheels; docs/tyres.md, 'A car'
steady state, steady motion, trim -> steady static | 'initial: {steady: ...}' starts in steady running or rotation,
    'initial: static' at rest
tire pressure, tyre pressure -> smiley_horne magic_formula | an aircraft tyre by size and pressure; 'pressure' of a .tir
    file
stiffness matrix, mass matrix -> superelement bushing matrix | of a part, of a connection of two nodes, of the section
    of a beam
torque margin, deployment margin, motorization margin, motorisation margin, deployment torque margin -> hinge.latch
    turning_law | `mecano post` draws the margin of hinges with a law and a latch (docs/shocks.md, What the results
    contain)
cbar, cbeam -> beam
crod, conrod -> bar
conm2 -> rigid_body
cbush -> bushing
celas, celas1, celas2, cdamp, cvisc -> spring_damper torsion_spring_damper
rbe2, rbar -> rigid_link rigid_body | 'attached' of a rigid_body lists the nodes that move with it
mpc -> coupler generic
spc -> nodes fixed | 'fixed: true' of a node
dmig -> superelement | matrices are read from a file (docs/superelements.md)
animation, picture, plot, graph -> | `mecano post` draws results, with --animate a page with the motion
"""
"""Words with the same meaning -> names in mecano, best first | a note; lines that are indented continue an entry."""


def _entries():
    """Yield (words, (names in mecano, note)) of each entry."""
    for entry in re.split(r"\n(?! )", TABLE.strip()):
        words, _, meaning = " ".join(entry.split()).partition(" ->")
        names, _, note = meaning.partition(" | ")
        yield words, (names.strip(), note)


NOTES = dict(_entries())
SYNONYMS = {word: entry for words, entry in NOTES.items() for word in words.split(", ")}
SEPARATORS = re.compile(r"[\s_-]+")
CAPITAL = re.compile(r"(?<=[a-z0-9])(?=[A-Z])")  # that begins a word, as in LossyGear


def synonym(name: str) -> tuple[tuple[str, ...], str] | None:
    """Return (names of the equivalents in mecano, best first; note) of a word of other programs, or None."""
    words = [SEPARATORS.sub(" ", text.lower().strip()) for text in (name, CAPITAL.sub(" ", name))]
    entry = next((SYNONYMS[form] for word in words for form in _forms(word) if form in SYNONYMS), None)
    return entry and (tuple(entry[0].split()), entry[1])


def synonym_of_end(name: str) -> tuple[tuple[str, ...], str] | None:
    """Return ``synonym`` of the longest end of several words that has one, as in "double wishbone", or None."""
    words = SEPARATORS.split(name.strip())
    return next((found for i in range(1, len(words)) if (found := synonym(" ".join(words[i:])))), None)


def _forms(word):
    """Yield a word and its other forms: singular, without "joint" or "element"."""
    yield word
    yield word.removesuffix("s")
    yield word.removesuffix(" joint").removesuffix(" element")
