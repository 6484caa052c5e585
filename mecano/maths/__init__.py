"""Compiled functions on numbers and small tuples: vectors, rotations, dual numbers, surfaces, interpolation."""
