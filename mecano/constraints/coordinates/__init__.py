"""Coordinates of joints: numbers that follow from where nodes are, with their derivatives in closed form."""
