"""The lines of fitted moves, in the words, modes and manner of the program around them."""

from __future__ import annotations

from dataclasses import dataclass
from math import ceil

import numpy as np

from cadfit.bezier import Array
from cadfit.toolpaths.cuts import Cut
from cadfit.toolpaths.machine import PLANES, Move, Place
from cadfit.toolpaths.pieces import Piece
from cadfit.toolpaths.runs import Run, Toolpath
from cadfit.toolpaths.splines import coefficients
from cadfit.toolpaths.words import Block

_OFFSETS = ("IJ", "KI", "JK")
_MOST_DIGITS = 9
_EXTRUDER_DIGITS = 5

State = tuple[int | None, int]  # motion and plane


def number(value: float, decimals: int, exact: bool = False) -> str:
    """Return a number with a decimal point (some controllers count whole numbers in ticks) and no idle zeros.

    >>> number(10.0, 3), number(-0.00004, 3), number(1.23456, 3), number(1.23456, 3, exact=True)
    ('10.', '0.', '1.235', '1.23456')
    """
    text = f"{value:.{decimals}f}"
    while exact and decimals < _MOST_DIGITS and abs(float(text) - value) > 1e-10:
        decimals += 1
        text = f"{value:.{decimals}f}"
    text = text.rstrip("0") if decimals else f"{text}."
    return "0." if text in ("-0.", "-.", ".") else text


def whole(value: float) -> str:
    """Return the number of a line, a feed or a speed in full, without an idle point.

    >>> whole(1234570.0), whole(1234.56789), whole(0.00001)
    ('1234570', '1234.56789', '0.00001')
    """
    return number(value, _MOST_DIGITS).rstrip(".")


def end_of_line(text: str) -> str:
    """Return what ends a line."""
    return text[len(text.rstrip("\r\n")) :] or "\n"


