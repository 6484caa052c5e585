"""Quantities with units, against their definitions."""

import math
import textwrap

import pytest
from deck_samples import VALID, problems_of, read_fake
from time_runs import INPUTS, input_deck

from mecano.deck import expression_units
from mecano.deck.catalogue import _fields as declared_fields
from mecano.deck.laws import _unit_in_use, units_in
from mecano.deck.read import deck_of_bytes
from mecano.deck.units import ANY, UnitError, converted, is_quantity, parsed, written_in_si
from mecano.errors import DeckError
from mecano.laws.roads import PER_ARGUMENT
from mecano.laws.term import DENSITY, SLOPE, VALUE

EXACT = [  # SI Brochure, 9th edition (2019), and NIST SP 811 (2008), appendix B
    ("25 mm", "m", 0.025), ("25mm", "m", 0.025), ("-3.5e2 cm", "m", -3.5), ("1 in", "m", 0.0254),
    ("1 ft", "m", 0.3048), ("60 km/h", "m/s", 60 / 3.6), ("1 kt", "m/s", 1852 / 3600), ("3 bar", "Pa", 3e5),
    ("1 psi", "Pa", 6894.757293168361), ("12 deg", "rad", math.pi / 15), ("12 °", "rad", math.pi / 15),
    ("60 rpm", "rad/s", 2 * math.pi), ("2 kN/mm", "N/m", 2e6), ("3 kN m", "N m", 3e3),
    ("1 lbf", "N", 4.4482216152605), ("80 cm2", "m2", 8e-3), ("80 cm^2", "m2", 8e-3), ("7 m³", "m3", 7.0),
    ("9 l", "m3", 9e-3), ("250 ml", "m3", 2.5e-4), ("12 l/min", "m3/s", 2e-4), ("9 L", "m3", None),
    ("2 t", "kg", 2e3), ("5 g", "kg", 5e-3), ("7.85 g/cm3", "kg/m3", 7850.0), ("5 %", "-", 0.05),
    ("2 N m/deg", "N m/rad", 360 / math.pi), ("2 N m", "N m/rad", 2.0), ("3 min", "s", 180.0),
    ("1 hp", "W", 745.6998715822702), ("5 Hz", "1/s", 5.0), ("9 m/s/s", "m/s2", 9.0), ("4 N", "N or N m", 4.0),
    ("4 N m", "N or N m", 4.0), ("4 furlong", ANY, None), ("4 mm", ANY, 4e-3), ("4 m", "kg", None),
    ("4 deg", "m", None), ("4 deg", "-", None), ("4 Hz", "rad/s", None), ("4 m/s", "m/s2", None),
    ("4 N/m s", "N s/m", None), ("4 Bar", "Pa", None),
]  # fmt: skip


@pytest.mark.parametrize("text,unit,expected", EXACT, ids=[f"{text}|{unit}" for text, unit, _ in EXACT])
def test_values(text, unit, expected):
    assert is_quantity(text)
    if expected is None:
        with pytest.raises(UnitError):
            converted(text, unit)
    else:
        assert converted(text, unit) == pytest.approx(expected, rel=1e-15)


@pytest.mark.parametrize("text", ["7", "7e10", "0x1F", ".5", "$a", "=3", "mm", "fast", "2 * $a", "-$a", "12:30:45", ""])
def test_what_is_no_quantity(text):
    assert not is_quantity(text)


def test_every_declared_unit_can_be_checked():
    """A field that is declared with a unit that is none could not be given one."""
    units = {field.unit for _, field in declared_fields()}
    for unit in units:
        if unit != "-" and "unit" not in unit:
            assert all(parsed(part.strip()) for part in unit.replace(" or ", ",").split(",")), unit


