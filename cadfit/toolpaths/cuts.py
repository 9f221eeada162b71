"""What is fitted to the path of a run: lines, arcs and helices, or cubic pieces."""

from __future__ import annotations

from math import cos, dist
from typing import NamedTuple

import numpy as np

from cadfit.bezier import Array, Ints
from cadfit.points.measures import lengths_along
from cadfit.toolpaths.channel import line_deviation
from cadfit.toolpaths.fewest import Flat, fewest
from cadfit.toolpaths.machine import PLANES, Place
from cadfit.toolpaths.pieces import Piece, Rules
from cadfit.toolpaths.runs import Toolpath
from cadfit.toolpaths.splines import Rounding, cubics

_LEAST = 3  # moves in a plane, between others in space, from which it counts
_EVEN = 0.1  # of the room: how far from even the climb of a helix may be
_LONGEST = 4096  # moves: where more climb evenly, several parts do


class Cut(NamedTuple):
    """A move in place of those up to a place of the run's path: to `end`, along `piece` in `plane` (0: straight).

    `at`: the row of the path's point, and the part of the way to the next. `poles` (4, 3), instead of a piece: those of
    a cubic one.
    """

    at: float
    end: Place
    plane: int = 0
    piece: Piece | None = None
    poles: Array | None = None

    @property
    def straight(self) -> bool:
        """Whether it is a line."""
        return self.poles is None and (self.piece is None or self.piece.centre is None)


def arcs(path: Toolpath, tolerance: float, angle: float, rules: Rules, best: bool) -> tuple[list[Cut], float]:
    """Return lines, arcs and helices along a path within the tolerance, and a bound on how far they are off.

    Corners (turns of more than `angle`, radians) are kept. What is in none of the planes of arcs gets lines or helices.
    """
    room = tolerance - rules.tick - path.off  # what rounding an axis that stands still may take
    cuts: list[Cut] = []
    if room <= rules.tick:
        return cuts, 0.0
    worst = 0.0
    corners, last = corners_of(path, tolerance, angle), len(path.begins)
    for plane, start, end in _planes(path):
        exact = (start == 0, end == last)
        if plane:
            found, far = _flat(path, plane, (start, end), corners, room, rules, exact, best)
        else:
            found, far = _straight(path, (start, end), corners, room, rules, exact)
            turns: list[Cut] = []
            off = 0.0
            for part in _climbs(path, (start, end), room, len(found)):
                some, apart = _flat(path, 17, part, corners, room, rules, (part[0] == 0, part[1] == last), best)
                turns, off = turns + some, max(off, apart)
            if 0 < len(turns) < len(found) and off <= room:
                found, far = turns, off
        cuts += found
        worst = max(worst, far)
    return cuts, worst + path.off


def corners_of(path: Toolpath, tolerance: float, angle: float) -> Ints:
    """Return the rows of the moves that begin at a turn of more than `angle` (radians) between moves not too short.

    Moves shorter than the tolerance count for nothing by themselves: their ends turn as what is around them does.
    """
    cosine = np.einsum("kd,kd->k", path.arriving[:-1], path.leaving[1:])
    long_enough = np.minimum(path.lengths[:-1], path.lengths[1:]) >= tolerance
    return np.flatnonzero((cosine < cos(angle)) & (long_enough | (cosine < -0.5))) + 1


def _planes(path: Toolpath) -> list[tuple[int, int, int]]:
    """Return the parts of a path in one plane (or none, 0), and the moves that each begins and ends with."""
    k = len(path.begins)
    still = path.points[path.begins] == path.points[path.ends]
    reach = np.zeros((k + 1, 3), dtype=np.intp)  # moves from each one on that are in the planes 17, 18, 19
    for row in range(k - 1, -1, -1):
        for j, axis in enumerate((2, 1, 0)):
            inside = still[row, axis] and path.planes[row] in (0, 17 + j)
            reach[row, j] = reach[row + 1, j] + 1 if inside else 0
    most, parts, start = reach.max(axis=1), [], 0
    while start < k:
        end = start
        while end < k and most[end] < min(_LEAST, k - end):
            end += 1
        if end > start:
            parts.append((0, start, end))
        if end < k:
            j = int(np.argmax(reach[end]))
            parts.append((17 + j, end, end + int(reach[end, j])))
            end = parts[-1][2]
        start = end
    return parts


def _climbs(path: Toolpath, part: tuple[int, int], room: float, most: int) -> list[tuple[int, int]]:
    """Return the parts, at most so many, in which Z changes evenly along X and Y; none where they are not all of it."""
    (start, end), heights = part, path.points[:, 2]
    along = lengths_along(path.points[:, :2])
    parts: list[tuple[int, int]] = []
    if not np.isin(path.planes[start:end], (0, 17)).all():
        return parts
    while start < end and len(parts) < most:
        first, rows = path.begins[start], path.ends[start : min(end, start + _LONGEST)]
        way, climb = along[rows] - along[first], heights[rows] - heights[first]
        if way[0] == 0.0:
            return []
        low = np.maximum.accumulate((climb - _EVEN * room) / way)
        high = np.minimum.accumulate((climb + _EVEN * room) / way)
        stop = start + int(np.flatnonzero((low <= climb / way) & (climb / way <= high))[-1]) + 1
        parts.append((start, stop))
        start = stop
    return parts if start == end else []


