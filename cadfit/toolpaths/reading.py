"""Programs read line by line, and the moves they make."""

from __future__ import annotations

from collections.abc import Iterator
from os import PathLike
from pathlib import Path
from typing import IO

from cadfit.toolpaths.machine import Machine, Move
from cadfit.toolpaths.words import Block, parse, refuse

_LONGEST_LINE = 10_000  # characters


def moves(source: str | PathLike[str]) -> Iterator[Move]:
    """Yield the moves of a program of G-code as they are read: lines, and arcs and helices with centre and sweep.

    Places and lengths are in the program's unit. Moves whose place is not known (before the first absolute ones, or
    after words that are not followed) are left out. Raises ValueError naming the line, as `refit` does.
    """
    machine = Machine()
    with Path(source).open("rb") as program:
        for block in blocks(program):
            if machine.ended:
                continue
            move = machine.step(block)
            if move is not None:
                yield move


def blocks(program: IO[bytes]) -> Iterator[Block]:
    """Yield the lines of a program; one that % opens must be closed by another."""
    marks, line = 0, 0
    while raw := program.readline(_LONGEST_LINE):
        line += 1
        if len(raw) == _LONGEST_LINE:
            refuse(line, f"longer than {_LONGEST_LINE} characters: is this a file of G-code?")
        block = parse(line, raw.decode("utf-8", "surrogateescape"))
        if block.opaque and block.text.lstrip().startswith("%"):
            marks += 1
        yield block
    if not line:
        refuse(1, "the file is empty")
    if marks == 1:
        refuse(line, "the file begins with % and does not end with it: it is cut short")