def test_units_in_a_deck():
    text = VALID.replace("mass: 7e1", "mass: 0.07 t").replace("[0, 0, 2.1]", "[0, 0, 210 cm]")
    text = text.replace("stiffness: 1e6", "stiffness: 1 kN/mm").replace("every: 5e-3", "every: 5 ms")
    assert read_fake(text).values == read_fake(VALID).values
    values = read_fake(VALID.replace("sink: 3.05", "sink: 183 m/min")).values
    assert values["initial"]["velocities"][0]["velocity"][2] == pytest.approx(-3.05)
    assert problems_of(VALID.replace("every: 5e-3", "every: 5 m")) == [
        "41:17 'output.every': a time [s] is expected, and 'm' is a length"
    ]
    assert problems_of(VALID.replace("sink: 3.05", "sink: 3 furlong"))[0] == (
        "3:20 parameter 'sink': 'furlong' is not a unit"
    )


@pytest.mark.parametrize("text", ["kg.0", "Kg.0", "m.0"])
def test_no_unit_with_the_power_zero_is_suggested(text):
    (problem,) = problems_of(VALID.replace("mass: 7e1", f"mass: 7 {text}"))
    assert "is not a unit" in problem and "0'?" not in problem


@pytest.mark.parametrize(
    ("old", "new", "reported"),
    [
        ("every: 5e-3", "every: -5 ms", "'output.every' must be greater than zero [s], got -5 ms"),
        ("mass: 7e1", "mass: \u22125 kg", "got the text '\u22125 kg'; write -5 kg"),
        ("{table: {points: [[0, 0], [1, 1e3]]}}", "-5 * kN", "[N], got the text '-5 * kN'; a number is written as 2.5"),
        ("{table: {points: [[0, 0], [1, 1e3]]}}", "5 kNm", "'kNm' is not a unit; did you mean 'kN m'?"),
        ("mass: 7e1", "mass: 7 kilograms", "'kilograms' is not a unit; did you mean 'kg'?"),
        ("mass: 7e1", "mass: 7 kgs", "'kgs' is not a unit; did you mean 'kg'?"),
        ("mass: 7e1", "mass: 7d1", "'d1' is not a unit; an exponent begins with e: e1"),
        ("every: 5e-3", "every: 5 sec", "'sec' is not a unit; did you mean 's'?"),
        ("[0, 0.1, 0]", "[0, 30 degrees, 0]", "'degrees' is not a unit; did you mean 'deg'?"),
        ("[0, 0, 2.1]", "[0, 0, 2 metre]", "'metre' is not a unit; did you mean 'm'?"),
        ("[0, 0, 2.1]", "[0, 0, 2 Millimeters]", "'Millimeters' is not a unit; did you mean 'mm'?"),
        ("upper: 0.3, stiffness: 1e6", "upper: 0.3, stiffness: 1 kN/mm**1", "did you mean 'kN/mm^1'?"),
        ("upper: 0.3, stiffness: 1e6", "upper: 0.3, stiffness: 1 Nm/rad", "did you mean 'N m/rad'?"),
        ("damper: {coefficient: 1.19e4}", "damper: {coefficient: 12 kNs/m}", "did you mean 'kN s/m'?"),
        ("damper: {coefficient: 1.19e4}", "damper: {coefficient: 12 Newton-sec/metre}", "did you mean 'N s/m'?"),
        ("{table: {points: [[0, 0], [1, 1e3]]}}", "5 KN", "'KN' is not a unit; did you mean 'kN'?"),
        ("mass: 7e1", "mass: 90 deg + $sink", "'deg + $sink' is not a unit; expressions contain no units"),
        (
            "mass: 7e1",
            "mass: $sink + 90 kg",
            "the expression '$sink + 90 kg' cannot be understood: expressions contain",
        ),
        ("mass: 7e1", "mass: $pi", "'pi' is a constant: write pi without $"),
        (
            "[[0, 0], [1, 1e3]]",
            "[[0, 0], [1, 1 kg]]",
            "20:71 force 'push': 'value.table.points[1][1]': a force [N] is expected, and 'kg' is a mass",
        ),
        ("mass: 7e1", "mass: pi", "got the text 'pi'; write '=pi'"),
    ],
)
def test_quantities_that_are_refused(old, new, reported):
    """What stands there, and what would be right."""
    assert VALID.count(old) == 1
    (problem,) = problems_of(VALID.replace(old, new))
    assert reported in problem


