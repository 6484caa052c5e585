"""Units of products and powers of quantities in SI units: N times m/s is W, m/s divided by s is m/s2.

Radians are numbers: an angular velocity times a length is a speed in m/s. They remain in angles and their rates, and in
denominators, as in N m/rad.
"""

import re

FACTOR = r"([A-Za-z]+)(-?[0-9]+)?"
MADE_OF = {"Pa": {"N": 1.0, "m": -2.0}, "J": {"N": 1.0, "m": 1.0}, "W": {"N": 1.0, "m": 1.0, "s": -1.0},
           "Hz": {"s": -1.0}}  # fmt: skip
NAMES = {"N m/s": "W", "N/m2": "Pa"}
WORK = {"W", "s"}  # units of a product that is an energy, not a moment
NUMBER = "-"  # unit of a number
ORDER = ("kg", "N", "m", "rad", "s")


def product_unit(*factors: tuple[str, float]) -> str:
    """Return the unit of a product of ``factors`` (SI unit, power); "" if it is unknown, as for a root of a length."""
    powers = dict.fromkeys(ORDER, 0.0)
    for unit, power in factors:
        own = _powers(unit)
        if own is None:
            return ""
        for symbol, one in own.items():
            powers[symbol] += power * one
    if powers["rad"] > 0.0 and any(powers[symbol] for symbol in ("kg", "N", "m")):
        powers["rad"] = 0.0
    if len(factors) == 2 and set(factors) == {(unit, 1.0) for unit in WORK}:
        return "J"
    return _text(powers) if all(power.is_integer() for power in powers.values()) else ""


def _powers(unit):
    """Return {symbol: power} of a unit, such as "N m s/rad", or None if it has others than those of ``ORDER``."""
    product, *divisors = unit.split("/")
    found: dict[str, float] = {}
    for factor, sign in [*((factor, 1.0) for factor in product.split()), *((factor, -1.0) for factor in divisors)]:
        if factor in (NUMBER, "1"):
            continue
        match = re.fullmatch(FACTOR, factor)
        made_of = MADE_OF.get(match[1], {match[1]: 1.0}) if match else {}
        if match is None or not made_of.keys() <= set(ORDER):
            return None
        for symbol, one in made_of.items():
            found[symbol] = found.get(symbol, 0.0) + sign * one * float(match[2] or 1)
    return found


def _text(powers):
    """Return the unit with these powers {symbol: whole number}: kg m/s2."""
    above = [_factor(symbol, power) for symbol, power in powers.items() if power > 0.0]
    below = [_factor(symbol, -power) for symbol, power in powers.items() if power < 0.0]
    unit = "/".join([" ".join(above) or "1", *below]) if above or below else NUMBER
    return NAMES.get(unit, unit)


def _factor(symbol, power):
    return symbol if power == 1.0 else f"{symbol}{power:.0f}"
