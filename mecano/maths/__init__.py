"""Compiled functions on floats and tuples: vectors, rotations, curves, laws, ground profiles."""
