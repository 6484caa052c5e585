"""Wheels, from rigid rolling to slipping tyres, and the laws of their tyres."""
