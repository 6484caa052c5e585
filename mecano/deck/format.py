"""Problems of a deck as text: position, message, the line and a caret."""

from mecano.errors import DeckError, Problem

MAX_PRINTED = 50
WINDOW = 100  # characters shown of a long line
CUT = "…"  # replaces the first or last character shown if the line continues there


def problem_text(problem: Problem, others: int = 0) -> str:
    """Return one problem as lines: ``file:line:column: message; hint``, the line of the deck, a caret.

    ``others`` is the number of further copies of the same entry with the same problem.
    """
    hint = f"; {problem.hint}" if problem.hint else ""
    if problem.mark is None:
        return f"{problem.message}{hint}"
    lines = [f"{problem.mark}: {problem.message}{hint}"]
    if others:
        lines[0] += f" (and {others} {'copy' if others == 1 else 'copies'} of it)"
    if problem.mark.text.strip():
        lines += _line_and_caret(problem.mark)
    lines += [f"  {outer.role} {outer}" for outer in reversed(problem.mark.stack)]
    return "\n".join(lines)


def _line_and_caret(mark):
    column = mark.column - 1
    begin = max(0, column - WINDOW // 2) if column > WINDOW - 10 else 0
    text = mark.text.rstrip()
    line = text[begin : begin + WINDOW].replace("\t", " ")
    line = "".join(c if c.isprintable() else "?" for c in line)
    line = CUT + line[1:] if begin else line
    line = line[:-1] + CUT if begin + WINDOW < len(text) else line
    return [f"    {line}", "    " + " " * (column - begin) + "^"]


def deck_error_text(error: DeckError) -> str:
    """Return the first problems of a DeckError, sorted by position, and the number of all; copies count once."""
    copies: dict[tuple[tuple[str, int, int], str], list[Problem]] = {}
    for problem in sorted(error.problems, key=_place):
        copies.setdefault((_place(problem), problem.message.partition(": ")[2] or problem.message), []).append(problem)
    parts = [problem_text(same[0], len(same) - 1) for same in list(copies.values())[:MAX_PRINTED]]
    count = len(copies)
    total = "1 error" if count == 1 else f"{count} errors"
    fixed = "this error is" if count == 1 else "these errors are"
    further = f"; {error.unchecked} once {fixed} fixed" if error.unchecked else ""
    parts.append((total if count <= MAX_PRINTED else f"and {count - MAX_PRINTED} more; {total}") + further)
    return "\n".join(parts)


def _place(problem):
    mark = problem.mark
    return (mark.file, mark.line, mark.column) if mark else ("", 0, 0)
