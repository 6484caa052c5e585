"""Line 9: decks that are hard to integrate: stick-slip, snap-through, latches, lift-off, sudden loads, jams, Zeno.

Each must come to its end with its energies balanced, or say why it cannot. And rejected steps may leave nothing behind.
"""

import random
import re
import resource
from collections import Counter
from functools import partial

import numpy as np
from scorecard.outcome import forked, unfit
from scorecard.trial import Job, Line

LINES = (
    Line(
        9,
        "hard decks: the end with a balance within 1 %, or exit 3 with element, time and advice; rejected steps",
        10,
        60,
    ),
)
CPU = 60  # s
BALANCE = 0.01  # of the largest exchange
EXCHANGED = ("kinetic", "potential", "dissipated", "given")
REST = 1e-6  # of the length scale: where there is no tolerance, by how much rejected steps may change a position
ELEMENT = re.compile(r"\b[a-z_]+ '[^']+'")
HEAD = "mecano: 1\ngravity: [0, 0, {g}]\n"


def jobs(lines, factor, seed):
    """As many decks as asked for, of all families in turn."""
    count, made = max(round(factor * LINES[0].count), len(FAMILIES)), Counter()
    for i in range(count):
        name, family = FAMILIES[i % len(FAMILIES)]
        text = family(random.Random(f"{seed} hard {i}"), made[name])
        made[name] += 1
        yield Job(9, f"{name} {made[name]}", partial(trial, text), wall=900.0)


def trial(text, folder):
    """Run a deck; then again with rejected steps."""
    (folder / "deck.yaml").write_text(text)
    outcome = forked(
        ["run", "deck.yaml", "--quiet"], folder, lambda: resource.setrlimit(resource.RLIMIT_CPU, (CPU, CPU + 5))
    ).ended()
    (folder / "said.txt").write_text(outcome.err)
    if outcome.code in (-24, 152):
        return f"no end within {CPU} s of processor time"
    if why := unfit(outcome, (0, 3), cpu=CPU):
        return why
    return (
        unexplained(outcome.err, last_time(folder))
        if outcome.code
        else unbalanced(energies(folder)) or rejected(folder)
    )


def last_time(folder):
    """The last saved step of a run [s]."""
    import mecano

    with mecano.open_results(folder / "deck.h5") as results:
        steps = results.steps["time"]
        return float(steps[-1]) if len(steps) else float(results.time[0])


def unexplained(text, last):
    """Return what the message of a failed run lacks; ``last`` is the time of the last step in its file [s]."""
    if not ELEMENT.search(text):
        return f"no element is named: {text.strip().splitlines()[0]}"
    if not (named := re.search(r"t = ([-+.\de]+) s", text)):
        return "no time is named"
    if abs(float(named[1]) - last) > 1e-6 * max(1.0, abs(last)):
        return f"the time named is {named[1]} s, the last in the file {last:.9g} s"
    return "" if "what to try" in text or "try:" in text else "no advice"


def energies(folder):
    """Largest and least value of each energy over all steps: {name: (greatest, least)}."""
    import mecano

    with mecano.open_results(folder / "deck.h5") as results:
        found = {name: results.extremes[f"energy/{name}"] for name in ("balance", *EXCHANGED)}
        return {name: (e.maximum, e.minimum) for name, e in found.items()}


def unbalanced(found):
    """By how much more than allowed the balance of energies varies; or empty."""
    exchange = max(found[name][0] - found[name][1] for name in EXCHANGED)
    off = found["balance"][0] - found["balance"][1]
    if not np.isfinite(off) or off > BALANCE * exchange:
        return f"the balance varies by {off:.3g} J, {100 * off / exchange:.3g} % of the largest exchange"
    return ""


