"""Summary of a results file and its run, as text."""

import json
import math
import os
import shlex
from collections.abc import Sequence
from fnmatch import fnmatchcase
from textwrap import wrap

import numpy as np

from mecano.element_interface import Display
from mecano.errors import UnknownNameError, name_list
from mecano.post.event_groups import groups, most_notable, repeated
from mecano.post.extremes import named, notable
from mecano.post.info_other_files import info_other, is_other
from mecano.post.runs import Run
from mecano.post.verdict import verdict
from mecano.results.energy_balance import EXCHANGED, scale_of_balance
from mecano.results.lookup import similar_outputs
from mecano.results.reader import Results, open_results
from mecano.results.writer import WRITING

MOST_EVENTS = 20
MOST_EXTREMES = 60
MOST_NAMES = 6  # names listed of entries with the same outputs
WIDTH = 100
NOTICED = 0.01  # s, least compile time reported
MERGED = "**"  # all events, in lines of similar ones
RESUME = "--resume"
ENDS = {"running": "still running", "killed": "killed, all acknowledged steps are kept", "truncated": "cut short"}


def info(path: str | os.PathLike[str], pattern: str | None = None, events: str | None = None) -> str:
    """Return the summary of a results file or, with a ``pattern`` such as "wheel", "wheel.*" or "*", of these outputs.

    Similar events at one instant are merged into one line, and repeated ones too if there are many; if the lines are
    still too many, shocks and releases come first. With ``events`` these lines are shown alone, all of them if it is
    MERGED, and for a pattern, such as "latch*", "locks" or "*", each event of these elements, or of these names.
    ``pattern`` does not apply to files of modes. Raises ResultsError, and UnknownNameError if no output matches.
    """
    if is_other(path):
        return info_other(path)
    with open_results(path) as results:
        if pattern is not None:
            paths = _matching(results, pattern)
            return "\n".join([*_names(results, paths), "", *_extremes(results, paths, math.inf)])
        if events is not None:
            return "\n".join(_events(results, math.inf) if events == MERGED else _listed(results, events))
        return "\n".join(
            [*_run(results), "", *_events(results, MOST_EVENTS), "", *_output_lines(results), "", *_extremes(results)]
        )


def one_line(runs: Sequence[Run]) -> str:
    """Return a line for the head of a picture: the outcome of one run, or the names of several."""
    if len(runs) > 1:
        return f"{len(runs)} runs: {', '.join(run.results.path.name for run in runs)}"
    results = runs[0].results
    return "; ".join([verdict(results), count(results), f"mecano {results.metadata['version_mecano']}"])


def facts(results: Results) -> list[tuple[str, str]]:
    """Return (label, text) of each fact on the outcome and provenance of a run."""
    data = results.metadata
    versions = [f"{key.removeprefix('version_')} {data[key]}" for key in data if key.startswith("version_")]
    versions.sort(key=lambda text: not text.startswith("mecano"))
    return [
        ("title", data["title"] or "none"),
        ("run", count(results)),
        ("saved", _saved(results)),
        ("time spent", _times_text(data)),
        ("deck", data["deck_path"] or "not a file"),
        ("overrides", " ".join(data["overrides"]) or "none"),
        ("other files", ", ".join(data["includes"]) or "none"),
        ("plugins", _plugins(data.get("plugins", "{}"))),
        ("automatic", _automatic(results)),
        *_set_in_motion(results),
        *(("resumed", text) for text in results.resumptions),
        *(("energy", text) for text in _energy(results)),
        ("started", f"{data['started']} on {data['host']}, {data['threads']} thread(s)"),
        ("with", ", ".join(versions)),
    ]


def _set_in_motion(results):
    """Yield the fact that constraints give velocities to nodes that the deck leaves at rest."""
    if nodes := results.model.get("set_in_motion"):
        yield "at start", f"the constraints set nodes in motion that the deck leaves at rest: {nodes}"


def _plugins(text):
    """Return the files and packages of plugins as text, with the names that they register and their digests."""
    found = json.loads(text).items()
    return "; ".join(f"{source} ({', '.join(one['names'])}; {one['sha256'][:12]})" for source, one in found) or "none"


def _times_text(data):
    """Return a text on the wall-clock times of run and compilation, and on the CPU time of the process."""
    compiling = f" and {data['compile_time']:.2f} s for compiling" if data["compile_time"] >= NOTICED else ""
    return (
        f"{data['wall_time']:.2f} s of wall-clock time for the run{compiling}; {data['processor_time']:.2f} s of CPU "
        "time for the whole process, its start and compiling included"
    )


def _run(results):
    lines = [str(results.path)]
    warnings = [("warning", text) for text in results.warnings]
    for label, text in [*facts(results), *warnings, ("status", _status(results))]:
        lines += wrap(text, WIDTH, initial_indent=f"  {label:<12}", subsequent_indent=" " * 14)
    lines += [f"              {line}" for line in results.end.strip().split("\n")[1:]]
    return [*lines, *(f"  {'resume with':<12}{command}" for command in _going_on(results))]  # to be copied: not wrapped


