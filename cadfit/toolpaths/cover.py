"""A smooth stretch of a path, in a plane, covered with the longest lines and arcs that stay within a tolerance.

The best arcs along a curve, each as long as the tolerance lets it be and joined without a kink, meet on the curve, but
not in its direction. Where the curvature grows by k' per length, an arc of length h with the mean curvature is off the
curve's direction by k' (h s / 2 - s^2 / 2 - h^2 / 12) at s, and off the curve by the integral of that, which vanishes
at both ends and in the middle. So at a joint the direction is that of the curve less k' h^2 / 12, and the largest error
is k' h^3 sqrt(3) / 216, an eighth of that of arcs that keep the curve's directions at every second joint.
"""

from __future__ import annotations

from collections.abc import Callable
from math import cos, radians, sin
from typing import NamedTuple

import numpy as np

from cadfit.bezier import Array
from cadfit.toolpaths.biarcs import Piece, Point, Rules, arc_from, biarc
from cadfit.toolpaths.tangents import directions, straights

_LINE_KINK = cos(radians(0.5))  # a line may turn off the path's direction by so much
_ASTRAY = 2.0  # tolerances that the direction at an arc's end, over its length, may lead off the best one
_MOST_MOVED = 0.45  # tolerances that a vertex may be moved


class Step(NamedTuple):
    """The moves from vertex `first` to vertex `last`, and how far they are from the path there at most."""

    first: int
    last: int
    pieces: tuple[Piece, ...]
    deviation: float


def cover(points: Array, tolerance: float, rules: Rules, least: float, exact: tuple[bool, bool]) -> list[Step]:
    """Return moves from the first to the last vertex of a smooth path (n, 2) that are within `tolerance` of it.

    Each begins in the direction in which the one before ended (lines: within half a degree), but for chords of the path
    that are left as they are, where no move covers two or more. `least`: the tolerance of the directions. `exact`:
    whether the first and the last vertex are kept as they are, whatever the decimals.
    """
    path = _Path(points, tolerance, rules, least, exact)
    at, heading, reaches = 0, None, {_Path.line: 2, _Path.arc: 2, _Path.biarc: 3}
    steps: list[Step] = []
    while at < path.end:
        best = path.chord(at)
        for make, reach in reaches.items():
            found = _farthest(path, make, at, heading, reach)
            if found is not None:
                reaches[make] = found.last - at
                best = max(best, found, key=lambda step: ((step.last - step.first) / len(step.pieces), step.last))
        steps.append(best)
        at = best.last
        heading = path.heading(at) if best.last - best.first == 1 else best.pieces[-1].direction(True)
    return path.as_they_were(steps)


