r"""Redundant constraints by joint, including joints whose nodes share unknowns.

Joints identify unknowns of their nodes (Boolean identification), and the forces that they transmit through these have
no multipliers, so redundant constraints would not name these joints. Here every node has unknowns of its own, and each
identification is replaced by an equivalent constraint, :math:`x_i - x_j = 0` or :math:`R_0 (\delta\Theta_i -
\delta\Theta_j) = 0`, where :math:`R_0` is the orientation of both nodes in the deck, so that axes are those of the
deck, carried along. The number of redundancies is that of the model, plus the number of identifications of unknowns
that are already identified.
"""

from collections.abc import Iterable
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from mecano.element_interface import nothing
from mecano.laws.law_table import LawTable
from mecano.model.model import Element, Model
from mecano.model.numbering import AXES, Classes, EquationName
from mecano.model.system import System
from mecano.solve.diagnostics.mobility import Analysis, Group, gradient, groups
from mecano.solve.diagnostics.null_space import Entries, left_null_space

if TYPE_CHECKING:
    from mecano.element_interface import Kind
    from mecano.model.state import State

PARTS = {"x": "force {}", "R": "moment about initial {}"}
SIDE = np.sqrt(0.5)  # the two coefficients of an identification, as a row of length 1
DIGITS = 6  # of a reaction over the largest one


def redundant_groups(system: System, s: "State", length: float, analysis: Analysis) -> tuple[Group, ...]:
    """Return the groups of redundant constraints at ``s``, with all joints involved; ``analysis`` is that of ``s``."""
    if not (analysis.redundant or _identified_twice(system)):
        return ()
    B, _, names, group, holds = _without_identifications(system, s, length)
    return groups(left_null_space(B, group, holds), names, lambda: names)


def by_same_joints(found: Iterable[Group]) -> tuple[Group, ...]:
    """Merge Groups of redundant constraints that belong to the same joints; return them as a tuple, in order."""
    united: dict[frozenset[str], list[Group]] = {}
    for group in found:
        united.setdefault(frozenset(name.place for name in group.names), []).append(group)
    return tuple(
        Group(
            sum(group.count for group in some),
            tuple(name for group in some for name in group.names),
            {place: total for group in some for place, total in group.totals.items()},
        )
        for some in united.values()
    )


def contradicting(system: System, s: "State", length: float, phi: np.ndarray) -> list[EquationName]:
    """Return the names of the contradictory constraints and joints of an assembly that failed with the gaps ``phi``.

    ``phi`` (n_l,) are then reactions in balance with those of identifications; all constraints whose reactions are not
    small are named, the largest first.
    """
    from scipy.sparse import csr_array

    B, size, names, _, _ = _without_identifications(system, s, length)
    rows, n_l, reactions = csr_array((B.values, (B.rows, B.cols)), B.shape), len(size), phi * size
    shared = _least_norm(rows[n_l:].T, -rows[:n_l].T @ reactions)
    found = np.abs(np.concatenate([reactions, shared]))
    share = np.round(found / (found.max(initial=0.0) or 1.0), DIGITS)
    order = np.argsort(-share, kind="stable")[: np.count_nonzero(share)]
    return list(dict.fromkeys(names[i] for i in order))


def _least_norm(A, b):
    """Return the least-squares solution (n,) of least norm of A x = b, A (m, n) sparse, by its independent parts."""
    from scipy.sparse import bmat
    from scipy.sparse.csgraph import connected_components

    m, n = A.shape
    count, part = connected_components(bmat([[None, A], [A.T, None]]), directed=False)
    order = np.argsort(part, kind="stable")
    x, A = np.zeros(n), A.tocsr()
    for own in np.split(order, np.cumsum(np.bincount(part, minlength=count))[:-1]):
        rows, cols = own[own < m], own[own >= m] - m
        if len(rows) and len(cols):
            x[cols], *_ = np.linalg.lstsq(A[rows][:, cols].toarray(), b[rows], rcond=None)
    return x