def _going_on(results):
    """Yield the command that resumes a run that ended early, unless its reason gives it or it would fail again."""
    status, reason = results.status, results.reason
    again = status != "failed" or WRITING in reason
    if again and results.resumable and RESUME not in reason:
        deck, overrides = results.metadata["deck_path"] or "DECK", results.metadata["overrides"]
        settings = [word for text in overrides for word in ("--set", text)]
        yield shlex.join(["mecano", "run", deck, *settings, "-o", str(results.path), RESUME])


def _automatic(results):
    chosen = {name.replace("_", " "): value for name, value in results.automatic.items()}
    return ", ".join(f"{name} {value:.4g}" for name, value in chosen.items() if value is not None) or "none"


def _energy(results):
    """Yield a text on the error of the energy balance over its scale, if there is a balance."""
    extremes = {name: results.extremes.get(f"energy/{name}") for name in EXCHANGED}
    balance = results.extremes.get("energy/balance")
    if balance is None or None in extremes.values() or not np.isfinite(balance.maximum - balance.minimum):
        return
    off, ranges = balance.maximum - balance.minimum, {**extremes, "balance": balance}
    compared, scale = scale_of_balance({name: (e.minimum, e.maximum) for name, e in ranges.items()})
    relative = f", {off / scale:.2g} of {compared}" if scale > 0.0 else ""
    yield f"the balance varies by {off:.3g} J{relative}"


def _status(results):
    status = ENDS.get(results.status, verdict(results))
    reason = results.end.strip().partition("\n")[0]
    return f"{status}: {reason}" if reason else status


def count(results: Results) -> str:
    """Return a text with the numbers of steps, rejected trials and iterations of a run."""
    steps = results.steps
    if not len(steps):
        return "no step"
    text = f"{len(steps)} steps"
    if {"rejected", "iterations"} <= set(results.step_columns):
        rejected, iterations = int(steps["rejected"].sum()), int(steps["iterations"].sum())
        text += f", {rejected} rejected, {iterations} Newton iterations ({iterations / len(steps):.2f} per step)"
    if "step_size" in results.step_columns:
        low, high = steps["step_size"].min(), steps["step_size"].max()
        text += f", of {_range(low, high)} {results.axis.unit}".rstrip()
    return text


def _range(low, high):
    return f"{low:.3g}" if high - low <= 1e-6 * high else f"{low:.3g} to {high:.3g}"


def _saved(results):
    time = results.time
    if not len(time):
        return "nothing yet"
    if results.axis.unit != "s":
        return f"{len(time)} equilibria, {results.axis.path} from {time[0]:.6g} to {time[-1]:.6g}"
    text = f"{len(time)} times from {time[0]:.6g} to {time[-1]:.6g} s"
    intervals = np.diff(time)
    if len(intervals) > 1 and np.ptp(intervals[:-1]) <= 1e-6 * intervals[0]:
        text += f", every {intervals[0]:.6g} s"
    return text


def _output_lines(results):
    """Return the lines on outputs by owner, with the kinds of the deck."""
    run = Run(results)
    kinds = {path: d["type"] for path, d in run.things.items()}
    owners: dict[tuple[str, str, str], list[str]] = {}  # (section, kind, path of the owner) -> names of its outputs
    for path in results.names():
        owner, _, name = path.rpartition("/")
        if not owner.startswith("formulas/"):  # those written in place, such as the instant of a release
            owners.setdefault((owner.partition("/")[0], kinds.get(owner, ""), owner), []).append(name)
    alike: dict[tuple[str, str, tuple[str, ...]], list[str]] = {}  # owners of the same outputs
    for (section, kind, owner), names in owners.items():
        alike.setdefault((section, kind, tuple(names)), []).append(owner.rpartition("/")[2])
    lines = ["Outputs (units and descriptions, and all names: mecano info FILE --names)"]
    ranked = sorted(alike.items(), key=lambda item: _rank(results, *item[0][:2]))
    for (section, kind, outputs), members in ranked:
        shown = name_list(members, MOST_NAMES)
        head = f"  {section}{f', {kind}' if kind else ''}" + (f": {shown}" if members != [section] else "")
        lines += wrap(f"{head}: {', '.join(outputs)}", WIDTH, initial_indent="  ", subsequent_indent="      ")
    return lines


def _rank(results, section, kind):
    """Return the rank of outputs in a list: joints, wheels, other elements, loads, nodes, others."""
    order = ("joints", "wheels", "elements", "loads", "nodes")
    wheel = "wheels" in results.displays.get(kind, Display()).pictures
    return order.index("wheels" if wheel else section) if section in order else len(order)


