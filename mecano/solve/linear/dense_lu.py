"""LU with partial pivoting of full matrices by LAPACK, called from compiled code."""

import ctypes

from scipy.linalg import cython_lapack

from mecano.jit.entry import Records, entry
from mecano.jit.memory import call_with, floats
from mecano.model.loop_records import fields

# Addresses of the functions of LAPACK and of their arguments, and the number of floats in the matrix
LU = fields(words="getrf getrs transposed n n_right values n_values factors exchanges outcome right solved")


@entry
def factor_dense(matrix: Records(LU)):
    """Factor the matrix; ``outcome`` is zero if no pivot is zero; one that is not finite may pass."""
    m = matrix[0]
    values, lu = floats(m.values, m.n_values), floats(m.factors, m.n_values)
    for i in range(m.n_values):
        lu[i] = values[i]
    call_with(m.getrf, (m.n, m.n, m.factors, m.n, m.exchanges, m.outcome))


@entry
def solve_dense(matrix: Records(LU)):
    """Solve A x = b with the factors; b becomes x."""
    m = matrix[0]
    call_with(m.getrs, (m.transposed, m.n, m.n_right, m.factors, m.n, m.exchanges, m.right, m.n, m.solved))


def of_lapack(name: str) -> int:
    """Return the address of a function of LAPACK, whose arguments are all addresses."""
    capsule, get_name = cython_lapack.__pyx_capi__[name], ctypes.pythonapi.PyCapsule_GetName
    get_name.restype, get_name.argtypes = ctypes.c_char_p, [ctypes.py_object]
    get = ctypes.pythonapi.PyCapsule_GetPointer
    get.restype, get.argtypes = ctypes.c_void_p, [ctypes.py_object, ctypes.c_char_p]
    return get(capsule, get_name(capsule))
