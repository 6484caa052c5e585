"""Sections and keys that are expanded before the check: ``include``, ``set``, ``templates``, ``place``, ``repeat``."""

from mecano.deck.templates import PLACE
from mecano.schema import Field, Type, named

FILES = Type("files", "the name of a file, or a list of names")
SETTINGS = Type("settings", "a mapping of paths in the deck to values, as in --set", schema={"type": "object"})
TEMPLATE = Type("template", "a mapping of 'parameters' with their defaults, 'place', and sections of names")
REPEAT = Field(
    "repeat", Type("repeat", "names with ranges or lists, or a list of rows"), "-",
    "in any named entry: one copy for each value, inserted into its name: post$i, post$(i+1); in a list: copies of "
    "'items'", None,
)  # fmt: skip
EXPANDED_SECTIONS = (
    Field(
        "include", FILES, "-", "files in the folder of the deck, or below it, whose sections are added to the deck", ()
    ),
    Field(
        "set", SETTINGS, "-", "values by their paths, as in --set, which replace those of included files: a variant", {}
    ),
    Field("templates", named(TEMPLATE), "-", "parts that are placed by 'place', each a small deck", {}),
    PLACE,
)  # fmt: skip
