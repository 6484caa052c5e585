"""Forces transmitted by joints that share unknowns: weighted sums of the forces on the nodes that they join."""

from collections.abc import Sequence

import numpy as np

from mecano.model.instance import Shared

NEGLIGIBLE = 1e-12  # weight of a force: rounding


class ReactionPartition:
    """For each joint that shares an unknown, the slots of nodes whose forces it transmits, and their weights.

    The force that such a joint transmits is not a multiplier: it is the sum of the forces on the nodes on one side. If
    a fixed node is on that side, whose support force is unknown, it is the negative sum over the other side. If the
    joint is in a loop, or a fixed node is on both sides, equilibrium does not determine the force: the joints then
    divide the forces such that the sum of the squares of theirs is least.
    """

    def __init__(self, shared: Sequence[Shared], fixed: set[int], n_slots: int):
        self.fixed, self.n_slots = fixed, n_slots
        self.starts, self.ends = [0], [(i, j) for _, i, j, _ in shared]
        self.members: list[int] = []
        self.weights: list[float] = []
        self.neighbours: dict[tuple[str, int], list[tuple[int, int]]] = {}  # of a node: (other node, number of joint)
        for number_, (what, i, j, _) in enumerate(shared):
            self.neighbours.setdefault((what, i), []).append((j, number_))
            self.neighbours.setdefault((what, j), []).append((i, number_))
        self.owners = {owner for *_, owner in shared}
        self.shared = {}
        for number_, (what, i, j, owner) in enumerate(shared):
            self.shared[owner, what, j] = (number_, i)
            self.shared[owner, what, i] = (number_, j)
        self._divided: dict[int, dict[int, float]] = {}
        """number of an undetermined joint -> {node: weight} of the force that its first node exerts"""

    def slots(self, owner: int, what: str, node: int) -> list[int]:
        """Return 3 slots with the forces that all nodes on the side of ``node`` exert through the joint ``owner``."""
        if (owner, what, node) not in self.shared:
            plain = 6 * node + 3 * (what == "R")
            return [plain, plain + 1, plain + 2]
        weights = self._weights(what, node, *self.shared[owner, what, node])
        first = self.n_slots + len(self.starts) - 1
        for axis in range(3):
            self.members += [6 * i + 3 * (what == "R") + axis for i in weights]
            self.weights += weights.values()
            self.starts.append(len(self.members))
        return [first, first + 1, first + 2]

    def _weights(self, what, node, edge, other):
        """Return {node: weight} of the forces that the joint ``edge`` transmits from ``node`` to the ``other``."""
        side = self._side(what, node, edge)
        if other not in side and self.fixed.isdisjoint(side):
            return dict.fromkeys(side, 1.0)
        across = self._side(what, other, edge)
        if other not in side and self.fixed.isdisjoint(across):
            return dict.fromkeys(across, -1.0)
        if edge not in self._divided:
            self._divide(what, [i for i in (node, other) if i not in self.fixed])
        sign = 1.0 if node == self.ends[edge][0] else -1.0
        return {i: sign * weight for i, weight in self._divided.get(edge, {}).items()}

    def _side(self, what, node, edge):
        seen, stack = [node], [node]
        while stack:
            for j, number_ in self.neighbours.get((what, stack.pop()), []):
                if number_ != edge and j not in seen:
                    seen.append(j)
                    stack.append(j)
        return seen

    def _divide(self, what, free):
        """Find the least forces of all joints that are in balance with those on the ``free`` nodes joined to these."""
        edges: dict[int, int] = {}  # number of a joint -> its column
        nodes = list(free)
        for i in nodes:  # the list grows
            for j, number_ in self.neighbours[what, i]:
                edges.setdefault(number_, len(edges))
                if j not in self.fixed and j not in nodes:
                    nodes.append(j)
        balance = np.zeros((len(nodes), len(edges)))
        for number_, column in edges.items():
            for end, sign in zip(self.ends[number_], (1.0, -1.0), strict=True):
                if end not in self.fixed:
                    balance[nodes.index(end), column] = sign
        for number_, row in zip(edges, np.linalg.pinv(balance), strict=True):
            self._divided[number_] = {i: float(x) for i, x in zip(nodes, row, strict=True) if abs(x) > NEGLIGIBLE}

    def tables(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Return CSR lists (starts, members) of the sums, and the weights of the members."""
        members = np.array(self.members, np.int64)
        return np.array(self.starts, np.int64), members, np.array(self.weights, np.float64)
