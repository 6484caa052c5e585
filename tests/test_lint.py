"""Warnings about legal but suspicious decks and models, with line and column; none about proper decks."""

from textwrap import dedent

import numpy as np
import pytest
from process import flowing
from time_runs import INPUTS, deck, input_deck

from mecano.analyses.initial_state import set_initial_state
from mecano.analyses.prepare import prepare, startup_warnings, warnings_of
from mecano.analyses.summary import summary
from mecano.deck.read import deck_of_bytes, read_deck

SUSPICIOUS_INPUTS = {
    "hoist": "bar 'wire' is strained by 0.4 % at the start"
}  # its rope carries the load from the start
STARTERS = INPUTS.parent / "mecano" / "deck" / "starters"
HEAD = """
    mecano: 1
    gravity: [0, 0, -9.81]
    time: {end: 1, step: 0.01}
    nodes: {a: {position: [0, 0, 0], fixed: true}, b: {position: [1, 0, 0]}}
    elements:
      weight: {type: point_mass, node: b, mass: 2}
      rope: {type: cable, nodes: [a, b], axial_stiffness: 1000}
"""


def warned(text):
    """Texts of the warnings of a deck."""
    return warnings_of(prepare(deck(text)))


def at(text, line):
    """The place of the first character of a line of HEAD and what follows that begins with ``line``."""
    lines = deck(text).text.splitlines()
    number = next(i for i, found in enumerate(lines) if found.strip().startswith(line))
    return f"test.yaml:{number + 1}:{len(lines[number]) - len(lines[number].lstrip()) + 1}: "


def test_negative_stiffness_and_damping():
    """One warning for all like elements, in runs and checks; none if nothing is negative."""
    bars = [f"elements.{side}_bar.law={{spring: {{stiffness: {k}}}}}" for side, k in (("left", -2), ("right", -3))]
    given = input_deck("snap_through", *bars)
    (said,) = startup_warnings(prepare(given))
    assert said.startswith("override elements.left_bar.law:1:")
    assert (
        "spring_damper 'left_bar', 'right_bar': 'law.spring.stiffness' is negative (-3 to -2): it pushes away" in said
    )
    assert f"warning {said}" in flowing(summary(given))
    swings = "{linear: {slope: 1}, damper_polynomial: {coefficients: [0, -1, 0, 4]}}"
    (found,) = input_deck("pendulum", f"joints.hinge.compliance={{along_1: {swings}}}").warnings
    assert found.message.startswith(
        "hinge 'hinge': 'compliance.along_1.damper_polynomial.coefficients[1]' is negative (-1): it"
    )


@pytest.mark.parametrize(
    ("value", "angle", "said"),
    [
        ("speed", "2*pin.angle", "'value' is the formula 'speed'; a moment or an energy [N m] is expected, and"),
        ("2 - pin.rate", "0", "'value' is the formula '2 - pin.rate'; a moment or an energy [N m] is expected"),
        ("2", "min(bob.position.x, 1)", "'natural_angle' is the formula 'min(bob.position.x, 1)'; an angle [rad] is"),
        ("pin.angle + speed", "0", "the formula 'pin.angle + speed' adds or compares rad and rad/s"),
        ("9*(7 - pin.angle)", "0", "'9*(7 - pin.angle)' adds 7 to an angle or compares both: it is 7 rad, more than a"),
        ("9*max(30, pin.angle)", "0", "'9*max(30, pin.angle)' adds 30 to an angle or compares both: it is 30 rad"),
        ("30*pin.angle - 6", "0", ""), ("9*(6.28 - pin.angle)", "0", ""),
        ("torque", "min(pin.angle, 2*pin.rate)", ""), ("torque", "pin.angle + sin(pin.angle)", ""),
        ("torque", "pin.angle",  ""), ("3*speed", "tanh(speed)", ""), ("2 + time", "1 + time", ""),
    ],
)  # fmt: skip
def test_formulas_in_other_units_than_their_fields(value, angle, said):
    """A moment and an angle are compared with units that the deck gives or that follow; products have any unit."""
    found = warned(f"""
        mecano: 1
        gravity: none
        nodes: {{bob: {{position: [0, 0, 0]}}}}
        elements: {{bob: {{type: rigid_body, node: bob, mass: 1, inertia: [1, 1, 1]}}}}
        joints:
          pin:
            {{type: hinge, nodes: [ground, bob], axis: [0, 0, 1], turning_law: {{spring: 1}}, natural_angle: "{angle}"}}
        signals:
          speed: {{type: curve, input: time, law: {{constant: 3 rpm}}, unit: rpm}}
          torque: {{type: formula, value: 3*speed, unit: J}}
        loads: {{motor: {{type: joint_moment, joint: pin, value: "{value}"}}}}
        time: {{end: 1, step: 0.1}}
        """)
    assert len(found) == bool(said)
    assert not said or said in found[0]


@pytest.mark.parametrize(
    ("parameters", "value", "said", "unit"),
    [
        ("goal: 30 deg", "$goal - pin.angle", "", "rad"),
        ("goal: 30 m", "$goal - pin.angle", "adds or compares m and rad", "SI"),
        ("goal: 30 deg", "max(2*$goal, bob.position.x)", "", "SI"),  # a number may have any unit
        ("goal: 30 deg", "max($goal, bob.position.x)", "adds or compares rad and m", "SI"),
        ("k: 3 N m/deg", "-$k*pin.angle", "", "N m"),
        ("c: 3 N m s, k: 2 N m", "(-$k)*pin.angle + ($c - $c)*pin.rate", "", "N m"),
        ("k: 2 N m, sum: $k + 0", "$sum*pin.angle", "", "N m"),
        ("a: 2, k: 2 N m", "$a*pin.angle/$k", "", "SI"),
        ("late: 3 s, b: 5 s", "step(time, $late, $b)", "", "-"),
        ("late: 3 kg", "min(time, $late)", "adds or compares s and kg", "SI"),
    ],
)  # fmt: skip
@pytest.mark.parametrize("copied", [False, True])
def test_units_of_parameters_in_formulas(parameters, value, said, unit, copied):
    """They are those of the quantities in whose place they stand, also in the copy of a template."""
    model = f"""
            parameters: {{{parameters}}}
            nodes: {{bob: {{position: [0, 0, 0]}}}}
            elements: {{bob: {{type: rigid_body, node: bob, mass: 1, inertia: [1, 1, 1]}}}}
            joints: {{pin: {{type: hinge, nodes: [ground, bob], axis: [0, 0, 1]}}}}
            signals: {{found: "{value}"}}
        """
    part = ", ".join(model.split("\n")[1:-1])
    placed = f"templates: {{part: {{{part}}}}}\nplace: {{my: {{template: part}}}}\nnodes: {{}}"
    head = "mecano: 1\ngravity: none\ntime: {end: 1, step: 0.1}\n"
    found = prepare(deck(head + (placed if copied else dedent(model))))
    texts = [text for text in warnings_of(found) if "is not used" not in text]
    assert len(texts) == bool(said) and all(said in text for text in texts), texts
    assert found.system.signal_units[f"signals/{'my_' if copied else ''}found/value"] == unit


