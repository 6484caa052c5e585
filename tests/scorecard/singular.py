"""Line 8: models with redundant, contradicting or missing constraints, and good ones: who is at fault is named.

Every model has innocent bystanders, a pendulum and a mass on a spring, which must not be named.
"""

import random
import re
from functools import partial

import numpy as np
from scorecard.outcome import in_process, last_line, unfit, unplaced
from scorecard.trial import Job, Line

LINES = (Line(8, "60 singular models and 60 good ones: all elements at fault named, no false alarm", 9, 120),)
WORDS = (
    "boom arm leg yoke strut flap hatch gate beak vane fork lever rocker shackle clevis bracket bell_crank drag_brace "
    "tie_rod side_stay door-left door-right pin-1 pin-2 axle_7 knee hip elbow wrist ankle spool hub mast spar rib"
).split()
BYSTANDERS = (
    "innocent_bar",
    "innocent_pin",
    "innocent_mass",
    "innocent_spring",
    "innocent_node",
    "innocent_top",
    "innocent_low",
)
CPU = 20.0
AROUND = 4  # motions of the bystanders


class Deck:
    """Sections of a deck, filled entry by entry."""

    def __init__(self, rng):
        self.rng, self.words = rng, rng.sample(WORDS, len(WORDS))
        self.nodes, self.elements, self.joints, self.loads = {}, {}, {}, {}
        self.end = "time: {end: 0.01, step: 1e-3}"
        self.innocent()

    def name(self):
        """A name that no entry has."""
        return self.words.pop()

    def innocent(self):
        """A pendulum and a mass on a spring, far away."""
        self.nodes["innocent_node"] = "{position: [20, 5, 0]}"
        self.elements["innocent_bar"] = (
            "{type: rigid_body, node: innocent_node, mass: 1, center_of_mass: [0.5, 0, 0], inertia: [0.01, 0.1, 0.1]}"
        )
        self.joints["innocent_pin"] = "{type: hinge, nodes: [ground, innocent_node], axis: [0, 1, 0]}"
        self.nodes["innocent_top"] = "{position: [20, -5, 1], fixed: true}"
        self.nodes["innocent_low"] = "{position: [20, -5, 0]}"
        self.elements["innocent_mass"] = "{type: point_mass, node: innocent_low, mass: 1}"
        self.elements["innocent_spring"] = (
            "{type: spring_damper, nodes: [innocent_top, innocent_low], law: {spring: {stiffness: 100}}}"
        )

    def body(self, position, attached=(), center=(0.1, 0.05, 0.02)):
        """A rigid body: its name and that of its node."""
        node, name = self.name(), self.name()
        self.nodes[node] = f"{{position: {vector(position)}}}"
        points = []
        for point in attached:
            points.append(self.name())
            self.nodes[points[-1]] = f"{{position: {vector(point)}}}"
        self.elements[name] = (
            f"{{type: rigid_body, node: {node}, mass: {self.rng.uniform(0.5, 5):.3g}, "
            f"center_of_mass: {vector(center)}, inertia: [0.1, 0.12, 0.15], attached: [{', '.join(points)}]}}"
        )
        return name, node, *points

    def joint(self, kind, a, b, more=""):
        """A joint: its name."""
        name = self.name()
        self.joints[name] = f"{{type: {kind}, nodes: [{a}, {b}]{more}}}"
        return name

    @property
    def text(self):
        """The whole deck."""
        sections = {"nodes": self.nodes, "elements": self.elements, "joints": self.joints, "loads": self.loads}
        return "mecano: 1\ngravity: [0, 0, -9.81]\n" + "".join(
            f"{section}:\n" + "".join(f"  {name}: {entry}\n" for name, entry in entries.items())
            for section, entries in sections.items() if entries
        ) + self.end + "\n"  # fmt: skip


def vector(x):
    """Three numbers as YAML."""
    return "[" + ", ".join(f"{float(c):.12g}" for c in x) + "]"


