"""Runs: cutting moves that follow one another with nothing else said or changed, and the path that they make."""

from __future__ import annotations

from dataclasses import dataclass, field
from math import acos, ceil

import numpy as np

from cadfit.bezier import Array, Ints
from cadfit.toolpaths.machine import PLANES, Modes, Move
from cadfit.toolpaths.words import Block

LONGEST = 20_000  # moves: a longer run is cut, so that memory is bounded
_EVEN = 0.02  # how much of its mean the extrusion for a length may vary within a run ...
_LAST_DIGIT = 2e-5  # ... beyond what rounding does
_SAGITTA = 0.01  # of the tolerance: how far the chords that stand for an arc while it is fitted are off it
_WIDEST = 6.2  # radians: an arc of more is kept as it is


@dataclass(frozen=True, slots=True, eq=False)
class Toolpath:
    """Where a run goes: `points` (n, 3), from move to move and, along arcs, chords that are at most `off` off them.

    Moves that stay where they are are left out. `extruded` (n,): the length by then. `moves` (n,): the row, in the run,
    of the move that each is on. `begins`, `ends` (k,): the rows of the points between which each move is. `leaving`,
    `arriving` (k, 3): its directions; `lengths`, `sweeps`, `planes` (k,): of arcs, 0 for lines.
    """

    points: Array
    extruded: Array
    moves: Ints
    begins: Ints
    ends: Ints
    leaving: Array
    arriving: Array
    lengths: Array
    sweeps: Array
    planes: Ints
    off: float


@dataclass(slots=True)
class Run:
    """Moves that may be replaced together, with their lines.

    `modes`: during it. `extruder`: where E was before it. `arcs`: whether these may join.
    """

    modes: Modes
    extruder: float
    arcs: bool
    blocks: list[Block] = field(default_factory=list)
    moves: list[Move] = field(default_factory=list)
    extruded: float = 0.0
    length: float = 0.0

    def takes(self, block: Block, move: Move) -> bool:
        """Return whether a move may join: one that says and changes nothing but the place."""
        length = move.length
        if not move.joins or (move.extruded and not length) or _says(block.comment):
            return False
        if move.arc is not None and (not self.arcs or abs(move.arc.sweep) > _WIDEST):
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
        self.length += move.length

    def path(self, tolerance: float) -> Toolpath:
        """Return where the moves go, arcs as chords that are within a hundredth of the tolerance of them."""
        points, extruded, rows = [np.array([self.moves[0].start])], [0.0], [-1]
        begins, ends, leaving, arriving, kept = [], [], [], [], []
        total, at, off = 0.0, 0, 0.0
        for row, move in enumerate(self.moves):
            total += move.extruded
            if move.end == move.start:
                continue
            if move.arc is None:
                chords, way = np.array([move.end]), np.subtract(move.end, move.start) / move.length
                ways = (way, way)
            else:
                chords, ways, apart = _chords(move, _SAGITTA * tolerance)
                off = max(off, apart)
            m = len(chords)
            points.append(chords)
            extruded += [total - move.extruded * (m - 1 - k) / m for k in range(m)]
            rows += [row] * m
            begins.append(at)
            at += m
            ends.append(at)
            leaving.append(ways[0])
            arriving.append(ways[1])
            kept.append(move)
        sweeps = np.array([0.0 if move.arc is None else move.arc.sweep for move in kept])
        planes = np.array([0 if move.arc is None else move.arc.plane for move in kept], dtype=np.intp)
        return Toolpath(
            np.concatenate(points), np.array(extruded), np.array(rows), np.array(begins, dtype=np.intp),
            np.array(ends, dtype=np.intp), np.reshape(leaving, (-1, 3)), np.reshape(arriving, (-1, 3)),
            np.array([move.length for move in kept]), sweeps, planes, off,
        )  # fmt: skip


def _chords(move: Move, sagitta: float) -> tuple[Array, tuple[Array, Array], float]:
    """Return the ends (m, 3) of chords of an arc or a helix, its directions at both ends, and how far they are off it.

    Where its ends differ in radius controllers go their own ways between: by so much more the chords may be off.
    """
    arc = move.arc
    assert arc is not None
    first, second = PLANES[arc.plane]
    axes, third = [first, second], 3 - first - second
    start, end = np.array(move.start), np.array(move.end)
    arms = start[axes] - arc.centre, end[axes] - arc.centre
    radii = [float(np.hypot(*arm)) for arm in arms]
    m = ceil(abs(arc.sweep) / (2.0 * acos(1.0 - min(sagitta / max(radii), 0.5))))
    share = np.arange(1, m + 1) / m
    angle = np.arctan2(arms[0][1], arms[0][0]) + share * arc.sweep
    radius = radii[0] + share * (radii[1] - radii[0])
    points = np.empty((m, 3))
    points[:, first], points[:, second] = arc.centre[0] + radius * np.cos(angle), arc.centre[1] + radius * np.sin(angle)
    points[:, third] = start[third] + share * (end[third] - start[third])
    points[-1] = end
    ways = []
    for arm in arms:
        way = np.empty(3)
        way[axes] = np.array([-arm[1], arm[0]]) * arc.sweep
        way[third] = end[third] - start[third]
        ways.append(way / np.linalg.norm(way))
    return points, (ways[0], ways[1]), sagitta + abs(radii[1] - radii[0])


def _says(comment: str) -> bool:
    """Whether a comment does something, as (MSG, ...) does."""
    return comment[:1] == "(" and comment[1:].lstrip().upper().startswith(
        ("MSG", "PRINT", "DEBUG", "LOG", "PROBE", "AX")
    )
