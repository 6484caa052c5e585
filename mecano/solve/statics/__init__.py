"""Equilibria: one point, paths of them, their stability."""