def test_units_of_parameters_in_conditions():
    """At a mistaken unit in a condition, and none where it agrees."""
    wrong, right = (
        warned(f"""
        mecano: 1
        gravity: none
        parameters: {{limit: {limit}}}
        nodes: {{bob: {{position: [0, 0, 0]}}}}
        elements: {{bob: {{type: rigid_body, node: bob, mass: 1, inertia: [1, 1, 1]}}}}
        joints:
          pin: {{type: hinge, nodes: [ground, bob], axis: [0, 0, 1], release: {{when: pin.angle > $limit}}}}
        time: {{end: 1, step: 0.1}}
        """)
        for limit in ("3 m", "30 deg")
    )
    assert right == [] and len(wrong) == 1 and "adds or compares rad and m" in wrong[0]


@pytest.mark.parametrize(
    ("name", "override", "text"),
    [
        ("pendulum", "nodes.pin.orientation=[0, 90, 0]", "node 'pin': 'orientation' is 90 rad, more than a turn"),
        ("pendulum", "nodes.pin.orientation=[0, 90 deg, 0]", ""),
        ("pendulum", "nodes.pin.orientation=[0, 5, 0]", "node 'pin': 'orientation' is 5 rad, more than half a turn"),
        ("pendulum", "nodes.pin.orientation=[0, 3, 0]", ""),
        ("panel_lock", "joints.hinge.latch.angle=90", "hinge 'hinge': 'latch.angle' is 90 rad, more than a turn"),
        (
            "solar_array",
            "joints.hinge1.natural_angle=110",
            "hinge 'hinge1': 'natural_angle' is 110 rad, more than a turn",
        ),
        (
            "flexible_pendulum",
            "joints.hinge={type: hinge, nodes: [ground, pin], axis: [0, 1, 0], turning_law: {spring: 1}, "
            "natural_angle: {sine: {amplitude: 20, frequency: 1}}}",
            "hinge 'hinge': 'natural_angle' is 20 rad, more than a turn",
        ),
        ("panel_lock", "joints.hinge.latch.angle==4*pi", ""),
        ("panel_lock", "joints.hinge.stops={upper: 450.5}", "hinge 'hinge': 'stops.upper' is 450.5 rad, more than a"),
        (
            "flexible_pendulum",
            "sections.rubber.E=210000",
            "section 'rubber': 'E' is 210000 Pa, softer than rubber; is it intended, or in MPa?",
        ),
        (
            "flexible_pendulum",
            "sections.rubber.E=210",
            "section 'rubber': 'E' is 210 Pa, softer than rubber; is it intended, or in GPa?",
        ),
        ("hoist", "elements.wire.E=5000", "bar 'wire': 'E' is 5000 Pa, softer than rubber; is it intended, or in MPa?"),
        ("snap_through", "loads.weight.node=left", "force 'weight': node 'left' is fixed, so the load has no effect"),
        ("flexible_pendulum", "sections.rubber.density=1.1", "section 'rubber': 'density' is 1.1 kg/m3, lighter than"),
        (
            "flexible_pendulum",
            "sections.rubber={type: circle, diameter: 0.02, E: 210 GPa, nu: 0.3, density: 7.85}",
            "section 'rubber': sound travels through it at 164 km/s, through diamond at 18; is 'density' in g/cm3",
        ),
        ("pendulum", "gravity=[0, 0, -9810]", "'gravity' is 9810 m/s2; on Earth it is 9.81"),
        ("pendulum", "gravity=[0, 0, -981]", "'gravity' is 981 m/s2"),
        ("pendulum", "gravity=[0, -32.17, 0]", "'gravity' is 32.17 m/s2"),
        ("pendulum", "gravity=[0, 0, -9.81e-3]", "'gravity' is 0.00981 m/s2"),
        ("pendulum", "gravity=[0, 0, -1.62]", ""),
        ("pendulum", "gravity=[0, 0, -24.8]", ""),
        ("pendulum", "gravity=[0, 0, -9.81e-6]", ""),
        ("pendulum", "gravity=none", ""),
    ],
)
def test_suspicious_numbers(name, override, text):
    """With the place of the number, here on the command line."""
    found = input_deck(name, override).warnings
    assert len(found) == bool(text) and all(problem.message.startswith(text) for problem in found)
    assert all(str(problem.mark).startswith(f"override {override.split('=')[0]}:1:") for problem in found)


UNUSED = """
    parameters: {used: 2, other: $used, spare: 3}
    laws:
      pull: 3.0
      rising: {linear: {slope: 1}}
    sections:
      rod: {type: circle, diameter: 0.1, E: 2.1e11, nu: 0.3, density: 7800}
    grounds:
      road: {plane: {point: [0, 0, 0], normal: [0, 0, 1]}}
    tire_laws:
      tyre: {radius: 0.3, radial: {linear: {slope: 1e5}}, friction: 0.8, slip_regularization: 0.1}
    loads:
      force: {type: force, node: b, direction: [1, 0, 0], value: pull}
"""


def test_what_is_never_used():
    """A parameter that only another one uses is used; what is used in a name or a range is, too."""
    text = HEAD + UNUSED
    places = ["rising: ", "rod: ", "road: ", "tyre: "]
    unused = ["law 'rising'", "section 'rod'", "ground 'road'", "tire law 'tyre'"]
    expected = {f"{at(text, place)}{what} is not used" for place, what in zip(places, unused, strict=True)}
    said = warned(text)
    assert {line for line in said if "parameter" not in line} == expected
    parameters = [line.partition(": ")[2] for line in said if "parameter" in line]
    assert parameters == ["parameter 'other' is not used", "parameter 'spare' is not used"]
    used = "parameters: {n: 2, m: 0.1}\nnodes: {p$i: {repeat: {i: 1..$n}, position: [$i, $m, 0]}}\nelements:\n"
    used += "  w$i: {repeat: {i: 1..$n}, type: point_mass, node: p$i, mass: 1}\n"
    begin = "mecano: 1\ngravity: none\ntime: {end: 1, step: 0.1}\n" + used
    assert warned(begin) == []
    part = "{nodes: {end: {position: [0, 0, 0]}}, elements: {end: {type: point_mass, node: end, mass: 1}}}"
    templates = f"templates:\n  part: {part}\n"
    outer = "  outer: {place: {inner: {template: part}}}\n"
    assert warned(begin + templates + outer + "place: {one: {template: outer}}\n") == []
    spare = [
        f"{at(begin + templates + outer, f'{name}: {{')}template '{name}' is not placed" for name in ("part", "outer")
    ]
    assert warned(begin + templates + outer) == spare


