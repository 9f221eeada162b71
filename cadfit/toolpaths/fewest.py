"""A path in a plane as the fewest lines and arcs that are found, as they are written, held to the path itself."""

from __future__ import annotations

from math import hypot, inf, tan
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from cadfit.arcing.chain import Layer
from cadfit.arcing.polyline import chosen, kept, lines, sampled, share
from cadfit.arcing.reach import Edges, Limits, feasible
from cadfit.arcing.stretch import Chain, along, certified
from cadfit.bezier import Array, Ints
from cadfit.toolpaths.pieces import Piece, Point, Rules, written_arc

_PER_ARC = 8.0  # nodes in the length of an arc
_AROUND = 24  # rows of nodes: to each side of where no chain is found, more are tried
_TRIES = 8
_WIDEST = 6.2  # radians, of an arc
_AIMED = 0.99  # of the tolerance: rounding takes some ...
_TIGHTER = 0.9  # ... and after each try by so much less, as between samples arcs are farther off than at them
_AT_ONCE = 400  # vertices, or as many as there are from one corner to the next


class Flat(NamedTuple):
    """A path in a plane: `points` (n, 2), from move to move; the rows of its `corners`; and what moves it is made of.

    `begins`, `ends` (k,): the rows between which each move is; `sweeps` (k,): 0 for lines, of arcs in radians; `turns`
    (k + 1,): by how much the path turns where each begins, and at the end. `heights` (n,): above the plane.
    """

    points: Array
    corners: Ints
    begins: Ints
    ends: Ints
    sweeps: Array
    turns: Array
    heights: Array

    def part(self, start: int, end: int) -> Flat:
        """Return the path from one vertex, where moves meet, to another."""
        some = (self.begins >= start) & (self.ends <= end)
        corners = self.corners[(self.corners > start) & (self.corners < end)] - start
        turns = np.append(self.turns[:-1][some], 0.0)
        return Flat(
            self.points[start : end + 1], corners, self.begins[some] - start, self.ends[some] - start,
            self.sweeps[some], turns, self.heights[start : end + 1],
        )  # fmt: skip

    def between(self, start: float, end: float) -> Array:
        """Return the polyline between two places: rows of vertices, and parts of the way to the next."""
        inside = self.points[int(np.floor(start)) + 1 : int(np.ceil(end))]
        return np.concatenate([self._at(start), inside, self._at(end)])

    def height(self, places: ArrayLike) -> Array:
        """Return the heights at places (...)."""
        return np.asarray(np.interp(np.asarray(places, float), np.arange(len(self.heights)), self.heights))

    def _at(self, place: float) -> Array:
        k = min(int(place), len(self.points) - 2)
        return self.points[k : k + 1] + (place - k) * (self.points[k + 1 : k + 2] - self.points[k : k + 1])


class Step(NamedTuple):
    """A move that stands for the path up to the place `end`, and how far it is from it at most."""

    end: float
    piece: Piece
    deviation: float


def fewest(path: Flat, tolerance: float, rules: Rules, exact: tuple[bool, bool], best: bool) -> list[Step]:
    """Return moves along a path, within the tolerance of it, as few as are found; never more than it is made of.

    Each begins in the direction in which the one before ended, but at corners, beside lines (by half a degree), and
    next to moves that are kept: there the path turns by no more than it did. `exact`: whether the first and the last
    vertex are kept as they are, whatever the decimals.
    """
    ends = [*path.corners.tolist(), len(path.points) - 1]
    found: list[Step] = []
    start = 0
    for end, following in zip(ends, [*ends[1:], None], strict=True):
        if following is not None and following - start <= _AT_ONCE:
            continue
        part = path.part(start, end)
        steps = _part(part, tolerance, rules, (exact[0] or start > 0, exact[1] or following is not None), best)
        found += [step._replace(end=step.end + start) for step in steps]
        start = end
    return found


