"""Quantities with units: "25 mm", "3 bar", "12 deg", "2 kN/mm" -> numbers in SI units, with dimensions checked.

A unit is a product of factors, each with a power, and divided by single ones: "N m", "m/s2", "kg m2", "kN/mm",
"N m/rad", "N/m^1.5". Angles have their own dimension, so that degrees cannot be converted to metres.
"""

import itertools
import math
import re
from collections.abc import Mapping
from functools import lru_cache
from typing import TypeAlias

from mecano.deck.scalar import number

NUMBER = r"[-+]?(?:\.[0-9]+|[0-9]+(?:\.[0-9]*)?)(?:[eE][-+]?[0-9]+)?"
UNIT = r"[A-Za-zµμ°%][^\s,\[\]]*(?: [^\s,\[\]]+)*"
QUANTITY = re.compile(rf"({NUMBER})(?:\s+(?=1/)|\s*(?!1/|[eE][-+]?[0-9]))({UNIT}|1/[^\s,\[\]]+)\s*")
NAME = "[A-Za-zµμ°%]+"
EXPRESSION = r"[$()+]| [-*] "  # arithmetic after a unit
FACTOR = re.compile(r"([A-Za-zµμ°%]+|1)(?:\^?(-?[0-9])|\^(-?[0-9]\.[0-9]{1,3})|([²³]))?")
NO_POWER = r"[A-Za-z]\^?0"  # that nobody means
PREFIXES = {"": 1.0, "G": 1e9, "M": 1e6, "k": 1e3, "d": 1e-1, "c": 1e-2, "m": 1e-3, "u": 1e-6, "µ": 1e-6, "μ": 1e-6,
            "n": 1e-9}  # fmt: skip
Powers: TypeAlias = tuple[float, float, float, float]  # of m, kg, s and rad
LENGTH, MASS, TIME, ANGLE, NONE = (1, 0, 0, 0), (0, 1, 0, 0), (0, 0, 1, 0), (0, 0, 0, 1), (0, 0, 0, 0)
FORCE, PRESSURE, ENERGY, POWER, PER_TIME = (1, 1, -2, 0), (-1, 1, -2, 0), (2, 1, -2, 0), (2, 1, -3, 0), (0, 0, -1, 0)
VOLUME = (3, 0, 0, 0)
PREFIXED = {  # powers of m, kg, s, rad, and the value in SI
    "m": (1.0, LENGTH), "g": (1e-3, MASS), "s": (1.0, TIME), "rad": (1.0, ANGLE), "N": (1.0, FORCE),
    "Pa": (1.0, PRESSURE), "bar": (1e5, PRESSURE), "J": (1.0, ENERGY), "W": (1.0, POWER), "Hz": (1.0, PER_TIME),
}  # fmt: skip
ALONE = {
    "1": (1.0, NONE), "%": (0.01, NONE), "deg": (math.pi / 180, ANGLE), "°": (math.pi / 180, ANGLE),
    "rev": (math.tau, ANGLE), "rpm": (math.tau / 60, (0, 0, -1, 1)), "min": (60.0, TIME), "h": (3600.0, TIME),
    "t": (1e3, MASS), "lb": (0.45359237, MASS), "slug": (14.593902937206364, MASS), "inch": (0.0254, LENGTH),
    "in": (0.0254, LENGTH), "ft": (0.3048, LENGTH), "mi": (1609.344, LENGTH), "kt": (1852 / 3600, (1, 0, -1, 0)),
    "mph": (0.44704, (1, 0, -1, 0)), "lbf": (4.4482216152605, FORCE), "kgf": (9.80665, FORCE),
    "psi": (6894.757293168361, PRESSURE), "atm": (101325.0, PRESSURE), "hp": (745.6998715822702, POWER),
    "l": (1e-3, VOLUME), "ml": (1e-6, VOLUME),
}  # fmt: skip
SI = {
    NONE: "1", LENGTH: "m", MASS: "kg", TIME: "s", ANGLE: "rad", FORCE: "N", PRESSURE: "Pa", ENERGY: "J", POWER: "W",
    VOLUME: "m3", PER_TIME: "Hz", (0, 0, -1, 1): "rad/s", (1, 0, -1, 0): "m/s",
}  # fmt: skip
NAMES = {
    "a number without unit": "1", "a length": "m", "a mass": "kg", "a time": "s", "an angle": "rad", "a force": "N",
    "a pressure": "Pa", "a moment or an energy": "J", "a power": "W", "a frequency": "Hz", "a speed": "m/s",
    "an acceleration": "m/s2", "an angular velocity": "rad/s", "an area": "m2", "a volume": "m3",
    "a density": "kg/m3", "a moment of inertia": "kg m2", "a stiffness": "N/m", "a damping": "N s/m",
    "a torsional stiffness": "N m/rad", "a torsional damping": "N m s/rad", "a mass per length": "kg/m",
    "a bending stiffness": "N m2",
}  # fmt: skip
COMMON = (  # candidates for suggestions
    "mm", "cm", "km", "kg", "ms", "mrad", "kN", "MN", "kPa", "MPa", "GPa", "mbar", "kJ", "kW", "kHz", "km/h", "m/s",
    "m/s2", "rad/s", "deg/s", "N/m", "N/mm", "kN/mm", "kN/m", "N m", "kN m", "kg m2", "kg/m3", "mm2", "cm2", "m2",
)  # fmt: skip
IN_FULL = {  # words -> symbols; the words of symbols with a prefix, such as kilonewton, follow from these
    "metre": "m", "meter": "m", "gram": "g", "gramme": "g", "second": "s", "sec": "s", "radian": "rad", "newton": "N",
    "pascal": "Pa", "joule": "J", "watt": "W", "hertz": "Hz", "degree": "deg", "revolution": "rev", "turn": "rev",
    "minute": "min", "hour": "h", "hr": "h", "tonne": "t", "ton": "t", "pound": "lb", "inche": "in", "foot": "ft",
    "feet": "ft", "mile": "mi", "knot": "kt", "litre": "l", "liter": "l", "percent": "%", "kilo": "kg",
    "kph": "km/h", "kmh": "km/h",
}  # fmt: skip
PREFIXES_IN_FULL = {"giga": "G", "mega": "M", "kilo": "k", "deci": "d", "centi": "c", "milli": "m", "micro": "u",
                    "nano": "n"}  # fmt: skip