def test_what_an_override_replaces_need_not_be_used():
    """As the tyre law that the other cases of a study have."""
    text = deck(HEAD + UNUSED).text
    unused = [deck_of_bytes(text.encode(), "test.yaml", overrides=given).warnings for given in ((), ("time.end=2",))]
    assert [len([w for w in found if "is not used" in w.message]) for found in unused] == [6, 0]
    inside = "{nodes: {end: {position: [0, 0, 0]}}, elements: {end: {type: point_mass, node: end, mass: 1}}}"
    placed = f"{text}templates: {{part: {inside}}}\nplace: {{one: {{template: part}}}}\n"
    found = deck_of_bytes(placed.encode(), "test.yaml", overrides=("place={}",)).warnings
    assert not [w for w in found if "is not placed" in w.message]


def test_what_an_included_file_has_need_not_be_used(tmp_path):
    (tmp_path / "laws.yaml").write_text("laws: {oleo: 3.0}\n")
    text = deck(HEAD).text.replace("mecano: 1", "mecano: 1\ninclude: laws.yaml")
    (tmp_path / "deck.yaml").write_text(text)
    assert read_deck(tmp_path / "deck.yaml").warnings == ()


@pytest.mark.parametrize(
    ("element", "text"),
    [
        ("type: bar, nodes: [a, b], axial_stiffness: 1000, natural_length: 0.997", "strained by 0.301 % at the start"),
        ("type: bar, nodes: [a, b], axial_stiffness: 1000, natural_length: 1.003", "strained by -0.299 %"),
        ("type: bar, nodes: [a, b], axial_stiffness: 1000, natural_length: 0.9985", ""),
        ("type: cable, nodes: [a, b], axial_stiffness: 1000, natural_length: 0.9", "strained by 11.1 %"),
        ("type: cable, nodes: [a, b], axial_stiffness: 1000, natural_length: 1.5", ""),
        ("type: bar, nodes: [a, b], axial_stiffness: 1000, natural_length: {linear: {slope: 1, offset: 1}}", ""),
        (
            "type: spring_damper, nodes: [a, b], natural_length: 1000, law: {spring: {stiffness: 3}}",
            "strained by -99.9",
        ),
        ("type: spring_damper, nodes: [a, b], natural_length: 0.8, law: {spring: {stiffness: 3}}", ""),
    ],
)
def test_what_is_strained_at_the_start(element, text):
    whole = HEAD + f"      line: {{{element}}}\n"
    said = warned(whole)
    assert len(said) == bool(text)
    assert all(line.startswith(f"{at(whole, 'line: ')}{element.split()[1][:-1]} 'line' is {text}") for line in said)


@pytest.mark.parametrize(
    "initial", ["initial: static", "initial: {steady: {angular_velocity: [0, 0, 40], about: [0, 0, 0]}}"]
)
def test_a_start_that_is_solved_for_is_strained_by_its_loads(initial):
    """The weight of 500 kg stretches a rope of 1 m by 5 %, 8 m/s of a mass of 1.6 kg that circles by 2 %."""
    text = f"""
        mecano: 1
        gravity: {"[0, 0, -9.81]" if "static" in initial else "none"}
        nodes: {{a: {{position: [0, 0, 0], fixed: true}}, b: {{position: PLACE}}}}
        elements:
          load: {{type: point_mass, node: b, mass: MASS}}
          rope: {{type: cable, nodes: [a, b], axial_stiffness: 100 kN, natural_length: 1}}
        {initial}
        time: {{end: 1, step: 1 ms}}
    """
    place, mass = ("[0, 0, -1]", "500") if "static" in initial else ("[1.0001, 0, 0]", "1.6")
    prepared = prepare(deck(text.replace("PLACE", place).replace("MASS", mass)))
    set_initial_state(prepared)
    assert np.linalg.norm(prepared.state.z[:3]) > 1.02 and startup_warnings(prepared) == []


CHAIN = """
    mecano: 1
    gravity: [0, 0, -9.81]
    sections:
      rod: {type: stiffness, EA: 1e6, GA2: 1e6, GA3: 1e6, GJ: 10, EI2: 10, EI3: 10, mass_per_length: MASS,
            rotary_inertia: [TURNING, 0, 0]}
    nodes: {a: {position: [0, 0, 0], fixed: true}, b: {position: [0.5, 0, 0]}, c: {position: [1, 0, 0]}}
    elements:
      one: {type: beam, nodes: [a, b], section: rod, up: [0, 0, 1], mesh: MESH}
      two: {type: beam, nodes: [b, c], section: rod, up: [0, 0, 1]}
      ends: {type: rigid_body, node: NODE, mass: 1, inertia: [1, 1, 1]}
    time: {end: 1, step: 1 ms}
"""


@pytest.mark.parametrize(
    ("mesh", "mass", "turning", "node", "said"),
    [
        (1, 1, 0, "c", True),
        (2, 1, 0, "b", True),
        (1, 1, 0, "b", False),
        (2, 1, 1e-4, "c", False),
        (1, 0, 0, "b", False),
    ],
)
def test_a_section_whose_twist_has_no_inertia(mesh, mass, turning, node, said):
    """A curved cantilever without it sags by 0.34 m after 0.5 s in steps of 1 ms, with 1e-6 kg m or more by 0.19 m."""
    text = CHAIN.replace("MESH", str(mesh)).replace("MASS", str(mass)).replace("TURNING", str(turning))
    found = [line for line in warned(text.replace("NODE", node)) if "rotary inertia" in line]
    assert len(found) == said
    assert all("section 'rod' has mass, but no rotary inertia about axis 1" in line for line in found)


