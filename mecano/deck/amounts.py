"""How much a run will be: steps, saved times, bytes of results; warnings where it is more than was meant."""

import math

MOST_STEPS = 1e7
MOST_BYTES = 4e9
NUMBER = 8  # bytes


def steps(values):
    """Steps of fixed size that checked deck ``values`` ask for; None when the step size follows an error."""
    time = values["time"]
    return None if time["adaptive"] else _count(time, time["step"])


def saved_times(values):
    """Times that are saved, the start among them; None when every step is and their number is not known."""
    every = values["output"]["every"]
    count = steps(values) if every == "step" else _count(values["time"], every)
    return None if count is None else count + 1


def _count(time, interval):
    count = (time["end"] - time["start"]) / interval
    return math.ceil(count - max(1e-6, 1e-12 * count))  # rounding makes no step of its own


def result_bytes(values, row, history):
    """Bytes of results, as far as they can be foreseen: ``row`` numbers a saved time, ``history`` numbers a step."""
    return NUMBER * ((saved_times(values) or 0) * row + (steps(values) or 0) * history)


def warnings(values, row, history):
    """Texts for a user who may have mistyped a step or an interval; arguments as in ``result_bytes``."""
    texts, count = [], steps(values) or 0
    time, every = values["time"], values["output"]["every"]
    if time and isinstance(every, float) and every > time["end"] - time["start"]:
        texts.append(
            f"only the start and the end are saved: 'output.every' ({every:g} s) is longer than the run "
            f"({time['end'] - time['start']:g} s)"
        )
    if count > MOST_STEPS:
        texts.append(f"{count:.3g} steps of {values['time']['step']:g} s are asked for: is 'time.step' meant so?")
    size = result_bytes(values, row, history)
    if size > MOST_BYTES:
        texts.append(
            f"the results file will have some {size / 1e9:.3g} GB, for {saved_times(values) or 0:.3g} saved times of "
            f"{row} numbers and {count:.3g} steps: are 'output.every' and 'time.step' meant so?"
        )
    return texts