def _flat(
    path: Toolpath, plane: int, part: tuple[int, int], corners: Ints, room: float, rules: Rules,
    exact: tuple[bool, bool], best: bool,
) -> tuple[list[Cut], float]:  # fmt: skip
    axes = list(PLANES[plane])
    flat = _projected(path, axes, part, corners)
    steps = fewest(flat, room, rules, exact, best)
    first = int(path.begins[part[0]])
    cuts = []
    for step in steps:
        at_end = exact[1] and step.end == len(flat.points) - 1
        level = float(flat.height(step.end))
        place = np.full(3, level if at_end or not np.ptp(flat.heights) else round(level, rules.decimals))
        place[axes] = step.piece.end
        x, y, z = place.tolist()
        cuts.append(Cut(first + step.end, (x, y, z), plane, step.piece))
    return cuts, max(step.deviation for step in steps)


def _projected(path: Toolpath, axes: list[int], part: tuple[int, int], corners: Ints) -> Flat:
    """Return the part of a path, from a move to before another, in the plane of two axes."""
    some, first = slice(*part), int(path.begins[part[0]])
    leaving, arriving = path.leaving[some][:, axes], path.arriving[some][:, axes]
    before, after = arriving[:-1], leaving[1:]
    cross = before[:, 0] * after[:, 1] - before[:, 1] * after[:, 0]
    turns = np.concatenate([[0.0], np.arctan2(cross, np.einsum("kd,kd->k", before, after)), [0.0]])
    begins, ends = path.begins[some] - first, path.ends[some] - first
    inside = corners[(corners > part[0]) & (corners < part[1])] - part[0]
    points = path.points[first : int(path.ends[part[1] - 1]) + 1]
    heights = points[:, 3 - sum(axes)]
    return Flat(points[:, axes], begins[inside], begins, ends, path.sweeps[some], turns, heights)


def _straight(
    path: Toolpath, part: tuple[int, int], corners: Ints, room: float, rules: Rules, exact: tuple[bool, bool]
) -> tuple[list[Cut], float]:
    """Return the longest lines, one after the other, that stay within the room of a part of a path."""
    first, last = int(path.begins[part[0]]), int(path.ends[part[1] - 1])
    points = path.points[first : last + 1]
    written = np.round(points, rules.decimals)
    for end, kept in zip((0, -1), exact, strict=True):
        if kept:
            written[end] = points[end]
    inside = corners[(corners > part[0]) & (corners < part[1])]
    cuts, worst, at = [], 0.0, 0
    for stop in [*(path.begins[inside] - first).tolist(), last - first]:
        reach = 1
        while at < stop:
            low, high, far = at + 1, stop + 1, line_deviation(points[at : at + 2], written[at], written[at + 1])
            while high - low > 1:
                to = min(low + reach, stop) if high == stop + 1 else (low + high) // 2
                tried = line_deviation(points[at : to + 1], written[at], written[to])
                if tried <= room:
                    low, far, reach = to, tried, 2 * reach
                else:
                    high, reach = to, max((to - at) // 2, 1)
            worst = max(worst, far)
            x, y, z = written[low].tolist()
            cuts.append(Cut(float(first + low), (x, y, z)))
            at = low
    return cuts, worst


def splines(
    path: Toolpath, tolerance: float, angle: float, rules: Rules, written: Rounding, flat: bool
) -> tuple[list[Cut], float]:
    """Return cubic pieces and lines along a path of lines, as `arcs` does.

    `flat`: pieces are in the plane of X and Y alone; a path that leaves it gets lines.
    """
    cuts: list[Cut] = []
    worst, start, last = 0.0, 0, len(path.begins)
    none = np.zeros(0, dtype=np.intp)
    for end in [*corners_of(path, tolerance, angle).tolist(), last]:
        first, exact = int(path.begins[start]), (start == 0, end == last)
        part = path.points[first : int(path.ends[end - 1]) + 1]
        level = bool((part[:, 2] == part[0, 2]).all())
        lines, far = _straight(path, (start, end), none, tolerance - rules.tick, rules, exact)
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
                lines.append(Cut(float(first + row), (x, y, z), 17 if flat else 0, poles=space))
        cuts += lines
        worst, start = max(worst, far), end
    return cuts, worst


def _rows(points: Array, poles: Array) -> list[int]:
    """Return for each piece the vertex that is taken for its end: rising, the nearest in length."""
    along = lengths_along(points)
    sizes = np.cumsum(np.linalg.norm(np.diff(poles, axis=1), axis=2).sum(axis=1))
    rows = np.searchsorted(along, sizes * along[-1] / sizes[-1])
    m, n = len(rows), len(points)
    rising = np.maximum.accumulate(rows - np.arange(m)) + np.arange(m)
    rows = np.clip(np.minimum(rising, n - m + np.arange(m)), np.arange(1, m + 1), n - 1)
    rows[-1] = n - 1
    return [int(row) for row in rows]