@pytest.mark.parametrize(
    ("coefficients", "values"),
    [
        ("[0, 2 kN/mm, 3 N/mm^2]", [0.0, 2e6, 3e6]),
        ("[1 N, 2 kN/mm, 0, 4 N/m3]", [1.0, 2e6, 0.0, 4.0]),
        ("[0, 5 N s/m, 0, 2 N s3/m3]", [0.0, 5.0, 0.0, 2.0]),
        ("[0, 2 N m/rad, 3 N m]", [0.0, 2.0, 3.0]),
    ],
)
def test_units_of_coefficients(coefficients, values):
    text = VALID.replace("{table: {points: [[0, 0], [1, 1e3]]}}", f"{{polynomial: {coefficients}}}")
    ((name, found),) = read_fake(text).values["loads"]["push"]["value"]
    assert name == "polynomial" and found["coefficients"] == pytest.approx(values, rel=1e-15)


def test_units_of_coefficients_that_do_not_go_together():
    coefficients = "[2 N, 2 N/mm, 3 N/mm]"
    text = VALID.replace("{table: {points: [[0, 0], [1, 1e3]]}}", f"{{polynomial: {coefficients}}}")
    (problem,) = problems_of(text)
    assert "units are inconsistent: 2 N (power 0), 2 N/mm (power 1), 3 N/mm (power 2)" in problem


@pytest.mark.parametrize(
    ("radial", "reported"),
    [
        ("linear: {slope: 400 kN/m, offset: 0 N}", ""),
        ("linear: {slope: 400 bar}", "'radial.linear.slope': a stiffness [N/m] is expected, and 'bar' is a pressure"),
        ("polynomial: [0, 400 kN/m, 3 kN/m^2]", ""),
        ("polynomial: [0, 400 kN/m, 3 N/m]", "coefficients[2]': a pressure [N/m^2] is expected, and 'N/m' is a stiff"),
        ("power: {coefficient: 9 MN/m^1.5, exponent: 1.5}", ""),
        ("power: {coefficient: 9 MN/m, exponent: 1.5}", "'radial.power.coefficient': "),
        ("table: {points: [[0, 0], [1 cm, 4 kN]]}", ""),
        ("table: {points: [[0, 0], [1 deg, 4 kN]]}", "points[1][0]': a length [m] is expected, and 'deg' is an angle"),
    ],
)
def test_units_in_a_law_whose_use_is_known(radial, reported):
    """The radial force [N] of a tyre is a curve of its deformation [m]."""
    text = (INPUTS / "nose_wheel_steering.yaml").read_text()
    text = text.replace("radial: {linear: {slope: 5.0e5}}", f"radial: {{{radial}}}")
    if not reported:
        assert deck_of_bytes(text.encode(), "steering.yaml").values["tire_laws"]["rubber"]["radial"]
        return
    with pytest.raises(DeckError) as error:
        deck_of_bytes(text.encode(), "steering.yaml")
    assert reported in str(error.value)


@pytest.mark.parametrize(
    ("law", "reported"),
    [
        ("damper_table: {points: [[0 deg/s, 0 N m], [1 rad/s, 2 kN m]]}", ""),
        ("damper_table: {points: [[0, 0], [1 deg, 2]]}", "[1][0]': an angular velocity [rad/s] is expected, and 'deg'"),
        ("damper_polynomial: [0, 3 N m s/rad, 3 N m s2/rad2]", ""),
        ("damper_power: {coefficient: 2 N m s^1.5/rad^1.5, exponent: 1.5}", ""),
        ("damper_power: {coefficient: 2 N m/rad^2, exponent: 2}", "[N m s^2/rad^2] is expected, and 'N m/rad^2' is"),
    ],
)
def test_units_of_forces_of_the_rate(law, reported):
    """The moment [N m] of a hinge from its angle [rad] and rate."""
    text = (INPUTS / "pendulum.yaml").read_text()
    text = text.replace("axis: [0, 1, 0]}", f"axis: [0, 1, 0], turning_law: {{{law}}}}}")
    if not reported:
        assert deck_of_bytes(text.encode(), "damped.yaml").values["joints"]["hinge"]["turning_law"]
        return
    with pytest.raises(DeckError) as error:
        deck_of_bytes(text.encode(), "damped.yaml")
    assert reported in str(error.value)


