"""Studies: a deck that is run many times with other values, each case as a process of its own."""
