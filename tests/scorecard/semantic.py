"""Line 3: one mistake a deck, of meaning or of spelling: the right line, what would be right, the right suggestion."""

import random
import re
from functools import partial

from scorecard.outcome import INPUTS, in_process, last_line, unfit
from scorecard.trial import Job, Line

LINES = (
    Line(
        3,
        "semantic mistakes and typos of 1-2 letters: the right line, what would be right, the right suggestion",
        7,
        1120,
    ),
)
MISTAKES = 120  # of the trials; the others are typos
WORD = re.compile(r"(?<![\w$.'\"/-])[A-Za-z][A-Za-z0-9_]{3,}(?![\w$.'\"/-])")
KEY = re.compile(r"\s*:(?:\s|$)")
CPU = 6.0
NAMING = (
    "parameters",
    "nodes",
    "elements",
    "joints",
    "loads",
    "laws",
    "grounds",
    "tire_laws",
    "sections",
    "signals",
    "templates",
    "place",
)
GLYPHS = "abcdefghijklmnopqrstuvwxyz_"


def jobs(lines, factor, seed):
    """Mistakes of all families in turn over the decks that can have them; then typos in all words, or in some."""
    rng = random.Random(f"{seed} semantic")
    texts = {
        path.stem: path.read_text() for path in sorted(INPUTS.glob("*.yaml")) if not path.stem.startswith("reflector")
    }
    made = {family: list(family_of(family, texts, rng)) for family in FAMILIES}
    count, families = max(round(factor * MISTAKES), len(FAMILIES)), [f for f in FAMILIES if made[f]]
    for i in range(count):
        family = families[i % len(families)]
        name, text, line, wanted = made[family][i // len(families) % len(made[family])]
        yield Job(3, f"{family[0]} in {name} {i}", partial(mistake, text, line, wanted), cpu=CPU)
    found = list(words(texts))
    rng.shuffle(found)
    for i, (name, place, word) in enumerate(found[: max(round(factor * (LINES[0].count - MISTAKES)), 40)]):
        yield Job(
            3,
            f"typo of {word} in {name} {i}",
            partial(typo, texts[name], place, word, all_words(texts), rng.random()),
            cpu=CPU,
        )


# --- mistakes

UNLIKE = r"warning \S*:\d+:\d+: (the formula .* adds or compares|.* do not agree)"
UNIT = re.compile(r" ?[A-Za-z]")  # behind a number, which is then no number alone

# (name, pattern with the group "old", text in its place, what the message must say of what would be right)
FAMILIES = (
    ("negative mass", r"\bmass: (?P<old>[\d.]+)", "-1", r"positive|greater than (0|zero)|> 0"),
    ("no mass", r"\bmass: (?P<old>[\d.]+)", "0", r"positive|greater than (0|zero)|> 0"),
    ("mass as a pressure", r"\bmass: (?P<old>[\d.]+)", "2 bar", r"a mass \[kg\] is expected"),
    ("length as an angle", r"\bradius: (?P<old>[\d.]+)", "3 deg", r"a length \[m\] is expected"),
    ("unknown unit", r"\bmass: (?P<old>[\d.]+)", "2 furlong", r"unit"),
    ("word for a number", r"\bstep: (?P<old>[\d.e-]+)", "soon", r"a number"),
    ("two coordinates", r"position: (?P<old>\[[^\]]*\])", "[0, 1]", r"a list of 3 numbers"),
    ("four coordinates", r"position: (?P<old>\[[^\]]*\])", "[0, 1, 2, 3]", r"a list of 3 numbers"),
    ("no direction", r"\baxis: (?P<old>\[[^\]]*\])", "[0, 0, 0]", r"zero|not all"),
    ("unknown node", r"\bnode: (?P<old>\w+)", "nobody", r"node"),
    ("unknown node of a pair", r"nodes: \[(?P<old>\w+), \w+\]", "nobody", r"node"),
    ("one node of two", r"nodes: (?P<old>\[\w+, \w+\])", "[ground]", r"2 node|list of 2|one of two"),
    ("a node twice", r"nodes: (?P<old>\[(\w+), \w+\])", "[ground, ground]", r"ground|different|two|same"),
    ("unknown kind", r"type: (?P<old>\w+)", "gadget", r"kind|type|one of|mecano list"),
    ("a joint among elements", r"type: (?P<old>rigid_body)\b", "hinge", r"joints"),
    ("an element among joints", r"type: (?P<old>hinge)\b", "rigid_body", r"elements"),
    ("no step", r"\bstep: (?P<old>[\d.e-]+)", "0", r"positive|greater than (0|zero)|> 0"),
    ("end before the start", r"\bend: (?P<old>[\d.]+)", "-1", r"after|greater|later|positive|start"),
    ("negative stiffness of a beam", r"\bE: (?P<old>[\d.e]+)", "-2e11", r"positive|greater than (0|zero)|> 0"),
    ("negative friction", r"\bfriction: (?P<old>[\d.]+)", "-0.4", r"negative|positive|>= 0|at least 0"),
    ("restitution beyond 1", r"\brestitution: (?P<old>[\d.]+)", "1.5", r"0 (and|to) 1|between 0|at most 1|<= 1"),
    ("unknown parameter", r"\bmass: (?P<old>[\d.]+)", "$nothing", r"parameter"),
    ("expression cut off", r"\bmass: (?P<old>[\d.]+)", "=2 *", r"expression|cannot|end"),
    ("call of what is none", r"\bmass: (?P<old>[\d.]+)", "=cosine(1)", r"cosine|function|sqrt|did you mean"),
    ("a list for a number", r"\bmass: (?P<old>[\d.]+)", "[1, 2]", r"a number"),
    ("a mapping for a list", r"position: (?P<old>\[[^\]]*\])", "{x: 1}", r"a list of 3 numbers"),
    ("infinite", r"\bmass: (?P<old>[\d.]+)", ".inf", r"finite|number"),
    ("comma for a point", r"\bmass: (?P<old>[\d.]+)\b", "'1,5'", r"number|1\.5|point"),
    ("unequal inertia", r"\binertia: (?P<old>\[[^\]]*\])", "[1, 1, 5]", r"sum|triangle|exceed|at most|physical|larger"),
    ("negative inertia", r"\binertia: (?P<old>\[[^\]]*\])", "[1, -1, 1]", r"positive|> 0"),
    ("no method", r"\btime: {(?P<old>)end", "method: euler, ", r"generalized_alpha|one of"),
    ("rho beyond 1", r"\btime: {(?P<old>)end", "rho_inf: 1.5, ", r"0 (and|to) 1|between 0|at most 1|<= 1"),
    ("unknown ground", r"\bground: (?P<old>\w+)", "moon", r"ground"),
    ("unknown law", r"\blaw: (?P<old>\w+)", "nowhere", r"law"),
    ("unknown tyre", r"\btire_law: (?P<old>\w+)", "nothing", r"tire"),
    ("true for a number", r"\bmass: (?P<old>[\d.]+)", "true", r"a number"),
)  # fmt: skip


def family_of(family, texts, rng):
    """(deck, its text with one such mistake, line of the mistake, what must be said), in random order of decks."""
    _, pattern, new, wanted = family
    names = list(texts)
    rng.shuffle(names)
    for name in names:
        text = texts[name]
        spots = [m for m in re.finditer(pattern, text) if not commented(text, m.start("old"))]
        spots = [m for m in spots if not UNIT.match(text, m.end("old"))]
        if spots:
            spot = rng.choice(spots)
            begin, end = spot.span("old")
            yield name, text[:begin] + new + text[end:], text[:begin].count("\n") + 1, wanted


def commented(text, place):
    """Whether a place of a text stands behind a #."""
    return "#" in text[text.rfind("\n", 0, place) + 1 : place]


def mistake(text, line, wanted, folder):
    """A deck with one mistake; a parameter of another unit in a formula is only warned of."""
    outcome = checked(text, folder)
    of_parameter = under("\n".join(text.splitlines()[: line - 1]) + "\n", 1) == "parameters"
    warned = of_parameter and outcome.code == 0 and re.search(UNLIKE, " ".join(outcome.out.split()))
    return "" if warned else judged(outcome, line, wanted)


def checked(text, folder):
    """What `check` says of a text among the inputs."""
    from scorecard.malformed import written

    return in_process(["check", "deck.yaml"], written(text.encode(), folder))


def judged(outcome, line, wanted):
    """Why a mistake is not said as it should be: at its line, with what would be right (a pattern)."""
    if why := unfit(outcome, (0, 2, 4)):
        return why
    if outcome.code != 2:
        return f"exit code {outcome.code}: {last_line(outcome.err or outcome.out)[:80]}"
    places = re.findall(r"^[^\s:][^\n:]*:(\d+):\d+: (.*)$", outcome.err, re.MULTILINE)
    of_parameter = re.compile(rf"\bis given in line {line}\b")  # an error where a parameter is used names its line
    here = [message for number, message in places if int(number) == line or of_parameter.search(message)]
    if not here:
        return f"line {[int(number) for number, _ in places][:3]} instead of {line}"
    return (
        ""
        if any(re.search(wanted, message, re.IGNORECASE) for message in here)
        else f"no word of what would be right: {here[0][:100]}"
    )


# --- typos


def words(texts):
    """(deck, place, word) of each key, type and name that the decks use, once for each word."""
    seen = set()
    for name, text in texts.items():
        for match in WORD.finditer(text):
            if (
                commented(text, match.start())
                or match[0] in seen
                or in_title(text, match.start())
                or labels(text, match.start())
                or text[match.end() : match.end() + 1] == "."
            ):
                continue
            if not KEY.match(text, match.end()) and text[: match.start()].rstrip()[-1:] not in "[,{:":
                continue  # a word of a sentence
            if defines(text, match) or match[0] in ("mecano", "true", "false", "null"):
                continue
            seen.add(match[0])
            yield name, match.start(), match[0]


def in_title(text, place):
    """Whether a place stands in the title."""
    return text[text.rfind("\n", 0, place) + 1 :].startswith("title:")


def labels(text, place):
    """Whether a place is that of a value in a list of copies, which may be any word: repeat: [{name: left}, ...]."""
    line = text[text.rfind("\n", 0, place) + 1 : place]
    return "repeat: [{" in line and line.rstrip().endswith(":")


def defines(text, match):
    """Whether a word is the name of an entry of a section, which may be any word, or a key that no schema has."""
    if not KEY.match(text, match.end()):
        return False
    line = text[text.rfind("\n", 0, match.start()) + 1 : match.start()]
    section = re.findall(r"^(\w+):", text[: match.start()], re.MULTILINE)[-1:]
    entry = line == "  " or (line[:1].strip() and line.count("{") - line.count("}") == 1)
    if entry and section[:1] != [] and section[0] in NAMING:
        return True
    return (not line.strip() and under(text[: match.start()], len(line)) in NAMING) or match[0] not in known()


def under(before, indent):
    """The key under which a line with this indent stands, as in the sections of a template; "" at the top."""
    keys = re.findall(r"^( *)([A-Za-z_]+):", before, re.MULTILINE)
    return next((key for spaces, key in reversed(keys) if len(spaces) < indent), "")


def known():
    """All keys, kinds and terms that decks may have."""
    if not KNOWN:
        from mecano.deck.json_schema import deck_schema

        gather(deck_schema(), KNOWN)
    return KNOWN


KNOWN = set()


def gather(tree, found):
    """Add the names of all properties in a JSON Schema."""
    if isinstance(tree, dict):
        found |= set(tree.get("properties", {}))
        for value in tree.values():
            gather(value, found)
    elif isinstance(tree, list):
        for value in tree:
            gather(value, found)


def all_words(texts):
    """All words of the decks and of the schema: a typo may be none of them."""
    if not ALL:
        ALL.update(known(), *(WORD.findall(text) for text in texts.values()))
    return ALL


ALL = set()


def misspelt(word, rng):
    """A word with one or two letters lost, doubled, swapped or changed."""
    for _ in range(rng.choice((1, 1, 2)) if len(word) > 5 else 1):
        i = rng.randrange(len(word) - 1)
        word = rng.choice((
            word[:i] + word[i + 1 :], word[: i + 1] + word[i:], word[:i] + word[i + 1] + word[i] + word[i + 2 :],
            word[:i] + rng.choice(GLYPHS) + word[i + 1 :],
        ))  # fmt: skip
    return word


def typo(text, place, word, others, seed, folder):
    """A deck with one word misspelt."""
    rng = random.Random(seed)
    wrong = next(
        (w for w in (misspelt(word, rng) for _ in range(100)) if w != word and w not in others and w[:1].isalpha()),
        None,
    )
    if wrong is None:
        return ""
    outcome = checked(text[:place] + wrong + text[place + len(word) :], folder)
    return suggested(outcome, text[:place].count("\n") + 1, word, wrong)


def suggested(outcome, line, word, wrong):
    """Why a misspelt word is not said with the right line and the right suggestion."""
    named = rf"'(\w+_)?{re.escape(word)}'"  # a name in a template has the name of the instance before it
    return judged(outcome, line, named).replace(f"'{wrong}'", "'...'")
