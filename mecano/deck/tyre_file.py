"""Read .tir files of tyres: keys and numbers in sections, converted from the units of the file to SI units."""

import math
import re
from itertools import pairwise

from mecano.deck.compose import Node
from mecano.deck.named_file import source_of
from mecano.deck.scalar import number
from mecano.deck.scope import Scope
from mecano.deck.wording import quoted
from mecano.elements.wheels.magic_formula import KNOWN

LINE = re.compile(r"\s*([A-Za-z_][A-Za-z0-9_]*)\s*=\s*('[^']*'|\"[^\"]*\"|[^\s$!]+)")
UNITS = {  # key of the section [UNITS]: {word: its size in SI units}
    "LENGTH": {"meter": 1.0, "m": 1.0, "mm": 1e-3, "millimeter": 1e-3, "cm": 1e-2, "inch": 0.0254, "foot": 0.3048},
    "FORCE": {"newton": 1.0, "n": 1.0, "kn": 1e3, "kilonewton": 1e3, "pound_force": 4.4482216152605},
    "ANGLE": {"radian": 1.0, "radians": 1.0, "rad": 1.0, "degree": math.pi / 180.0, "degrees": math.pi / 180.0,
              "deg": math.pi / 180.0},
    "MASS": {"kg": 1.0, "kilogram": 1.0, "gram": 1e-3, "pound_mass": 0.45359237},
    "TIME": {"second": 1.0, "sec": 1.0, "s": 1.0, "millisecond": 1e-3},
}  # fmt: skip
POWERS = {  # of length, force, angle, time in the unit of a key; numbers without one are ratios
    "UNLOADED_RADIUS": (1, 0, 0, 0), "FNOMIN": (0, 1, 0, 0), "FZMIN": (0, 1, 0, 0), "FZMAX": (0, 1, 0, 0),
    **dict.fromkeys(("NOMPRES", "INFLPRES", "PRESMIN", "PRESMAX"), (-2, 1, 0, 0)),
    **dict.fromkeys(("LONGVL", "VXLOW"), (1, 0, 0, -1)), "VERTICAL_DAMPING": (-1, 1, 0, 1),
    "YAW_STIFFNESS": (1, 1, -1, 0),
    **dict.fromkeys(("VERTICAL_STIFFNESS", "LONGITUDINAL_STIFFNESS", "LATERAL_STIFFNESS"), (-1, 1, 0, 0)),
    **dict.fromkeys(("ALPMIN", "ALPMAX", "CAMMIN", "CAMMAX"), (0, 0, 1, 0)),
}  # fmt: skip
CURVE = "[DEFLECTION_LOAD_CURVE]"
VERSIONS = {5: 5.2, 6: 5.2, 21: 5.2, 60: 6.1, 61: 6.1, 62: 6.2}  # of the numbers FITTYP
OF_MOTORCYCLES = "PCY2"  # a coefficient that other formulas do not have
MOTORCYCLE = re.compile(r"MC([_-]?TYRE)?$")  # ends the format of such files
FORMATS = {"PAC2002": 5.2, "MF_05": 5.2, "MF-TYRE": None}


def read_tyre(name: str, node: Node, scope: Scope) -> tuple[dict[str, float], list[list[float]]] | None:
    """Return what the Magic Formula uses of a file named in the deck at ``node``.

    That is its coefficients, and the points (deflection [m], load [N]) of its section [DEFLECTION_LOAD_CURVE], empty
    without one. Return None, with errors noted, if it cannot be read, is for another formula or contains an invalid
    number.
    """
    source = source_of(name, node, scope)
    if source is None:
        return None
    reading = _Reading(source, node, name, scope)
    found = reading.coefficients()
    return None if found is None else (found, reading.curve)


