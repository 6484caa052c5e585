"""Equal curves, which would cover one another: drawn once, with all their names."""

from collections.abc import Iterable, Sequence

from mecano.post.sheet import Curve, Panel

LONGEST = 40  # characters of the names of equal curves in a legend


def equal_curves(curves: Iterable[Curve]) -> list[list[Curve]]:
    """Return lists of equal curves, in the order of their first ones."""
    found: list[list[Curve]] = []
    for curve in curves:
        own = next((group for group in found if group[0].equals(curve)), None)
        found.append([curve]) if own is None else own.append(curve)
    return found


def first_subjects(panels: Sequence[Panel], subjects: Iterable[str]) -> dict[str, str]:
    """Return {subject: first of the ``subjects`` whose curves equal its own in all ``panels``}."""
    found: dict[str, str] = {}
    for subject in subjects:
        same = (other for other in dict.fromkeys(found.values()) if _alike(panels, other, subject))
        found[subject] = next(same, subject)
    return found


def joined(names: Iterable[str]) -> str:
    """Return the names of equal curves as text, "a = b", the first of them if all would be too long."""
    names = list(dict.fromkeys(names))
    shown = names
    while len(shown) > 1 and len(" = ".join(shown)) > LONGEST:
        shown = shown[:-1]
    hidden = len(names) - len(shown)
    return " = ".join([*shown, f"{hidden} other{'s' * (hidden > 1)}"] if hidden else shown)


def _alike(panels, one, other):
    """Return whether the curves of two subjects are equal in all panels."""
    for panel in panels:
        pairs = [[curve for curve in panel.curves if curve.subject == name] for name in (one, other)]
        if [curve.y.what for curve in pairs[0]] != [curve.y.what for curve in pairs[1]]:
            return False
        if not all(a.equals(b) for a, b in zip(*pairs, strict=True)):
            return False
    return True
