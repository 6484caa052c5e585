"""What `mecano check` says of a model: bodies, mass, unknowns, mobility, redundant constraints, mechanisms."""

from mecano.prepare import prepare
from mecano.statics import start_in_words

MOST_NAMES = 12  # names printed of one mechanism


def summary(deck):
    """The summary of a checked deck as text; raises AssemblyError where the positions cannot be assembled."""
    prepared = prepare(deck)
    system, analysis = prepared.system, prepared.analysis
    values = deck.values
    masses = [d["mass"] for d in values["elements"].values() if "mass" in d]
    lines = [
        f"{deck.file}: {values['title'] or 'no title'}",
        f"nodes            {len(values['nodes'])}",
        *_counts(values),
        f"bodies           {len(masses)}, together {sum(masses):.6g} kg",
        f"unknowns         {system.n}: {system.n_q} degrees of freedom, {system.n_l} multipliers",
        f"length scale     {prepared.length:.6g} m",
    ]
    lines += _process(prepared)
    if not analysis.complete:
        return "\n".join([*lines, "mobility         not computed: too many constraints in closed loops"])
    lines.append(f"mobility         {analysis.mobility}")
    alone = [name for group in analysis.mechanisms for name in group.names if len(group.names) == 1]
    if alone:
        lines.append(f"  {len(alone)} unknown(s) that no constraint ties: {_some(alone)}")
    for group in (group for group in analysis.mechanisms if len(group.names) > 1):
        lines.append(f"  mechanism of {group.count} degree(s) of freedom: {_some(group.names)}")
    redundant = sum(group.count for group in analysis.redundant)
    lines.append(f"redundant        {redundant} constraint(s)")
    for group in analysis.redundant:
        lines.append(f"  {group.count} too many among these, whose reactions are therefore not unique:")
        lines += [f"    {name}" for name in group.names]
    if prepared.displacement > 1e-9 * prepared.length:
        lines.append(f"assembly         moves the positions of the deck by up to {prepared.displacement:.3g} m")
    return "\n".join(lines)


def _process(prepared):
    """What a run of the deck does, and for statics how stable the start is."""
    static, time = prepared.deck.values["static"], prepared.deck.values["time"]
    first = prepared.deck.values["initial"]["static"]
    if static:
        what = "load factor" if static["over"] == "load_factor" else "time"
        yield f"process          static equilibrium, {what} to {static['end']:g} by {static['method']}"
    else:
        begun = f", from the static equilibrium found by {first['method']}" if first else ""
        yield f"process          march from {time['start']:g} to {time['end']:g} s{begun}"
    if static or first:
        yield from (f"  {text}" for text in start_in_words(prepared))


def _counts(values):
    for section in ("elements", "joints", "loads"):
        kinds = [d["type"] for d in values[section].values()]
        counted = ", ".join(f"{kinds.count(kind)} {kind}" for kind in dict.fromkeys(kinds))
        yield f"{section:<16} {len(kinds)}{': ' if kinds else ''}{counted}"


def _some(names):
    shown = "; ".join(names[:MOST_NAMES])
    return shown if len(names) <= MOST_NAMES else f"{shown}; and {len(names) - MOST_NAMES} more"