@dataclass(slots=True)
class Writer:
    """Keeps what the written program has set, which may differ from the original's while moves are replaced."""

    curve: int | str = 5  # the word of cubic pieces
    motion: int | str | None = None
    plane: int = 17

    def restored(self, motion: int | None, plane: int, block: Block) -> str:
        """Return the words needed before an untouched line, for it to find these modes as they were; or nothing.

        A mode that the line sets itself is not set before it.
        """
        words = []
        codes = [value for letter, value in block.words if letter == "G"]
        if self.plane != plane and not any(code in PLANES for code in codes):
            words.append(f"G{plane}")
        if self.motion != motion and motion is not None and not any(code in (0, 1, 2, 3) for code in codes):
            words.append(f"G{motion}")
        self.motion, self.plane = motion, plane
        return " ".join(words)

    def untouched(self, block: Block, move: Move | None, before: State, after: State) -> list[str]:
        """Return a line as it was, after what it needs; `before` and `after` it: the original's motion and plane."""
        if not block.words:
            return [block.text]
        needed = self.restored(*before, block)
        self.motion, self.plane = after
        return [needed + end_of_line(block.text), block.text] if needed else [block.text]

    def finished(self) -> list[str]:
        """Return what the end of the program needs."""
        return []

    def lines(self, run: Run, path: Toolpath, cuts: list[Cut], decimals: int) -> list[str]:
        """Return the lines of the moves that replace a run."""
        blocks, first = run.blocks, run.blocks[0]
        code = first.text.split(";")[0].split("(")[0].strip()
        gap = " " if " " in code else ""
        explicit = all(any(letter == "G" for letter, _ in block.words) for block in blocks)
        feed = next((value for letter, value in first.words if letter == "F"), None)
        numbers = _numbers(blocks, cuts, path)
        extruded = np.interp([cut.at for cut in cuts], np.arange(len(path.points)), path.extruded).tolist()
        here, modes, done, lines = run.moves[0].start, run.modes, 0.0, []
        for k, cut in enumerate(cuts):
            words = self._motion(cut, explicit)
            exact = k == len(cuts) - 1
            here, said = self._place(here, cut, modes.absolute, decimals, exact)
            words += said
            if cut.poles is not None:
                words += self._curve(cut.poles, decimals, exact)
            elif cut.piece is not None and cut.piece.centre is not None:
                words += self._centre(cut.piece, cut.plane, modes.centres_absolute, decimals)
            if run.extruded:
                value = run.extruder + extruded[k] if modes.extruder_absolute else extruded[k] - done
                text = number(value, _EXTRUDER_DIGITS, exact)
                done += float(text) if not modes.extruder_absolute else 0.0
                words.append(f"E{text}")
            if k == 0 and feed is not None:
                words.append(f"F{whole(feed)}")
            head = [f"N{whole(numbers[k])}"] if numbers else []
            comment = f" {first.comment}" if first.comment else ""
            lines.append(gap.join(head + words) + comment + end_of_line(first.text))
        return lines

    def _motion(self, cut: Cut, explicit: bool) -> list[str]:
        words = []
        motion: int | str = 1
        if cut.poles is not None:
            motion = self.curve
        elif cut.piece is not None and cut.piece.centre is not None:
            motion = 3 if cut.piece.sweep > 0.0 else 2
        if motion != 1 and cut.plane and cut.plane != self.plane:
            self.plane = cut.plane
            words.append(f"G{cut.plane}")
        if explicit or motion != self.motion or words:
            self.motion = motion
            words.append(f"G{motion}" if isinstance(motion, int) else motion)
        return words

    def _place(self, here: Place, cut: Cut, absolute: bool, decimals: int, exact: bool) -> tuple[Place, list[str]]:
        """Return where the tool is after a move, and the words that bring it there."""
        words, there = [], list(here)
        if cut.poles is not None and self.curve == "POLY":
            return cut.end, []
        arc = not cut.straight
        plane = PLANES[cut.plane or 17]
        for k, letter in enumerate("XYZ"):
            moves = abs(cut.end[k] - here[k]) > 1e-10
            if not moves and not (arc and k in plane):
                continue
            text = number(cut.end[k] if absolute else cut.end[k] - here[k], decimals, exact)
            there[k] = float(text) if absolute else here[k] + float(text)
            words.append(f"{letter}{text}")
        return (there[0], there[1], there[2]), words

    def _centre(self, piece: Piece, plane: int, absolute: bool, decimals: int) -> list[str]:
        assert piece.centre is not None
        centre = piece.centre if absolute else (piece.centre[0] - piece.start[0], piece.centre[1] - piece.start[1])
        pairs = zip(_OFFSETS[plane - 17], centre, strict=True)
        return [f"{letter}{number(value, decimals)}" for letter, value in sorted(pairs)]

    def _curve(self, poles: Array, decimals: int, exact: bool) -> list[str]:
        """Return the words of a cubic piece: of G5 its control points, of POLY its ends and coefficients."""
        if self.curve == 5:
            offsets = (*(poles[1] - poles[0])[:2], *(poles[2] - poles[3])[:2])
            return [f"{letter}{number(float(value), decimals)}" for letter, value in zip("IJPQ", offsets, strict=True)]
        square, cube = coefficients(poles)
        words = []
        for k, letter in enumerate("XYZ"):
            if (poles[:, k] == poles[0, k]).all():
                continue
            inside = [number(float(poles[3, k]), decimals, exact)]
            inside += [number(float(value[k]), decimals) for value in (square, cube)]
            words.append(f"PO[{letter}]=({','.join(inside)})")
        return words


def _numbers(blocks: list[Block], cuts: list[Cut], path: Toolpath) -> list[float]:
    """Return a line number for each move, from those of the lines it replaces; none if not all lines had one."""
    given = [next((value for letter, value in block.words if letter == "N"), None) for block in blocks]
    if any(value is None for value in given):
        return []
    found, after = [], len(given)
    for cut in reversed(cuts):
        after = min(int(path.moves[ceil(cut.at)]), after - 1)
        found.append(given[after])
    return [value for value in reversed(found) if value is not None]
