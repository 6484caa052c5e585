"""The basic constraints of which joints are made."""
