"""Texts with positions: strict reading of files, and marks of lines and columns."""

import hashlib
import os
import re
from array import array
from collections.abc import Iterator
from functools import lru_cache
from pathlib import Path

from mecano.errors import DeckError, Mark, Problem
from mecano.immutable import immutable

MAX_BYTES = 64 * 2**20
BLOCK = 2**16  # characters, or more to the end of a line
LINE_END = re.compile("\r\n|[\r\n\x85\u2028\u2029]")  # line ends of YAML
# everything but the printable characters of YAML; the set of these takes ten times as long to compile, 5 ms
FORBIDDEN = re.compile("[\0-\x08\x0b\x0c\x0e-\x1f\x7f-\x84\x86-\x9f\ud800-\udfff\ufeff\ufffe\uffff]")
BYTE_ORDER_MARK = b"\xef\xbb\xbf"
HDF5 = b"\x89HDF\r\n\x1a\n"


@immutable
class Source:
    """A text with the file name shown in messages; the part to be read begins at ``begin``."""

    file: str
    text: str
    begin: int = 0
    stack: tuple[Mark, ...] = ()  # marks of the including file or the place of the template, outermost first

    @property
    def lines(self) -> "Lines":
        """Lines without their ends."""
        return _lines(self.text)

    def each_line(self) -> Iterator[str]:
        """Yield the lines of a text without forbidden characters one by one, keeping few of them at a time."""
        begin = 0
        while begin < len(self.text):
            last = LINE_END.search(self.text, begin + BLOCK)
            end = last.end() if last else len(self.text)
            yield from self.text[begin:end].splitlines()  # its other line ends are forbidden
            begin = end

    def mark(self, line: int, column: int) -> Mark:
        """Return the Mark of a line and column, both counted from 0 after ``begin``; beyond the last line, its end."""
        if line >= len(self.lines):
            line = len(self.lines) - 1
            return Mark(self.file, line + 1, len(self.lines[line]) + 1, self.stack, self.lines[line])
        shift = self.begin if line == 0 else 0
        return Mark(self.file, line + 1, column + shift + 1, self.stack, self.lines[line])

    def mark_at(self, position: int) -> Mark:
        """Return the Mark of a position in the text."""
        before = LINE_END.split(self.text[:position])
        return self.mark(len(before) - 1, len(before[-1]))


class Lines:
    """Lines of a text without their ends, by number; a list of texts would take five times the memory of the text."""

    def __init__(self, text: str):
        self._text, self._begins = text, array("q", [0])
        self._begins.extend(end.end() for end in LINE_END.finditer(text))
        self._last: tuple[int | None, str] = (None, "")  # the last line requested: many errors may share a long one

    def __len__(self):
        return len(self._begins)

    def __getitem__(self, i):
        if i != self._last[0]:
            begin = self._begins[i]  # IndexError ends an iteration
            end = LINE_END.search(self._text, begin)
            self._last = i, self._text[begin : end.start() if end else None]
        return self._last[1]


@lru_cache(maxsize=4)  # the copies of a template share one text
def _lines(text):
    return Lines(text)


class Unreadable(Exception):
    """Error for a file that cannot be opened or is too large, with the reason."""


def is_utf8(path: str | os.PathLike[str]) -> bool:
    """Return False for a path with bytes that are no UTF-8 text, which Python keeps as lone surrogates."""
    try:
        str(path).encode()
    except UnicodeEncodeError:
        return False
    return True


def read_source(path: str | os.PathLike[str], file: str | None = None) -> tuple[Source, str]:
    """Return the Source of a file and the SHA-256 of its bytes; ``file`` is the name to show, by default the path.

    Raises Unreadable, or DeckError if the bytes are not valid UTF-8 text.
    """
    data = read_bytes(path)
    return decoded(data, str(path) if file is None else file), hashlib.sha256(data).hexdigest()


def read_bytes(path: str | os.PathLike[str]) -> bytes:
    """Return the bytes of a file. Raises Unreadable."""
    if not is_utf8(path):
        raise Unreadable("its name is not UTF-8 text")  # results files name it as text
    try:
        if Path(path).exists() and not Path(path).is_file():
            raise Unreadable("it is not a regular file")
        with open(path, "rb") as stream:
            data = stream.read(MAX_BYTES + 1)
    except (OSError, ValueError) as error:
        raise Unreadable(getattr(error, "strerror", None) or str(error)) from None
    if len(data) > MAX_BYTES and not data.startswith(HDF5):
        raise Unreadable(f"it is larger than {MAX_BYTES // 2**20} MiB")
    return data


def decoded(data: bytes, file: str) -> Source:
    """Return the Source of bytes, UTF-8 without control characters; a leading byte order mark is dropped.

    Raises DeckError for other bytes.
    """
    if data.startswith(HDF5):
        text = "this is an HDF5 file, such as the results of a run, not a deck"
        hint = f"`mecano info {file}` names its deck; modes, response and margins about a saved state take "
        hint += f"the deck and --at {file}:TIME, in Python at="
        raise DeckError([Problem(text, Mark(file, 1, 1), hint)])
    data = data.removeprefix(BYTE_ORDER_MARK)
    try:
        source = Source(file, data.decode())
    except UnicodeDecodeError as error:
        source = Source(file, data.decode(errors="replace"))
        mark = source.mark_at(len(data[: error.start].decode(errors="replace")))
        text = f"byte 0x{data[error.start]:02x} is not UTF-8"
        raise DeckError([Problem(text, mark, "save the file as UTF-8")]) from None
    wrong = FORBIDDEN.search(source.text)
    if wrong:
        mark = source.mark_at(wrong.start())
        raise DeckError([Problem(f"character U+{ord(wrong[0]):04X} is not allowed in a deck", mark)])
    return source
