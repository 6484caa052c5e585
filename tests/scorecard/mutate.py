"""Seeded mutations of decks: ``mutate(text, rng)`` returns a deck with one to four things wrong, or merely unusual."""

import re

TOKEN = re.compile(r"[A-Za-z_$][A-Za-z0-9_$-]*|[-+]?[0-9.]+(?:e[-+]?[0-9]+)?|[^\sA-Za-z0-9]")
NUMBER = re.compile(r"[-+]?\b[0-9]+\.?[0-9]*(?:e[-+]?[0-9]+)?\b")
KEY = re.compile(r"[A-Za-z_$][A-Za-z0-9_$()+-]*(?=:(?:\s|$))", re.MULTILINE)
VALUE = re.compile(r"(?<=: )[^\n#,{}\[\]]+|(?<=[\[{,] )[^\n#,{}\[\]:]+")
UNIT = re.compile(r"(?<=[0-9] )[A-Za-z%][A-Za-z0-9/^ ]*(?=[,\]}\n])")
ENTRY = re.compile(r"(?<=: \{)(?=\w+: )")

EXTREMES = [
    "0", "-0.0", "-1", "5e-324", "1e-310", "1e-300", "1e-150", "1e-90", "1e-20", "1e12", "1e90", "-1e99", "1e150",
    "1e308", "1e400", "-1e400", "nan", ".nan", ".inf", "-.inf", "9" * 400, "9007199254740993", "1e-9", "1e9",
]  # fmt: skip
SCALARS = [
    "0x1F", "0o17", "1_000", "1,5", "12:30:45", "2026-01-01", "no", "true", "null", "~", "''", '"x"', '"0"', "1/3",
    "2*3", "ground", "all", "automatic", "step", "é", "\u2028", "\x85", "\ud7ff", "😀", "x" * 3000, "y" * 303,
    "a" * 303 + ".csv", "a" * 303 + ".yaml", "a" * 303 + ".mtx", "z/" * 2000 + "z.npz", "a\0b", "\ufeff", "# x",
]  # fmt: skip
SYNTAX = [
    "[]", "{}", "[1, 2]", "{a: 1}", "[[[]]]", "*a", "&a 1", "&a [*a]", "!x 1",
    "!!python/object/apply:os.system [id]", "!!binary aGk=", "!!set {a, b}",
    "|", ">", "? ", "- ", ": ", "#", "%YAML 1.1", "@", "`", "\t", "\\", '"', "'", "---",
    "...", "<<", "<<: *a", "[" * 300, "{a: " * 80, "- " * 300, "? " * 300,
]  # fmt: skip
EXPRESSIONS = [
    "$", "$$", "-$sink", "$none", "$()", "$(", "$(i", "$i$", "$(k % 0)", "=", "=1/0", "=9**9**9", "=-1**0.5",
    "='a'", "=__import__('os')", "=open('executed', 'w')", "$(open('executed', 'w'))", "=(1).__class__", "$i.real",
    "=lambda: 1", "=[x for x in (1,)]", "={}", "=1 if 1 else 2", "=10**400", "=(((((((1)))))))", "=" + "(" * 80,
    "=" + "-" * 300 + "1", "=" + "1+" * 249 + "1", "=sqrt(-1)", "=atan2(1)", "=f'{1}'", "=1e308*10", "=2**-1074",
    "=1and 2", "=0777", "=1_0", "=1j", "=0xg", "='\\d'", "=1is 1", "=(1)(2)", "=1[0]",
]  # fmt: skip
QUANTITIES = [
    "3 mm", "3 bar", "-1e308 km", "1e400 m", "5 %", "1 N/m s", "2 furlong", "7 m^9", "4 m/s/s/s", "1 °", "3 µm",
    "1 Gm9", "5e-324 mm", "2 m^-9", "1 " + "m " * 40, "1 m" + "/s" * 40, "2 kN/mm", "10 deg", "1 rpm",
]  # fmt: skip
RANGES = [
    "0..", "..5", "0..5..7", "5..0", "0..1e9", "0..$n", "-3..3", "1..400", "{i: 0..2, j: 0..3}", "[{i: 1}, {j: 2}]",
    "{repeat: {i: 0..3}}", "{i: [a, b]}", "{i: 1..99999}", "{i: 0..999, j: 0..999}",
]  # fmt: skip
FILES = [
    "../deck.yaml", "deck.yaml", "/etc/passwd", "/dev/zero", "/dev/stdin", "/proc/self/mem", ".", "..", "",
    "superelement_arm.npz", "[pendulum.yaml, pendulum.yaml]",
]  # fmt: skip
LINES = [
    "include: pendulum.yaml", "include: [four_bar.yaml, slider_crank.yaml]", "include: nowhere.yaml",
    "include: " + "a" * 303, "templates: {t: {}}", "templates: {t: {nodes: {a: {position: [0, 0, 0]}}}}",
    "place: {a: {template: t}}", "place: {b$i: {repeat: {i: 0..3}, template: t}}",
    "    place: {again: {template: t}}", "    parameters: {length: $length}", "parameters: {n: $n}",
    "parameters: {a: $b + 1, b: $c, c: 2}", "    nodes: {$a: {position: [0, 0, 0]}}", "repeat: {i: 1..3}",
    "  x$i: {repeat: {i: 1..9}, position: [$i, $i, $i]}", "gravity: [0, 0, 1e90]", "title: &t [*t]",
    "elements: {}", "nodes: {}", "joints: null", "loads: [1]", "static: {end: 1}", "initial: static",
    "initial: {steady: {velocity: [1, 0, 0]}}", "output: {every: 5e-324}", "time: {end: 1, step: 1e-300}",
    "time: {end: 1e90, step: 1}", "    fixed: true", "  ? [a, b]", "\t", "---", "...", "%TAG ! tag:x,2026:",
]  # fmt: skip
NASTY = [*EXTREMES, *SCALARS, *SYNTAX, *EXPRESSIONS, *QUANTITIES, *RANGES, *FILES]