HEADS = ("N", "kN", "MN", "kg", "Pa", "W")  # of products that are written without a space, such as Nm
MOST_READINGS = 64
CLOSE = 0.5, 0.7  # likeness of a suggestion to short and longer words
ANY = "unit of its use"
LONGEST = 60  # characters of a unit
ROUNDING = 1e-14  # of the value of a unit


class UnitError(Exception):
    """Error in the unit of a quantity; its text completes "'mass': ..."."""


def is_quantity(text: str) -> bool:
    """Return True if a text is a number followed by a possible unit; a number in quotes is not."""
    return QUANTITY.fullmatch(text) is not None and number(text) is None


def converted(text: str, declared: str) -> float:
    """Return the value of a quantity in SI units, for a field declared with a unit.

    ``declared`` may name several units ("N or N m"); "-" means none; any unit is accepted if it depends on the use
    ("unit of the value"). Raises UnitError.
    """
    number, unit = number_and_unit(text)
    factor = factor_of(unit, declared)
    power = _power_of_ten(factor)
    return float(number) * factor if power >= 0 else float(number) / 10.0**-power  # 100 us are 1e-4 s


def number_and_unit(text: str) -> tuple[str, str]:
    """Return the number and the unit, as written, of a quantity."""
    match = QUANTITY.fullmatch(text)
    assert match is not None, f"{text!r} is not a quantity"
    return match[1], match[2]


def _dimension(unit: str) -> Powers:
    """Return the powers of a valid unit."""
    found = parsed(unit)
    assert found is not None, f"{unit!r} is not a unit"
    return found[1]


def dimension_of(text: str, quantity: bool = False) -> tuple[float, ...] | None:
    """Return the powers of m, kg and s of a unit, or of a ``quantity``; None without a unit. Angles are numbers."""
    if quantity:
        return _powers(text) if is_quantity(text) and parsed(number_and_unit(text)[1]) else None
    found = (1.0, NONE) if text == "-" else parsed(text)
    return None if found is None else found[1][:3]


def unit_of_dimension(powers: tuple[float, ...]) -> str:
    """Return a unit with these powers of m, kg and s as text: kg m/s2."""
    known: dict[tuple[float, ...], str] = {dimension[:3]: unit for dimension, unit in SI.items() if not dimension[3]}
    if powers in known:
        return known[powers]
    parts = [
        f"{name}{power:g}" if power != 1 else name
        for name, power in zip(("m", "kg", "s"), powers, strict=True)
        if power
    ]
    return " ".join(parts)


