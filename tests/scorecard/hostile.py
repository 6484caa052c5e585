"""Line 2: decks that are to harm: nothing is executed, little time and memory are taken, and the place is said."""

import io
import os
import pickle
import random
import zipfile
from functools import partial

import numpy as np
from scorecard.outcome import INPUTS, in_command, unfit, unplaced
from scorecard.trial import Job, Line

LINES = (Line(2, "hostile decks and files: nothing executed, at most 5 s and 300 MB, a place in the message", 8, 325),)
EXPRESSIONS = 200  # of 325
MEMORY = 300.0  # MB
CANARY = "executed"
HEAD = "mecano: 1\ngravity: [0, 0, 0]\n"
REST = "elements: {m: {type: point_mass, node: a, mass: 1}}\ntime: {end: 1e-2, step: 1e-3}\n"
PLAIN = HEAD + "nodes: {a: {position: [0, 0, 0]}}\n" + REST
FORCE = (
    HEAD
    + "nodes: {{a: {{position: [0, 0, 0]}}}}\n"
    + REST.replace("{", "{{").replace("}", "}}")
    + ("loads: {{f: {{type: force, node: a, direction: [1, 0, 0], value: {value}}}}}\n")
)
ENTRIES = np.load(INPUTS / "superelement_arm.npz").files
PART = (INPUTS / "superelement_arm.yaml").read_text()
CODE = (
    "__import__('os').system('touch executed')", "open('executed', 'w')", "exec('import os')", "eval('1')",
    "().__class__",
    "(1).__class__.__bases__[0].__subclasses__()", "[].append(1)", "lambda: open('executed', 'w')",
    "f'{open(\"executed\")}'",
    "[open('executed', 'w') for x in (1,)]", "globals()", "locals()['x']", "getattr(1, 'real')", "vars()",
    "breakpoint()",
    "print(1)", "input()", "exit()", "quit()", "compile('1', '', 'eval')", "__builtins__", "sqrt.__globals__",
    "sqrt.__self__",
    "max.__call__(1)", "'a' * 10**9", "[0] * 10**9", "(0,) * 10**9", "9**9**9", "9**9**9**9", "10**(10**10)",
    "2**2**40",
    "1 << 10**9", "10**400", "-10**400", "1e308 * 10", "(" * 5000 + "1" + ")" * 5000, "-" * 50000 + "1",
    "1+" * 50000 + "1",
    "1 if open('executed') else 2", "x := 1", "yield 1", "await x", "*a", "**a", "{}", "{1: 2}", "{1}", "'1'",
    "b'1'", "...",
    "None", "True", "1 and 2", "not 1", "1 == 1", "1 < 2 < 3", "1 @ 1", "1 // 0", "1 % 0", "0 ** -1", "sqrt(-1)",
    "log(0)",
    "atan2(1)", "max()", "min(*[1])", "sqrt(x=1)", "import os", "1; 2", "1\\n2", "\\x00", "1j", "0x", "0o9", "1__0",
    "\u200b1",
    "\uff11", "\u0661", "ａｂｓ(1)", "hypot(1e308, 1e308)", "exp(1e9)", "a" * 100000, "$" * 1000, "$" + "a" * 100000,
)  # fmt: skip


