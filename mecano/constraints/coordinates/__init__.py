"""Coordinates of joints: functions of the positions and rotations of nodes, with derivatives in closed form."""