def test_beams_that_the_assembly_stretches():
    """A tip that is prescribed elsewhere: a beam of 1 m is stretched by 10 mm."""
    whole = HEAD.partition("      rope")[0] + BEAM
    (said,) = warned(whole)
    assert said.startswith(f"{at(whole, 'line: ')}beam 'line' is strained by 1 %")


@pytest.mark.parametrize(("width", "said"), [(30, "it is 1 m long and 30 m wide: are the dimensions"), (0.3, "")])
def test_beams_much_wider_than_long(width, said):
    section = f"rod: {{type: rectangle, width: {width}, height: 3 mm, E: 70 GPa, nu: 0.3, density: 2700}}"
    whole = HEAD.partition("      rope")[0] + "      line: {type: beam, nodes: [a, b], section: rod, up: [0, 0, 1]}\n"
    found = warned(f"{whole}    sections: {{{section}}}\n")
    assert found == [] if not said else f"beam 'line': {said}" in found[0]


@pytest.mark.parametrize(("inertia", "said"), [(450, "has a radius of gyration of 10.6 m: are mass"), (0.45, "")])
def test_beams_with_the_rotary_inertia_of_something_wider(inertia, said):
    """Of 4 kg/m: sqrt(450/4) m."""
    section = "rod: {type: stiffness, EA: 1e6, GA2: 1e6, GA3: 1e6, GJ: 100, EI2: 100, EI3: 100, mass_per_length: 4, "
    section += f"rotary_inertia: [{inertia}, 0.01, {inertia}]}}"
    whole = HEAD.partition("      rope")[0] + "      line: {type: beam, nodes: [a, b], section: rod, up: [0, 0, 1]}\n"
    found = warned(f"{whole}    sections: {{{section}}}\n")
    assert found == [] if not said else said in found[0]


BEAM = """      line: {type: beam, nodes: [a, b], section: rod, mesh: 2}
    sections: {rod: {type: circle, diameter: 0.1, E: 2.1e11, nu: 0.3, density: 7800}}
    joints:
      push: {type: prescribed_position, node: b, direction: [1, 0, 0], value: 0.01}
"""


SPRING = "s: {type: spring_damper, nodes: [b, c], law: {spring: {stiffness: 9}}}"


@pytest.mark.parametrize(
    ("more", "expected"),
    [
        (SPRING, ["node c: nothing gives mass to its displacement, which"]),
        ("link: {type: rigid_body, node: c, mass: 1, inertia: [1, 1, 1]}", []),
        (f"{SPRING}\n      link: {{type: rigid_link, nodes: [c, d]}}",
         ["node c, d: nothing gives mass to its rotation", "node c: nothing gives mass to its displacement",
          "node d: nothing gives mass to its displacement"]),
        ("link: {type: rigid_body, node: c, mass: 1, inertia: [1, 1, 1], attached: [d]}", []),
    ],
    ids=["spring", "body", "link", "attached"],
)  # fmt: skip
def test_massless_nodes(more, expected):
    """A node between springs, a link that nothing gives mass; not those that hang on a body."""
    where = "c: {position: [2, 0, 0]}" + (", d: {position: [3, 0, 0]}" if "d]" in more else "")
    whole = HEAD.replace("b: {position: [1, 0, 0]}", f"b: {{position: [1, 0, 0]}}, {where}") + f"      {more}\n"
    said = sorted(warned(whole), key=lambda line: line.partition("node")[2])
    assert len(said) == len(expected)
    for line, start in zip(said, expected, strict=True):
        assert line.startswith("test.yaml:5:") and line.partition(": ")[2].startswith(start)
        missing = "point_mass or a rigid_body" if "displacement" in start else "rigid_body or a held_rotation"
        assert line.endswith(f"or is a {missing} missing?")


@pytest.mark.parametrize(
    ("start", "end", "said"),
    [
        (0.0, 0.5, None), (0.5, 1.0, None),
        (1.0, 2.0, "before the start at 1 s: it happens at the start"),
        (0.0, 0.4, "after the end at 0.4 s: it does not happen in this run"),
    ],
)  # fmt: skip
def test_triggers_outside_of_a_run(start, end, said):
    whole = (
        HEAD.replace("time: {end: 1,", f"time: {{start: {start}, end: {end},")
        + """
      spring: {type: spring_damper, nodes: [a, b], law: {spring: 9}, activate: {time: 0.5}}
    joints:
      latch: {type: prismatic, nodes: [ground, b], axis: [1, 0, 0], latch: {displacement: 1, release: {time: 0.5}}}
"""
    )
    fields = {"spring": "activate.time", "latch": "latch.release.time"} if said else {}
    found = [line for line in warned(whole) if "is 0.5 s" in line]
    assert len(found) == len(fields)
    for line, (name, field) in zip(found, fields.items(), strict=True):
        assert line.endswith(f"'{name}': '{field}' is 0.5 s, {said}")


@pytest.mark.parametrize("other", ["cable", "bar"])
def test_knots_of_lines_alone(other):
    """A node without mass between two lines is loose once they go slack; a bar holds it."""
    lines = f"""k: {{type: cable, nodes: [b, c], axial_stiffness: 9}}
      l: {{type: {other}, nodes: [c, a], axial_stiffness: 9}}
"""
    whole = HEAD.replace("b: {position: [1, 0, 0]}", "b: {position: [1, 0, 0]}, c: {position: [2, 0, 0]}")
    (said,) = warned(f"{whole}      {lines}")
    assert said.partition(": ")[2].startswith("node c: nothing gives mass to its displacement, ")
    assert ("only lines that may go slack hold it (cable 'k', cable 'l')" in said) == (other == "cable")


def test_a_model_without_mass():
    text = HEAD.replace("weight: {type: point_mass, node: b, mass: 2}", "")
    assert startup_warnings(prepare(deck(text))) == ["nothing in the model has a mass: is this intended?"]
    assert warned(text) == startup_warnings(prepare(deck(text)))  # of `mecano check`


