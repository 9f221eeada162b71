"""Runs: cutting moves that follow one another with nothing else said or changed, and what is fitted to them."""

from __future__ import annotations

from dataclasses import dataclass, field
from math import dist, hypot
from typing import NamedTuple

import numpy as np

from cadfit.bezier import Array
from cadfit.toolpaths.biarcs import Piece, Rules
from cadfit.toolpaths.channel import line_deviation
from cadfit.toolpaths.cover import cover
from cadfit.toolpaths.fewest import fewest
from cadfit.toolpaths.machine import PLANES, Modes, Move, Place
from cadfit.toolpaths.splines import Rounding, cubics
from cadfit.toolpaths.tangents import corners
from cadfit.toolpaths.words import Block

LONGEST = 20_000  # moves: a longer run is cut, so that memory is bounded
_EVEN = 0.02  # how much of its mean the extrusion for a length may vary within a run ...
_LAST_DIGIT = 2e-5  # ... beyond what rounding does


class Cut(NamedTuple):
    """A move in place of those up to vertex `row` of its run: to `end`, along `piece` in `plane` (0: straight).

    `poles` (4, 3), instead: those of a cubic piece. `share`: of the way from the vertex before to that vertex, where
    several moves are put in its place.
    """

    row: int
    end: Place
    plane: int = 0
    piece: Piece | None = None
    share: float = 1.0
    poles: Array | None = None

    @property
    def straight(self) -> bool:
        """Whether it is a line."""
        return self.poles is None and (self.piece is None or self.piece.centre is None)


@dataclass(slots=True)
class Run:
    """Moves that may be replaced together, with their lines; `modes` during it, `extruder`: where E was before it."""

    modes: Modes
    extruder: float
    blocks: list[Block] = field(default_factory=list)
    moves: list[Move] = field(default_factory=list)
    extruded: float = 0.0
    length: float = 0.0

    def takes(self, block: Block, move: Move) -> bool:
        """Return whether a move may join: one that says and changes nothing but the place."""
        length = hypot(*(b - a for a, b in zip(move.start, move.end, strict=True)))
        if not move.joins or (move.extruded and not length) or _says(block.comment):
            return False
        if not self.moves:
            return True
        first, comment = self.moves[0], self.blocks[0].comment
        if move.feed != first.feed or block.comment != comment or len(self.moves) >= LONGEST:
            return False
        if not length or not self.length:
            return True
        rate = self.extruded / self.length
        return bool(abs(move.extruded - rate * length) <= _EVEN * abs(rate) * length + _LAST_DIGIT * bool(rate))

    def add(self, block: Block, move: Move) -> None:
        """Put a move at the end."""
        self.blocks.append(block)
        self.moves.append(move)
        self.extruded += move.extruded
        self.length += hypot(*(b - a for a, b in zip(move.start, move.end, strict=True)))

    def vertices(self) -> tuple[Array, Array, list[int]]:
        """Return the vertices (n, 3) without repeats, the extruded lengths there (n,), and the moves that end there."""
        places, extruded, ends, total = [self.moves[0].start], [0.0], [-1], 0.0
        for k, move in enumerate(self.moves):
            total += move.extruded
            if move.end != places[-1]:
                places.append(move.end)
                extruded.append(total)
                ends.append(k)
        return np.array(places), np.array(extruded), ends


def _says(comment: str) -> bool:
    """Whether a comment does something, as (MSG, ...) does."""
    return comment[:1] == "(" and comment[1:].lstrip().upper().startswith(
        ("MSG", "PRINT", "DEBUG", "LOG", "PROBE", "AX")
    )


def arcs(points: Array, tolerance: float, angle: float, rules: Rules, best: bool) -> tuple[list[Cut], float]:
    """Return lines and arcs along the path of points (n, 3) within the tolerance, and a bound on how far they are off.

    The path is split at corners (turns of more than `angle`, radians) and where its plane changes; what is in none of
    the planes of arcs gets lines.
    """
    room = tolerance - rules.tick  # what rounding an axis that stands still may take
    last = len(points) - 1
    cuts: list[Cut] = []
    worst, start = 0.0, 0
    for end in [*corners(points, tolerance, angle).tolist(), last]:
        while start < end:
            plane, stop = _in_plane(points, start, end)
            exact = (start == 0, stop == last)
            part = points[start : stop + 1]
            if plane:
                found, far = _flat(part, plane, room, rules, tolerance, exact, best)
            else:
                found, far = _straight(part, room, rules, exact)
            cuts += [cut._replace(row=cut.row + start) for cut in found]
            worst, start = max(worst, far), stop
    return cuts, worst