def rejected(folder):
    """Return whether a run that rejects and repeats every third step reaches another end; or empty."""
    from mecano.analyses.prepare import integrator_of, prepare
    from mecano.deck.read import read_deck

    ends = []
    for every in (0, 3):
        checked = read_deck(folder / "deck.yaml")
        prepared = prepare(checked)
        integrator = integrator_of(prepared)
        reject(integrator, every)
        final = integrator.to(
            checked.values["time"]["end"], integrator.begin(prepared.state, checked.values["time"]["step"])
        )
        ends.append(final.motion)
    adaptive = checked.values["time"]["adaptive"]
    of, plain = prepared.system.numbering, ends[0]
    places = (of.x[:, None] + np.arange(3)).ravel()
    off = float(np.abs(ends[1].z[places] - plain.z[places]).max()) / prepared.length
    allowed = adaptive["tolerance"] if adaptive else REST
    return f"rejected steps move the end by {off:.3g} of the length scale" if not off <= allowed else ""


def reject(integrator, every):
    """Let a run reject every ``every``-th step, try another size in between, and repeat the step."""
    trials, count = integrator.trials, [0]
    judge = trials._size_to_retry

    def instead(run, trial, h, *more):
        smaller = judge(run, trial, h, *more)
        count[0] += smaller is None
        if every and smaller is None and count[0] % every == 0:
            trials._step(run, 0.3 * h)
            return h
        return smaller

    trials._size_to_retry = instead
    integrator.ordinary = lambda run, stop: (run, None, True)  # every step is one of Python's, which asks


def log(rng, low, high):
    """A number between two, evenly over its logarithm, of three digits."""
    return float(f"{low * (high / low) ** rng.random():.3g}")


# --- families: (rng, number of the deck) -> text


def stick_slip(rng, i):
    """A block that a spring draws over a guide whose friction falls with speed."""
    stiffness, mass, speed = log(rng, 50, 5e3), log(rng, 0.5, 5), log(rng, 0.01, 0.2)
    rest, moving = 0.5, 0.5 * rng.uniform(0.4, 0.9)
    return (
        HEAD.format(g=-9.81)
        + f"""
nodes:
  block: {{position: [0, 0, 0]}}
  hand: {{position: [0.5, 0, 0]}}
elements:
  block: {{type: rigid_body, node: block, mass: {mass}, inertia: [0.01, 0.01, 0.01]}}
  hand: {{type: rigid_body, node: hand, mass: 0.1, inertia: [1e-3, 1e-3, 1e-3]}}
  spring: {{type: spring_damper, nodes: [block, hand], law: {{spring: {{stiffness: {stiffness}}}}}}}
joints:
  guide:
    type: prismatic
    nodes: [ground, block]
    axis: [1, 0, 0]
    friction:
      coefficient: {{exponential: {{start: {rest}, limit: {moving:.3g}, rate: 20}}}}
      regularization: {log(rng, 1e-5, 1e-3)}
  rail: {{type: prismatic, nodes: [ground, hand], axis: [1, 0, 0]}}
  drive: {{type: prescribed_position, node: hand, direction: [1, 0, 0], value: {{linear: {{slope: {speed}}}}}}}
time: {{end: 2, step: 1e-3, adaptive: {{tolerance: 1e-4}}}}
"""
    )


def snap_through(rng, i):
    """The truss of von Mises under a load that rises beyond what it bears, with and without damping."""
    height, stiffness, mass = rng.uniform(0.1, 0.5), log(rng, 1e2, 1e5), log(rng, 0.1, 10)
    damper = f", damper: {{coefficient: {log(rng, 0.1, 10)}}}" if i % 2 else ""
    bar = f"law: {{spring: {{stiffness: {stiffness}}}{damper}}}"
    load = 2 * stiffness * height**3  # beyond the limit load of a flat truss, 0.385 k h^3 x 2
    return (
        HEAD.format(g=0)
        + f"""
nodes:
  left: {{position: [-1, 0, 0], fixed: true}}
  right: {{position: [1, 0, 0], fixed: true}}
  top: {{position: [0, 0, {height:.3g}]}}
elements:
  mass: {{type: point_mass, node: top, mass: {mass}}}
  left_bar: {{type: spring_damper, nodes: [left, top], {bar}}}
  right_bar: {{type: spring_damper, nodes: [right, top], {bar}}}
joints:
  plane: {{type: prescribed_position, node: top, direction: [0, 1, 0], value: 0.0}}
loads:
  weight: {{type: force, node: top, direction: [0, 0, -1], value: {{ramp: {{start: 0.1, end: 1, from: 0, to: {load:.4g}}}}}}}
time: {{end: 1.5, step: 1e-3, adaptive: {{tolerance: 1e-4}}}}
"""  # noqa: E501
    )