@pytest.mark.parametrize(
    ("rail", "extra", "stands"),
    [
        ("[1, 0, 0]", "", False),
        ("[0, 1, 0]", "", True),
        ("[0, 1, 0]", ", drive: {type: prescribed_angle, nodes: [ground, crank], axis: [0, 1, 0], value: 0}", False),
        ("[0, 1, 0]", ", catch: {type: grip, nodes: [ground, slider], close: {time: 1}}", False),
    ],
)
def test_a_mechanism_that_cannot_move(rail, extra, stands):
    """A slider-crank whose rail is across its plane, unless a motion is prescribed or a joint changes later."""
    text = f"""
    mecano: 1
    gravity: none
    nodes:
      {{crank: {{position: [0, 0, 0]}}, pin: {{position: [1, 0, 1]}}, rod: {{position: [1, 0, 1]}},
       end: {{position: [4, 0, 0]}}, slider: {{position: [4, 0, 0]}}}}
    elements:
      crank: {{type: rigid_body, node: crank, mass: 1, inertia: [1, 1, 1], attached: [pin]}}
      rod: {{type: rigid_body, node: rod, mass: 1, inertia: [1, 1, 1], attached: [end]}}
      slider: {{type: rigid_body, node: slider, mass: 1, inertia: [1, 1, 1]}}
    joints:
      {{a: {{type: hinge, nodes: [ground, crank], axis: [0, 1, 0]}},
       b: {{type: hinge, nodes: [pin, rod], axis: [0, 1, 0]}},
       c: {{type: hinge, nodes: [end, slider], axis: [0, 1, 0]}},
       rail: {{type: prismatic, nodes: [ground, slider], axis: {rail}}}{extra}}}
    time: {{end: 1, step: 0.01}}
    """
    assert any("nothing can move" in line for line in warned(text)) == stands


def test_copies_that_are_strained_are_counted():
    """A chain of springs hung into its rest length: one line, however long it is."""
    text = """
    mecano: 1
    gravity: none
    nodes: {p$i: {repeat: {i: 0..20}, position: [$i, 0, 0]}}
    elements:
      mass$i: {repeat: {i: 0..20}, type: point_mass, node: p$i, mass: 1}
      coil$i: {repeat: {i: 1..20}, type: spring_damper, nodes: [p$(i - 1), p$i], law: {spring: 9}, natural_length: 0.1}
    time: {end: 1, step: 0.01}
    """
    (said,) = warned(text)
    assert "spring_damper 'coil1' is strained by 900 %" in said and said.endswith("(and 19 more copies of it)")


def test_copies_of_a_node_without_mass_are_counted():
    """Seats of springs that no body carries, in a template that is placed on the left and on the right."""
    text = """
    mecano: 1
    gravity: none
    templates:
      corner:
        nodes: {seat: {position: [0, 0, 1]}, hub: {position: [0, 0, 0]}}
        elements:
          hub: {type: point_mass, node: hub, mass: 1}
          spring: {type: spring_damper, nodes: [seat, hub], law: {spring: 9}}
    place: {$side: {repeat: [{side: left, y: 1}, {side: right, y: -1}], template: corner, position: [0, $y, 0]}}
    time: {end: 1, step: 0.01}
    """
    (said,) = warned(text)
    assert "node left_seat: nothing gives mass" in said and said.endswith("(and 1 more copy of it)")


DECKS = [*sorted(INPUTS.glob("*.yaml")), *sorted(STARTERS.glob("*.yaml"))]


@pytest.mark.parametrize("path", DECKS, ids=lambda path: path.stem)
def test_no_warning_of_the_text_of_good_decks(path):
    assert read_deck(path).warnings == ()


@pytest.mark.parametrize(
    "name", ["hoist", "pendulum", "cable_catch", "base_excitation", "slider_crank", "gears", "fiala_sweep"]
)
def test_no_warning_of_good_models(name):
    said = warnings_of(prepare(input_deck(name)))
    assert len(said) == (name in SUSPICIOUS_INPUTS)
    assert all(SUSPICIOUS_INPUTS[name] in line for line in said)


WAVE = "{sine: {amplitude: 1, frequency: 30}}"  # three steps of HEAD a period and a third
SPRING = "{type: spring_damper, nodes: [a, b], law: {linear: {slope: 1}}, natural_length: FIELD}"
OF_TIME = {
    "push": "    loads: {push: {type: force, node: b, direction: [1, 0, 0], value: FIELD}}",
    "held": "    joints: {held: {type: prescribed_position, node: b, direction: [1, 0, 0], value: FIELD}}",
    "spring": f"      spring: {SPRING}",
}


@pytest.mark.parametrize("name", OF_TIME)
@pytest.mark.parametrize("wave", [WAVE, "{sine: {amplitude: 1, frequency: -30, offset: 2}, constant: 3}"])
def test_waves_of_time_that_the_steps_do_not_sample(name, wave):
    text = HEAD + OF_TIME[name].replace("FIELD", wave) + "\n"
    (found,) = deck(text).warnings
    assert f"'{name}': " in found.message and "oscillates at 30 Hz, but steps of 0.01 s (time.step)" in found.message
    assert "sample it only 3.33 times per period" in found.message and "0.00833 s is the longest step" in found.message
    assert str(found.mark).startswith(at(text, OF_TIME[name].strip()[:12]).rpartition(":")[0].rpartition(":")[0])


LOAD = HEAD + "    loads: {push: {type: force, node: b, direction: [1, 0, 0], value: FIELD}}\n"
FIXED, ADAPTIVE = "step: 0.01", "step: {step}, adaptive: {{tolerance: 1e-3, maximum_step: {longest}}}"


@pytest.mark.parametrize(
    ("value", "time", "text"),
    [
        ("{sine: {amplitude: 1, frequency: 25}}", FIXED, ""),  # four steps a period
        ("{sine: {amplitude: 0, frequency: 30}}", FIXED, ""),
        ("{random: {density: 1, highest: 30}}", FIXED, "oscillates at 30 Hz"),
        ("sin(2*pi*30*time)", FIXED, "oscillates at 30 Hz"),
        ("1 + cos(3 - 2*pi*30*time)**2", FIXED, "oscillates at 30 Hz"),
        ("sin(2*pi*25*time)", FIXED, ""),
        ("sin(pi*30*time**2)", FIXED, "oscillates at 30 Hz"),  # a sweep, at the end of the run
        ("sin(200*b.position.x) + 200*time", FIXED, ""),
        ("sin(sqrt(-1 - time))", FIXED, ""),
        (WAVE, ADAPTIVE.format(step=0.001, longest=0.01), "steps of 0.01 s (time.adaptive.maximum_step)"),
        (WAVE, ADAPTIVE.format(step=0.001, longest=0.008), ""),
        (WAVE, ADAPTIVE.format(step=0.001, longest="automatic"), ""),
        (WAVE, ADAPTIVE.format(step=0.1, longest="automatic"), "steps of 0.1 s (time.step, the first step)"),
    ],
)
def test_waves_of_time(value, time, text):
    found = deck(LOAD.replace("FIELD", value).replace(FIXED, time)).warnings
    assert len(found) == bool(text) and all(text in one.message for one in found)