NAMED = """
    mecano: 1
    gravity: none
    nodes: {a: {position: [0, 0, 0]}, b: {position: [1, 0, 0]}}
    elements:
      a: {type: rigid_body, node: a, mass: 1, inertia: [1, 1, 1]}
      b: {type: point_mass, node: b, mass: 1}
      s: {type: spring_damper, nodes: [a, b], law: LAW}
    joints: {h: {type: hinge, nodes: [ground, a], axis: [0, 0, 1], turning_law: coil}}
    loads: {f: {type: force, node: b, direction: [1, 0, 0], value: push}}
    laws: {coil: {spring: {stiffness: 3 N m/deg}}, line: {spring: {stiffness: 3 N/mm}}, push: PUSH}
    time: {end: 1, step: 0.1}
    """


@pytest.mark.parametrize(
    ("law", "push", "message", "hint"),
    [
        ("line", "5 kN", "", ""),
        ("coil", "5 kN", "law 'coil': 'spring.stiffness': a stiffness [N/m] is expected, and 'N m/deg' is a torsional",
         "spring_damper 's' uses it in line 8"),
        ("line", "5 bar", "law 'push': a force [N] is expected, and 'bar' is a pressure", "force 'f' uses it in line"),
        ("line", "{sine: {amplitude: 3 N, frequency: 2 m}}", "'sine.frequency': a frequency [1/s] is expected", "'f'"),
        ("line", "{table: {points: [[0 s, 0], [1, 2 N m]]}}", "[1][1]': a force [N] is expected, and 'N m' is", "'f'"),
    ],
)  # fmt: skip
def test_units_of_named_laws_are_those_of_each_use(law, push, message, hint):
    text = textwrap.dedent(NAMED.replace("LAW", law).replace("PUSH", push))
    if not message:
        assert deck_of_bytes(text.encode(), "named.yaml").values["laws"]["push"] == (("constant", {"value": 5e3}),)
        return
    with pytest.raises(DeckError) as error:
        deck_of_bytes(text.encode(), "named.yaml")
    (problem,) = error.value.problems
    assert message in problem.message and hint in problem.hint


def test_laws_are_declared_with_the_unit_of_their_argument():
    """Except those of the signal 'curve', whose input may be anything, and of coordinates, lengths or angles."""
    fields = [field for _, field in declared_fields()]
    laws = {field.doc: units_in(field) for field in fields if field.type.name in ("law", "curve", "drive")}
    assert [doc for doc, units in laws.items() if not all(units)] == [
        "f, both c_1 and c_2 in SI units: rad, m",
        "c, the value as a function of the input, both in SI units",
    ]


@pytest.mark.parametrize(
    ("value", "argument", "expected"),
    [
        ("N", "m", ["N/m", "N", "N/m", "1/m"]), ("N m", "rad", ["N m/rad", "N m", "N m/rad", "1/rad"]),
        ("-", "m/s", ["s/m", "-", "N/m or N m/rad", "s/m"]),
        ("N/rad", "N", ["N/rad/N", "N/rad", "N/m or N m/rad", "1/N"]),
        ("", "s", [SLOPE, VALUE, "N/m or N m/rad", "1/s"]), ("N", "", [SLOPE, "N", "N/m", PER_ARGUMENT]),
    ],
)  # fmt: skip
def test_units_of_a_term_in_its_use(value, argument, expected):
    assert [_unit_in_use(unit, value, argument) for unit in (SLOPE, VALUE, "N/m or N m/rad", PER_ARGUMENT)] == expected


