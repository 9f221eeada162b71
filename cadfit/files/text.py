"""Points as text: .csv, .txt, .xyz, .dat, as spreadsheets, loggers, scanners and airfoil collections write them.

A row has 2 to 8 numbers apart by semicolons, commas, or blanks and tabs; the first row decides. Where the comma does
not part the numbers, or is within quotes, it is the decimal point ("1,5;2,5"). Exponents may be Fortran's ("1.0D-03").
Blank lines, those of separators alone as spreadsheets leave them, comments (# anywhere, % or // at the start of a line)
and lines of text above the first row are passed over; a separator at the end of a line is too. A first line with one
whole number is the count of the rows, with or without a comment line below it (.xyz); element symbols in front of the
rows of an .xyz file are taken off. For airfoils see `cadfit.files.airfoil`.

Nothing else is passed over: a row that is not like the first is an error, with its line.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path

import numpy as np

from cadfit.bezier import Array
from cadfit.files.airfoil import from_lednicer
from cadfit.files.curves import Curves
from cadfit.files.table import as_table
from cadfit.stages import Progress, unheard

_BLOCK = 1 << 16  # rows between two reports of progress

Lines = list[tuple[int, str]]  # the line's number in the file, from 1, and what is on it

_NUMBER = re.compile(r"[+-]?((\d+\.?\d*|\.\d+)([eEdD][+-]?\d+)?|inf|infinity|nan)", re.ASCII | re.IGNORECASE)
_MISSING = {"na", "n/a", "null", "none"}  # words for no number, never the names of columns
_FIGURES = re.compile(r"(?=\D*\d)[\W\d_]+")  # digits and signs, no letters
_QUOTED = re.compile(r'"([^"]*)"')
_CONTROL = re.compile(rb"[\x00-\x08\x0e-\x19\x1b-\x1f]")


def read(path: Path, unit: str, progress: Progress = unheard) -> Array:
    """Return the points (n, d) of a text file.

    Raises ValueError with the file, the line (from 1) and its text: a cell that is not a number or not finite, rows
    of different lengths, no rows at all, a count that is not the number of rows, bytes that are not text.
    """
    suffix = path.suffix.lower()
    raw = _text(path).replace("\r\n", "\n").replace("\r", "\n").split("\n")
    lines = [
        (k, line)
        for k, whole in enumerate(raw, 1)
        if (line := _unquoted(whole.split("#", 1)[0]).strip()).strip(",; \t") and not line.startswith(("%", "//"))
    ]
    try:
        rows = _below_head(lines, suffix)
        table = _table(rows, progress)
        if suffix == ".dat" or (suffix == ".txt" and len(rows) < len(lines)):
            table = from_lednicer(table, [k for k, _ in rows])
    except _BadLine as bad:
        raise ValueError(f"{path}: line {bad.line}: {bad} in {_short(raw[bad.line - 1])}") from None
    except ValueError as error:
        raise ValueError(f"{path}: {error}") from None
    return as_table(table, str(path))


def write(path: Path, result: Array | Curves, unit: str, progress: Progress = unheard) -> None:
    """Write points (n, d), or the poles of curves, one a row: .csv with commas and names, others with blanks.

    Numbers by repr, so they read back bit for bit; the poles of several curves are apart by a blank line.
    """
    blocks = [curve.poles for curve in result.curves] if isinstance(result, Curves) else [result]
    separator = "," if path.suffix.lower() == ".csv" else " "
    with path.open("w", encoding="utf-8", newline="\n") as file:
        if separator == ",":
            d = blocks[0].shape[1]
            file.write(",".join("xyz"[:d] if d <= 3 else (f"x{k + 1}" for k in range(d))) + "\n")
        for k, block in enumerate(blocks):
            file.write("\n" * (k > 0))
            for start in range(0, len(block), _BLOCK):
                progress((k + start / len(block)) / len(blocks))
                rows = block[start : start + _BLOCK].tolist()
                file.writelines(separator.join(map(repr, row)) + "\n" for row in rows)


def names(path: Path) -> list[str]:
    """Return the names of a text file's columns: the line above its numbers where that has a name for each; else none.

    >>> import tempfile
    >>> path = Path(tempfile.mkdtemp()) / "a.csv"
    >>> _ = path.write_text("x, y, z, r\\n0, 0, 0, 1\\n")
    >>> names(path)
    ['x', 'y', 'z', 'r']
    """
    lines = [line.strip().lstrip("#%/").strip() for line in _text(path).splitlines()]
    lines = [line for line in lines if line]
    first = next((k for k, line in enumerate(lines) if _separator(line) != ""), 0)
    if first == 0:
        return []
    separator = _separator(lines[first])
    found = [cell.strip(' \t"') for cell in lines[first - 1].split(separator)]
    return found if len(found) == len(_cells(lines[first], separator)) else []


class _BadLine(ValueError):
    """What is wrong with one line, and which it is."""

    def __init__(self, line: int, what: str) -> None:
        super().__init__(what)
        self.line = line


def _text(path: Path) -> str:
    data = path.read_bytes()
    if data.startswith((b"\xff\xfe", b"\xfe\xff")):  # how spreadsheets save "Unicode text"
        return data.decode("utf-16", errors="replace")
    if _CONTROL.search(data):
        raise ValueError(f"{path}: not a text file")
    data = data.rstrip(b"\x1a")  # the end-of-file mark of DOS
    try:
        return data.decode("utf-8-sig")
    except UnicodeDecodeError:
        return data.decode("latin-1")  # names and comments only: numbers are ASCII


def _unquoted(line: str) -> str:
    """Take the quotes off the cells of a line; a comma within does not part them."""
    return _QUOTED.sub(lambda cell: cell[1].replace(",", "."), line) if '"' in line else line


def _below_head(lines: Lines, suffix: str) -> Lines:
    """Return the rows of numbers: the lines below a count and lines of text."""
    if len(lines) > 1 and lines[0][1].isdecimal() and not lines[-1][1].isdecimal():
        (line, count), *lines = lines
        more = len(lines) - int(count)
        comment, lines = lines[: more == 1], lines[more == 1 :]  # one line more is the comment
        first = lines[0][1]
        lost = any(_are_alike(text, first) for _, text in comment)  # it may be a row, and the count wrong
        if more not in (0, 1) or lost or not (_separator(first) != "" or _is_element_row(first)):
            raise _BadLine(line, "a count that is not the number of rows below,")
    if suffix == ".xyz" and lines and _is_element_row(lines[0][1]):
        return _without_symbols(lines)
    return _below_text(lines, suffix)


def _below_text(lines: Lines, suffix: str) -> Lines:
    """Return the rows of numbers below names, titles and units; raise where a line of text may well be a row."""
    separators = (_separator(text) for _, text in lines)
    start, separator = next(((i, s) for i, s in enumerate(separators) if s != ""), (len(lines), None))
    width = len(_cells(lines[start][1], separator)) if start < len(lines) else 0
    for i, (line, text) in enumerate(lines[:start]):
        if text[0] in ",;":
            raise _BadLine(line, "the first column has no name: row numbers, not a coordinate?")
        cells = _cells(text, separator)
        if _are_numbers(cells):
            raise _BadLine(line, "a single number, where points have 2 to 8,")
        # The name of an airfoil may well have a number in it: "NACA 2412".
        is_name = i == 0 and suffix in (".dat", ".txt") and separator is None and not _NUMBER.fullmatch(cells[0])
        # Thousands parted, or a minus that is no hyphen: no names, where there is one for each column.
        is_row = len(cells) == width and all(map(_FIGURES.fullmatch, cells))
        missing = all(cell.lower() in _MISSING for cell in cells)
        if missing or is_row or (any(map(_NUMBER.fullmatch, cells)) and not is_name):
            bad = next(cell for cell in cells if not _NUMBER.fullmatch(cell))
            raise _BadLine(line, f"{bad!r} is not a number")
    if start == len(lines):
        last = f": line {lines[-1][0]} is {_short(lines[-1][1])}" if lines else ""
        raise ValueError(f"no rows of numbers in it{last}")
    return lines[start:]


def _table(lines: Lines, progress: Progress) -> Array:
    """Return the rows of numbers (n, d)."""
    separator = _separator(lines[0][1])
    if separator is None or separator == ";":
        lines = [(k, line.replace(",", ".")) for k, line in lines]
    try:
        table = np.concatenate([*_blocks(lines, separator, progress)])
    except ValueError:  # something is wrong, or written in a way numpy does not know
        width = len(_cells(lines[0][1], separator))
        table = np.array([_row(k, line, separator, width) for k, line in lines])
    finite = np.isfinite(table).all(axis=1)
    if not finite.all():
        raise _BadLine(lines[int(np.argmin(finite))][0], "a number that is not finite")
    return table


def _blocks(lines: Lines, separator: str | None, progress: Progress) -> Iterator[Array]:
    for start in range(0, len(lines), _BLOCK):
        progress(start / len(lines))
        rows = [line.rstrip(separator) for _, line in lines[start : start + _BLOCK]]
        yield np.loadtxt(rows, delimiter=separator, comments=None, ndmin=2)


def _row(k: int, line: str, separator: str | None, width: int) -> list[float]:
    """Read one row cell by cell, and say what is wrong with it."""
    cells = _cells(line, separator)
    for cell in cells:
        if not _NUMBER.fullmatch(cell):
            raise _BadLine(k, f"{cell!r} is not a number" if cell else "an empty cell")
    if len(cells) != width:
        raise _BadLine(k, f"{len(cells)} number{'s'[: len(cells) != 1]}, not {width} as in the first row,")
    return [float(re.sub("[dD]", "e", cell)) for cell in cells]


def _separator(line: str) -> str | None:
    """Return what parts the numbers of a row: ";", ",", or None for blanks and tabs; "" where it is no row."""
    for separator in (";", ",", None):
        cells = _cells(line, separator)
        if len(cells) > 1 and _are_numbers(cells):
            return separator
    return ""


def _cells(line: str, separator: str | None) -> list[str]:
    if separator != ",":
        line = line.replace(",", ".")
    return [cell.strip(' \t"') for cell in line.rstrip(separator).split(separator)]


def _are_numbers(cells: list[str]) -> bool:
    return all(map(_NUMBER.fullmatch, cells))


def _are_alike(line: str, other: str) -> bool:
    """Return whether both are rows of as many numbers, parted alike."""
    separator = _separator(line)
    return "" != separator == _separator(other) and len(_cells(line, separator)) == len(_cells(other, separator))


def _is_element_row(line: str) -> bool:
    symbol, *cells = line.split()
    return symbol.isalnum() and symbol[0].isalpha() and len(cells) > 1 and _are_numbers(cells)


def _without_symbols(lines: Lines) -> Lines:
    for k, line in lines:
        if not _is_element_row(line):
            raise _BadLine(k, "no element symbol and numbers, as in the first row,")
    return [(k, line.split(None, 1)[1]) for k, line in lines]


def _short(text: str) -> str:
    return repr(text if len(text) <= 60 else f"{text[:60]}...")