def test_a_law_of_time_with_several_uses_is_one_warning():
    more = "pull: {type: force, node: b, direction: [0, 1, 0], value: FIELD}}"
    given = LOAD.replace("FIELD}}", f"FIELD}}, {more}").replace("FIELD", "shake") + f"    laws: {{shake: {WAVE}}}\n"
    (found,) = deck(given).warnings
    assert "force 'push'" in found.message and "(and 1 more uses)" in found.message


def test_a_ground_that_moves_by_a_wave_of_time():
    ground = "plane: {point: [0, 0, 0], normal: [0, 0, 1]}, motion: {direction: [1, 0, 0], speed: FIELD}"
    found, _ = deck(HEAD + f"    grounds: {{belt: {{{ground.replace('FIELD', WAVE)}}}}}\n").warnings
    assert "ground 'belt': 'motion.speed' oscillates at 30 Hz" in found.message


@pytest.mark.parametrize(
    ("start", "nodes", "axis", "hinge"),
    [
        (3.1, "[ground, arm]", "[0, 0, 1]", None),
        (3.5, "[ground, arm]", "[0, 0, 1]", -2.78319),  # 3.5 - 2 pi
        (3.5, "[arm, ground]", "[0, 0, 1]", 2.78319),
        (3.5, "[ground, arm]", "[0, 0, -1]", 2.78319),
        (-10, "[arm, ground]", "[0, 0, -1]", 2.56637),  # 4 pi - 10, and the other sense twice
    ],
)
def test_a_motor_begins_at_another_turn_than_its_hinge(start, nodes, axis, hinge):
    text = f"""
    mecano: 1
    gravity: none
    time: {{end: 1, step: 0.01}}
    nodes: {{arm: {{position: [0, 0, 0]}}}}
    elements: {{body: {{type: rigid_body, node: arm, mass: 2, inertia: [1, 1, 1]}}}}
    joints:
      shaft: {{type: hinge, nodes: [ground, arm], axis: [0, 0, 1]}}
      motor: {{type: prescribed_angle, nodes: {nodes}, axis: {axis}, value: {{linear: {{slope: 1, offset: {start}}}}}}}
    """
    begins = f"test.yaml:9:3: prescribed_angle 'motor' begins at {start} rad, but hinge 'shaft' at {hinge} rad: "
    found = warned(text)
    assert len(found) == (hinge is not None) and all(one.startswith(begins) for one in found)


@pytest.mark.parametrize(("x", "far"), [(9e4, False), (1e6, True)])
def test_a_mechanism_far_from_the_origin(x, far):
    text = HEAD.replace("position: [0, 0, 0]", f"position: [{x}, 0, 0]").replace("[1, 0, 0]", f"[{x + 1}, 0, 0]")
    found = [one for one in warned(text) if "from the origin" in one]
    assert len(found) == far and all("the nearest node, 'a', is 1e+06 m from the origin" in one for one in found)
    assert all(one.startswith("test.yaml:5:") for one in found)


ONE_POINT = """
    mecano: 1
    gravity: [0, 0, -9.81]
    time: {end: 1, step: 0.01, adaptive: {tolerance: 1e-3LENGTH}}
    nodes: {a: {position: [2, 0, 0]}, b: {position: [APART, 0, 0]}}
    elements: {weight: {type: point_mass, node: a, mass: 2}, other: {type: point_mass, node: b, mass: 1}}
"""


@pytest.mark.parametrize(
    ("apart", "length", "warns"), [("2", "", True), ("2.1", "", False), ("2", ", length_scale: 10 cm", False)]
)
def test_a_tolerance_relative_to_a_single_point(apart, length, warns):
    found = warned(ONE_POINT.replace("APART", apart).replace("LENGTH", length))
    assert len(found) == warns and all("all nodes are at one point" in one for one in found)
    assert all(one.startswith("test.yaml:5:") for one in found)


@pytest.mark.parametrize(
    ("name", "override", "said"),
    [
        (
            "crosswind_landing",
            "joints.left_bearing=null",
            "flexible_wheel 'left_wheel': no joint or member holds its node",
        ),
        ("wheel_spin_up", "joints.bearing.axis=[1, 0, 0]", "hinge 'bearing': its axis is not that of the wheel 'tire'"),
        ("twin_wheel_gear", "joints.left_bearing.axis=[0, -1, 0.1]", ""),
        ("paper_disc", "title=A disc on no axle", ""),
        ("sleigh", "title=A blade turns with its body", ""),
        (
            "twin_wheel_gear",
            "parameters.friction=65",
            "tire law 'tyre': a coefficient of friction of 65 is larger than",
        ),
        ("friction_pendulum", "joints.hinge.friction.coefficient=15", "hinge 'hinge': a coefficient of friction of 15"),
        (
            "landing_roll",
            "tire_laws.tyre.rolling_resistance.coefficient=2",
            "tire law 'tyre': a coefficient of rolling",
        ),
    ],
)
def test_bearings_and_frictions_of_wheels(name, override, said):
    found = [problem.message for problem in input_deck(name, override).warnings]
    assert len(found) == bool(said) and all(text.startswith(said) for text in found)


@pytest.mark.parametrize(("to", "mass", "warned"), [(4.0, 0.8, True), (6.0, 0.8, False), (4.0, 0.0, False)])
def test_a_line_whose_mass_does_not_follow_its_length(to, mass, warned):
    """10 m of a wire of 0.8 kg/m are hauled in to 4 m."""
    changes = (f"elements.wire.natural_length.step.to={to}", f"elements.wire.mass_per_length={mass}")
    said = [text for text in warnings_of(prepare(input_deck("hoist", *changes))) if "its mass stays" in text]
    assert len(said) == warned and all("8 kg of 10 m, while its natural length becomes 4 m" in text for text in said)


@pytest.mark.parametrize(("inertia", "warned"), [("[100, 83333, 83333]", True), ("[10, 100, 100]", False)])
def test_inertia_of_a_body_much_larger_than_the_model(inertia, warned):
    """A bar of 1 kg and 1 m in kg mm2, and one that is heavy at distant places."""
    model = prepare(input_deck("double_pendulum", f"elements.upper.inertia={inertia}"))
    said = [text for text in warnings_of(model) if "radius of gyration" in text]
    assert len(said) == warned and all("a radius of gyration of 289 m" in text for text in said)


