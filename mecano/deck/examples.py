"""Example lines of decks for each kind, shape of a section and term of a law, shown by `mecano explain`.

All belong to one imaginary deck with nodes crank, rod, slider, wheel..., a ground road, tire laws, a section pipe, a
law viscous, joints knee and rail (tests/test_deck_examples.py).
"""

from textwrap import wrap

EXAMPLES = {
    "point_mass": "ballast: {type: point_mass, node: rod, mass: 2 kg}",
    "rigid_body":
        "crank: {type: rigid_body, node: crank, mass: 1.2 kg, inertia: [1.0e-3, 2.0e-2, 2.0e-2], attached: [pin]}",
    "attitude": "gyro: {type: attitude, node: rod}",
    "rigid_link": "arm: {type: rigid_link, nodes: [crank, pin]}",
    "hinge": "elbow: {type: hinge, nodes: [crank, rod], axis: [0, 1, 0], stops: {lower: -30 deg, upper: 120 deg}}",
    "spherical": "ball: {type: spherical, nodes: [crank, rod]}",
    "constant_velocity": "rzeppa: {type: constant_velocity, nodes: [crank, rod], axis: [1, 0, 0], axis_b: [1, 0, 0.2]}",
    "universal": "cross: {type: universal, nodes: [crank, rod], axis_a: [1, 0, 0], axis_b: [0, 1, 0]}",
    "cylindrical": "sleeve: {type: cylindrical, nodes: [ground, slider], axis: [1, 0, 0]}",
    "prismatic": "guide: {type: prismatic, nodes: [ground, slider], axis: [1, 0, 0]}",
    "planar": "table: {type: planar, nodes: [ground, slider], axis: [0, 0, 1]}",
    "screw": "jack: {type: screw, nodes: [ground, slider], axis: [1, 0, 0], pitch: 5 mm}",
    "fixed": "weld: {type: fixed, nodes: [ground, crank]}",
    "grip": "gripper: {type: grip, nodes: [crank, slider], close: {time: 0.2 s}, release: {time: 0.6 s}}",
    "rigid_rod": "rod: {type: rigid_rod, nodes: [crank, slider]}",
    "gear_pair":
        "gears: {type: gear_pair, nodes: [ground, crank, slider], axis_a: [0, 1, 0], radius_a: 0.4 m, radius_b: 0.6 m, "
        "backlash: 0.1 mm, friction: {efficiency: 0.98, regularization: 1 mm/s}}",
    "coupler": "spindle: {type: coupler, angles: [knee], displacements: [rail], factors: [0.1, -1]}",
    "nonlinear_coupler":
        "indexer: {type: nonlinear_coupler, displacement: rail, of_angle: knee, "
        "function: {sine: {amplitude: 20 mm, frequency: 0.159155}}}",
    "rack_and_pinion":
        "rack: {type: rack_and_pinion, nodes: [ground, rod], axis: [0, 1, 0], direction: [1, 0, 0], radius: 50 mm}",
    "point_on_curve":
        "cam: {type: point_on_curve, nodes: [ground, slider], center: [1 m, 0, 0.8 m], semi_axis_1: [0, 0, 200 mm], "
        "semi_axis_2: [100 mm, 0, 0]}",
    "slider_on_beam": "collar: {type: slider_on_beam, node: rod, line: [crank, girder.1, slider]}",
    "prescribed_position":
        "shaker: {type: prescribed_position, node: slider, direction: [1, 0, 0], "
        "value: {sine: {amplitude: 2 mm, frequency: 5 Hz}}}",
    "prescribed_length":
        "leg: {type: prescribed_length, nodes: [crank, slider], value: {sine: {amplitude: 20 mm, frequency: 1 Hz}}}",
    "prescribed_angle":
        "motor: {type: prescribed_angle, nodes: [ground, crank], axis: [0, 1, 0], value: {linear: {slope: 60 rpm}}}",
    "held_rotation": "upright: {type: held_rotation, nodes: [ground, slider]}",
    "generic": "mount: {type: generic, nodes: [ground, slider], axis: [0, 0, 1], free: [along_axis]}",
    "beam": "leg: {type: beam, nodes: [crank, slider], section: pipe, mesh: 4}",
    "superelement": "wing: {type: superelement, nodes: [crank, slider], file: wing.npz}",
    "bar": "tie: {type: bar, nodes: [crank, slider], E: 210 GPa, area: 80 mm2}",
    "cable": "rope: {type: cable, nodes: [crank, slider], axial_stiffness: 50 kN, natural_length: 0.9 m}",
    "spring_damper": "strut: {type: spring_damper, nodes: [crank, slider], law: viscous}",
    "oleo": (
        "strut: {type: oleo, nodes: [crank, slider], gas: {pressure: 12 bar, volume: 1.4e-3, area: 4.0e-3}, "
        "oil: {area: 4.0e-3, volume: 1.5e-3, orifice: 1.2e-4}}"
    ),
    "torsion_spring_damper":
        "coil: {type: torsion_spring_damper, nodes: [crank, rod], axis: [0, 1, 0], "
        "law: {spring: {stiffness: 2 N m/deg}}}",
    "belt": (
        "rope: {type: belt, nodes: [crank, wheel, slider], radii: [0, 0.1 m, 0], axis: [0, 1, 0], "
        "axial_stiffness: 50 kN}"
    ),
    "reeved_cable": (
        "rope: {type: reeved_cable, nodes: [crank, wheel, slider], radii: [0, 0.1 m, 0], axis: [0, 1, 0], "
        "axial_stiffness: 50 kN}"
    ),
    "bushing":
        "mount: {type: bushing, nodes: [ground, crank], stiffness: [1 kN/mm, 1 kN/mm, 3 kN/mm, 50, 50, 20], "
        "axis: [0, 0, 1]}",
    "contact": (
        "stop: {type: contact, nodes: [crank, slider], plane: {normal: [1, 0, 0]}, radius: 10 mm, restitution: 0.3}"
    ),
    "plane_contact": "foot: {type: plane_contact, node: slider, ground: road, restitution: 0.4}",
    "force": "push: {type: force, node: slider, direction: [1, 0, 0], value: 3 kN}",
    "follower_force":
        "thruster: {type: follower_force, node: crank, direction: [1, 0, 0], value: {step: {time: 0.5, rise: 0.1, "
        "from: 0, to: 200 N}}}",
    "drag": "canopy: {type: drag, node: slider, area: 50 m2, coefficient: 1.5}",
    "gravity_gradient":
        "orbit: {type: gravity_gradient, node: crank, mass: 1.2 kg, inertia: [1.0e-3, 2.0e-2, 2.0e-2], rate: 1.1e-3, "
        "normal: [0, 0, 1], radial: [1, 0, 0]}",
    "line_load": "wind: {type: line_load, line: [crank, girder.1, slider], direction: [1, 0, 0], value: 200}",
    "line_moment": "screw: {type: line_moment, line: [crank, girder.1, slider], direction: [1, 0, 0], value: 30 N}",
    "pressure":
        "water: {type: pressure, line: [crank, girder.1, slider], across: [0, 1, 0], width: 0.4, value: 0.2 bar}",
    "moment": "twist: {type: moment, node: crank, direction: [0, 1, 0], value: 12 N m}",
    "follower_moment": "twist: {type: follower_moment, node: crank, direction: [0, 1, 0], value: 12 N m}",
    "couple": "drive: {type: couple, nodes: [crank, rod], axis: [0, 1, 0], value: 12 N m}",
    "joint_moment":
        "motor: {type: joint_moment, joint: knee, value: 40*(0.5 - knee.angle) - 2*knee.rate}",
    "joint_force": "thruster: {type: joint_force, joint: rail, value: 3 kN}",
    "internal_force": "magnet: {type: internal_force, nodes: [crank, slider], axis: [0, 0, 1], value: 40 N}",
    "line_force": "cylinder: {type: line_force, nodes: [crank, slider], value: -200*slider.velocity.x}",
    "formula": "speed: {type: formula, value: 'hypot(slider.velocity.x, slider.velocity.z)'}",
    "curve": "command: {type: curve, input: time, law: {table: {points: [[0, 0], [2, 1.2], [5, 0.4]]}}}",
    "lag": "smooth: {type: lag, input: knee.rate, time_constant: 20 ms}",
    "integrator": "offset: {type: integrator, input: 0.3 - rail.displacement}",
    "washout": "shock: {type: washout, input: slider.velocity.z, time_constant: 0.5 s}",
    "pid":
        "command: {type: pid, input: 0.3 - rail.displacement, proportional: 80, integral: 40, derivative: 6, "
        "derivative_time: 10 ms, lower: -200, upper: 200}",
    "transfer_function":
        "actuator: {type: transfer_function, input: knee.angle, numerator: [1], denominator: [1, 0.06, 0.01]}",
    "state_space":
        "observer: {type: state_space, inputs: [knee.angle, knee.rate], A: [[-10]], B: [[8, 2]], C: [1]}",
    "limit": "torque: {type: limit, input: 40*rail.velocity, lower: -5, upper: 5, unit: N m}",
    "switch": "valve: {type: switch, input: rail.velocity, upper: 0.1, lower: -0.1, high: 5, low: -5}",
    "sample_and_hold": "seen: {type: sample_and_hold, input: knee.angle, period: 10 ms}",
    "delay": "late: {type: delay, input: knee.rate, time: 30 ms}",
    "external": "command: {type: external, unit: N m}",
    "brake": "brake: {type: brake, nodes: [crank, rod], axis: [0, 1, 0], torque: 400 N m}",
    "rigid_wheel": "disc: {type: rigid_wheel, node: wheel, radius: 0.3 m, axis: [0, 1, 0], ground: road}",
    "cardona_wheel": "disc: {type: cardona_wheel, node: wheel, radius: 0.3 m, axis: [0, 1, 0], ground: road}",
    "mecanum_wheel":
        "disc: {type: mecanum_wheel, node: wheel, radius: 0.3 m, axis: [0, 1, 0], ground: road, roller_angle: 45 deg}",
    "skate": "blade: {type: skate, node: slider, axis: [0, 1, 0], ground: road}",
    "wheel": "nose: {type: wheel, node: wheel, axis: [0, 1, 0], tire_law: tyre, ground: road}",
    "wheel_on_body":
        "nose: {type: wheel_on_body, nodes: [crank, wheel], axis: [0, 1, 0], tire_law: tyre, "
        "cylinder: {axis: [0, 1, 0], radius: 0.4 m}}",
    "transient_wheel": "nose: {type: transient_wheel, node: wheel, axis: [0, 1, 0], tire_law: brush, ground: road}",
    "flexible_wheel": "nose: {type: flexible_wheel, node: wheel, axis: [0, 1, 0], tire_law: soft_tyre, ground: road}",
    "adhesive_wheel": "nose: {type: adhesive_wheel, node: wheel, axis: [0, 1, 0], tire_law: soft_tyre, ground: road}",
    "fiala":
        "road_tyre: {radius: 0.3 m, radial: {linear: {slope: 200 kN/m}}, "
        "fiala: {cornering_stiffness: 60 kN, friction: 0.8, contact_length: 120 mm}}",
    "yawed_rolling":
        "main: {smiley_horne: {diameter: 25.5 in, width: 8 in, pressure: 145 psi, rated_pressure: 200 psi, "
        "load: 30 kN}, yawed_rolling: {friction: 0.6}}",
    "magic_formula": "car: {magic_formula: {file: passenger_car.tir, pressure: 2.3 bar}}",
    "circle": "shaft: {type: circle, diameter: 30 mm, E: 210 GPa, nu: 0.3, density: 7850}",
    "tube": "tube: {type: tube, diameter: 80 mm, thickness: 5 mm, E: 210 GPa, nu: 0.3, density: 7850}",
    "rectangle": "strip: {type: rectangle, width: 20 mm, height: 2 mm, E: 70 GPa, nu: 0.33, density: 2700}",
    "stiffness":
        "rod: {type: stiffness, EA: 1.0e4, GA2: 5.0e3, GA3: 5.0e3, GJ: 100, EI2: 100, EI3: 100, mass_per_length: 1, "
        "rotary_inertia: [2.0e-2, 1.0e-2, 1.0e-2]}",
    "matrix":
        "blade: {type: matrix, stiffness: [[1.0e6, 0, 0, 0, 0, 0], [0, 3.0e5, 0, 0, 0, 0], [0, 0, 3.0e5, 0, 0, 0], "
        "[0, 0, 0, 50, 10, 0], [0, 0, 0, 10, 80, 0], [0, 0, 0, 0, 0, 900]], "
        "mass: [[1, 0, 0, 0, 0, 0], [0, 1, 0, 0, 0, 0], [0, 0, 1, 0, 0, 0], "
        "[0, 0, 0, 2.0e-3, 0, 0], [0, 0, 0, 0, 1.0e-3, 0], [0, 0, 0, 0, 0, 1.0e-3]]}",
    "constant": "load: {constant: 3 kN, sine: {amplitude: 1 kN, frequency: 2 Hz}}",
    "linear": "turning: {linear: {slope: 60 rpm}}",
    "polynomial": "stiffening: {polynomial: {coefficients: [0, 2 kN/mm, 3 N/mm^2]}}",
    "power": "contact: {power: {coefficient: 1.0e9 N/m^1.5, exponent: 1.5}} # of Hertz",
    "table": "measured: {table: {points: [[0, 0], [10 mm, 2 kN], [20 mm, 5 kN]], beyond: extend}}",
    "sine": "shaking: {sine: {amplitude: 2 mm, frequency: 5 Hz}}",
    "ramp": "pull: {ramp: {start: 0.5 s, end: 1 s, from: 0, to: 3 kN}}",
    "step": "pull: {step: {time: 0.5 s, rise: 0.1 s, from: 0, to: 3 kN}}",
    "exponential": "friction: {exponential: {start: 0.8, limit: 0.3, rate: 0.05}}",
    "acceleration": "quake: {acceleration: {points: [[0 s, 0], [0.1 s, 2], [0.3 s, -1], [0.5 s, 0]]}}",
    "bump": "bump: {bump: {start: 10 m, length: 2 m, height: 50 mm}}",
    "random": "road: {random: {density: 1.0e-6, seed: 1}}",
    "spring": "coil: {spring: {stiffness: 20 kN/m}}",
    "preload": "coil: {spring: {stiffness: 20 kN/m}, preload: {force: 500 N}}",
    "damper": "shock: {spring: {stiffness: 20 kN/m}, damper: {coefficient: 300}}",
    "damper_polynomial": "shock: {damper_polynomial: {coefficients: [0, 300, 0, 20]}}",
    "damper_power": "drag: {damper_power: {coefficient: 12 N s2/m2, exponent: 2}}",
    "damper_table": "shock: {damper_table: {points: [[-1, -500], [0, 0], [1, 2000]]}}",
    "gas_spring": "oleo: {gas_spring: {force: 20 kN, length: 0.5 m, exponent: 1.2}}",
    "oil_damper": "oleo: {oil_damper: {compression: 8.0e3, rebound: 6.0e4}}",
    "metering_pin":
        "oleo: {metering_pin: {density: 870, piston_area: 80 cm2, discharge_coefficient: 0.7, "
        "points: [[0, 4 cm2], [0.3, 1 cm2]]}}",
    "dry_friction": "seal: {dry_friction: {force: 200 N, regularization: 1 mm/s}}",
    "stop": "bumper: {stop: {stiffness: 5 kN/mm, lower: -100 mm, upper: 100 mm}}",
    "dead_band": "play: {dead_band: {stiffness: 5 kN/mm, lower: -1 mm, upper: 1 mm}}",
}  # fmt: skip


def example_lines(name: str, section: str, width: int) -> list[str]:
    """Return the lines of an example in its section; none for a name without an example."""
    if name not in EXAMPLES:
        return []
    lines = wrap(EXAMPLES[name], width, initial_indent="    ", subsequent_indent="      ", break_on_hyphens=False)
    return ["", "Example", f"  {section}:", *lines]