def unit(rng):
    """A random direction."""
    v = np.array([rng.gauss(0, 1) for _ in range(3)])
    return v / np.linalg.norm(v)


def jobs(lines, factor, seed):
    """Half of them singular, of all families in turn, half good."""
    count = max(round(factor * LINES[0].count / 2), len(SINGULAR))
    for families, sort in ((SINGULAR, "singular"), (GOOD, "good")):
        for i in range(count):
            family = families[i % len(families)]
            deck = Deck(random.Random(f"{seed} {sort} {i}"))
            judge, *expected = family(deck)
            yield Job(8, f"{family.__name__} {i}", partial(trial, deck.text, judge, expected), cpu=CPU)


def trial(text, judge, expected, folder):
    """Check and run the deck, and judge what is said."""
    (folder / "deck.yaml").write_text(text)
    checked = in_process(["check", "deck.yaml", "--all"], folder)
    ran = in_process(["run", "deck.yaml"], folder)
    (folder / "said.txt").write_text(f"{checked.out}\n{checked.err}\n{ran.err}\nmust be named: {expected}\n")
    for outcome in (checked, ran):
        if why := unfit(outcome, (0, 2, 3, 4), cpu=CPU):
            return why
    return judge(checked, ran, *expected)


def names_in(text, names):
    """Which of the names stand in the text, as words."""
    return {name for name in names if re.search(rf"(?<![\w.$-]){re.escape(name)}(?![\w$-]|\.\w)", text)}


def wrongly(text, must, what):
    """Why a text does not name whom it must, or names a bystander."""
    if missing := sorted(set(must) - names_in(text, must)):
        return f"{what}: {len(missing)} of {len(must)} at fault not named"
    if named := names_in(text, BYSTANDERS):
        return f"{what}: bystanders named: {', '.join(sorted(named))}"
    return ""


# --- judges: (outcome of check, outcome of run, names that must stand there, ...) -> why not


def is_redundant(checked, ran, must, count):
    """`check` counts and names the redundant constraints; the run warns, with some names of many, and continues."""
    if checked.code:
        return f"check: exit code {checked.code}: {last_line(checked.err)}"
    head, _, block = checked.out.partition("redundant ")
    found = re.match(r"\s*(\d+) constraint", block)
    if not found or int(found[1]) != count:
        return f"{found[1] if found else 'no'} redundant constraints instead of {count}"
    if ran.code:
        return f"run: exit code {ran.code}: {last_line(ran.err)}"
    if "redundant" not in ran.err:
        return "the run does not say that constraints are redundant"
    some = re.search(r"and\s+\d+\s+more", ran.err)
    return wrongly(block, must, "check") or wrongly(ran.err, () if some else must, "run")


def is_refused(checked, ran, must, codes=(3, 4)):
    """The run ends with one of the codes and names who is at fault."""
    if ran.code == 2 and not unplaced(ran):
        return wrongly(ran.err, must, "run")
    if ran.code not in codes:
        return f"run: exit code {ran.code} instead of {codes}"
    return wrongly(ran.err, must, "run")


def is_movable(checked, ran, must, mobility):
    """`check` counts what can move and names the nodes."""
    if checked.code:
        return f"check: exit code {checked.code}: {last_line(checked.err)}"
    found = re.search(r"mobility +(\d+)", checked.out)
    if not found or int(found[1]) - AROUND != mobility:
        return f"mobility {found[1] if found else 'unknown'} instead of {mobility + AROUND}"
    return wrongly(checked.out, must, "check") if not names_in(checked.out, must) >= set(must) else ""


def is_locked(checked, ran, must):
    """Nothing can move: said in words, exit code 2 with a place, or a run in which nothing moves."""
    for what, outcome in (("check", checked), ("run", ran)):
        if outcome.code == 2 and unplaced(outcome) or outcome.code not in (0, 2):
            return f"{what}: exit code {outcome.code}: {last_line(outcome.err)}"
    return ""