def test_units_of_a_column_go_together():
    """In a law of the section 'laws', whose use is not known where it is read."""
    text = VALID.replace("smooth: 0.8", "smooth: {table: {points: [[0, 0.8], [10 mm, $own], [2 %s, 0.5 %s]]}}")
    text = text.replace("mass: 82.0", "mass: 82.0, own: 50 %%")
    place, hint = "26:55 law 'smooth': 'table.points[2]", "; give each a unit as that of 10 mm, or none"
    assert problems_of(text % ("N", "%")) == [f"{place}[0]': units of a column are inconsistent: 10 mm and 2 N{hint}"]
    (problem,) = problems_of(text % ("cm", "m"))
    assert "'table.points[2][1]': units of a column are inconsistent: 50 % and 0.5 m" in problem


@pytest.mark.parametrize(
    ("points", "odd"),
    [
        (
            "[[0, 0], [30 deg, 1], [1.2, 2]]",
            "'table.points[2][0]': units of a column are inconsistent: 30 deg and 1.2, w",
        ),
        (
            "[[-0.5, 0], [0, 1], [10 mm, 2]]",
            "'table.points[0][0]': units of a column are inconsistent: 10 mm and -0.5, w",
        ),
        ("[[0, 0], [1 m, 1], [1.2, 2]]", ""),
        ("[[0, 0], [90 deg, 0.4], [180 deg, 50 %]]", ""),
    ],
)
def test_numbers_alone_beside_units_are_in_si(points, odd):
    """In a column of degrees or millimetres, where they are not meant so; not zero, which needs no unit."""
    text = VALID.replace("smooth: 0.8", f"smooth: {{table: {{points: {points}}}}}")
    if odd:
        (problem,) = problems_of(text)
        assert odd in problem
    else:
        assert read_fake(text).values["laws"]["smooth"]


def test_a_parameter_with_a_unit_is_checked_where_it_stands_alone():
    """Also one that is given by another; an expression has numbers only."""
    text = VALID.replace("mass: 82.0", "mass: $own, own: 82 %s")
    assert read_fake(text % "kg").values["elements"]["hub"]["mass"] == 82.0
    (problem,) = problems_of(text % "N")
    assert problem.startswith(
        "13:39 body 'hub': 'mass': parameter $mass is 82 N: a mass [kg] is expected, and 'N' is a"
    )
    assert problem.endswith("$mass is given in line 3")
    assert read_fake(text.replace("mass: $mass,", "mass: =1*$mass,") % "N").values["elements"]["hub"]["mass"] == 82.0


def test_other_names_of_the_modulus():
    text = "mecano: 1\ngravity: [0, 0, 0]\nnodes: {a: {position: [0, 0, 0]}, b: {position: [1, 0, 0]}}\n"
    text += "elements: {s: {type: bar, nodes: [a, b], young_modulus: 1 GPa, area: 1 mm2}}\ntime: {end: 1, step: 0.1}\n"
    with pytest.raises(DeckError) as info:
        deck_of_bytes(text.encode(), "deck.yaml")
    assert info.value.problems[0].hint == "here it is called 'E'"


@pytest.mark.parametrize(
    ("unit", "si"),
    [("N*mm", "N m"), ("deg/s", "rad/s"), ("kN/m^1.5", "N/m^1.5"), ("%", "-"), ("kg m²", "kg m2"), ("rpm", "rad/s")],
)
def test_units_of_signals_in_si(unit, si):
    assert written_in_si(unit) == si


@pytest.mark.parametrize(
    ("signal", "field", "wanted"),
    [
        ("{type: switch, input: time, upper: 600 ms, lower: 0.1 s}", "upper", 0.6),
        ("{type: switch, input: hinge.angle, upper: $most}", "upper", math.pi / 6),
        ("{type: pid, input: hinge.angle, proportional: 2, upper: 3 kN m, unit: N m}", "upper", 3e3),
        ("{type: lag, input: hinge.angle, time_constant: 1, initial: 20 deg}", "initial", math.pi / 9),
        ("{type: washout, input: hinge.angle, time_constant: 1, initial_state: 20 deg}", "initial_state", math.pi / 9),
    ],
)
def test_levels_and_limits_of_signals_take_the_unit_of_input_or_value(signal, field, wanted):
    """The input of a switch may be any quantity; its levels are of the same one."""
    text = (INPUTS / "pendulum.yaml").read_text().replace("elements:", f"signals: {{s: {signal}}}\nelements:", 1)
    text = f"parameters: {{most: 30 deg}}\n{text}"
    given = deck_of_bytes(text.encode(), "deck.yaml")
    assert given.values["signals"]["s"][field] == pytest.approx(wanted, rel=1e-14)