def alike(first: str, second: str) -> bool:
    """Return True if two quantities (texts) are of one kind, such as 1 m and 2 mm."""
    return _powers(first) == _powers(second)


def _powers(text):
    """Return the powers of length, mass and time of a quantity; radians are numbers."""
    return _dimension(number_and_unit(text)[1])[:3]


def go_together(coefficients: Mapping[int, str]) -> bool:
    """Return True if quantities {power: text} can be the coefficients of one polynomial."""
    powers = {n: _powers(text) for n, text in coefficients.items()}
    for argument in (NONE, LENGTH, TIME, FORCE, (1, 0, -1, 0), PER_TIME):
        values = {tuple(a + n * b for a, b in zip(own, argument, strict=False)) for n, own in powers.items()}
        if len(values) <= 1:
            return True
    return False


def same_dimension(one: str, other: str) -> bool:
    """Return True if two valid quantities have the same dimension."""
    return _dimension(number_and_unit(one)[1]) == _dimension(number_and_unit(other)[1])


def is_in_si(text: str) -> bool:
    """Return True if the unit of a valid quantity is that of SI, such as N m, without a prefix, or a share."""
    found = parsed(number_and_unit(text)[1])
    assert found is not None, f"{text!r} has no unit"
    return found[0] == 1.0 or found[1] == NONE


def si_unit(text: str) -> str:
    """Return the SI unit of a valid quantity in the form closest to the written one: for "40 km/h" it is m/s."""
    unit = re.sub(NAME, lambda match: SI[_simple(match[0])[1]], number_and_unit(text)[1])
    return "" if unit == "1" else unit


def written_in_si(unit: str) -> str:
    """Return the SI unit of a quantity given in ``unit``, as outputs are declared: "N m" of N*mm, "-" of %.

    Raises UnitError.
    """
    _unit(unit)
    plain = unit.translate(str.maketrans("*·²³", "  23"))
    si = " ".join(
        re.sub(NAME, lambda match: SI[_simple(match[0])[1]], re.sub(r"\^(-?[0-9])(?!\.)", r"\1", plain)).split()
    )
    return "-" if si == "1" else si


def factor_of(unit: str, declared: str) -> float:
    """Return the value of a unit in SI units, for a field declared with another; arguments as in ``converted``."""
    if len(unit) > LONGEST:
        raise UnitError(f"'{unit[:40]}...' is not a unit")
    wanted = _declared(declared)
    value, powers = _unit(unit, wanted)
    if wanted is not None and not any(_fits(powers, known) for known in wanted):
        shown = "" if declared == "-" else f" [{declared}]"
        expected = " or ".join(_name(known, declared) for known in wanted)
        raise UnitError(f"{expected}{shown} is expected, and '{unit}' is {_name(powers, unit)}")
    return value


@lru_cache(maxsize=1024)
def parsed(unit: str) -> tuple[float, Powers] | None:
    """Return (value in SI, powers of m, kg, s, rad) of a unit, or None if it is not a unit."""
    product, *divisors = [part.strip() for part in unit.replace("·", " ").replace("*", " ").split("/")]
    factors = [(factor, 1) for factor in product.split()] + [(factor, -1) for factor in divisors]
    value, powers = 1.0, NONE
    if ("1", 1) in factors and product != "1":  # 1/s is a unit, 1 mm a quantity
        return None
    for factor, sign in factors:
        match = FACTOR.fullmatch(factor)
        known = _simple(match[1]) if match else None
        if match is None or known is None:
            return None
        power = sign * (float(match[3]) if match[3] else int(match[2] or {"²": 2, "³": 3}.get(match[4], 1)))
        value *= known[0] ** power
        powers = tuple(a + power * b for a, b in zip(powers, known[1], strict=True))
    exponent = _power_of_ten(value)
    return (float(f"1e{exponent}") if exponent else value, powers) if factors else None


def _power_of_ten(value: float) -> int:
    """Return the exponent of a power of ten, but for its rounding, such as that of (1e-3)^3; 0 for other numbers."""
    if not 0.0 < value < math.inf:
        return 0
    exponent = round(math.log10(value))
    return exponent if abs(value / float(f"1e{exponent}") - 1.0) < ROUNDING and abs(exponent) <= 22 else 0


def _simple(name):
    """Return (value, powers) of a unit without powers, with its prefix; None if there is none."""
    if name in ALONE:
        return ALONE[name]
    for prefix, factor in PREFIXES.items():
        base = name.removeprefix(prefix)
        if name.startswith(prefix) and base in PREFIXED:
            return factor * PREFIXED[base][0], PREFIXED[base][1]
    return None


