"""Events and shocks: what happens at one instant."""