def latches(rng, i):
    """A folded chain of panels, opened by springs, each locked by a latch; some locks at nearly the same time."""
    count, text = 2 + i % 4, HEAD.format(g=0)
    nodes, elements, joints, before, start = [], [], [], "ground", np.zeros(3)
    for k in range(count):
        side = k % 2  # of the folded stack: panels lie on one another, turned by pi
        turn = f", orientation: [0, 0, {3.1 * side}]" if side else ""
        x, y = (np.cos(3.1), np.sin(3.1)) if side else (1.0, 0.0)
        end = start + np.array([x, y, 0.0])
        nodes += [f"p{k}: {{position: [{start[0]:.15g}, {start[1]:.15g}, 0]{turn}}}",
                  f"e{k}: {{position: [{end[0]:.15g}, {end[1]:.15g}, 0]{turn}}}"]  # fmt: skip
        elements.append(
            f"panel{k}: {{type: rigid_body, node: p{k}, mass: {log(rng, 0.5, 2)}, center_of_mass: [0.5, 0, 0], "
            f"inertia: [1e-3, 0.08, 0.08], attached: [e{k}]}}"
        )
        angle = 1.57 if k == 0 else (3.1 if side == 0 else -3.1)
        joints.append(
            f"hinge{k}: {{type: hinge, nodes: [{before}, p{k}], axis: [0, 0, 1], natural_angle: {1.05 * angle:.4g}, "
            f"turning_law: {{spring: {{stiffness: {log(rng, 0.2, 2)}}}, damper: {{coefficient: 0.02}}}}, "
            f"latch: {{angle: {angle}}}}}"
        )
        before, start = f"e{k}", end
    for section, rows in (("nodes", nodes), ("elements", elements), ("joints", joints)):
        text += f"{section}:\n" + "".join(f"  {row}\n" for row in rows)
    return text + "time: {end: 8, step: 1e-3, adaptive: {tolerance: 1e-4}}\n"


def lift_off(rng, i):
    """What is shaken on a floor, or rolls over bumps: contacts that open and close."""
    if i % 2:
        return (
            HEAD.format(g=-9.81)
            + f"""
nodes: {{hub: {{position: [0, 0, 0.298]}}}}
elements:
  rim: {{type: rigid_body, node: hub, mass: 20, inertia: [0.6, 1, 0.6]}}
  tire: {{type: wheel, node: hub, axis: [0, 1, 0], tire_law: rubber, ground: road}}
joints: {{guide: {{type: planar, nodes: [ground, hub], axis: [0, 1, 0]}}}}
tire_laws:
  rubber: {{radius: 0.3, radial: {{linear: {{slope: {log(rng, 5e4, 5e5)}}}}}, friction: 0.5, slip_regularization: 0.1}}
grounds:
  road:
    plane: {{point: [0, 0, 0], normal: [0, 0, 1]}}
    profile: {{direction: [1, 0, 0], height: {{sine: {{amplitude: {log(rng, 0.005, 0.03)}, frequency: {log(rng, 0.2, 1)}}}}}}}
initial: {{velocities: [{{nodes: [hub], velocity: [{log(rng, 5, 25)}, 0, 0], angular_velocity: [0, 40, 0]}}]}}
time: {{end: 1, step: 1e-3, adaptive: {{tolerance: 3e-5}}}}
"""  # noqa: E501
        )
    restitution = rng.choice([0, 0.2, 0.5, 0.9])
    return (
        HEAD.format(g=-9.81)
        + f"""
nodes: {{block: {{position: [0, 0, 0]}}, foot: {{position: [0, 0, 0]}}}}
elements:
  block: {{type: rigid_body, node: block, mass: 2, inertia: [0.1, 0.1, 0.1], center_of_mass: [0, 0, 0.2], attached: [foot]}}
  contact: {{type: plane_contact, node: foot, ground: floor, restitution: {restitution}}}
joints: {{guide: {{type: prismatic, nodes: [ground, block], axis: [0, 0, 1]}}}}
grounds: {{floor: {{plane: {{point: [0, 0, 0], normal: [0, 0, 1]}}}}}}
loads:
  shaker: {{type: force, node: block, direction: [0, 0, 1], value: {{sine: {{amplitude: {log(rng, 30, 100)}, frequency: {log(rng, 1, 20)}}}}}}}
time: {{end: 3, step: 1e-3, adaptive: {{tolerance: 1e-4}}}}
"""  # noqa: E501
    )


