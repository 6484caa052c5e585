"""Time integration: the start, steps and their errors, the march over them."""