def is_good(checked, ran, mobility):
    """No redundancy, the mobility, and a run without a word of warning."""
    if checked.code or ran.code:
        return f"exit code {checked.code or ran.code}: {last_line(checked.err or ran.err)}"
    if "redundant        0" not in checked.out:
        return "a false alarm: redundant constraints"
    found = re.search(r"mobility +(\d+)", checked.out)
    if mobility is not None and (not found or int(found[1]) != mobility + AROUND):
        return f"mobility {found[1] if found else 'unknown'} instead of {mobility + AROUND}"
    alarm = re.search(r"redundant|contradict|singular|mechanism|not unique", ran.err)
    return f"a false alarm: {alarm[0]}" if alarm else ""


# --- singular models: Deck -> (judge, names that must be named, ...)


def coaxial_hinges(deck):
    """A door on two to four hinges of one axis, as doors are."""
    axis, count = unit(deck.rng), deck.rng.randint(2, 4)
    points = [0.4 * k * axis for k in range(count)]
    _, node, *rest = deck.body(points[0], points[1:])
    names = [deck.joint("hinge", "ground", n, f", axis: {vector(axis)}") for n in (node, *rest)]
    return is_redundant, names, 5 * (count - 1)


def two_slides(deck):
    """A carriage on two parallel rails, as printers have."""
    axis = unit(deck.rng)
    other = np.cross(axis, unit(deck.rng))
    _, node, far = deck.body(np.zeros(3), [other / np.linalg.norm(other) * 0.3])
    names = [deck.joint("prismatic", "ground", n, f", axis: {vector(axis)}") for n in (node, far)]
    return is_redundant, names, 5  # two of the positions, and the rotations, which both share


def parallelogram(deck):
    """A parallelogram of hinges: 3 constraints too many with two cranks, 7 with three."""
    count, height = deck.rng.randint(2, 3), deck.rng.uniform(0.3, 1)
    cranks = [deck.body([k, 0, 0], [[k, 0, height]], (0, 0, height / 2)) for k in range(count)]
    ends = [[k, 0, height] for k in range(1, count)]
    _, coupler, *points = deck.body([0, 0, height], ends)
    names = [deck.joint("hinge", "ground", crank[1], ", axis: [0, 1, 0]") for crank in cranks]
    names += [
        deck.joint("hinge", crank[2], point, ", axis: [0, 1, 0]")
        for crank, point in zip(cranks, (coupler, *points), strict=True)
    ]
    return is_redundant, names, 3 if count == 2 else 7


def doubled_rods(deck):
    """Two rigid rods between the same points."""
    _, node, tip = deck.body([0, 0, 0], [[1, 0, 0]])
    deck.joint("spherical", "ground", node)
    wall = deck.name()
    deck.nodes[wall] = "{position: [1, 1, 0], fixed: true}"
    names = [deck.joint("rigid_rod", wall, tip) for _ in range(2)]
    return is_redundant, names, 1


def held_twice(deck):
    """A body bolted to the ground, and hinged to it besides."""
    _, node, other = deck.body([0, 0, 0], [[0.5, 0, 0]])
    names = [
        deck.joint("fixed", "ground", node),
        deck.joint("hinge", "ground", other, f", axis: {vector(unit(deck.rng))}"),
    ]
    return is_redundant, names, 5


def two_hinges_of_one_point(deck):
    """Two hinges of the same nodes with different axes: the body is held, and both share its position."""
    _, node = deck.body([0, 0, 0])
    names = [deck.joint("hinge", "ground", node, f", axis: {axis}") for axis in ("[1, 0, 0]", "[0, 1, 0]")]
    return is_redundant, names, 4


