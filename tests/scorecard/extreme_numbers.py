"""Line 7: numbers that nobody means in all places of decks that take one, and NaN in the records of elements."""

import math
import random
import re
from functools import partial

import numpy as np
from scorecard.killed import held
from scorecard.outcome import INPUTS, in_process, unfit, unplaced
from scorecard.trial import Job, Line

LINES = (
    Line(
        7,
        "NaN, inf, 1e308, denormals, 0, 1e12 steps in decks; NaN in elements: refused by place, or named, file valid",
        6,
        700,
    ),
)
INJECTED = 500  # of 700: NaN in an element
EXTREMES = (".nan", ".inf", "-.inf", "1e308", "-1e308", "5e-324", "1e-310", "0", "1e400")
NUMBER = re.compile(r"(?<![\w.$'\"-])[-+]?\d+\.?\d*(?:[eE][-+]?\d+)?(?![\w.])")
TINY_END = ("time.end=0.02",)
DECKS = (
    "pendulum", "four_bar", "nose_gear_rigid", "wheel_drop", "cable_snatch", "friction_pendulum", "bouncing_ball",
    "strut",
    "winder", "hoist", "slider_crank", "bushing", "flexible_pendulum", "thruster", "rolling_disc", "deployment_lock",
)  # fmt: skip
NAMED = re.compile(r"\b[a-z_]+ '[^']+'|\bnode '?[\w.$-]+'?")
TIME = re.compile(r"t = [-+.\de]+ s")
CPU = 20.0  # s


def jobs(lines, factor, seed):
    """Decks with one number made extreme, and runs into which NaN is injected."""
    rng = random.Random(f"{seed} numbers")
    for i in range(max(round(factor * (LINES[0].count - INJECTED)), len(EXTREMES) + 1)):
        name = DECKS[i % len(DECKS)]
        what = (*EXTREMES, "steps")[i % (len(EXTREMES) + 1)]
        yield Job(7, f"{name} {what} {i}", partial(in_deck, name, what, rng.random()), cpu=CPU)
    for i in range(max(round(factor * INJECTED), len(DECKS))):
        yield Job(
            7, f"{DECKS[i % len(DECKS)]} injected {i}", partial(injected, DECKS[i % len(DECKS)], rng.random()), cpu=CPU
        )


def in_deck(name, what, place, folder):
    """One number of a deck is another one."""
    text = (INPUTS / f"{name}.yaml").read_text()
    if what == "steps":
        return many_steps(text, folder)
    plain = [m for m in NUMBER.finditer(text) if "#" not in text[text.rfind("\n", 0, m.start()) : m.start()]]
    spots = [m for m in plain if not text[: m.start()].endswith("mecano: ") and "title" not in line_of(text, m.start())]
    spot = spots[int(place * len(spots))]
    (folder / "deck.yaml").write_text(text[: spot.start()] + what + text[spot.end() :])
    (folder / "place.txt").write_text(f"{what} in place of {spot[0]} in: {line_of(text, spot.start())}\n")
    settings = [] if re.match(r"\s*time:", line_of(text, spot.start())) else ["--set", *TINY_END]
    return judged(in_process(["run", "deck.yaml", "--quiet", *settings], folder), folder)


def line_of(text, place):
    """The line of a text around a place in it."""
    return text[text.rfind("\n", 0, place) + 1 :].partition("\n")[0]


def many_steps(text, folder):
    """1e12 steps: `check` answers at once, and says so."""
    (folder / "deck.yaml").write_text(text)
    settings = ["--set", "time={end: 1, step: 1e-12}", "--set", "output.every=step"]
    outcome = in_process(["check", "deck.yaml", *settings], folder)
    if why := unfit(outcome, (0, 2)):
        return why
    said = outcome.out + outcome.err
    return (
        "" if re.search(r"1e\+?12|1000000000000|1,000,000,000,000", said) else "1e12 steps, and check does not say so"
    )


