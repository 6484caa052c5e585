"""What is wrong with a model or a run, in the words of the deck: constraints, mechanisms, failures, scales."""
