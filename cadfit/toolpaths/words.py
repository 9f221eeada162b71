"""Lines of G-code: words (a letter and a number), comments, numbers of lines, blocks that may be skipped."""

from __future__ import annotations

import re
from typing import NamedTuple, NoReturn

_WORD = re.compile(r"([A-Z])([+-]?(?:\d+\.?\d*|\.\d+))")
_WORDS = re.compile(r"(?:[A-Z][+-]?(?:\d+\.?\d*|\.\d+))*")
_CONTROL = re.compile(r"[\x00-\x08\x0b-\x1f\x7f]")
_EXPONENT = re.compile(r"[\d.]+[eE][+-]?\d+")
_MACRO = re.compile(r"[#\[\]]|^(?:O|IF|WHILE|GOTO|END|DO)\d*(?=[A-Z<\[#])")
_BLANKS = str.maketrans("", "", " \t")
_COORDINATES = frozenset("XYZABCUVWEIJKR")
_FARTHEST = 1e6  # no machine travels farther, in millimetres or inches
_LARGEST = 1e15  # of any number

# Commands of printers' firmware that are a name and settings; none of these moves the tool or sets a mode.
_NAMED = (
    "EXCLUDE_OBJECT",
    "SET_PRESSURE_ADVANCE",
    "SET_VELOCITY_LIMIT",
    "SET_PRINT_STATS_INFO",
    "SET_FAN_SPEED",
    "TIMELAPSE_TAKE_FRAME",
)


class Block(NamedTuple):
    """One line: its number, its text as it was, its words, its comment (with the brackets), and whether it has a `/`.

    `opaque`: it holds something beside words, and is to be left alone.
    """

    line: int
    text: str
    words: tuple[tuple[str, float], ...]
    comment: str = ""
    skippable: bool = False
    opaque: bool = False


def refuse(line: int, reason: str) -> NoReturn:
    """Raise the ValueError that names a line and says what is wrong there."""
    raise ValueError(f"line {line}: {reason}")


def parse(line: int, text: str) -> Block:
    """Return the words of a line of G-code; `line` is its number, `text` may end with the line's end.

    Blanks between and within words do not count, nor does the case of letters. Raises ValueError naming the line: for
    what is no word, a comment that is not closed, bytes that are no text, a word given twice, a coordinate beyond 1e6,
    and macros (O-words, variables, expressions), whose course cannot be followed.
    Source: LinuxCNC's description of the RS274/NGC language; NIST IR 6556, The NIST RS274NGC Interpreter, 2000.

    >>> parse(7, "N70 g1 x1. y -.5 (to the edge)")[2:4]
    ((('N', 70.0), ('G', 1.0), ('X', 1.0), ('Y', -0.5)), '(to the edge)')
    """
    body = text.strip()
    if not body:
        return Block(line, text, ())
    if (control := _CONTROL.search(body)) is not None:
        refuse(line, f"the byte 0x{ord(control.group()):02x} is no text: is this a file of G-code?")
    code, comment = (body, "") if ";" not in body and "(" not in body else _comment(line, body)
    if not code:
        return Block(line, text, (), comment)
    if code[0] == "%":
        return Block(line, text, (), comment, opaque=True)
    if skippable := code[0] == "/":
        code = code[1:].lstrip("0123456789")
    compact = code.translate(_BLANKS).upper()
    if _WORDS.fullmatch(compact) is None:
        return _other(line, text, code, compact, comment, skippable)
    if "E" in compact and " " in code and _EXPONENT.search(code):
        refuse(line, f"{_EXPONENT.search(code).group()!r} has an exponent, which G-code's numbers do not have")  # type: ignore[union-attr]
    words = tuple([(letter, float(value)) for letter, value in _WORD.findall(compact)])
    _check(line, words)
    return Block(line, text, words, comment, skippable)


def _comment(line: int, body: str) -> tuple[str, str]:
    """Return a line without its comments, and the comments."""
    code: list[str] = []
    comment: list[str] = []
    depth = 0
    for k, letter in enumerate(body):
        if letter == ";" and depth == 0:
            comment.append(body[k:])
            break
        depth += letter == "("
        (comment if depth else code).append(letter)
        depth -= letter == ")" and depth > 0
    if depth:
        refuse(line, "a comment is opened with ( and not closed")
    return "".join(code).strip(), "".join(comment)


def _other(line: int, text: str, code: str, compact: str, comment: str, skippable: bool) -> Block:
    """Take a line that is not words alone: text that an M-code takes, or a named command; else refuse it."""
    if compact.startswith(_NAMED):
        return Block(line, text, (), comment, skippable, opaque=True)
    if _MACRO.search(compact):
        refuse(
            line, f"{code.strip()[:40]!r} is a macro (a variable, an expression or an O-word), which is not followed"
        )
    if (told := re.match(r"(?:N\d+)?M(\d+)", compact)) is not None:
        return Block(line, text, (("M", float(told.group(1))),), comment, skippable, opaque=True)
    if "*" in compact and _WORDS.fullmatch(compact[: compact.rindex("*")]):  # a printer's checksum
        words = tuple((letter, float(value)) for letter, value in _WORD.findall(compact[: compact.rindex("*")]))
        _check(line, words)
        return Block(line, text, words, comment, skippable, opaque=True)
    bad = compact[_WORDS.match(compact).end() :]  # type: ignore[union-attr]
    if re.match(r"[A-Z][+-]?(?![\d.])", bad) and not re.match(r"[A-Z]{2}", bad):
        refuse(line, f"the word {bad[0]} has no number in {code.strip()[:40]!r}")
    refuse(line, f"{code.strip()[:40]!r} is not G-code: letters, each with a number, were expected")


def _check(line: int, words: tuple[tuple[str, float], ...]) -> None:
    """Refuse words that stand twice, coordinates that no machine reaches, and numbers that are none."""
    seen = ""
    for letter, value in words:
        if letter in _COORDINATES and not -_FARTHEST <= value <= _FARTHEST:
            refuse(line, f"{letter}{value:g} is beyond {_FARTHEST:g}, farther than any machine travels")
        if abs(value) > _LARGEST:
            refuse(line, f"the number of {letter} is beyond {_LARGEST:g}")
        if letter in seen and letter not in "GM":
            refuse(line, f"the word {letter} stands twice")
        seen += letter