def jobs(lines, factor, seed):
    """Attacks by expressions in random places, and one of each other sort, repeated with other sizes."""
    rng = random.Random(f"{seed} hostile")
    for i in range(max(round(factor * EXPRESSIONS), 10)):
        code = CODE[i % len(CODE)] if factor >= 1 else rng.choice(CODE)
        yield Job(2, f"expression {i}", partial(expression, code, rng.choice(list(PLACES))), wall=200.0)
    count = max(round(factor * (LINES[0].count - EXPRESSIONS)), 12)
    attacks = list(ATTACKS)
    if count < len(attacks):
        rng.shuffle(attacks)
    for i in range(count):
        attack = attacks[i % len(attacks)]
        yield Job(2, f"{attack.__name__} {i}", partial(made, attack, i // len(attacks), rng.random()), wall=200.0)


PLACES = {
    "parameter": lambda code: PLAIN + f"parameters: {{p: {quoted('=' + code)}}}\n",
    "field": lambda code: PLAIN.replace("mass: 1", f"mass: {quoted('=' + code)}"),
    "vector": lambda code: PLAIN.replace("[0, 0, 0]}}", f"[0, {quoted('=' + code)}, 0]}}}}"),
    "name": lambda code: PLAIN + f"laws: {{{quoted('l$(' + code + ')')}: {{repeat: {{i: 1..2}}, constant: 1}}}}\n",
    "range": lambda code: PLAIN + f"laws: {{l$i: {{repeat: {{i: {quoted('0..$(' + code + ')')}}}, constant: 1}}}}\n",
    "set": lambda code: PLAIN,
}


def quoted(text):
    """A text as YAML between single quotes."""
    return "'" + text.replace("'", "''") + "'"


def expression(code, where, folder):
    """An expression in some place of a deck."""
    (folder / "deck.yaml").write_text(PLACES[where](code))
    words = ["--set", f"elements.m.mass=={code}"[:120_000]] if where == "set" else []
    return judged(in_command(["check", "deck.yaml", *words], folder, timeout=60.0), folder, harmless=True)


def made(attack, size, place, folder):
    """An attack that makes files and returns the deck, None where it has written it, with True where it may be read."""
    harmless = False
    data = attack(folder, size, random.Random(place))
    if isinstance(data, tuple):
        data, harmless = data
    if data is not None:
        (folder / "deck.yaml").write_bytes(data if isinstance(data, bytes) else data.encode())
    outcome = in_command(["check", "deck.yaml"], folder, timeout=60.0)
    why = judged(outcome, folder, harmless)
    for path in folder.iterdir():
        if path.is_fifo() or (path.is_file() and path.stat().st_size > 1e7):
            path.unlink()
    return why


def judged(outcome, folder, harmless=False):
    """Why an attack has succeeded; a ``harmless`` one may be read."""
    if any(path.name == CANARY for path in folder.rglob("*")):
        return "something was executed"
    if outcome.code == -9:
        return "no end within a minute"
    if why := unfit(outcome, (0, 2, 4)):
        return why
    if outcome.memory > MEMORY:
        return f"{outcome.memory:.0f} MB"
    if outcome.code == 0:
        return "" if harmless else "the deck was read"
    return unplaced(outcome) if outcome.code == 2 else ""


# --- attacks: (folder, number of the repetition, rng) -> the deck, or (the deck, it may be read)


def alias_bomb(folder, size, rng):
    rows = [f"a0: &a0 [{', '.join(['x'] * 9)}]"]
    rows += [f"a{i}: &a{i} [{', '.join([f'*a{i - 1}'] * 9)}]" for i in range(1, 9 + 3 * size)]
    return PLAIN + "title:\n" + "".join(f"  {row}\n" for row in rows)


def mapping_bomb(folder, size, rng):
    rows = ["a0: &a0 {x: 1}"]
    rows += [f"a{i}: &a{i} {{{', '.join(f'k{k}: *a{i - 1}' for k in range(9))}}}" for i in range(1, 9 + 3 * size)]
    return PLAIN + "parameters:\n" + "".join(f"  {row}\n" for row in rows)


def merge_bomb(folder, size, rng):
    rows = ["a0: &a0 {x: 1}"]
    rows += [f"a{i}: &a{i} {{<<: [{', '.join([f'*a{i - 1}'] * 9)}]}}" for i in range(1, 9 + 3 * size)]
    return PLAIN + "laws:\n" + "".join(f"  {row}\n" for row in rows)


def own_alias(folder, size, rng):
    return PLAIN + ("title: &a [*a]\n", "laws: &l {x: *l}\n", "parameters: &p {<<: *p}\n")[size % 3]


def depth_of_lists(folder, size, rng):
    return PLAIN + "title: " + "[" * 10 ** (4 + size % 3)


def depth_of_mappings(folder, size, rng):
    return PLAIN + "title: " + "{a: " * 10 ** (4 + size % 3)


def depth_of_blocks(folder, size, rng):
    return PLAIN + "title:\n" + "".join(" " * i + "-\n" for i in range(1, 2000 + 1000 * size))


def depth_in_a_line(folder, size, rng):
    return PLAIN + "title:\n  " + "- " * 10 ** (4 + size % 2) + "1\n"


def tag(folder, size, rng):
    tags = ("!!python/object/apply:os.system ['touch executed']", "!!python/object/new:os.system ['touch executed']",
            "!!python/name:os.system", "!!python/module:os", "!!python/tuple [1]", "!!timestamp 2001-01-01",
            "!!binary aGk=",
            "!!set {a}", "!own x", "!!omap [a: 1]",
            "!!python/object/apply:builtins.exec ['open(\"executed\", \"w\")']")  # fmt: skip
    return (PLAIN + f"title: {tags[size % len(tags)]}\n", "binary" in tags[size % len(tags)])


def long_scalar(folder, size, rng):
    text = "x" * 10**8
    return PLAIN + (f"title: {text}\n", f'title: "{text}"\n', f"title: |\n  {text}\n", f"{text}: 1\n", f"# {text}\n",
                    f"parameters: {{a: ={'1' * 10**8}}}\n")[size % 6]  # fmt: skip


def long_number(folder, size, rng):
    return PLAIN.replace("mass: 1", "mass: " + ("9" * 10**6, "1e" + "9" * 10**6, "0." + "0" * 10**6 + "1")[size % 3])


def nul(folder, size, rng):
    at = rng.randrange(len(PLAIN))
    return PLAIN[:at].encode() + b"\0" + PLAIN[at:].encode()


def byte_order_mark(folder, size, rng):
    return (("\ufeff" + PLAIN).encode(("utf-8", "utf-16-le", "utf-16-be", "utf-32-le")[size % 4]), True)


def wrong_bytes(folder, size, rng):
    at = rng.randrange(len(PLAIN))
    return (
        PLAIN[:at].encode()
        + (b"\xff", b"\xed\xa0\x80", b"\xc0\xaf", b"\xf5\x80\x80\x80")[size % 4]
        + PLAIN[at:].encode()
    )


def outside(folder, size, rng):
    secret = folder.parent / "secret.yaml"
    secret.write_text("title: secret\n")
    return PLAIN + f"include: {('../secret.yaml', str(secret), '/etc/hostname', './../secret.yaml')[size % 4]}\n"


def table_outside(folder, size, rng):
    (folder.parent / "secret.csv").write_text("0,0\n1,1\n")
    return FORCE.format(
        value=f"{{table: {{file: {('../secret.csv', '/etc/passwd', '/proc/self/environ')[size % 3]}}}}}"
    )


def link_outside(folder, size, rng):
    (folder.parent / "secret.yaml").write_text("title: secret\n")
    (folder / "inside.yaml").symlink_to(folder.parent / "secret.yaml")
    return PLAIN + "include: inside.yaml\n"


def linked_folder(folder, size, rng):
    (folder / "parts").symlink_to("/etc")
    return PLAIN + "include: parts/hostname\n"


def circle_of_links(folder, size, rng):
    (folder / "a.yaml").symlink_to("b.yaml")
    (folder / "b.yaml").symlink_to("a.yaml")
    return PLAIN + "include: a.yaml\n"


def device(folder, size, rng):
    name = ("/dev/zero", "/dev/random", "/dev/stdin", "/dev/tty")[size % 4]
    (folder / "dev.yaml").symlink_to(name)
    return PLAIN + f"include: {('dev.yaml', name)[size // 4 % 2]}\n"


def device_as_deck(folder, size, rng):
    (folder / "deck.yaml").symlink_to(("/dev/zero", "/dev/random", "/proc/self/mem", "/dev/null")[size % 4])


def fifo_as_deck(folder, size, rng):
    os.mkfifo(folder / "deck.yaml")


def fifo(folder, size, rng):
    os.mkfifo(folder / "pipe.csv")
    if size % 2:
        return PLAIN + "include: pipe.csv\n"
    return FORCE.format(value="{table: {file: pipe.csv}}")


def fifo_of_a_part(folder, size, rng):
    os.mkfifo(folder / "superelement_arm.npz")
    return PART


def folder_as_file(folder, size, rng):
    (folder / "parts.csv").mkdir()
    return (PLAIN + "include: parts.csv\n", FORCE.format(value="{table: {file: parts.csv}}"))[size % 2]


def circle_of_includes(folder, size, rng):
    (folder / "b.yaml").write_text(f"include: {('b.yaml', 'deck.yaml')[size % 2]}\n")
    return PLAIN + "include: b.yaml\n"


def tree_of_includes(folder, size, rng):
    for i in range(40):
        (folder / f"i{i}.yaml").write_text(f"include: [i{i + 1}.yaml, j{i + 1}.yaml]\n")
        (folder / f"j{i}.yaml").write_text(f"include: [i{i + 1}.yaml, j{i + 1}.yaml]\n")
    return PLAIN + "include: i0.yaml\n"


def circle_of_parameters(folder, size, rng):
    count = (1, 2, 1000)[size % 3]
    return PLAIN + "parameters:\n" + "".join(f"  p{i}: $p{(i + 1) % count} + 1\n" for i in range(count))


def chain_of_parameters(folder, size, rng):
    return (
        PLAIN + "parameters:\n  p0: 1\n" + "".join(f"  p{i}: $p{i - 1} * $p{i - 1}\n" for i in range(1, 5000)),
        True,
    )


def many_repeats(folder, size, rng):
    what = ("{i: 1..1000000000}", "{i: 1..9999, j: 1..9999}", "{i: 1..99, j: 1..99, k: 1..99, l: 1..99}")[size % 3]
    name = ("p$i", "p$(i)_$j", "p$(i)_$(j)_$(k)_$l")[size % 3]
    return PLAIN.replace("nodes: {", f"nodes: {{{name}: {{repeat: {what}, position: [0, 0, $i]}}, ")


def templates_of_templates(folder, size, rng):
    text = "templates:\n  t0: {nodes: {n: {position: [0, 0, 0]}}}\n"
    text += "".join(f"  t{i}: {{place: {{x$k: {{repeat: {{k: 1..10}}, template: t{i - 1}}}}}}}\n" for i in range(1, 12))
    return PLAIN + text + "place: {all: {template: t11}}\n"


def template_of_itself(folder, size, rng):
    return PLAIN + "templates: {t: {place: {again: {template: t}}}}\nplace: {a: {template: t}}\n"


def pickled(folder, size, rng):
    class Touch:
        def __reduce__(self):
            return os.system, ("touch executed",)

    path = folder / "superelement_arm.npz"
    if size % 2:
        path.write_bytes(pickle.dumps(Touch()))
    else:
        np.savez(path, mass=np.array([Touch()], dtype=object), allow_pickle=True)
    return PART


def zip_bomb(folder, size, rng):
    with zipfile.ZipFile(folder / "superelement_arm.npz", "w", zipfile.ZIP_DEFLATED) as file:
        for name in ENTRIES:
            head = io.BytesIO()
            np.lib.format.write_array_header_1_0(head, {"descr": "<f8", "fortran_order": False, "shape": (10**7 * 4,)})
            with file.open(f"{name}.npy", "w") as part:
                part.write(head.getvalue())
                for _ in range(320):
                    part.write(bytes(10**6))
    return PART


def array_bomb(folder, size, rng):
    with zipfile.ZipFile(folder / "superelement_arm.npz", "w") as file:
        for name in ENTRIES:
            head = io.BytesIO()
            np.lib.format.write_array_header_1_0(
                head, {"descr": "<f8", "fortran_order": False, "shape": (10**6, 10**6)}
            )
            file.writestr(f"{name}.npy", head.getvalue())
    return PART


def broken_part(folder, size, rng):
    data = bytearray((INPUTS / "superelement_arm.npz").read_bytes())
    for _ in range(20):
        data[rng.randrange(len(data))] = rng.randrange(256)
    (folder / "superelement_arm.npz").write_bytes(data[: rng.randrange(len(data))] if size % 2 else data)
    return PART, True


def matrix_bomb(folder, size, rng):
    head = "%%MatrixMarket matrix coordinate real symmetric\n"
    (folder / "k.mtx").write_text(head + ("1000000000 1000000000 1\n1 1 1\n", "6 6 1000000000\n1 1 1\n")[size % 2])
    return PART.replace("superelement_arm.npz", "k.mtx")


def rows(folder, size, rng):
    with open(folder / "t.csv", "w") as file:
        file.write("t [s], F [N]\n")
        file.writelines(f"{i},{i % 7}\n" for i in range(10**6))
        file.write("" if size % 2 else "2,nan\n")
    return FORCE.format(value="{table: {file: t.csv}}"), True


def columns(folder, size, rng):
    (folder / "t.csv").write_text("\n".join(",".join(["1"] * 10**6) for _ in range(1 + size % 3)) + "\n")
    return FORCE.format(value="{table: {file: t.csv}}")


def long_row(folder, size, rng):
    (folder / "t.csv").write_text(("x" * 10**8, '"' + "\n" * 10**7)[size % 2])
    return FORCE.format(value="{table: {file: t.csv}}")


def many_entries(folder, size, rng):
    return HEAD + "nodes:\n" + "".join(f"  n{i}: {{position: [0, 0, 0]}}\n" for i in range(10**6)) + REST


def many_errors(folder, size, rng):
    return PLAIN + "laws:\n" + "".join(f"  l{i}: {{sprong: {i}}}\n" for i in range(20_000))


ATTACKS = (
    alias_bomb, mapping_bomb, merge_bomb, own_alias, depth_of_lists, depth_of_mappings, depth_of_blocks,
    depth_in_a_line, tag,
    long_scalar, long_number, nul, byte_order_mark, wrong_bytes, outside, table_outside, link_outside, linked_folder,
    circle_of_links, device, device_as_deck, fifo_as_deck, fifo, fifo_of_a_part, folder_as_file, circle_of_includes,
    tree_of_includes, circle_of_parameters, chain_of_parameters, many_repeats, templates_of_templates,
    template_of_itself,
    pickled, zip_bomb, array_bomb, broken_part, matrix_bomb, rows, columns, long_row, many_entries, many_errors,
)  # fmt: skip