class _Reading:
    """Reader of one file."""

    def __init__(self, source, node, name, scope):
        self.source, self.node, self.name, self.scope = source, node, name, scope
        self.texts, self.sizes, self.curve = {}, dict.fromkeys(UNITS, 1.0), []

    def coefficients(self):
        """Return {name: number in SI units} of the coefficients that the formula uses."""
        before = len(self.scope.problems)
        self._read()
        if len(self.curve) == 1 or any(a[0] >= b[0] for a, b in pairwise(self.curve)):
            self._refuse(f"has {CURVE} with {len(self.curve)} point(s): two are needed, in ascending order")
        version = self._version()
        if len(self.scope.problems) > before or version is None:
            return None
        found = {key: self._number(key, text) for key, text in self.texts.items() if key in KNOWN}
        if len(self.scope.problems) > before:
            return None
        if not found:
            return self._refuse("has no line such as 'FNOMIN = 4000': is it a .tir file?")
        found.pop("FITTYP", None)
        return {**found, "VERSION": version}

    def _read(self):
        section = ""
        for line in self.source.each_line():
            text = line.strip()
            if text.startswith("["):
                section = text.strip("[]").split("]")[0].upper()
            match = LINE.match(line) if not text.startswith(("$", "!")) else None
            if match:
                key, value = match[1].upper(), match[2].strip("'\"").strip()
                if key in KNOWN and self.texts.get(key, value) != value:
                    self._refuse(f"has {key} twice: {self.texts[key]} and {value}")
                self.texts[key] = value
                if section == "UNITS" and key in UNITS:
                    self._unit(key, value)
            elif section == CURVE.strip("[]") and text[:1].lstrip("-.").isdigit():
                self._point(text)

    def _point(self, text):
        words = re.split(r"[$!]", text)[0].replace(",", " ").split()
        numbers = [float(found) for word in words if (found := number(word)) is not None and math.isfinite(found)]
        if len(words) != 2 or len(numbers) != 2:
            self._refuse(f"has {quoted(text)} in {CURVE}, which is not a deflection and a load")
            return
        self.curve.append([numbers[0] * self.sizes["LENGTH"], numbers[1] * self.sizes["FORCE"]])

    def _unit(self, key, word):
        known = UNITS[key]
        if word.lower() in known:
            self.sizes[key] = known[word.lower()]
        else:
            self._refuse(f"has the unit {key} = {quoted(word)}; known: {', '.join(known)}")

    def _version(self):
        kind = number(self.texts.get("FITTYP", ""))
        named = self.texts.get("PROPERTY_FILE_FORMAT", "").upper()
        if OF_MOTORCYCLES in self.texts or MOTORCYCLE.search(named):
            return self._refuse(
                "is for the Magic Formula of motorcycles (PAC_MC, MF-MCTyre), whose camber thrust has a shape factor "
                f"{OF_MOTORCYCLES}; supported: 5.2, 6.1 and 6.2, for motorcycles with 'crown_radius' in the "
                "tyre law; or 'fiala' with its 'camber_stiffness'"
            )
        if kind is not None and int(kind) in VERSIONS:
            return VERSIONS[int(kind)]
        if kind is None and FORMATS.get(named) is not None:
            return FORMATS[named]
        what = (
            f"FITTYP = {self.texts['FITTYP']}" if kind is not None else f"no FITTYP, format {quoted(named or 'none')}"
        )
        return self._refuse(f"has {what}; supported: 6, 21 (Magic Formula 5.2, PAC2002), 60, 61 (6.1) and 62 (6.2)")

    def _number(self, key, text):
        found = number(text)
        if found is None or not math.isfinite(found):
            self._refuse(f"has {key} = {quoted(text)}, which is not a number")
            return 0.0
        length, force, angle, time = POWERS.get(key, (0, 0, 0, 0))
        s = self.sizes
        return float(found) * s["LENGTH"] ** length * s["FORCE"] ** force * s["ANGLE"] ** angle * s["TIME"] ** time

    def _refuse(self, text):
        self.scope.refuse(self.node, f"file {quoted(self.name)} {text}")