def _events(results, most):
    """Return the lines on events, with similar events merged, at most ``most`` lines on them."""
    instants = groups(results)
    if not instants:
        return ["Events: none"]
    found = repeated(instants) if len(instants) > MOST_EVENTS else instants
    shown = found if len(found) <= most else most_notable(found, most)
    lines = [f"Events: {len(results.events)}"]
    if len(found) < len(results.events):
        alike = "repeated ones" if len(found) < len(instants) else "like ones at one instant"
        lines[0] += f", {alike} merged, in {len(found)} lines"
    if len(shown) < len(found):
        lines[0] += f"; {len(shown)} lines, shocks and releases first, mecano info FILE --events shows all lines"
    elif len(found) < len(instants):
        lines[0] += "; mecano info FILE --events '*' lists all events"
    if any(group.is_shock for group in found):
        lines[0] += f"; {sum(group.lost for group in found if group.is_shock):.6g} J lost in shocks"
    return lines + _lines_of(shown, results.axis.unit)


def _listed(results, pattern):
    """Return the lines on the events of the elements or names that match a pattern, one for each."""
    found = [one for group in groups(results) for one in group.single]
    if not found:
        return ["Events: none"]
    shown = [group for group in found if any(fnmatchcase(text, pattern) for text in _names_of(group))]
    if not shown:
        known = list(dict.fromkeys(text for group in found for text in _names_of(group)))
        raise UnknownNameError(
            f"no event of {results.path} matches '{pattern}'; there are {name_list(known, MOST_EVENTS)}"
        )
    shocks = [group.lost for group in shown if group.is_shock]
    lost = f"; {sum(shocks):.6g} J lost in shocks" if shocks else ""
    return [f"Events: {len(shown)}{lost}", *_lines_of(shown, results.axis.unit)]


def _names_of(group):
    return group.names[0], group.events[0].name.replace("_", " ")


def _lines_of(shown, unit):
    width = max(len(group.title) for group in shown)
    return [_event(group, unit, width) for group in shown]


def _event(group, unit, width):
    first, number = group.events[0], len(group.events)
    text = first.name.replace("_", " ")
    if first.before != first.after:
        text += f"  ({first.before} -> {first.after})"
    if group.is_shock:
        each, all_ = ("up to ", " in all") if number > 1 else ("", "")
        text += f"  impulse {each}{group.impulse:.6g} {first.impulse_unit}, {group.lost:.6g} J lost{all_}"
    elif group.lost:
        text += f"  {abs(group.lost):.6g} J {'lost' if group.lost > 0.0 else 'given'}"
    if group.times > 1:
        text += f"  {group.times} times, to {group.events[-1].time:.6g} {unit}".rstrip()
    return f"  {group.time:12.6g} {unit:1}  {group.title:<{width}}  {text}"


def _matching(results, pattern):
    """Return the paths that match a pattern; the name of an element means all its outputs, that of an output any."""
    paths = results.names(pattern)
    if not paths and "*" not in pattern and "?" not in pattern:
        paths = results.names(f"{pattern}.*") or results.names(f"*.{pattern}")
    if not paths:
        near = similar_outputs(pattern, results.names())
        hint = f"did you mean {' or '.join(near)}?" if near else "'wheel.*' matches all of a wheel"
        raise UnknownNameError(f"no output of {results.path} matches '{pattern}'; {hint}")
    return paths


def _names(results, paths):
    lines, declared = [], results.series
    for path in paths:
        series = declared.get(path) or declared[path.rpartition(".")[0]]  # of a component
        shape = f": {', '.join(series.components)}" if series.components and path in declared else ""
        unit = f" [{series.unit}]" if series.unit not in ("", "-") else ""
        lines.append(f"{path.replace('/', '.')}{unit}{shape}")
        lines += wrap(series.doc, WIDTH, initial_indent="    ", subsequent_indent="    ")
    return lines


def _extremes(results, paths=None, most=MOST_EXTREMES):
    """Return the table of extremes of ``paths``, or of the run as a whole."""
    rows = notable(results.extremes)
    if paths is not None:
        chosen = set(paths)
        rows = [(named(x), e) for x, e in results.extremes.items() if x in chosen or x.rpartition(".")[0] in chosen]
    if not rows or not len(results.time):
        return ["Extremes: none"]
    shown = rows if len(rows) <= most else rows[:most]
    width, at = max(len(name) for name, _ in shown), f"at [{results.axis.unit}]" if results.axis.unit else "at"
    lines = [f"Extremes over all accepted steps\n  {'':<{width}} {'min':>12} {at:>10} {'max':>12} {at:>10}"]
    lines += [f"  {name:<{width}} {_numbers(extreme)}" for name, extreme in shown]
    if len(shown) < len(rows):
        lines.append(f"  and {len(rows) - len(shown)} more: mecano info FILE --names PATTERN")
    if paths is None:
        lines.append("  without nodes, formulas written in place, and values that are zero or rounding errors")
    return lines


def _numbers(extreme):
    values = (extreme.minimum, extreme.minimum_time, extreme.maximum, extreme.maximum_time)
    low, low_time, high, high_time = (value + 0.0 for value in values)  # no negative zeros
    unit = "" if extreme.unit in ("", "-") else f"  {extreme.unit}"
    return f"{low:12.5g} {low_time:10.5g} {high:12.5g} {high_time:10.5g}{unit}"
