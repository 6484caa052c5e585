"""Diagnostics of models and runs in the words of the deck: constraints, mechanisms, failures, scales."""
