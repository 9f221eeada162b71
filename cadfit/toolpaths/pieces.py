"""Moves in a plane, straight or circular, as a controller takes them: rounded to its decimals."""

from __future__ import annotations

from math import atan2, hypot, pi
from typing import NamedTuple

import numpy as np

from cadfit.bezier import Array
from cadfit.toolpaths.channel import arc_deviation, climb_deviation, line_deviation
from cadfit.toolpaths.circles import radii_agree

Point = tuple[float, float]
_NEAR = tuple((i, j) for i in (0, -1, 1) for j in (0, -1, 1))


class Piece(NamedTuple):
    """A move in a plane, from `start` to `end`: straight, or about `centre` by `sweep` (left turns positive)."""

    start: Point
    end: Point
    centre: Point | None = None
    sweep: float = 0.0

    @property
    def radius(self) -> float:
        """The distance of the start from the centre."""
        assert self.centre is not None
        return hypot(self.start[0] - self.centre[0], self.start[1] - self.centre[1])

    @property
    def length(self) -> float:
        """How long the move is."""
        if self.centre is None:
            return hypot(self.end[0] - self.start[0], self.end[1] - self.start[1])
        return self.radius * abs(self.sweep)

    def deviation(self, points: Array) -> float:
        """Return an upper bound on the distance between the polyline of points (n, 2) and the move, both ways."""
        start, end = np.array(self.start), np.array(self.end)
        if self.centre is None:
            return line_deviation(points, start, end)
        return arc_deviation(points, start, end, np.array(self.centre), self.sweep)

    def climb_deviation(self, points: Array, heights: Array, climb: tuple[float, float]) -> float:
        """Return how far the heights (n,) of points are from those of the move, which climbs evenly, at most."""
        centre = None if self.centre is None else np.array(self.centre)
        return climb_deviation(points, heights, climb, np.array(self.start), np.array(self.end), centre, self.sweep)


class Rules(NamedTuple):
    """What a move must keep to: `tick` the least step of a coordinate, the radii of arcs, `unit` a millimetre."""

    tick: float
    least_radius: float
    largest_radius: float
    unit: float
    decimals: int

    def rounded(self, point: Point) -> Point:
        """Return the place as it is written."""
        return round(point[0], self.decimals), round(point[1], self.decimals)


def written_arc(start: Point, end: Point, centre: Point, sweep: float, rules: Rules) -> Piece | None:
    """Return the arc about the rounded centre, and the sweep it then has."""
    found = _written_centre(start, end, centre, rules)
    if found is None:
        return None
    u, v = (start[0] - found[0], start[1] - found[1]), (end[0] - found[0], end[1] - found[1])
    turn = atan2(u[0] * v[1] - u[1] * v[0], u[0] * v[0] + u[1] * v[1])
    if turn * sweep < 0.0 or (turn == 0.0 and abs(sweep) > 1.0):
        turn += 2.0 * pi if sweep > 0.0 else -2.0 * pi
    if abs(turn - sweep) > 0.5:  # so short that rounding decides
        return None
    return Piece(start, end, found, turn)


def _written_centre(start: Point, end: Point, centre: Point, rules: Rules) -> Point | None:
    """Return the centre, an offset from the start of so many decimals, whose ends are most nearly as far from it."""
    best, least = None, np.inf
    for i, j in _NEAR:
        offset = rules.rounded((centre[0] - start[0] + i * rules.tick, centre[1] - start[1] + j * rules.tick))
        here = (start[0] + offset[0], start[1] + offset[1])
        first, last = hypot(*offset), hypot(end[0] - here[0], end[1] - here[1])
        apart = abs(first - last)
        if apart < least - 1e-12 and first > 0.0:
            best, least = here, apart
            if i == j == 0 and apart <= 0.2 * rules.tick:
                break
    # 0.6 of the rule: controllers compute in their own floats, some of them 32-bit ones
    return best if best is not None and radii_agree(least, 0.0, 0.6 * rules.unit) else None
