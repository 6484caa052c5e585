"""Describe constraints by joint; joints of one kind with the same constraints share one text."""

from collections.abc import Iterable, Mapping

from mecano.errors import name_list
from mecano.model.numbering import AXES, EquationName


def by_joint(names: Iterable[EquationName], totals: Mapping[str, int], most: int) -> list[str]:
    """Describe the constraints ``names``: one text for all joints of a kind with the same constraints, in order.

    For example "hinge 'a', 'b': force y; moment about initial x, z (3 of 5 constraints each)". ``totals`` gives the
    number of all constraints of a joint by the place of their names; a text names ``most`` joints and counts the
    others.
    """
    held: dict[str, list[str]] = {}  # by place
    for name in names:
        held.setdefault(name.place, []).append(name.what)
    alike: dict[tuple[str, tuple[str, ...], int], list[str]] = {}
    for place, own in held.items():
        kind, _, joint = place.partition(" ")
        alike.setdefault((kind, tuple(own), totals.get(place, 0)), []).append(joint)
    return [_text(kind, constraints, total, joints, most) for (kind, constraints, total), joints in alike.items()]


def _text(kind, constraints, total, joints, most):
    """Return the text of ``joints`` of one kind with the same ``constraints``, out of ``total`` in each."""
    each = " each" if len(joints) > 1 else ""
    of = f" ({len(constraints)} of {total} constraints{each})" if total > 1 else ""
    return f"{kind} {name_list(joints, most)}: {'; '.join(_directions(constraints))}{of}"


def _directions(constraints):
    """Yield the constraints of a joint, with the axes of a force or moment in one text: "force x, y"."""
    axes: dict[str, list[str]] = {}
    for name in constraints:
        sort, _, axis = name.rpartition(" ")
        axes.setdefault(sort, []).append(axis) if sort and axis in AXES else axes.setdefault(name, [])
    for sort, own in axes.items():
        yield f"{sort} {', '.join(own)}" if own else sort
