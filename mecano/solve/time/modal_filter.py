r"""Modal filter: the part of accelerations that a step resolves, without oscillations faster than the step.

.. math:: \begin{bmatrix} S & k B^T \\ k B & 0 \end{bmatrix} \begin{bmatrix} y \\ \mu \end{bmatrix} =
   \begin{bmatrix} c_M M a \\ 0 \end{bmatrix}, \qquad S = K + c_C C + c_M M

with the effective tangent S of a step of size h: a mode of circular frequency omega keeps the share
1/(1 + beta' omega^2 h^2) of its acceleration. A slow one keeps all but O(h^2); of one far too fast for the step, whose
displacement d has the acceleration omega^2 d, remains d/(beta' h^2): what displaces it by d in one step. With other
weights of K and M the limit lies at another frequency.
"""

import numpy as np


def modal_filter(system, linear, s, cM):
    """Return the function that filters accelerations (n_q,), along the constraints, for a step.

    ``linear`` holds the factored effective tangent and is to keep it; ``s`` is the state of the masses; cM [1/s^2] is
    their weight in it.
    """
    n_q = system.n_q
    assembly = system.assemble(s, 1.0, 0.0, 0.0, 0.0, 1.0)
    among = (system.rows < n_q) & (system.cols < n_q)
    rows, columns, masses = system.rows[among], system.cols[among], assembly.data[:-1][among]

    def resolved_part(a):
        forces, x = np.zeros(system.n), np.zeros(system.n)
        forces[:n_q] = np.bincount(rows, masses * a[columns], n_q)
        linear.solve_again(cM * forces, x)
        return x[:n_q]

    return resolved_part