def test_letters_that_cannot_be_printed_are_replaced():
    text = VALID.replace("mass: 7e1", "mass: 4.0e\ua6ff")
    assert text != VALID
    messages = problems_of(text)
    assert any("'e?' is not a unit" in message for message in messages) and all(map(str.isprintable, messages))


@pytest.mark.parametrize(
    ("mass", "text"),
    [
        ("$load/$g", ""), ("2*$load/$g", ""), ("$load/9.81", ""), ("$load", "'N' is a force"), ("3*$load", ""),
        ("$load*$g", "it is in m2 kg s-4, where kg is expected"),
        ("$own + $load", "it adds or compares kg and N"), ("$own + 3", ""), ("$own*cos($turn)", ""),
        ("\"max($own, $load)\"", "it adds or compares kg and N"), ("sqrt($own**2 + $own**2)", ""),
        ("$own**2", "it is in kg2, where kg is expected"), ("$half", "it is in N, where kg is expected"),
        ("$load/$half*$own", ""),
    ],
)  # fmt: skip
def test_units_of_expressions(mass, text):
    """A number that is a factor may have any unit; angles are numbers."""
    parameters = 'own: 82 kg, load: 800 N, g: 9.81 m/s2, turn: 30 deg, half: "$load + 0"'
    text_of_deck = VALID.replace("mass: 82.0", f"mass: {mass}, {parameters}")
    if "is a force" in text:
        assert text in problems_of(text_of_deck)[0]
        return
    found = [problem.message for problem in read_fake(text_of_deck).warnings if "expression" in problem.message]
    assert len(found) == bool(text) and all(text in message for message in found), found


def test_units_of_a_chain_of_expressions_are_found_once(monkeypatch):
    """Each parameter occurs twice in the next one: found anew in each place, they would take 2^15 evaluations."""
    evaluated, of_text = [], expression_units._of_text
    monkeypatch.setattr(expression_units, "_of_text", lambda *given: evaluated.append(given) or of_text(*given))
    chain = "".join(f", p{i}: $p{i - 1} + $p{i - 1}" for i in range(1, 16))
    read_fake(VALID.replace("mass: 82.0", f"mass: $p15, p0: 1 kg{chain}"))
    assert 15 <= len(evaluated) < 50


@pytest.mark.parametrize(
    ("text", "value"), [("100 us", 1e-4), ("9 mm", 0.009), ("3 mm3", 3e-9), ("7.85 g/cm3", 7850.0), ("2 kN/mm", 2e6)]
)
def test_powers_of_ten_are_exact(text, value):
    """9 times 1e-3 is 0.009000000000000001, and so are cubes of 1e-3 not those of a millimetre."""
    assert converted(text, ANY) == value


@pytest.mark.parametrize("unit", ["Gm^9 Gm^9 Gm^9 Gm^9", "1/Gm^9/Gm^9/Gm^9/Gm^9"])
def test_units_beyond_the_range_of_numbers_are_refused_or_infinite(unit):
    assert parsed(unit)[0] in (0.0, math.inf)


@pytest.mark.parametrize(
    ("value", "argument", "unit"),
    [("m", "m", "m3"), ("N", "s", "N2 s"), ("m/s2", "s", "m2 s/s4"), ("N m", "s", "N2 m2 s"), ("m3", "s", "m6 s")],
)
def test_the_unit_of_the_density_of_a_random_road(value, argument, unit):
    assert _unit_in_use(DENSITY, value, argument) == unit and parsed(unit)


def test_a_density_in_another_unit_is_refused():
    with pytest.raises(DeckError) as error:
        input_deck("trailing_wheel_bump", "parameters.rough=64e-6 m2")
    assert "a volume [m3] is expected" in error.value.problems[0].message
    assert input_deck("trailing_wheel_bump", "parameters.rough=64 cm3").warnings == ()