def mutate(text, rng):
    """Return a deck that differs from ``text`` in one to four places.

    Parameters
    ----------
    text : str
        A deck.
    rng : random.Random
        Equal states give equal decks.
    """
    for _ in range(rng.randint(1, 4)):
        text = rng.choice(MUTATIONS)(rng, text)
    return text


def overrides(text, rng):
    """Return one to three texts ``path=value`` for ``--set``, of keys of the deck ``text`` and of others."""
    keys = KEY.findall(text) or ["a"]
    paths = [".".join(rng.choice([*keys, "0", "2", "x"]) for _ in range(rng.randint(1, 4))) for _ in range(3)]
    return [f"{path}={rng.choice(NASTY)}" for path in paths[: rng.randint(1, 3)]]


def replaced(rng, text, pattern, new):
    """Return the text with one match of a pattern replaced by ``new(match)``."""
    found = [match.span() for match in pattern.finditer(text)]
    begin, end = rng.choice(found or [(0, 0)])
    return text[:begin] + new(text[begin:end]) + text[end:]


def typo(rng, word):
    """Return a word with one letter lost, doubled or changed."""
    i = rng.randrange(len(word)) if word else 0
    return word[:i] + rng.choice(["", word[i : i + 1] * 2, "q", "_", "A"]) + word[i + 1 :]


def on_lines(change):
    """Return the mutation that changes the list of lines at one of them, in place."""

    def mutation(rng, text):
        lines = text.split("\n")
        change(rng, lines, rng.randrange(len(lines)))
        return "\n".join(lines)

    return mutation


def delete(rng, lines, i):
    """Lose a line."""
    del lines[i]


def duplicate(rng, lines, i):
    """Write a line twice, not always in the same place."""
    lines.insert(rng.randrange(len(lines)), lines[i])


def indent(rng, lines, i):
    """Shift a line."""
    lines[i] = rng.choice(["  ", " ", "\t", "      "]) + lines[i] if rng.random() < 0.6 else lines[i].lstrip()


def insert(rng, lines, i):
    """Write a line of the language that may or may not fit."""
    lines.insert(i, rng.choice(LINES))


def from_elsewhere(pattern):
    """Return the mutation that writes one match of a pattern in the place of another."""

    def mutation(rng, text):
        found = [match.span() for match in pattern.finditer(text)]
        begin, end = rng.choice(found or [(0, 0)])
        return replaced(rng, text, pattern, lambda _: text[begin:end])

    return mutation


def one_of(pattern, words):
    """Return the mutation that writes one of some words in the place of a match."""
    return lambda rng, text: replaced(rng, text, pattern, lambda _: rng.choice(words))


def characters(rng, text):
    """Insert characters of any kind, or write them over others."""
    i = rng.randrange(len(text) + 1)
    codes = [rng.choice([rng.randrange(32), rng.randrange(256), rng.randrange(0xD800)]) for _ in range(8)]
    new = "".join(map(chr, codes[: rng.choice([1, 1, 2, 8])]))
    return text[:i] + new + text[i + rng.choice([0, len(new)]) :]


def repeated_entry(rng, text):
    """Give an entry in one line a ``repeat``."""
    return replaced(rng, text, ENTRY, lambda _: f"repeat: {rng.choice(RANGES)}, ")


def anchored(rng, text):
    """Give a value an anchor, and use it in the place of another."""
    text = replaced(rng, text, VALUE, lambda value: f"&a {value}")
    return replaced(rng, text, VALUE, lambda _: "*a")


MUTATIONS = [
    on_lines(delete),
    on_lines(duplicate),
    on_lines(indent),
    on_lines(insert),
    characters,
    repeated_entry,
    anchored,
    from_elsewhere(TOKEN),
    from_elsewhere(KEY),
    from_elsewhere(VALUE),
    one_of(NUMBER, EXTREMES),
    one_of(NUMBER, EXTREMES),
    one_of(NUMBER, QUANTITIES),
    one_of(NUMBER, NASTY),
    one_of(VALUE, NASTY),
    one_of(VALUE, EXPRESSIONS),
    one_of(TOKEN, NASTY),
    one_of(UNIT, ["bar", "mm", "deg", "rpm", "kN/mm", "1e9", "%", "furlong", ""]),
    lambda rng, text: replaced(rng, text, TOKEN, lambda word: typo(rng, word)),
    lambda rng, text: replaced(rng, text, KEY, lambda word: typo(rng, word)),
    lambda rng, text: replaced(rng, text, TOKEN, lambda _: ""),
    lambda rng, text: text[: rng.randrange(len(text) + 1)],
]
