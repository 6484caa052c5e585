"""Time integration: consistent starts, steps and their errors, the loop over the steps."""
