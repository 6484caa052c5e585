"""Events and shocks: their location in time, changes of phase, impacts."""