RISES = [10.0**-k for k in range(1, 13)]


def sudden_load(rng, i):
    """A load that rises within 1e-1 to 1e-12 s on rigid parts, a beam, a spring; with steps fixed and adaptive."""
    rise = RISES[i % len(RISES)]
    steps = rng.choice(["step: 1e-3", "step: 1e-3, adaptive: {tolerance: 1e-4}"])
    law = f"{{step: {{time: 0.05, rise: {rise:.0e}, from: 0, to: {log(rng, 1, 20)}}}}}"
    load = f"loads: {{blow: {{type: force, node: tip, direction: [0, 0, 1], value: {law}}}}}\n"
    end = f"time: {{end: 0.3, {steps}}}\n"
    return HEAD.format(g=0) + rng.choice(STRUCK) + load + end


STRUCK = (
    "nodes: {tip: {position: [0, 0, 0]}}\nelements: {m: {type: point_mass, node: tip, mass: 1}}\n",
    "nodes: {wall: {position: [0, 0, 1], fixed: true}, tip: {position: [0, 0, 0]}}\n"
    "elements:\n  m: {type: point_mass, node: tip, mass: 1}\n"
    "  s: {type: spring_damper, nodes: [wall, tip], law: {spring: {stiffness: 1e4}, damper: {coefficient: 3}}}\n",
    "nodes: {root: {position: [0, 0, 0]}, tip: {position: [1, 0, 0]}}\n"
    "elements: {bar: {type: rigid_body, node: root, mass: 1, center_of_mass: [0.5, 0, 0], inertia: [1e-3, 0.08, 0.08], "
    "attached: [tip]}}\njoints: {pin: {type: hinge, nodes: [ground, root], axis: [0, 1, 0]}}\n",
    "sections: {tube: {type: tube, diameter: 0.05, thickness: 0.002, E: 7e10, nu: 0.3, density: 2700, damping: 1e-4}}\n"
    "nodes: {root: {position: [0, 0, 0], fixed: true}, tip: {position: [1, 0, 0]}}\n"
    "elements:\n  boom: {type: beam, nodes: [root, tip], section: tube, mesh: 4}\n"
    "  m: {type: point_mass, node: tip, mass: 1}\n",
)


def jam(rng, i):
    """What comes to rest against itself: a guide that locks, a crank at its dead centre, a drive against a stop."""
    return (sticking_guide, dead_centre, driven_on_a_stop)[i % 3](rng)


