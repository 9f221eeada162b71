"""What a controller knows as it goes through a program: position, modes, feed; and the moves it makes."""

from __future__ import annotations

from dataclasses import dataclass
from math import dist, hypot
from typing import NamedTuple

from cadfit.toolpaths.circles import by_centre, by_radius
from cadfit.toolpaths.words import Block, refuse

Place = tuple[float, float, float]

AXES = "XYZ"
PLANES = {17: (0, 1), 18: (2, 0), 19: (1, 2)}  # the two axes of an arc, in the order that makes G3 turn left
_OFFSETS = (("I", "J"), ("K", "I"), ("J", "K"))
# G-codes in tenths. What neither moves the tool nor says how coordinates are meant:
_HARMLESS = {40, 80, 90, 110, 131, 150, 400, 500, 501, 600, 610, 611, 620, 640, 690, 940, 950, 960, 970, 980, 990}
_MOVED = {100, 280, 300, 520, 530, *range(540, 600), 921, 922, 923}  # after these the position has other coordinates
_LENGTHS = {430, 431, 432, 440, 490}  # and after these it has another Z
_TAKE_AXES = {40, 100, 280, 300, 431, 520, 530}
_AWAY = {  # what makes coordinates mean something else than the tool's place or F its speed, and what ends it
    70: {80}, 71: {131}, 121: {131}, 160: {150}, 410: {400}, 411: {400}, 420: {400}, 421: {400}, 434: {490},
    435: {490}, 510: {500}, 511: {501}, 680: {690}, 930: {940, 950},
}  # fmt: skip
_CALLS = {97, 98}  # M-codes that go elsewhere
_MACROS = {650, 660, 661}  # and G-codes that do: what they leave behind is not known
_STOPS = {2, 30}


@dataclass(frozen=True, slots=True)
class Arc:
    """A circular move in the plane of two axes: `centre` there, `radius`, `sweep` (radians, left turns positive)."""

    plane: int
    centre: tuple[float, float]
    radius: float
    sweep: float


class Move(NamedTuple):
    """One move of the tool, straight or (with `arc`) along a circle or a helix, from `start` to `end` (x, y, z).

    `motion`: 0 rapid, 1, 2, 3. `extruded`: what the axis E moves. `feed`: None where it was never set. `joins`: it is
    a plain cut that moves may be fitted to: nothing on its line says or does anything else.
    """

    line: int
    motion: int
    start: Place
    end: Place
    arc: Arc | None
    feed: float | None
    extruded: float
    joins: bool

    @property
    def length(self) -> float:
        """How long the move is, in the program's unit."""
        if self.arc is None:
            return dist(self.start, self.end)
        along = 3 - sum(PLANES[self.arc.plane])
        return hypot(self.arc.radius * self.arc.sweep, self.end[along] - self.start[along])


class Modes(NamedTuple):
    """What words mean from here on: the last motion, the plane, absolute places, centres, extruder; inches."""

    motion: int | None
    plane: int
    absolute: bool
    centres_absolute: bool
    extruder_absolute: bool
    inches: bool


