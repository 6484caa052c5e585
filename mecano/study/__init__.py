"""Studies: a deck that is run many times with different values, each case in its own process."""