def sticking_guide(rng):
    """A sleeve on a post, loaded off its axis: with enough friction no load can move it."""
    arm, length = rng.uniform(0.02, 0.5), rng.uniform(0.05, 0.3)
    return (
        HEAD.format(g=-9.81)
        + f"""
nodes: {{sleeve: {{position: [0, 0, 0]}}, arm: {{position: [{arm:.3g}, 0, 0]}}}}
elements:
  sleeve: {{type: rigid_body, node: sleeve, mass: 1, inertia: [0.01, 0.01, 0.01], attached: [arm]}}
joints:
  post: {{type: prismatic, nodes: [ground, sleeve], axis: [0, 0, 1],
         friction: {{coefficient: {rng.uniform(0.1, 0.6):.3g}, regularization: 1e-4, length: {length:.3g}}}}}
loads: {{press: {{type: force, node: arm, direction: [0, 0, -1], value: {{ramp: {{start: 0.1, end: 0.6, from: 0, to: {log(rng, 10, 1e3)}}}}}}}}}
initial: {{velocities: [{{nodes: all, velocity: [0, 0, -0.2]}}]}}
time: {{end: 1, step: 1e-3, adaptive: {{tolerance: 1e-4}}}}
"""  # noqa: E501
    )


def dead_centre(rng):
    """A slider-crank pushed at its slider into the dead centre, with friction in the bore."""
    crank, rod, angle = 0.1, rng.uniform(0.15, 0.4), rng.uniform(0.3, 1.2)
    x, z = crank * np.cos(angle), crank * np.sin(angle)
    slider = x + np.sqrt(rod**2 - z**2)
    lean = float(np.arctan2(-z, slider - x))
    return (
        HEAD.format(g=0)
        + f"""
nodes:
  crank: {{position: [0, 0, 0]}}
  pin: {{position: [{x:.15g}, 0, {z:.15g}]}}
  big: {{position: [{x:.15g}, 0, {z:.15g}], orientation: [0, {-lean:.15g}, 0]}}
  small: {{position: [{slider:.15g}, 0, 0], orientation: [0, {-lean:.15g}, 0]}}
  slider: {{position: [{slider:.15g}, 0, 0]}}
elements:
  crank: {{type: rigid_body, node: crank, mass: 1, inertia: [1e-3, 1e-3, 1e-3], attached: [pin]}}
  rod: {{type: rigid_body, node: big, mass: 0.3, center_of_mass: [{rod / 2:.6g}, 0, 0], inertia: [1e-5, 1e-3, 1e-3], attached: [small]}}
  slider: {{type: rigid_body, node: slider, mass: 0.4, inertia: [1e-4, 1e-4, 1e-4]}}
joints:
  bearing: {{type: hinge, nodes: [ground, crank], axis: [0, 1, 0]}}
  big_end: {{type: spherical, nodes: [pin, big]}}
  small_end: {{type: cylindrical, nodes: [slider, small], axis: [0, 1, 0]}}
  bore: {{type: prismatic, nodes: [ground, slider], axis: [1, 0, 0],
         friction: {{coefficient: {rng.uniform(0.05, 0.4):.3g}, regularization: 1e-3}}}}
loads: {{push: {{type: force, node: slider, direction: [1, 0, 0], value: {log(rng, 5, 200)}}}}}
time: {{end: 0.5, step: 1e-4, adaptive: {{tolerance: 1e-4}}}}
"""  # noqa: E501
    )


def driven_on_a_stop(rng):
    """A slider that a prescribed motion, or a spring behind it, drives on a rigid stop."""
    stop, e = rng.uniform(0.05, 0.2), rng.choice([0, 0.3, 0.8])
    rigid = rng.random() < 0.5
    drive = (
        "drive: {type: prescribed_position, node: block, direction: [1, 0, 0], value: {linear: {slope: 0.5}}}"
        if rigid
        else "hand: {type: prescribed_position, node: hand, direction: [1, 0, 0], value: {linear: {slope: 0.5}}}"
    )
    return (
        HEAD.format(g=0)
        + f"""
nodes: {{block: {{position: [0, 0, 0]}}, hand: {{position: [-0.3, 0, 0]}}}}
elements:
  block: {{type: rigid_body, node: block, mass: 1, inertia: [0.01, 0.01, 0.01]}}
  hand: {{type: rigid_body, node: hand, mass: 0.1, inertia: [1e-3, 1e-3, 1e-3]}}
  spring: {{type: spring_damper, nodes: [hand, block], law: {{spring: {{stiffness: {log(rng, 50, 5e3)}}}, damper: {{coefficient: 2}}}}}}
joints:
  guide: {{type: prismatic, nodes: [ground, block], axis: [1, 0, 0], stops: {{upper: {stop:.3g}, restitution: {e}}}}}
  rail: {{type: prismatic, nodes: [ground, hand], axis: [1, 0, 0]}}
  {drive}
time: {{end: 0.6, step: 1e-3, adaptive: {{tolerance: 1e-4}}}}
"""  # noqa: E501
    )


