"""Errors of the syntax of YAML, with what is probably meant: missing spaces, colons, commas, brackets and quotes."""

import re
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    import yaml

    from mecano.deck.compose import Node

GLUED = re.compile(r"\s*([\w$()-]+:)[^\s:]")  # a key and its value without a space between them
UNCOLONED = re.compile(r"\s*([\w$()-]+)\s*=?\s*[{\[]")  # a key and a mapping or list without ':' between them
COMMENT = re.compile(r"\s*(//|/\*|--|!|%|;|\*)")  # of other languages
WITHOUT_COLON = re.compile(r"([\w$]+)(?:\s*=[^:]*|(?:\s+[^:\s]+){0,2})\s*$")
SWALLOWED = re.compile(r"[^\s,\[{]\s+#.*[\]}]")  # a comment that may contain the end of an entry
MOST_LINES = 100  # that are searched
NEAR = 200  # characters on each side of the place, and of other lines, that are searched
SAME_COLUMN = "keys that belong together begin in the same column"


def syntax_error(error: "yaml.MarkedYAMLError") -> str:
    """Return the message of an error of the YAML parser."""
    return "not valid YAML: " + ", ".join(part for part in (error.context, error.problem) if part)


def syntax_hint(error: "yaml.MarkedYAMLError", place: "Node") -> str:
    """Return what is probably meant where the YAML parser stopped, the node ``place``; or ""."""
    line, at, problem, context = place.mark.text, place.column, error.problem or "", error.context or ""
    before, rest, line = line[max(at - NEAR, 0) : at], line[at : at + NEAR], line[:NEAR]
    if rest.startswith("\t"):
        return "indent with spaces, not with tabs"
    if "directive" in context:
        return "comments begin with '#'"
    if rest[:1] in ("%", "@", "`"):
        return "put the text in quotes"
    if "alias" in context and before.strip() == "*":
        return "an item of a list begins with '-', not with '*'"
    if "alias" in context:
        return "'*' begins a reference of YAML; lists have no products: multiply each of their numbers"
    if "quoted scalar" in context and error.context_mark:
        return _of_quotes(error)
    if "flow" in context and error.context_mark:
        return _of_brackets(error, place, before, rest)
    if "expected key" in problem:
        return _of_key(line, before, rest)
    if "mapping values are not allowed" in problem:
        if rest.strip() == ":" and ": " in before:
            return "delete the ':' at the end of the line"
        glued = GLUED.match(before)
        hint = f"write a space after '{glued[1]}'" if glued else ""
        return hint or _of_line_above(place) or f"put a text with ': ' in quotes; {SAME_COLUMN}"
    if "unexpected ':'" in problem:
        return "write a space after ':'"
    if "'-' indicator" in problem:
        return "lines above begin with '-', as items of a list"
    if "expected ':'" in problem:
        return _of_line_above(place)
    return SAME_COLUMN if "document start" in problem else ""


def _of_quotes(error):
    if "decimal number" in error.problem or "escape" in error.problem:
        return "within double quotes a \\ begins an escape; use single quotes"
    return f"the quotation mark in line {error.context_mark.line + 1} is not closed"


def _of_brackets(error, place, before, rest):
    """Return a hint on an error within brackets."""
    opened = error.context_mark.line
    if before.endswith("$") and rest.startswith("{"):
        return "a parameter is written without brackets: $name"
    if re.search(r"[0-9]\s*$", before) and rest.startswith("["):
        return "a unit is written without brackets: 2 kN/m"
    if before.rstrip().endswith(("]", "}")) and rest[:1].isalnum():
        return "write ',' before it; in a list each number has its own unit"
    if re.search(r"\w;\s*\w*\s*$", before):
        return "write ',' instead of ';'"
    if rest.startswith(("[", "{")) and (key := re.search(r"[{,]\s*(\w+)\s*=?\s*$", before)):
        return f"write ': ' after '{key[1]}'"
    if rest.startswith(": ") and (key := re.search(r"\s(\w+)$", before)):
        return f"write ',' before '{key[1]}'"
    if rest.startswith(","):
        return "there is nothing before the ','"
    lines = range(opened, min(place.line, opened + MOST_LINES))
    comment = next((i + 1 for i in lines if SWALLOWED.search(place.source.lines[i][:NEAR])), None)
    also = f"; the '#' in line {comment} begins a comment" if comment else ""
    return f"the bracket opened in line {opened + 1} is not closed before this{also}"


def _of_key(line, before, rest):
    """Return a hint where a key was expected."""
    if glued := GLUED.match(line):
        return f"write a space after '{glued[1]}'"
    if uncoloned := UNCOLONED.match(line):
        return f"write ': ' after '{uncoloned[1]}'"
    if rest.startswith("- "):
        return "an entry of a mapping begins with its name, not with '-'"
    if before.endswith("'") and before.strip() != "'":
        return "within single quotes an apostrophe is written twice"
    return SAME_COLUMN


def _of_line_above(place):
    """Return a hint on the line above the place, if it is a key without its ':' or a comment of another language."""
    numbers = range(place.line - 1, max(place.line - 1 - MOST_LINES, -1), -1)
    number = next((i for i in numbers if place.source.lines[i].strip()), None)
    if number is None:
        return ""
    above = place.source.lines[number].strip()[:NEAR]
    if above.startswith("!include"):
        return f"write 'include: FILE' in line {number + 1}"
    if COMMENT.match(above):
        return f"comments begin with '#', not as in line {number + 1}"
    if glued := GLUED.match(above):
        return f"write a space after '{glued[1]}' in line {number + 1}"
    word = WITHOUT_COLON.match(above)
    return f"write ': ' after '{word[1]}' in line {number + 1}" if word else ""
