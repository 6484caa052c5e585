"""Size of a run (steps, saved times, bytes of results, tolerance), with warnings if it is probably unintended."""

import math

from mecano.schema import Values

MOST_STEPS = 1e7
MOST_BYTES = 4e9
NUMBER = 8  # bytes
LOOSEST = 0.03  # tolerance of adaptive steps: in longer ones Newton's iteration costs more than the steps save


def steps(values: Values) -> int | None:
    """Return the number of fixed steps of the checked deck ``values``; None if the step size is adaptive."""
    time = values["time"]
    return None if time["adaptive"] else _count(time, time["step"])


def saved_times(values: Values) -> int | None:
    """Return the number of saved times including the start; None if every step is saved and their number is unknown."""
    every = values["output"]["every"]
    count = steps(values) if every == "step" else _count(values["time"], every)
    return None if count is None else count + 1


def _count(time, interval):
    count = (time["end"] - time["start"]) / interval
    return math.ceil(count - max(1e-6, 1e-12 * count))  # rounding must not add a step


def result_bytes(values: Values, row: int, history: int) -> int:
    """Estimate the bytes of results: ``row`` numbers per saved time, ``history`` numbers per step."""
    return NUMBER * ((saved_times(values) or 0) * row + (steps(values) or 0) * history)


def size_warnings(values: Values, row: int, history: int) -> list[str]:
    """Return warnings about a step or an interval that is probably mistyped; arguments as in ``result_bytes``."""
    texts, count = [], steps(values) or 0
    adaptive = values["time"] and values["time"]["adaptive"]
    if adaptive and adaptive["tolerance"] > LOOSEST:
        texts.append(
            f"'time.adaptive.tolerance' is taken as {LOOSEST:g}, not {adaptive['tolerance']:g}: longer steps would "
            "cost more"
        )
    time, every = values["time"], values["output"]["every"]
    if time and isinstance(every, float) and every > time["end"] - time["start"]:
        texts.append(
            f"only the start and the end are saved: 'output.every' ({every:g} s) is longer than the run "
            f"({time['end'] - time['start']:g} s)"
        )
    if count > MOST_STEPS:
        texts.append(f"{count:.3g} steps of {values['time']['step']:g} s are needed: is 'time.step' intended?")
    size = result_bytes(values, row, history)
    if size > MOST_BYTES:
        texts.append(
            f"the results file will have about {size / 1e9:.3g} GB, for {saved_times(values) or 0:.3g} saved times of "
            f"{row} numbers and {count:.3g} steps: are 'output.every' and 'time.step' intended?"
        )
    return texts