class Machine:
    """The modal state of a controller. `step` takes one line and returns the move it makes, if it is understood.

    `unknown` lists (line, what) of words that were not understood; after one of them the position counts as unknown
    until it is given anew, so nothing is fitted to it.
    """

    def __init__(self) -> None:
        self.motion: int | None = None
        self.plane = 17
        self.inches: bool | None = None
        self.absolute = True
        self.centres_absolute = False
        self.extruder_absolute = True
        self.feed: float | None = None
        self.position = [0.0, 0.0, 0.0, 0.0]  # x, y, z, e
        self.known = [False, False, False, False]
        self.away: dict[int, set[int]] = {}
        self.unknown: list[tuple[int, str]] = []
        self.ended = False
        self._numbered = False

    @property
    def modes(self) -> Modes:
        """The modes now."""
        centres, extruder = self.centres_absolute, self.extruder_absolute
        return Modes(self.motion, self.plane, self.absolute, centres, extruder, bool(self.inches))

    def step(self, block: Block) -> Move | None:
        """Follow one line; raises ValueError, naming it, where it contradicts itself."""
        if not block.words:
            return None
        codes, told, given, others = self._sorted(block)
        if block.skippable:
            self._maybe(block, codes, given)
            return None
        plain = not (block.opaque or others or told)
        takes = False  # whether a code that is no motion takes the axis words
        motion = None
        for code in codes:
            if code in (0, 10, 20, 30):
                if motion is not None:
                    refuse(block.line, f"G{motion} and G{code // 10} on one line are two motions")
                motion = code // 10
                self.motion = motion
            else:
                plain = False
                takes |= self._mode(block.line, code, given)
        for code in told:
            self._tell(block.line, code)
        if "F" in given:
            self.feed = given["F"]
        if takes or not any(letter in given for letter in "XYZEIJKR"):
            return None
        if self.motion is None:
            self._lost("XYZE")
            return None
        return self._move(block, given, plain)

    def _sorted(self, block: Block) -> tuple[list[int], list[int], dict[str, float], bool]:
        """Return a line's G-codes (in tenths), its M-codes, its other words, and whether those are more than moves."""
        codes, told, given, others = [], [], {}, False
        for letter, value in block.words:
            if letter == "G":
                tenths = round(value * 10)
                if abs(value * 10 - tenths) > 1e-9 or value < 0:
                    refuse(block.line, f"there is no G{value:g}")
                codes.append(tenths)
            elif letter == "M":
                told.append(int(value))
            elif letter == "O":
                if self._numbered:
                    refuse(block.line, f"O{value:g} starts another program: one to a file")
                self._numbered, others = True, True
            else:
                given[letter] = value
                others |= letter not in "NXYZEFIJKR"
        return codes, told, given, others

    def _mode(self, line: int, code: int, given: dict[str, float]) -> bool:
        """Take a G-code that is no motion; return whether it takes the axis words of its line."""
        for start in [start for start, ends in self.away.items() if code in ends]:
            del self.away[start]
            self._lost("XYZ")
        if code in (170, 180, 190):
            self.plane = code // 10
        elif code in (200, 210):
            if self.inches is not None and self.inches != (code == 200):
                self._lost("XYZE")  # controllers differ in what becomes of the numbers
            self.inches = code == 200
        elif code in (900, 910):
            self.absolute = self.extruder_absolute = code == 900
        elif code in (901, 911):
            self.centres_absolute = code == 901
        elif code in _AWAY:
            self.away[code] = _AWAY[code]
            self._lost("XYZ")
        elif code == 920:
            self._set(given)
            return True
        elif code in _MOVED:
            self._lost("XYZE")
        elif code in _LENGTHS:
            self._lost("Z")
        elif code == 800:
            self.motion = None
        elif code in _MACROS:
            refuse(line, f"G{code / 10:g} calls a macro that is not followed")
        elif code not in _HARMLESS:
            self.unknown.append((line, f"G{code / 10:g}"))
            self.motion = None
            self._lost("XYZE")
        return code in _TAKE_AXES

    def _tell(self, line: int, code: int) -> None:
        """Take an M-code."""
        if code in (82, 83):
            self.extruder_absolute = code == 82
        elif code in _CALLS:
            refuse(line, f"M{code} calls a program that is not followed")
        elif code == 6:
            self._lost("XYZE")
        elif code in _STOPS:
            self.ended = True

    def _maybe(self, block: Block, codes: list[int], given: dict[str, float]) -> None:
        """Take a line that the operator may have skipped."""
        for code in codes:
            if code not in (0, 10, 20, 30) and code not in _HARMLESS:
                refuse(
                    block.line, f"G{code / 10:g} in a block that may be skipped (/): what follows would be uncertain"
                )
        if codes or any(letter in given for letter in "XYZEIJKRF"):
            self.motion, self.feed = None, None
            self._lost("XYZE")

    def _set(self, given: dict[str, float]) -> None:
        """G92: what the position is called from here on."""
        named = [letter for letter in "XYZE" if letter in given]
        if not named:
            self._lost("XYZE")
        for letter in named:
            k = "XYZE".index(letter)
            self.position[k], self.known[k] = given[letter], True

    def _lost(self, axes: str) -> None:
        for letter in axes:
            self.known["XYZE".index(letter)] = False

    def _move(self, block: Block, given: dict[str, float], plain: bool) -> Move | None:
        """Make the move of a line that has axis words."""
        motion = self.motion
        assert motion is not None
        start, was_known = self.position, self.known
        end, known, sure = start.copy(), was_known.copy(), True
        for k, letter in enumerate("XYZE"):
            if letter in given:
                if self.absolute if k < 3 else self.extruder_absolute:
                    end[k], known[k] = given[letter], True
                    sure &= was_known[k]
                else:
                    end[k] = start[k] + given[letter]
        self.position, self.known = end, known
        arc = None
        if motion >= 2:
            arc = self._arc(block.line, motion, start, end, given, sure)
        elif any(letter in given for letter in "IJKR"):
            plain = False  # which some controllers take for a chamfer or a rounding
        if not sure:
            return None
        x, y, z, e = start
        joins = plain and not self.away and (motion == 1 or arc is not None)
        return Move(block.line, motion, (x, y, z), (end[0], end[1], end[2]), arc, self.feed, end[3] - e, joins)

    def _arc(
        self, line: int, motion: int, start: list[float], end: list[float], given: dict[str, float], sure: bool
    ) -> Arc | None:
        first, second = PLANES[self.plane]
        i, j = _OFFSETS[self.plane - 17]
        stray = next((letter for letter in "IJK" if letter in given and letter not in (i, j)), None)
        if stray is not None:
            refuse(line, f"{stray} is no offset of an arc in the plane G{self.plane}")
        a, b = (start[first], start[second]), (end[first], end[second])
        if not ("R" in given or i in given or j in given):
            refuse(line, "an arc needs its centre (I, J, K) or its radius (R)")
        if not sure or self.away or not ((self.known[first] and self.known[second]) or not self.centres_absolute):
            return None
        unit = 1 / 25.4 if self.inches else 1.0
        left = motion == 3
        if "R" in given:
            if i in given or j in given:
                refuse(line, "an arc has a centre or a radius, not both")
            return Arc(self.plane, *by_radius(line, a, b, given["R"], left, unit))
        offset = (given.get(i, 0.0), given.get(j, 0.0))
        centre = offset if self.centres_absolute else (a[0] + offset[0], a[1] + offset[1])
        return Arc(self.plane, *by_centre(line, a, b, centre, left, unit))
