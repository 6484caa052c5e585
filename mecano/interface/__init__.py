"""The interface for Python programs and notebooks: `mecano.run`, `mecano.Deck` and the other names of `dir(mecano)`."""
