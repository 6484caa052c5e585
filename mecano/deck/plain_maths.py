"""Formulas of the documentation for a terminal: LaTeX -> letters, signs and fractions on one line."""

import re
from functools import partial

LETTERS = {
    "alpha": "α", "beta": "β", "gamma": "γ", "delta": "δ", "epsilon": "ϵ", "varepsilon": "ε", "zeta": "ζ", "eta": "η",
    "theta": "θ", "kappa": "κ", "lambda": "λ", "mu": "μ", "nu": "ν", "xi": "ξ", "pi": "π", "rho": "ρ", "sigma": "σ",
    "tau": "τ", "phi": "φ", "varphi": "φ", "chi": "χ", "psi": "ψ", "omega": "ω", "Gamma": "Γ", "Delta": "Δ",
    "Theta": "Θ", "Lambda": "Λ", "Xi": "Ξ", "Pi": "Π", "Sigma": "Σ", "Phi": "Φ", "Psi": "Ψ", "Omega": "Ω", "ell": "ℓ",
    "partial": "∂", "nabla": "∇", "infty": "∞",
}  # fmt: skip
SIGNS = {
    "cdot": "·", "times": "×", "ge": "≥", "geq": "≥", "le": "≤", "leq": "≤", "ne": "≠", "neq": "≠", "pm": "±",
    "approx": "≈", "in": "∈", "to": "→", "int": "∫", "sum": "Σ", "dots": "...", "ldots": "...", "quad": "  ",
    "qquad": "    ", "left": "", "right": "", "big": "", "Big": "",
}  # fmt: skip
THIN = re.compile(r"\\[,;: ] *")
MARKS = {r"\!": "", r"\|": "‖", r"\{": "{", r"\}": "}"}
RAISED = dict(zip("0123456789+-Tn", "⁰¹²³⁴⁵⁶⁷⁸⁹⁺⁻ᵀⁿ", strict=True))
ABOVE = {"dot": "\u0307", "ddot": "\u0308", "hat": "\u0302", "bar": "\u0304", "tilde": "\u0303"}
INNER = r"\{([^{}]*)\}"
ONE = r"(?:\{([^{}\\]*)\}|([^\W_]))"
MATRIX = re.compile(r"\\begin\{[bp]?matrix\}(.*?)\\end\{[bp]?matrix\}", re.DOTALL)
DISPLAY = re.compile(r"^( *)\.\. math:: *(.*(?:\n(?:\1 +\S.*))*)", re.MULTILINE)
INLINE = re.compile(r":math:`([^`]*)`")


def plain_text(doc: str) -> str:
    """Return documentation with its inline and displayed formulas as plain text."""
    doc = DISPLAY.sub(lambda match: f"{match[1]}    " + _display(match), doc)
    return INLINE.sub(lambda match: plain_maths(match[1]), doc).replace("``", "'")


def _display(match):
    lines = plain_maths(" ".join(line.strip() for line in match[2].splitlines()))
    return re.sub(r" {4,}", f"\n{match[1]}    ", lines.strip())


def plain_maths(tex: str) -> str:
    """Return one LaTeX formula as plain text."""
    tex = THIN.sub(" ", MATRIX.sub(_matrix, tex))
    for sign, plain in MARKS.items():
        tex = tex.replace(sign, plain)
    tex = re.sub(r"\\(?:mathrm|text|mathbf|operatorname)\{([^{}]*)\}", r"\1", tex)
    for name, letter in sorted(LETTERS.items(), key=lambda item: -len(item[0])):
        tex = re.sub(rf"\\{name}(?![A-Za-z])", letter, tex)
    tex = re.sub(r"\^(?:\{([-+0-9Tn]+)\}|([0-9Tn]))", lambda m: "".join(RAISED[c] for c in m[1] or m[2]), tex)
    tex = re.sub(r"_\{([^{}]*)\}", lambda m: f"_{m[1]}" if m[1].isalnum() else f"_({m[1]})", tex)
    for name, mark in ABOVE.items():
        tex = re.sub(rf"\\{name} ?{ONE}", partial(_accented, mark=mark), tex)
    tex = re.sub(rf"\\widehat{INNER}", r"hat(\1)", tex)
    tex = re.sub(r"\\[td]?frac(\d)(\d)", r"\1/\2", tex)
    for _ in range(3):  # inside out
        tex = re.sub(rf"\\[td]?frac{INNER}{INNER}", lambda m: f"{_bracketed(m[1])}/{_bracketed(m[2])}", tex)
        tex = re.sub(rf"\\sqrt{INNER}", r"√(\1)", tex)
    for name, sign in SIGNS.items():
        tex = re.sub(rf"\\{name}(?![A-Za-z])", sign, tex)
    return re.sub(r"\\([A-Za-z]+)", r"\1", tex).replace("{", "").replace("}", "")


def _accented(match, mark):
    letter, *others = match[1] or match[2]
    return letter + mark + "".join(others)


def _matrix(match):
    rows = [" ".join(cell.strip() for cell in row.split("&")) for row in match[1].split(r"\\")]
    return "[" + "; ".join(rows) + "]"


def _bracketed(part):
    return part if re.fullmatch(r"\w[\u0300-\u036f]?(_\w+)?|[0-9]+|\([^()]*\)", part) else f"({part.strip()})"
