"""Forces transmitted by joints that share unknowns: sums over the nodes beyond their second node."""

import numpy as np


class ReactionPartition:
    """For each joint that shares an unknown, the slots of all nodes on the side of its second node.

    The force that such a joint transmits is not a multiplier: it is the sum of the forces on the nodes on one side. If
    a fixed node is on that side, whose support force is unknown, it is the negative sum over the other side.
    """

    def __init__(self, shared, fixed, n_slots):
        self.fixed, self.n_slots = fixed, n_slots
        self.starts, self.members = [0], []
        self.neighbours = {}
        for number_, (what, i, j, _) in enumerate(shared):
            self.neighbours.setdefault((what, i), []).append((j, number_))
            self.neighbours.setdefault((what, j), []).append((i, number_))
        self.owners = {owner for *_, owner in shared}
        self.shared = {}
        for number_, (what, i, j, owner) in enumerate(shared):
            self.shared[owner, what, j] = (number_, i)
            self.shared[owner, what, i] = (number_, j)

    def slots(self, owner, what, node):
        """Return 3 slots with the forces that all nodes on the side of ``node`` exert through the joint ``owner``."""
        plain = 6 * node + 3 * (what == "R")
        if (owner, what, node) not in self.shared:
            return [plain, plain + 1, plain + 2]
        edge, other = self.shared[owner, what, node]
        side, opposite = self._side(what, node, edge), False
        if other in side:  # a closed loop of joints
            return [plain, plain + 1, plain + 2]
        if not self.fixed.isdisjoint(side):
            across = self._side(what, other, edge)
            if self.fixed.isdisjoint(across):
                side, opposite = across, True
        first = self.n_slots + len(self.starts) - 1
        for axis in range(3):
            slots = [6 * i + 3 * (what == "R") + axis for i in side]
            self.members += [~slot for slot in slots] if opposite else slots
            self.starts.append(len(self.members))
        return [first, first + 1, first + 2]

    def _side(self, what, node, edge):
        seen, stack = [node], [node]
        while stack:
            for j, number_ in self.neighbours.get((what, stack.pop()), []):
                if number_ != edge and j not in seen:
                    seen.append(j)
                    stack.append(j)
        return seen

    def tables(self):
        """Return CSR lists (starts, members) of the sums; ~slot counts with the opposite sign."""
        return np.array(self.starts, np.int64), np.array(self.members, np.int64)
