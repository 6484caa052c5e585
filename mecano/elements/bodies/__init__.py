"""Bodies: point masses, rigid bodies and links, reduced parts."""