BOOM = """
    mecano: 1
    gravity: none
    nodes: {a: {position: [0, 0, 0]}, b: {position: [1, 0, 0]}}
    sections: {tube: {type: tube, diameter: 50 mm, thickness: 2 mm, E: 210 GPa, nu: 0.3, density: 7850}}
    elements: {boom: {type: beam, nodes: [a, b], section: tube, mesh: MESH}}
    initial: {velocities: [{nodes: NODES, velocity: [1, 0, 0]}]}
    time: {end: 0.01, step: 0.001}
    """


def boom(mesh, nodes):
    return deck(BOOM.replace("MESH", str(mesh)).replace("NODES", nodes))


@pytest.mark.parametrize("mesh", [1, 2, 8])
def test_a_member_stands_for_its_nodes_in_initial_velocities(mesh):
    inner = [f"boom.{i}" for i in range(1, mesh)]
    checked = boom(mesh, "[b, boom]")
    assert checked.values["initial"]["velocities"][0]["nodes"] == ["b", "a", *inner] and not checked.warnings


def test_a_mesh_with_more_nodes_than_initial_velocities_name():
    assert not boom(4, "[a, b, boom.1, boom.2, boom.3]").warnings and not boom(8, "[a, b]").warnings
    (warning,) = boom(8, "[a, b, boom.1, boom.2, boom.3]").warnings
    assert "names nodes of 'boom', but not boom.4, boom.5, boom.6, and 1 more; 'boom' itself" in warning.message


LATCH = """
    mecano: 1
    gravity: none
    nodes: {arm: {position: [0, 0, 0]}}
    elements: {arm: {type: rigid_body, node: arm, mass: 1, inertia: [0.1, 0.1, 0.1]}}
    joints:
      pin: {type: hinge, nodes: [ground, arm], axis: [0, 1, 0], latch: {angle: 1.5}, LAW}
    MORE
    time: {end: 0.2, step: 0.001}
    """


@pytest.mark.parametrize(
    ("law", "more", "warned"),
    [
        ("turning_law: {spring: 40}, natural_angle: 1.6", "", False),
        ("turning_law: {spring: 40}, natural_angle: -1.6", "", True),
        ("turning_law: {preload: -3}", "", False),
        ("turning_law: {preload: 3}", "", True),
        ("turning_law: {preload: 3}", "loads: {motor: {type: joint_moment, joint: pin, value: 9}}", False),
        ("turning_law: {spring: 40}, natural_angle: -time", "", False),
        ("turning_law: {damper: 3}", "", False),
    ],
)
def test_a_law_that_pushes_away_from_the_latch(law, more, warned):
    found = [w.message for w in deck(LATCH.replace("LAW", law).replace("MORE", more)).warnings]
    assert len(found) == warned
    assert not warned or "'turning_law' pushes it away from its latch at the start; is a sign wrong" in found[0]


@pytest.mark.parametrize(
    ("motion", "said"),
    [
        ("{ramp: {start: 0.2, end: 0.4, from: 0, to: 1}}", "has a rate that jumps by 5 m/s at 0.2 s: a shock"),
        ("{ramp: {start: 0, end: 0.4, from: 0, to: 1}}", "has a rate that jumps by -2.5 m/s at 0.4 s: a shock"),
        ("{table: {points: [[0, 0], [0.2, 0.5]]}}", "has a rate that jumps by -2.5 m/s at 0.2 s: a shock"),
        ("{table: {points: [[0, 0], [1, 0.5]]}}", ""),  # up to the end of the run
        (
            "{table: {points: [[0, 0], [0.2, 0.5], [0.4, 0.5], [0.6, 0.8]], beyond: extend}}",
            "is a table with the default interpolation, a monotone cubic, whose acceleration jumps at each point",
        ),
        (
            "{table: {points: [[0, 0], [0.2, 0.5], [0.4, 0.5], [0.6, 0.8]], beyond: extend, interpolation: spline}}",
            "",
        ),
        ("{step: {time: 0.2, from: 0, to: 0.5, rise: 0}}", "jumps by 0.5 m at 0.2 s: no force moves"),
        ("{step: {time: 0.2, from: 0, to: 0.5, rise: 0.1}}", ""),
        ("0.1*time**2", ""),
    ],
)
def test_prescribed_motions_that_jump(motion, said):
    """At corners of laws within the run; the same for an axis of a generic joint."""
    start = """
        mecano: 1
        gravity: none
        time: {end: 1, step: 0.01}
        nodes: {b: {position: [1, 0, 0]}}
        elements: {weight: {type: rigid_body, node: b, mass: 2, inertia: [1, 1, 1]}}
    """
    node = "type: prescribed_position, node: b, direction: [1, 0, 0], value"
    axis = "type: generic, nodes: [ground, b], axis: [1, 0, 0], driven: {along_axis"
    for joint, path, end in ((node, "value", ""), (axis, "driven.along_axis", "}")):
        found = warned(f"{start}    joints: {{push: {{{joint}: {motion}{end}}}}}\n")
        assert [f"'push': '{path}' {said}" in one for one in found if "'push'" in one] == [True] * bool(said)


@pytest.mark.parametrize(
    ("override", "said"),
    [
        ("elements.upper.center_of_mass=[5.4, 0, 3]", "its centre of mass is 6.18 m from all nodes"),
        ("elements.upper.center_of_mass=[5.4, 0, 3]", "is [0, -0.4, 0] meant?"),
        ("elements.upper.center_of_mass=[0, -400, 0]", "in the axes of the node: is it in m?"),
        ("elements.upper.center_of_mass=[0, -0.4, 0]", ""),
        ("elements.lower.center_of_mass=[0.8, 0, 0]", ""),  # a last link may be longer than all others
        ("elements.lower.attached=[elbow]", "node 'elbow' is attached to 'upper', too, which welds both together"),
    ],
)
def test_misplaced_bodies(override, said):
    """The upper body has its y axis against x; [5.4, 0, 3] turned so is (5.4^2 + 3^2)^(1/2) m from the nodes."""
    base = deck("""
        mecano: 1
        gravity: [0, 0, -9.81]
        nodes:
          pin: {position: [5, 0, 3], orientation: [0, 0, 90 deg]}
          elbow: {position: [6, 0, 3]}
          arm: {position: [6, 0, 3]}
        elements:
          upper: {type: rigid_body, node: pin, mass: 1, inertia: [1, 1, 1], attached: [elbow]}
          lower: {type: rigid_body, node: arm, mass: 1, inertia: [1, 1, 1]}
        joints:
          shoulder: {type: hinge, nodes: [ground, pin], axis: [0, 1, 0]}
          elbow: {type: hinge, nodes: [elbow, arm], axis: [0, 1, 0]}
        time: {end: 1, step: 0.01}
        """)
    found = [one.message for one in deck_of_bytes(base.text.encode(), "test.yaml", overrides=[override]).warnings]
    assert len(found) == bool(said) and all(said in one for one in found)


