"""Whole numbers, each once."""

import numpy as np


def distinct(numbers):
    """The numbers (n,) of an array, which is sorted in place, each once and ascending, as numpy.unique.

    That goes through a hash table, which takes ten times as long for the few numbers of a block of a matrix as well as
    for the millions of a pattern.
    """
    numbers.sort()
    first = np.ones(len(numbers), bool)
    first[1:] = numbers[1:] != numbers[:-1]
    return numbers[first]
