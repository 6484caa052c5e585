"""Wheels, from rigid rolling to tyres that slip, and the laws of their tyres."""