def _farthest(path: _Path, make: _Make, at: int, heading: Point | None, guess: int) -> Step | None:
    """Return the step to the farthest vertex that can be had, if it takes fewer moves than there are chords."""
    least = 3 if make is _Path.biarc else 2
    if at + least > path.end:
        return None
    reach = max(guess, least)
    found, low, high = None, at + least - 1, path.end + 1  # low can be had (or is no step), high cannot
    while high - low > 1:
        last = min(at + reach, path.end) if low < at + reach < high else (low + high) // 2
        step = make(path, at, last, heading)
        if step is None:
            if found is None and last > at + least:
                reach = max((last - at) // 2, least)
            high = last
        else:
            found, low = step, last
            reach = (last - at) * 2
    return found


class _Path:
    """A path being covered: its vertices as they are and as they are written, its lengths and directions there."""

    def __init__(self, points: Array, tolerance: float, rules: Rules, least: float, exact: tuple[bool, bool]) -> None:
        self.points, self.tolerance, self.rules, self.end = points, tolerance, rules, len(points) - 1
        tangents, inward = directions(points, least)
        far = np.sqrt(np.einsum("nd,nd->n", inward, inward))
        nodes = points + np.where(far <= _MOST_MOVED * tolerance, 1.0, 0.0)[:, None] * inward
        self.written = [rules.rounded((float(x), float(y))) for x, y in nodes]
        for end, kept in zip((0, -1), exact, strict=True):
            if kept:
                self.written[end] = (float(points[end, 0]), float(points[end, 1]))
        self.angles = np.unwrap(np.arctan2(tangents[:, 1], tangents[:, 0]))
        self.along = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(points, axis=0).T))])
        self.straight = straights(points)

    def heading(self, at: int, length: float = 0.0) -> Point:
        """Return the direction at a vertex: for arcs of that length on both sides the best, for none the path's."""
        angle = float(self.angles[at])
        if length > 0.0 and not self.straight[at]:
            here, total = self.along[at], self.along[-1]
            middle = min(max(here, length), total - length) if 2.0 * length < total else here
            before, there, after = np.interp([middle - length, middle, middle + length], self.along, self.angles)
            angle -= float(before - 2.0 * there + after) / 12.0
        return cos(angle), sin(angle)

    def chord(self, at: int) -> Step:
        """Return the path's own chord from a vertex to the next."""
        piece = Piece(self.written[at], self.written[at + 1])
        return Step(at, at + 1, (piece,), piece.deviation(self.points[at : at + 2]))

    def line(self, at: int, last: int, heading: Point | None) -> Step | None:
        """Return the line between two vertices, if it keeps the tolerance and hardly turns off the path."""
        piece = Piece(self.written[at], self.written[last])
        x, y = piece.direction(False)
        if heading is not None and x * heading[0] + y * heading[1] < _LINE_KINK:
            return None
        there = self.heading(last)
        if last < self.end and x * there[0] + y * there[1] < _LINE_KINK:
            return None
        return self._kept(at, last, (piece,), (self.points[at : last + 1],))

    def arc(self, at: int, last: int, heading: Point | None) -> Step | None:
        """Return the arc from a vertex, in a direction, to another, if it keeps the tolerance and ends well."""
        length = float(self.along[last] - self.along[at])
        piece = arc_from(self.written[at], heading or self.heading(at, length), self.written[last], self.rules)
        if piece is None or piece.centre is None:
            return None
        if last < self.end:
            x, y = piece.direction(True)
            best = self.heading(last, length)
            if abs(x * best[1] - y * best[0]) * length > _ASTRAY * self.tolerance:
                return None
        return self._kept(at, last, (piece,), (self.points[at : last + 1],))

    def biarc(self, at: int, last: int, heading: Point | None) -> Step | None:
        """Return the pair of arcs from a vertex, in a direction, to another, if it keeps the tolerance."""
        length = float(self.along[last] - self.along[at]) / 2.0
        for size in (length, 0.0):  # where vertices are far apart, the best direction is not well known
            leaving, arriving = heading or self.heading(at, size), self.heading(last, size)
            pair = biarc(self.written[at], leaving, self.written[last], arriving, self.rules)
            if pair is None:
                continue
            halves = cut_at(self.points[at : last + 1], pair[0])
            step = None if halves is None else self._kept(at, last, pair, halves)
            if step is not None:
                return step
        return None

    def _kept(self, at: int, last: int, pieces: tuple[Piece, ...], parts: tuple[Array, ...]) -> Step | None:
        """Return the step, if each piece keeps the tolerance to its part of the path."""
        far = 0.0
        for piece, part in zip(pieces, parts, strict=True):
            far = max(far, piece.deviation(part))
            if far > self.tolerance:
                return None
        return Step(at, last, pieces, far)

    def as_they_were(self, steps: list[Step]) -> list[Step]:
        """Return the steps with the vertices between two chords where they were: moving them gained nothing."""
        chord = [step.last - step.first == 1 for step in steps]
        for k in range(len(steps) - 1):
            if chord[k] and chord[k + 1]:
                x, y = self.points[steps[k].last]
                self.written[steps[k].last] = self.rules.rounded((float(x), float(y)))
        return [self.chord(step.first) if kept else step for step, kept in zip(steps, chord, strict=True)]


_Make = Callable[[_Path, int, int, Point | None], Step | None]


def cut_at(points: Array, piece: Piece) -> tuple[Array, Array] | None:
    """Return the polyline in two parts, cut where it passes the end of a piece: at the normal nearest to it.

    None where it does not pass it within half as much again as the piece is long.
    """
    end, along = np.array(piece.end), np.array(piece.direction(True))
    reach = np.cumsum(np.hypot(*np.diff(points, axis=0).T))
    near_enough = 2 + int(np.searchsorted(reach, 1.5 * piece.length))
    gap = points[: near_enough + 1] - end
    ahead = gap @ along
    passes = np.flatnonzero((ahead[:-1] <= 0.0) & (ahead[1:] > 0.0))
    if not len(passes):
        return None
    near = passes[0]
    if len(passes) > 1:
        near = passes[np.argmin(np.einsum("nd,nd->n", gap[passes], gap[passes]))]
    share = -ahead[near] / (ahead[near + 1] - ahead[near])
    cut = points[near] + share * (points[near + 1] - points[near])
    return np.concatenate([points[: near + 1], cut[None]]), np.concatenate([cut[None], points[near + 1 :]])