def _part(path: Flat, tolerance: float, rules: Rules, exact: tuple[bool, bool], best: bool) -> list[Step]:
    written = _Written(path, tolerance, rules, exact)
    if len(path.begins) == 1:
        return written.own()
    limits = Limits(_AIMED * tolerance, rules.largest_radius, rules.least_radius, _WIDEST)

    def made(edges: Edges, found: list[Layer]) -> tuple[Ints, Chain]:
        return along(edges, found, rules.largest_radius)

    every = sampled(path.points, path.corners)
    taken, around = share(every, limits, _PER_ARC), _AROUND
    for _ in range(_TRIES):
        nodes = chosen(every, taken, limits.tolerance, best)
        links = feasible(nodes, limits)
        own = kept(nodes, path.begins, path.ends, path.sweeps, path.turns)
        edges = Edges.of(nodes, links.and_more(lines(nodes, links), own))
        try:
            return certified(edges, tolerance, made, written.judged)
        except LookupError as error:  # more nodes where it went no farther
            row = int(np.searchsorted(every.rows, nodes.rows[error.args[0]]))
            taken[max(row - around, 0) : row + around] = 1.0
            around *= 2
            limits = limits._replace(tolerance=_TIGHTER * limits.tolerance)
    return written.own()


class _Written:
    """A path's moves as they are written, each held to its part of the path."""

    def __init__(self, path: Flat, tolerance: float, rules: Rules, exact: tuple[bool, bool]) -> None:
        self.path, self.tolerance, self.rules, self.exact = path, tolerance, rules, exact
        self.climbs = bool(np.ptp(path.heights) > 0.0)
        self.seen: dict[tuple[float, Point, float, Point, float], Step | None] = {}

    def judged(self, chain: Chain) -> tuple[list[Step], Array]:
        """Return the steps of a chain, and how far (k,) they are off: infinitely, where none can be written."""
        joints = self._joints(chain.joints)
        rows = zip(
            chain.at[:-1].tolist(), joints[:-1], chain.at[1:].tolist(), joints[1:], chain.sweeps.tolist(), strict=True
        )
        found = []
        for key in rows:
            if key not in self.seen:
                self.seen[key] = self._step(*key)
            found.append(self.seen[key])
        far = np.array([inf if step is None else step.deviation for step in found])
        return [step for step in found if step is not None], far

    def own(self) -> list[Step]:
        """Return the moves that the path is made of."""
        path = self.path
        joints = self._joints(path.points[np.append(path.begins, path.ends[-1])])
        rows = zip(path.begins.tolist(), joints[:-1], path.ends.tolist(), joints[1:], path.sweeps.tolist(), strict=True)
        return [self._step(*row) or Step(row[2], Piece(row[1], row[3]), inf) for row in rows]

    def _joints(self, points: Array) -> list[Point]:
        joints = [self.rules.rounded((x, y)) for x, y in points.tolist()]
        for row, kept_so in zip((0, -1), self.exact, strict=True):
            if kept_so:
                joints[row] = (float(points[row, 0]), float(points[row, 1]))
        return joints

    def _step(self, at: float, start: Point, to: float, end: Point, sweep: float) -> Step | None:
        piece: Piece | None = Piece(start, end)
        if start == end:
            return None
        if sweep:
            x, y = end[0] - start[0], end[1] - start[1]
            height = 0.5 / tan(0.5 * sweep)
            centre = (start[0] + 0.5 * x - height * y, start[1] + 0.5 * y + height * x)
            piece = written_arc(start, end, centre, sweep, self.rules)
        if piece is None or (piece.centre is not None and piece.radius < 0.99 * self.rules.least_radius):
            return None
        points = self.path.between(at, to)
        far = piece.deviation(points)
        if self.climbs:
            places = np.concatenate([[at], np.arange(np.floor(at) + 1.0, np.ceil(to)), [to]])
            climb = self._height(at), self._height(to)
            far = hypot(far, piece.climb_deviation(points, self.path.height(places), climb))
        return Step(to, piece, far)

    def _height(self, place: float) -> float:
        """Return the height at a place as it is written; at the path's own ends within half the last digit."""
        return round(float(self.path.height(place)), self.rules.decimals)