def judged(outcome, folder):
    """Why a run with such a number has not ended as it may: refused by its place, named, or all finite."""
    if why := unfit(outcome, (0, 2, 3, 4, 6, 7), cpu=CPU):
        return why
    if outcome.code == 2:
        return unplaced(outcome)
    path = folder / "deck.h5"
    found = held(path) if path.exists() else None
    if isinstance(found, str):
        return f"exit code {outcome.code}, and the file cannot be read: {found}"
    if outcome.code == 0:
        return not_finite(found)
    if not NAMED.search(outcome.err):
        return f"exit code {outcome.code}, and nothing is named: {outcome.err.strip().splitlines()[:1]}"
    if found is not None:
        return not_finite(found) or (
            "" if TIME.search(outcome.err) else f"exit code {outcome.code}, and no time is named"
        )
    return ""


def not_finite(found):
    """The first series of a file that has a value that is not finite; or empty."""
    if found is None:
        return "exit code 0, and no file"
    for name, value in found.items():
        if isinstance(value, np.ndarray) and value.dtype.kind == "f" and not np.isfinite(value).all():
            return f"{name} is not finite in the file"
    return ""


def injected(name, place, folder):
    """From some step on a number in the record of an element is NaN: the run ends with its name, or does not mind."""
    from mecano.analyses.dynamic import run
    from mecano.deck.read import read_deck
    from mecano.errors import MecanoError

    rng = random.Random(place)
    (folder / "deck.yaml").write_text((INPUTS / f"{name}.yaml").read_text())
    checked = read_deck(folder / "deck.yaml", ("time.end=0.05", "output.every=step"))
    chosen, steps = [], rng.randrange(1, 12)

    def inject(system):
        batch = rng.choice([batch for batch in system.batches if numbers_of(batch)])
        k, field = rng.randrange(len(batch.names)), rng.choice(numbers_of(batch))
        batch.p[field][k] = math.nan if batch.p[field].ndim == 1 else np.full(batch.p[field].shape[1:], math.nan)
        chosen.append((batch.names[k], field))
        (folder / "place.txt").write_text(f"{field} of {batch.names[k]} after {steps} steps\n")

    outcome = None
    try:
        with after_steps(steps, inject):
            run(checked, folder / "deck.h5")
    except MecanoError as error:
        outcome = error
    return reported_in(outcome, chosen[0] if chosen else None, held(folder / "deck.h5"))


def numbers_of(batch):
    """Fields of the records of a batch that hold floats."""
    return [name for name in batch.p.dtype.names or () if batch.p[name].dtype.kind == "f"]


class after_steps:
    """In this context ``change(system)`` is called once a run has accepted so many steps."""

    def __init__(self, steps, change):
        self.steps, self.change = steps, change

    def __enter__(self):
        from mecano.solve.time.time_integration import TimeIntegrator

        self.advance, self.ordinary, outer = TimeIntegrator._advance, TimeIntegrator.ordinary, self
        count = [0]

        def advance(integrator, run, stop, trial=None):
            count[0] += 1
            if count[0] == outer.steps:
                outer.change(integrator.system)
            return outer.advance(integrator, run, stop, trial)

        TimeIntegrator._advance = advance
        TimeIntegrator.ordinary = lambda integrator, run, stop: (run, None, True)  # every step is counted

    def __exit__(self, *_):
        from mecano.solve.time.time_integration import TimeIntegrator

        TimeIntegrator._advance, TimeIntegrator.ordinary = self.advance, self.ordinary


def reported_in(error, chosen, found):
    """Why a run has not ended as it may after NaN in ``chosen`` (name, field); ``error`` is what it raised, or None."""
    if isinstance(found, str):
        return f"the file cannot be read: {found}"
    if why := not_finite(found):
        return f"{why}, after NaN in {chosen[1]} of {chosen[0].split()[0]}"
    if error is None or chosen is None:
        return ""
    if error.exit_code != 6:
        what = f"{chosen[1]} of {chosen[0].split()[0]}"
        return f"exit code {error.exit_code} after NaN in {what}: {str(error).splitlines()[0][:90]}"
    text = str(error)
    owner = re.search(r"'[^']+'", chosen[0])
    if not TIME.search(text):
        return "no time is named"
    return "" if owner is None or owner[0] in text else f"{chosen[0].split()[0]} is not named, NaN in {chosen[1]}"
