"""Distinct numbers of an array, by sorting it in place."""

import numpy as np


def distinct(numbers: np.ndarray) -> np.ndarray:
    """Return the unique values of an array (n,) in ascending order, like numpy.unique; sorts the array in place.

    numpy.unique uses a hash table, which takes ten times as long, both for the few numbers of a block of a matrix and
    for the millions of a sparsity pattern.
    """
    numbers.sort()
    first = np.ones(len(numbers), bool)
    first[1:] = numbers[1:] != numbers[:-1]
    return numbers[first]
