"""A program in Heidenhain's plain language: its splines are part of that alone, so every line is put into it.

Source: HEIDENHAIN, User's Manual Conversational Programming iTNC 530 (606 42x-04), 12.7 Spline interpolation, for SPL;
its chapters on path contours for L, CC, C, TOOL CALL and M.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from cadfit.bezier import Array
from cadfit.toolpaths.cuts import Cut
from cadfit.toolpaths.machine import Move
from cadfit.toolpaths.runs import Run, Toolpath
from cadfit.toolpaths.words import Block, refuse
from cadfit.toolpaths.writing import State, number, whole

_SAME = {17, 20, 21, 40, 49, 80, 90, 91, 94, 90.1, 91.1}  # what holds there anyway, or is taken into account
_MOVES = {0, 1, 2, 3}


@dataclass(slots=True)
class Klartext:
    """Writes a program block by block; refuses what has no counterpart, by its line."""

    block: int = 0
    name: str = "PART"
    inches: bool = False
    begun: bool = False
    feed: float | None = None

    def untouched(self, block: Block, move: Move | None, before: State, after: State) -> list[str]:
        """Return the blocks that do what a line of G-code does."""
        named = dict(block.words)
        codes = [value for letter, value in block.words if letter == "G"]
        if not self.begun and "O" in named:
            self.name = f"O{whole(named['O'])}"
        comment = [f"; {block.comment.strip('();')}"] if block.comment else []
        if block.opaque or block.skippable:
            if block.text.lstrip().startswith("%"):
                return []
            refuse(block.line, f"{block.text.strip()[:40]!r} has no counterpart in Heidenhain's plain language")
        strange = [f"G{code:g}" for code in codes if code not in _SAME | _MOVES]
        strange += [letter for letter, _ in block.words if letter not in "GNOXYZIJKRFSMT"]
        if strange:
            refuse(block.line, f"{strange[0]} has no counterpart in Heidenhain's plain language")
        if 20 in codes or 21 in codes:
            if self.begun and self.inches != (20 in codes):
                refuse(block.line, "the unit is set after the first block: it holds for a whole program there")
            self.inches = 20 in codes
        return self._numbered([*comment, *self._said(block, named, move, after)])

    def lines(self, run: Run, path: Toolpath, cuts: list[Cut], decimals: int) -> list[str]:
        """Return the blocks of the moves that replace a run."""
        here, found = run.moves[0].start, []
        for k, cut in enumerate(cuts):
            exact = k == len(cuts) - 1
            ends = _place(cut.end, here, decimals, exact)
            feed = self._feed(run.moves[0].feed)
            if cut.poles is None:
                found.append(f"L {ends}{feed}")
            else:
                moving = [a for a in range(3) if not (cut.poles[:, a] == cut.poles[0, a]).all()]
                ends = " ".join("XYZ"[a] + _signed(cut.end[a], decimals, exact) for a in moving)
                found.append(" ~\n".join([f"SPL {ends}", *(_cubic("XYZ"[a], cut.poles[:, a]) for a in moving)]) + feed)
            here = cut.end
        return self._numbered(found)

    def finished(self) -> list[str]:
        """Return the last block."""
        return self._numbered([f"END PGM {self.name} {self._unit}"])

    @property
    def _unit(self) -> str:
        return "INCH" if self.inches else "MM"

    def _numbered(self, blocks: list[str]) -> list[str]:
        if blocks and not self.begun:
            self.begun = True
            blocks = [f"BEGIN PGM {self.name} {self._unit}", *blocks]
        found = []
        for block in blocks:
            found.append(f"{self.block} {block}\n")
            self.block += 1
        return found

    def _said(self, block: Block, named: dict[str, float], move: Move | None, after: State) -> list[str]:
        """Return the blocks of a line's tool, spindle, move and M-codes."""
        found = []
        if "T" in named or "S" in named:
            tool = f" {whole(named['T'])} Z" if "T" in named else ""
            found.append(f"TOOL CALL{tool}" + (f" S{whole(named['S'])}" if "S" in named else ""))
        if any(letter in named for letter in "XYZIJKR"):
            found += self._move(block, move, after)
        return found + [f"M{whole(value)}" for letter, value in block.words if letter == "M"]

    def _move(self, block: Block, move: Move | None, after: State) -> list[str]:
        motion, plane = after
        if move is None:
            if motion not in (0, 1) or any(letter == "G" and value == 91 for letter, value in block.words):
                refuse(block.line, "where this move begins is not known")
            words = [letter + _signed(value, 9, False) for letter, value in block.words if letter in "XYZ"]
            told = next((value for letter, value in block.words if letter == "F"), self.feed)
            return [f"L {' '.join(words)}" + (" FMAX" if motion == 0 else self._feed(told))]
        feed = " FMAX" if move.motion == 0 else self._feed(move.feed)
        if move.arc is None:
            return [f"L {_place(move.end, move.start, 9, False)}{feed}"]
        if plane != 17 or move.end[2] != move.start[2]:
            refuse(block.line, "arcs out of the plane of X and Y, and helices, are not put into plain language")
        x, y = move.arc.centre
        turn = "+" if move.arc.sweep > 0.0 else "-"
        end = f"X{_signed(move.end[0], 9, False)} Y{_signed(move.end[1], 9, False)}"
        return [f"CC X{_signed(x, 9, False)} Y{_signed(y, 9, False)}", f"C {end} DR{turn}{feed}"]

    def _feed(self, feed: float | None) -> str:
        if feed is None or feed == self.feed:
            return ""
        self.feed = feed
        return f" F{whole(feed)}"


def _signed(value: float, decimals: int, exact: bool) -> str:
    text = number(value, decimals, exact).rstrip(".")
    return text if text.startswith("-") else f"+{text}"


def _place(end: tuple[float, ...], here: tuple[float, ...], decimals: int, exact: bool) -> str:
    moved = [k for k in range(3) if end[k] != here[k]] or [0]
    return " ".join("XYZ"[k] + _signed(end[k], decimals, exact) for k in moved)


def _cubic(axis: str, poles: Array) -> str:
    """Return the coefficients for an axis: of a parameter that runs from 1 to 0, so that the end is the constant."""
    start, leaving, arriving, end = (float(value) for value in poles)
    first, square = 3.0 * (arriving - end), 3.0 * (end - 2.0 * arriving + leaving)
    cube = start - end - first - square
    return " ".join(
        f"{name}{axis}{_coefficient(value)}" for name, value in (("K3", cube), ("K2", square), ("K1", first))
    )


def _coefficient(value: float) -> str:
    """Return a coefficient, below 10 with eight decimals, else with an exponent.

    >>> _coefficient(-0.25), _coefficient(123.5)
    ('-0.25', '+1.235E+2')
    """
    if abs(value) < 9.99999999:
        return _signed(value, 8, False)
    exponent = int(np.floor(np.log10(abs(value))))
    return f"{_signed(value / 10.0**exponent, 8, False)}E+{exponent}"