def _unit(unit, wanted=None):
    found = parsed(unit)
    if found is None and re.search(r"/[^/]* ", unit):
        raise UnitError(f"'{unit[:40]}' can be read in two ways: divide by one unit at a time, as in 'N/m/s'")
    if found is None and re.search(EXPRESSION, unit):
        raise UnitError(
            f"'{unit[:40]}' is not a unit; expressions contain no units: give a parameter the number with its unit"
        )
    if found is None or not math.isfinite(found[0]):
        near = _meant(unit[:40], wanted)
        hint = f"; did you mean '{near}'?" if near else ""
        if exponent := re.fullmatch("[dD]([-+]?[0-9]+)", unit):
            hint = f"; an exponent begins with e: e{exponent[1]}"
        raise UnitError(f"'{unit[:40]}' is not a unit{hint}")
    return found


def _meant(word, wanted=None):
    """Return the unit that is meant by a text, best one of the ``wanted`` dimensions, or ""."""
    text = re.sub(r"(?<=[A-Za-z])-(?=[A-Za-z])", " ", word.replace("**", "^"))
    parts = [[part] if i % 2 else _readings(part) for i, part in enumerate(re.split(r"([ /*·]+)", text))]
    combined = itertools.islice(itertools.product(*parts), MOST_READINGS)
    readings = (unit for unit in map("".join, combined) if not re.search(NO_POWER, unit))
    whole = {unit: found[1] for unit in readings if (found := parsed(unit))}
    near = []
    if len(word) > 1:
        from difflib import get_close_matches  # not needed by decks without mistakes

        near = get_close_matches(word, (*ALONE, *PREFIXED, *COMMON), n=1, cutoff=CLOSE[len(word) > 3])
    fitting = [unit for unit, powers in whole.items() if any(_fits(powers, known) for known in wanted or ())]
    return next(iter([*fitting, *whole, *near]), "")


def _readings(factor):
    """Return the units that a factor may mean: in another case, with spaces, in full, plural; or the factor."""
    if parsed(factor):
        return [factor]
    name = re.sub(r"\^?-?[0-9]\Z", "", factor)
    power = factor.removeprefix(name)
    plain = name.replace(".", "").lower()
    alike = [unit for unit in (*ALONE, *PREFIXED, *COMMON) if unit.replace(" ", "").lower() == plain]
    found = [*alike, _symbol(plain), _symbol(plain.removesuffix("s")), name.removesuffix("s"), *_splits(name)]
    return [unit + power for unit in found if parsed(unit)] or [factor]


def _splits(name):
    """Yield a product that is written without spaces, "Nms", with spaces: "N ms", "N m s"."""
    for head in HEADS:
        if name.startswith(head):
            rest = name.removeprefix(head)
            yield from (f"{head} {rest}", f"{head} {rest[:-1]} {rest[-1:]}")


def _symbol(word):
    """Return the symbol of a unit in full, such as "millimetre", or ""."""
    if word in IN_FULL:
        return IN_FULL[word]
    for prefix, letter in PREFIXES_IN_FULL.items():
        symbol = IN_FULL.get(word.removeprefix(prefix)) if word.startswith(prefix) else None
        if symbol in PREFIXED:
            return letter + symbol
    return ""


@lru_cache(maxsize=1024)
def _declared(text):
    """Return the powers allowed by a declared unit, or None if any unit is allowed."""
    if "unit" in text:
        return None
    if text == "-":
        return (NONE,)
    parts = [parsed(part.strip()) for part in re.split(r" or |,", text)]
    known = [part[1] for part in parts if part]
    return tuple(dict.fromkeys(known)) if len(known) == len(parts) else None


def _fits(powers, wanted):
    """Return True if dimensions agree; radians may be omitted in moments and stiffnesses, not in rates (Hz, rad/s)."""
    return powers == wanted or (powers[:3] == wanted[:3] and powers[1] != 0 and powers[3] == 0)


def _name(powers, unit):
    for name, known in NAMES.items():
        if _dimension(known) == powers:
            return name
    return "of another dimension" if unit != "-" else "a number"


@lru_cache(maxsize=1024)
def unit_of(declared: str, i: int, count: int) -> str:
    """Return the unit of item i of ``count``: of "m, m2" each of two has its own, otherwise all have the same."""
    units = declared.split(", ")
    return units[i] if len(units) == count else declared