def _identified_twice(system):
    """Decide whether an identification joins unknowns that are already identified; all fixed nodes count as one."""
    fixed = next((i for i, node in enumerate(system.nodes) if node.fixed), None)
    classes = Classes(2 * len(system.nodes))
    if fixed is not None:
        for i, node in enumerate(system.nodes):
            for part in (0, 1) if node.fixed else ():
                classes.join(2 * fixed + part, 2 * i + part)
    for what, i, j, _ in system.shared:
        i, j = 2 * i + (what == "R"), 2 * j + (what == "R")
        if classes.find(i) == classes.find(j):
            return True
        classes.join(i, j)
    return False


def _without_identifications(system, s, length):
    """Return (gradient without identifications, sizes of the rows of ``system``, names, nodes of columns, active rows).

    The rows of ``system`` come first, followed by 3 for each identification. There are 6 columns for each node (empty
    for fixed ones), followed by those of the scalars of elements.
    """
    whole = system.kept(_without_sharing)
    B, size, holds = gradient(whole, _state(system, whole, s), length)
    columns = _columns(whole)
    keep, names = holds[B.rows], list(whole.numbering.name[whole.n_q : whole.n])
    rows, cols, values = [B.rows[keep]], [columns[B.cols[keep]]], [B.values[keep]]
    for what, i, j, owner in system.shared:
        axes = np.asarray(system.nodes[i].R if what == "R" else np.eye(3))
        for axis in range(3):
            along = np.flatnonzero(axes[axis])
            for node, sign in ((i, SIDE), (j, -SIDE)):
                if not system.nodes[node].fixed:
                    rows.append(np.full(len(along), len(names)))
                    cols.append(6 * node + 3 * (what == "R") + along)
                    values.append(sign * axes[axis, along])
            names.append(EquationName(owner, PARTS[what].format(AXES[axis])))
    n = 6 * len(system.nodes)
    n_scalars = whole.numbering.n_scalars
    group = np.concatenate([np.repeat(np.arange(len(system.nodes)), 6), len(system.nodes) + np.arange(n_scalars)])
    shape = (len(names), n + n_scalars)
    holds = np.concatenate([holds, np.ones(len(names) - len(holds), bool)])
    B = Entries(np.concatenate(rows), np.concatenate(cols), np.concatenate(values), shape)
    return B, size, names, group, holds


def _without_sharing(system):
    """Return the System without identifications."""
    model = system.model
    kinds: dict[int, Kind] = {}  # without identifications, by the ids of those with them
    elements = [Element(e.name, _unshared(e, kinds), e.nodes, e.values) for e in model.elements]
    return System(Model(model.nodes, elements, LawTable(), model.gravity))


def _unshared(element, kinds):
    """Return the kind of an element without its identifications, the same object for all elements of the kind."""
    kind = element.kind.chosen(element.values)
    if id(kind) not in kinds:
        kinds[id(kind)] = replace(kind, name=element.kind.name, shares=nothing, variant=None, divide=None), kind
    return kinds[id(kind)][0]


def _state(system, whole, s):
    """Return the state ``s`` of ``system`` for the same model without identifications."""
    one, all_ = system.numbering, whole.numbering
    apart = whole.initial_state(s.t)
    three = np.arange(3)
    apart.z[all_.x[:, None] + three] = s.z[one.x[:, None] + three]
    apart.R[all_.rotation] = s.R[one.rotation]
    apart.z[all_.n_q - all_.n_scalars : all_.n_q] = s.z[one.n_q - one.n_scalars : one.n_q]
    return replace(apart, phases=s.phases, memory=s.memory)


def _columns(whole):
    """Return the columns (n_q,) of the unknowns of a model in ``_without_identifications``."""
    of, n = whole.numbering, 6 * len(whole.nodes)
    columns = np.zeros(of.n_all, np.int64)
    three = np.arange(3)
    columns[of.x[:, None] + three] = 6 * np.arange(len(whole.nodes))[:, None] + three
    columns[of.r[:, None] + three] = 6 * np.arange(len(whole.nodes))[:, None] + 3 + three
    columns[of.n_q - of.n_scalars : of.n_q] = n + np.arange(of.n_scalars)
    return columns[: whole.n_q]