def splines(
    points: Array, tolerance: float, angle: float, rules: Rules, written: Rounding, flat: bool
) -> tuple[list[Cut], float]:
    """Return cubic pieces and lines along the path of points (n, 3), as `arcs` does.

    `flat`: pieces are in the plane of X and Y alone; a path that leaves it gets lines.
    """
    cuts: list[Cut] = []
    worst, start, last = 0.0, 0, len(points) - 1
    for end in [*corners(points, tolerance, angle).tolist(), last]:
        part, exact = points[start : end + 1], (start == 0, end == last)
        level = bool((part[:, 2] == part[0, 2]).all())
        lines, far = _straight(part, tolerance - rules.tick, rules, exact)
        curves = None
        if level or not flat:
            begins = part.copy()
            begins[0] = cuts[-1].end if cuts else part[0]
            curves = cubics(begins[:, :2] if level else begins, tolerance - rules.tick, written, exact[1])
        if curves is not None and len(curves[0]) < len(lines):
            rows, far = _rows(part, curves[0]), curves[1] + dist(begins[0], part[0])
            lines = []
            for row, poles in zip(rows, curves[0], strict=True):
                space = np.column_stack([poles, np.full(4, part[0, 2])]) if level else poles
                x, y, z = space[3].tolist()
                lines.append(Cut(row, (x, y, z), 17 if flat else 0, poles=space))
        cuts += [cut._replace(row=cut.row + start) for cut in lines]
        worst, start = max(worst, far), end
    return cuts, worst


def _rows(points: Array, poles: Array) -> list[int]:
    """Return for each piece the vertex that is taken for its end: rising, the nearest in length."""
    along = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(points, axis=0), axis=1))])
    sizes = np.cumsum(np.linalg.norm(np.diff(poles, axis=1), axis=2).sum(axis=1))
    rows = np.searchsorted(along, sizes * along[-1] / sizes[-1])
    m, n = len(rows), len(points)
    rising = np.maximum.accumulate(rows - np.arange(m)) + np.arange(m)
    rows = np.clip(np.minimum(rising, n - m + np.arange(m)), np.arange(1, m + 1), n - 1)
    rows[-1] = n - 1
    return [int(row) for row in rows]


def _in_plane(points: Array, start: int, end: int) -> tuple[int, int]:
    """Return the plane of the stretch that begins at a vertex (0: none), and the vertex where it stops."""
    still = points[start:end] == points[start + 1 : end + 1]
    kept = np.logical_and.accumulate(still[:, [2, 1, 0]], axis=0)
    reach = kept.sum(axis=0)
    best = int(np.argmax(reach))
    if reach[best]:
        return (17, 18, 19)[best], start + int(reach[best])
    moving = still.any(axis=1)
    return 0, start + (int(np.argmax(moving)) if moving.any() else len(moving))


def _flat(
    points: Array, plane: int, room: float, rules: Rules, tolerance: float, exact: tuple[bool, bool], best: bool
) -> tuple[list[Cut], float]:
    first, second = PLANES[plane]
    third = 3 - first - second
    cuts, worst = [], 0.0
    flat = points[:, [first, second]]
    steps = cover(flat, room, rules, tolerance, exact)
    if best and (moves := sum(len(step.pieces) for step in steps)) > 2:
        found = fewest(flat, room, rules, exact)
        if found is not None and len(found.pieces) < moves:
            steps = [found]
    for step in steps:
        worst = max(worst, step.deviation)
        whole, along = sum(piece.length for piece in step.pieces), 0.0
        for piece in step.pieces:
            place = [0.0, 0.0, 0.0]
            place[first], place[second] = piece.end
            place[third] = float(points[step.last, third])
            along += piece.length
            share = 1.0 if piece is step.pieces[-1] else along / whole
            cuts.append(Cut(step.last, (place[0], place[1], place[2]), plane, piece, share))
    return cuts, worst


def _straight(points: Array, room: float, rules: Rules, exact: tuple[bool, bool]) -> tuple[list[Cut], float]:
    """Return the longest lines, one after the other, that stay within the room of points (n, 3)."""
    written = np.round(points, rules.decimals)
    for end, kept in zip((0, -1), exact, strict=True):
        if kept:
            written[end] = points[end]
    cuts, worst, at, n = [], 0.0, 0, len(points)
    reach = 1
    while at < n - 1:
        low, high, far = at + 1, n, line_deviation(points[at : at + 2], written[at], written[at + 1])
        while high - low > 1:
            last = min(low + reach, n - 1) if high == n else (low + high) // 2
            tried = line_deviation(points[at : last + 1], written[at], written[last])
            if tried <= room:
                low, far, reach = last, tried, 2 * reach
            else:
                high, reach = last, max((last - at) // 2, 1)
        worst = max(worst, far)
        cuts.append(Cut(low, (float(written[low, 0]), float(written[low, 1]), float(written[low, 2]))))
        at = low
    return cuts, worst