def motors_that_agree(deck):
    """Two motors with the same motion on one hinge."""
    _, node = deck.body([0, 0, 0])
    deck.joint("hinge", "ground", node, ", axis: [0, 0, 1]")
    law = f", axis: [0, 0, 1], value: {{linear: {{slope: {deck.rng.uniform(0.1, 1):.3g}}}}}"
    names = [deck.joint("prescribed_angle", "ground", node, law) for _ in range(2)]
    return is_redundant, names, 1


def motors_that_contradict(deck):
    """Two motors with different motions on one hinge."""
    _, node = deck.body([0, 0, 0])
    deck.joint("hinge", "ground", node, ", axis: [0, 0, 1]")
    slopes = (1.0, 1.0 + deck.rng.uniform(0.1, 2.0))
    names = [
        deck.joint("prescribed_angle", "ground", node, f", axis: [0, 0, 1], value: {{linear: {{slope: {slope:.3g}}}}}")
        for slope in slopes
    ]
    return is_refused, names


def motor_on_what_is_bolted(deck):
    """A motor on a body that is bolted to the ground."""
    _, node, tip = deck.body([0, 0, 0], [[0.5, 0, 0]])
    bolt = deck.joint("fixed", "ground", node)
    motor = deck.joint("prescribed_angle", "ground", tip, ", axis: [0, 0, 1], value: {linear: {slope: 1}}")
    return is_refused, [bolt, motor]


def pulled_two_ways(deck):
    """A point that two prescribed motions would have in two places."""
    _, node = deck.body([0, 0, 0])
    names = []
    for slope in (0.1, 0.2):
        name = deck.name()
        deck.joints[name] = (
            f"{{type: prescribed_position, node: {node}, direction: [1, 0, 0], value: {{linear: {{slope: {slope}}}}}}}"
        )
        names.append(name)
    return is_refused, names


def rod_that_is_too_short(deck):
    """A prescribed motion that would lengthen a rigid rod."""
    _, node, tip = deck.body([0, 0, 0], [[1, 0, 0]])
    deck.joint("prismatic", "ground", node, ", axis: [1, 0, 0]")
    wall = deck.name()
    deck.nodes[wall] = "{position: [2, 0, 0], fixed: true}"
    rod, motor = deck.joint("rigid_rod", tip, wall), deck.name()
    deck.joints[motor] = (
        f"{{type: prescribed_position, node: {node}, direction: [1, 0, 0], value: {{linear: {{slope: 0.3}}}}}}"
    )
    return is_refused, [rod, motor]


def free_body(deck):
    """A body that nothing holds."""
    _, node = deck.body([0, 0, 0])
    return is_movable, [node], 6


def free_linkage(deck):
    """Two to four bodies on one another, and on nothing else."""
    count = deck.rng.randint(2, 4)
    bodies = [deck.body([k, 0, 0], [[k + 1, 0, 0]]) for k in range(count)]
    for before, after in zip(bodies, bodies[1:], strict=False):
        deck.joint("hinge", before[2], after[1], f", axis: {vector(unit(deck.rng))}")
    return is_movable, [body[1] for body in bodies], 6 + count - 1


def massless_node(deck):
    """A force on a node that has neither mass nor stiffness."""
    node, load = deck.name(), deck.name()
    deck.nodes[node] = "{position: [0, 0, 0]}"
    deck.loads[load] = f"{{type: force, node: {node}, direction: [1, 0, 0], value: 1}}"
    return is_refused, [node], (3, 4)


def moment_without_inertia(deck):
    """A moment on a node that has no inertia."""
    node, mass, load = deck.name(), deck.name(), deck.name()
    deck.nodes[node] = "{position: [0, 0, 0]}"
    deck.elements[mass] = f"{{type: point_mass, node: {node}, mass: 1}}"
    deck.loads[load] = f"{{type: moment, node: {node}, direction: [0, 0, 1], value: 1}}"
    return is_refused, [node], (3, 4)