def zeno(rng, i):
    """Bounces without end: balls, a bar on two feet, a pendulum between stops."""
    e = rng.choice([0.1, 0.3, 0.5, 0.7, 0.8, 0.9, 0.95])
    if i % 3 == 0:
        balls = range(rng.randint(1, 4))
        nodes = "".join(f"  b{k}: {{position: [{k}, 0, {log(rng, 0.1, 1)}]}}\n" for k in balls)
        elements = "".join(
            f"  b{k}: {{type: point_mass, node: b{k}, mass: 1}}\n"
            f"  c{k}: {{type: plane_contact, node: b{k}, ground: floor, restitution: {e}}}\n" for k in balls
        )  # fmt: skip
        return HEAD.format(g=-9.81) + (
            f"nodes:\n{nodes}elements:\n{elements}"
            "grounds: {floor: {plane: {point: [0, 0, 0], normal: [0, 0, 1]}}}\n"
            "time: {end: 4, step: 1e-2}\n"
        )
    if i % 3 == 1:
        lean = rng.uniform(-0.3, 0.3)
        x, z = 0.5 * np.cos(lean), 0.5 * np.sin(lean)
        turned = f"orientation: [0, {lean:.15g}, 0]"
        return (
            HEAD.format(g=-9.81)
            + f"""
nodes:
  middle: {{position: [0, 0, 0.3], {turned}}}
  left: {{position: [{-x:.15g}, 0, {0.3 + z:.15g}], {turned}}}
  right: {{position: [{x:.15g}, 0, {0.3 - z:.15g}], {turned}}}
elements:
  bar: {{type: rigid_body, node: middle, mass: 2, inertia: [0.1, 0.2, 0.1], attached: [left, right]}}
  a: {{type: plane_contact, node: left, ground: floor, restitution: {e}}}
  b: {{type: plane_contact, node: right, ground: floor, restitution: {e}}}
joints: {{guide: {{type: planar, nodes: [ground, middle], axis: [0, 1, 0]}}}}
grounds: {{floor: {{plane: {{point: [0, 0, 0], normal: [0, 0, 1]}}}}}}
time: {{end: 2, step: 5e-3}}
"""
        )
    return (
        HEAD.format(g=-9.81)
        + f"""
nodes: {{pin: {{position: [0, 0, 0]}}}}
elements:
  bar: {{type: rigid_body, node: pin, mass: 1, center_of_mass: [0.75, 0, 0], inertia: [1e-4, 0.1875, 0.1875]}}
joints:
  hinge: {{type: hinge, nodes: [ground, pin], axis: [0, 1, 0], stops: {{lower: {-rng.uniform(0.1, 0.5):.3g}, upper: {rng.uniform(0.2, 1.4):.3g}, restitution: {e}}}}}
loads: {{motor: {{type: moment, node: pin, direction: [0, 1, 0], value: {{sine: {{amplitude: {log(rng, 1, 30)}, frequency: {log(rng, 0.3, 3)}}}}}}}}}
time: {{end: 3, step: 1e-3}}
"""  # noqa: E501
    )


FAMILIES = (
    ("sudden load", sudden_load), ("stick-slip", stick_slip), ("snap-through", snap_through), ("latches", latches),
    ("sudden load", sudden_load), ("lift-off", lift_off), ("jam", jam), ("Zeno", zeno),
)  # fmt: skip
