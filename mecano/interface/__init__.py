"""What Python programs and notebooks call: `mecano.run`, `mecano.Deck` and the other names of `dir(mecano)`."""