def massless_link(deck):
    """A weightless lever on a hinge, with a force at its end and nothing that resists."""
    root, tip, link, load = deck.name(), deck.name(), deck.name(), deck.name()
    deck.nodes[root], deck.nodes[tip] = "{position: [0, 0, 0]}", "{position: [1, 0, 0]}"
    deck.elements[link] = f"{{type: rigid_link, nodes: [{root}, {tip}]}}"
    deck.joint("hinge", "ground", root, ", axis: [0, 1, 0]")
    deck.loads[load] = f"{{type: force, node: {tip}, direction: [0, 0, 1], value: 1}}"
    return is_refused, [tip], (3, 4)


def statics_of_a_mechanism(deck):
    """The equilibrium of a bar that nothing holds against turning, under a force along it."""
    root, tip, bar, load = deck.name(), deck.name(), deck.name(), deck.name()
    deck.__dict__.update(nodes={}, elements={}, joints={}, loads={})
    deck.nodes[root], deck.nodes[tip] = "{position: [0, 0, 0]}", "{position: [1, 0, 0]}"
    deck.elements[bar] = f"{{type: rigid_body, node: {root}, mass: 1, inertia: [0.1, 0.1, 0.1], attached: [{tip}]}}"
    deck.joint("cylindrical", "ground", root, ", axis: [1, 0, 0]")
    deck.loads[load] = f"{{type: force, node: {tip}, direction: [1, 0, 0], value: 1}}"
    deck.end = "static: {steps: 2}"
    return is_refused, [root], (3, 4)


def nothing_free(deck):
    """A deck whose only node is fixed."""
    node, mass = deck.name(), deck.name()
    deck.__dict__.update(nodes={node: "{position: [0, 0, 0], fixed: true}"}, joints={}, loads={},
                         elements={mass: f"{{type: point_mass, node: {node}, mass: 1}}"})  # fmt: skip
    return is_locked, [node]


def bolted(deck):
    """A body bolted to the ground, and nothing else."""
    deck.__dict__.update(nodes={}, elements={}, joints={}, loads={})
    _, node = deck.body([0, 0, 0])
    deck.joint("fixed", "ground", node)
    return is_locked, [node]


def merged_in_a_ring(deck):
    """Three bodies bolted to one another in a ring: one of the bolts is too many."""
    bodies = [deck.body([0, 0, 0]) for _ in range(3)]
    names = [deck.joint("fixed", bodies[a][1], bodies[b][1]) for a, b in ((0, 1), (1, 2), (2, 0))]
    return is_redundant, names, 6


def balls_in_a_ring(deck):
    """Three bodies that share one point by ball joints, each with each."""
    bodies = [deck.body([0, 0, 0]) for _ in range(3)]
    names = [deck.joint("spherical", bodies[a][1], bodies[b][1]) for a, b in ((0, 1), (1, 2), (2, 0))]
    return is_redundant, names, 3


SINGULAR = (
    coaxial_hinges, motors_that_contradict, massless_node, nothing_free, parallelogram, free_linkage, merged_in_a_ring,
    doubled_rods, motor_on_what_is_bolted, moment_without_inertia, bolted, two_slides, free_body, balls_in_a_ring,
    held_twice,
    pulled_two_ways, massless_link, two_hinges_of_one_point, statics_of_a_mechanism, motors_that_agree,
    rod_that_is_too_short,
)  # fmt: skip


# --- good models: Deck -> (is_good, mobility or None)

FREEDOM = {"hinge": 1, "prismatic": 1, "cylindrical": 2, "universal": 2, "spherical": 3, "planar": 3, "screw": 1,
"fixed": 0,
           "rigid_rod": 5, "held_rotation": 3}  # fmt: skip