@pytest.mark.parametrize(
    ("center", "said"),
    [
        ([0.5, 0, 0.75], "its centre of mass is 0.559 m from its nodes"),  # (0.5^2 + 0.25^2)^(1/2)
        ([0.5, 0, 0.75], "is [0, 0, 0.25] meant?"),
        ([0, 0, 0.25], ""),
        ([0, 0, -0.25], ""),  # a counterweight
        ([0.5, 0, 0.3], ""),  # neither is among its nodes
    ],
)
def test_a_centre_of_mass_beside_the_nodes_of_its_body(center, said):
    """Among all nodes of the model, but not among its own, where it would be if it counted from the origin."""
    base = deck("""
        mecano: 1
        gravity: [0, 0, -9.81]
        nodes: {pin: {position: [0.5, 0, 0.5]}, end: {position: [0.5, 0, 1]}, wall: {position: [9, 0, 0], fixed: true}}
        elements:
          bar: {type: rigid_body, node: pin, mass: 1, inertia: [1, 1, 1], attached: [end]}
          spring: {type: spring_damper, nodes: [wall, end], law: {spring: 9}}
        joints: {pin: {type: hinge, nodes: [ground, pin], axis: [0, 1, 0]}}
        time: {end: 1, step: 0.01}
        """)
    found = deck_of_bytes(base.text.encode(), "test.yaml", overrides=[f"elements.bar.center_of_mass={center}"]).warnings
    assert [said in one.message for one in found] == [True] * bool(said)


SIZE = (
    "friction: 0.5, slip_regularization: 0.1, "
    "smiley_horne: {diameter: 820 mm, width: 245 mm, pressure: 9.5 bar, rated_pressure: 10 bar"
)


@pytest.mark.parametrize(
    ("override", "said"),
    [
        ("tire_laws.rubber.radial_damping=80", "'radial_damping' multiplies the radial force by 81 at 1 m/s"),
        ("tire_laws.rubber.radial_damping=0.5", ""),
        ("tire_laws.rubber.slip_regularization=100", "'slip_regularization' is 100 m/s: the tyre reaches its friction"),
        ("tire_laws.rubber.slip_regularization=2", ""),
        (f"tire_laws.rubber={{{SIZE}, load: 48}}}}", "'smiley_horne.load' of 48 N deflects the tyre by 0.00013 of its"),
        (f"tire_laws.rubber={{{SIZE}, load: 48 kN}}}}", ""),
    ],
)
def test_tyres_in_other_units(override, said):
    found = [one.message for one in input_deck("wheel_drop", override).warnings]
    assert found == [] if not said else found[0].startswith(f"tire law 'rubber': {said}")


@pytest.mark.parametrize(("radius", "said"), [(10, "'friction.radius' is 10 m, and the model has"), (0.01, "")])
def test_bearings_larger_than_the_model(radius, said):
    friction = f"joints.hinge_a.friction={{coefficient: 0.1, regularization: 1 mm/s, radius: {radius}}}"
    found = [text for text in warnings_of(prepare(input_deck("four_bar", friction))) if "friction.radius" in text]
    assert len(found) == bool(said) and all(said in text for text in found)


@pytest.mark.parametrize(
    ("expression", "angle"),
    [
        ("2*cos(30)", "'cos(30)' the angle is 30 rad"), ("'=sin(-22.5)'", "'sin(-22.5)' the angle is 22.5 rad"),
        ("cos($bare)", "'cos($bare)' the angle is 60 rad"), ("cos($tilt)", ""), ("cos(3)", ""), ("sin(7.1)", ""),
        ("cos(30*pi/180)", ""),
    ],
)  # fmt: skip
def test_angles_in_expressions_that_look_like_degrees(expression, angle):
    """Of a position, and in a formula of a signal, at the place of the text."""
    head = "mecano: 1\ngravity: none\nparameters: {tilt: 60 deg, bare: 60, none: $tilt + $bare}\n"
    head += "nodes: {a: {position: [0, 0, 0], fixed: true}, b: {position: [PLACE, 0, 1]}}\n"
    head += (
        "elements: {weight: {type: point_mass, node: b, mass: 1}, s: {type: cable, nodes: [a, b], E: 1e9, area: 1}}\n"
    )
    head += "loads: {push: {type: force, node: b, direction: [1, 0, 0], value: thrust}}\n"
    head += "signals: {thrust: FORMULA}\ntime: {end: 1, step: 0.01}\n"
    for place, formula, mark in ((expression, "1 + time", "4:63"), ("1", f"{expression} + time", "7:19")):
        text = head.replace("PLACE", place).replace("FORMULA", formula.replace("'", "").replace("=", ""))
        found = [one for one in deck(text).warnings if "more than a turn" in one.message]
        assert len(found) == bool(angle)
        assert not angle or (angle in found[0].message and str(found[0].mark) == f"test.yaml:{mark}")


@pytest.mark.parametrize(
    ("motion", "edge"),
    [
        ("30*step(time, 0, 1)", "30"),
        ("1.5*step(time, 0, 0.4) - 60 * step(time, 0.5, 1)", "60"),
        ("30*pi/180*step(time, 0, 1)", ""),
        ("30*step(time, 0, 1)*pi/180", ""),
        ("6.2*step(time, 0, 1)", ""),
        ("0.1*30*step(time, 0, 1)", ""),
    ],
)
def test_edges_of_angles_that_look_like_degrees(motion, edge):
    text = (
        "{mecano: 1, gravity: none, nodes: {a: {position: [0, 0, 0]}}, elements: {a: {type: rigid_body, node: a, "
        "mass: 1, inertia: [1, 1, 1]}}, joints: {pin: {type: hinge, nodes: [ground, a], axis: [0, 0, 1]}, motor: {"
        f"type: prescribed_angle, nodes: [ground, a], axis: [0, 0, 1], value: '{motion}'}}}}, "
        "time: {end: 1, step: 0.01}}"
    )
    found = [one.message for one in deck(text).warnings if "more than a turn" in one.message]
    wanted = f"'value': the edge '{edge}*step(...)' is one of {edge} rad"
    assert [wanted in text for text in found] == [True] * bool(edge)
