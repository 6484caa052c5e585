"""The sparse linear solver and Newton's iteration on it."""