def tree(deck):
    """Two to seven bodies, each on one before or on the ground, by joints of all kinds."""
    ends, mobility = ["ground"], 0
    places = {"ground": np.zeros(3)}
    for _ in range(deck.rng.randint(2, 7)):
        parent = deck.rng.choice(ends)
        kind = deck.rng.choice([kind for kind in FREEDOM if (parent, kind) != ("ground", "rigid_rod")])
        place = places[parent]
        far = place + unit(deck.rng)
        if parent == "ground":
            place, far = far, far + unit(deck.rng)
        elif kind == "rigid_rod":
            place, far = far, far + unit(deck.rng)
        _, node, end = deck.body(place, [far])
        axis, across = unit(deck.rng), unit(deck.rng)
        more = {"screw": f", axis: {vector(axis)}, pitch: 0.1", "spherical": "", "fixed": "", "rigid_rod": "",
        "held_rotation": "",
                "universal": f", axis_a: {vector(axis)}, axis_b: {vector(np.cross(axis, across))}"}  # fmt: skip
        deck.joint(kind, parent, node, more.get(kind, f", axis: {vector(axis)}"))
        mobility += FREEDOM[kind]
        ends += [node, end]
        places |= {node: place, end: far}
    return is_good, mobility


def linkage_with_balls(deck):
    """A four-bar with a ball and a sleeve: closed, and nothing too many."""
    height = deck.rng.uniform(0.3, 1)
    one, two = deck.body([0, 0, 0], [[0, 0, height]], (0, 0, 0.1)), deck.body([1, 0, 0], [[1, 0, height]], (0, 0, 0.1))
    _, coupler, far = deck.body([0, 0, height], [[1, 0, height]])
    for crank in (one, two):
        deck.joint("hinge", "ground", crank[1], ", axis: [0, 1, 0]")
    deck.joint("spherical", one[2], coupler)
    deck.joint("cylindrical", two[2], far, ", axis: [0, 1, 0]")
    return is_good, 1


def driven(deck):
    """A hinge with a motor."""
    _, node = deck.body([0, 0, 0])
    axis = vector(unit(deck.rng))
    deck.joint("hinge", "ground", node, f", axis: {axis}")
    deck.joint(
        "prescribed_angle", "ground", node, f", axis: {axis}, value: {{polynomial: {{coefficients: [0, 0, 1]}}}}"
    )
    return is_good, 0


def door_with_play(deck):
    """A door as an engineer models it: one hinge, and a second one that is a ball that slides."""
    axis = unit(deck.rng)
    _, node, far = deck.body([0, 0, 0], [axis])
    deck.joint("spherical", "ground", node)
    for direction in across(axis):
        name = deck.name()
        deck.joints[name] = f"{{type: prescribed_position, node: {far}, direction: {vector(direction)}, value: 0}}"
    return is_good, 1


def across(axis):
    """Two directions across an axis."""
    one = np.cross(axis, [1.0, 0, 0] if abs(axis[0]) < 0.9 else [0, 1.0, 0])
    one /= np.linalg.norm(one)
    return one, np.cross(axis, one)


def on_springs(deck):
    """A body that only springs hold."""
    _, node, *points = deck.body([0, 0, 0], [unit(deck.rng) for _ in range(3)])
    for point in (node, *points):
        anchor, spring = deck.name(), deck.name()
        deck.nodes[anchor] = f"{{position: {vector(3 * unit(deck.rng))}, fixed: true}}"
        deck.elements[spring] = (
            f"{{type: spring_damper, nodes: [{anchor}, {point}], law: {{spring: {{stiffness: 100}}}}}}"
        )
    return is_good, 6


def rods_to_the_ground(deck):
    """A platform on one to five rods of random directions."""
    count = deck.rng.randint(1, 5)
    _, node, *points = deck.body([0, 0, 0], [unit(deck.rng) for _ in range(count)])
    for point in points:
        anchor = deck.name()
        deck.nodes[anchor] = f"{{position: {vector(3 * unit(deck.rng))}, fixed: true}}"
        deck.joint("rigid_rod", anchor, point)
    return is_good, 6 - count


GOOD = (tree, linkage_with_balls, tree, driven, tree, door_with_play, tree, on_springs, tree, rods_to_the_ground)
