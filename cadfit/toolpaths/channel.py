"""How far a move, straight or circular, is from the polyline it stands for: upper bounds, both ways.

Each bound comes from a continuous map of the polyline onto the move, from start to start and end to end: nearest point
on a line, the same angle on a circle (outside its sweep: the end). No point of either is farther from the other than
the largest distance under the map, and that occurs at a vertex, at a foot of the centre on a segment, or is bounded by
those: on a segment the distance to a point or to a line is convex, and so is the distance to the centre.
"""

from __future__ import annotations

from math import hypot

import numpy as np

from cadfit.bezier import Array


def line_deviation(points: Array, start: Array, end: Array) -> float:
    """Return the largest distance from the polyline of points (n, d) to the segment from start to end (d,), both ways.

    >>> line_deviation(np.array([[0.0, 0.0], [1.0, 0.1], [2.0, 0.0]]), np.array([0.0, 0.0]), np.array([2.0, 0.0]))
    0.1
    """
    along = end - start
    square = float(along @ along)
    gap = points - start
    if square > 0.0:
        place = np.clip(gap @ along / square, 0.0, 1.0)
        gap = gap - place[:, None] * along
    ends = max(_distance(points[0], start), _distance(points[-1], end))
    return max(float(np.sqrt(np.einsum("nd,nd->n", gap, gap).max())), ends)


def arc_deviation(points: Array, start: Array, end: Array, centre: Array, sweep: float) -> float:
    """Return an upper bound on the distance between the polyline of points (n, 2) and an arc, both ways.

    The arc runs from `start` to `end` (2,) about `centre`, by `sweep` (radians, left turns positive); where its ends
    differ in radius it may have any radius between, as controllers differ there.

    >>> square = np.array([[1.0, 0.0], [0.8, 0.7], [0.0, 1.0]])
    >>> round(arc_deviation(square, square[0], square[-1], np.zeros(2), np.pi / 2), 4)
    0.0637
    """
    radii = (_distance(start, centre), _distance(end, centre))
    low, high = min(radii), max(radii)
    x, y = (points - centre).T
    far = np.sqrt(x * x + y * y)
    step_x, step_y = x[1:] - x[:-1], y[1:] - y[:-1]
    angle, cross = _turned(x, y, start - centre, sweep)
    before, after = angle < 0.0, angle > abs(sweep)
    inside = ~(before | after)
    worst = max(_distance(points[0], start), _distance(points[-1], end))
    if before.any():
        worst = max(worst, float(np.hypot(*(points[before] - start).T).max()))
    if after.any():
        worst = max(worst, float(np.hypot(*(points[after] - end).T).max()))
    if inside.any():
        near = far[inside]
        worst = max(worst, float(near.max()) - low, high - float(near.min()))
    # The feet of the centre on the segments, where these are nearest to it.
    square = step_x * step_x + step_y * step_y
    place = -(x[:-1] * step_x + y[:-1] * step_y)
    has_foot = (place > 0.0) & (place < square) & ~(before[:-1] & before[1:]) & ~(after[:-1] & after[1:])
    if has_foot.any():
        foot = np.abs(cross[has_foot]) / np.sqrt(square[has_foot])
        worst = max(worst, high - float(foot.min()))
    return worst


def climb_deviation(
    points: Array, heights: Array, climb: tuple[float, float],
    start: Array, end: Array, centre: Array | None, sweep: float,
) -> float:  # fmt: skip
    """Return an upper bound on how far heights (n,) of points (n, 2) are from those of a helix or line, under the map.

    The move is as in `arc_deviation` (`centre` None: straight) and rises evenly from one `climb` to the other.

    >>> square = np.array([[1.0, 0.0], [0.8, 0.7], [0.0, 1.0]])
    >>> heights, centre = np.array([0.0, 0.4, 1.0]), np.zeros(2)
    >>> round(climb_deviation(square, heights, (0.0, 1.0), square[0], square[-1], centre, np.pi / 2), 4)
    0.1493
    """
    if centre is None:
        along = end - start
        part, uneven = (points - start) @ along / float(along @ along), np.zeros(len(points) - 1)
    else:
        x, y = (points - centre).T
        angle, cross = _turned(x, y, start - centre, sweep)
        part = angle / abs(sweep)
        # On a segment the angle grows least where it is farthest from the centre: by at least so much of the average.
        square, turn = x * x + y * y, np.abs(np.diff(angle))
        least = np.abs(cross) / np.maximum(turn * np.maximum(square[1:], square[:-1]), 1e-300)
        uneven = np.where(turn > 0.0, 1.0 - np.minimum(least, 1.0), 0.0)
    uneven[((part[:-1] < 0.0) != (part[1:] < 0.0)) | ((part[:-1] > 1.0) != (part[1:] > 1.0))] = 1.0
    there = climb[0] + np.clip(part, 0.0, 1.0) * (climb[1] - climb[0])
    gap = np.abs(heights - there)
    between = np.maximum(gap[1:], gap[:-1]) + uneven * np.abs(np.diff(there))
    return float(max(between.max(), abs(heights[0] - climb[0]), abs(heights[-1] - climb[1])))


def _turned(x: Array, y: Array, first: Array, sweep: float) -> tuple[Array, Array]:
    """Return the angles about the centre from a first arm on, along the sweep, and the products across each segment."""
    cross = x[:-1] * y[1:] - y[:-1] * x[1:]
    angle = np.empty(len(x))
    angle[0] = np.arctan2(first[0] * y[0] - first[1] * x[0], first[0] * x[0] + first[1] * y[0])
    np.cumsum(np.arctan2(cross, x[:-1] * x[1:] + y[:-1] * y[1:]), out=angle[1:])
    angle[1:] += angle[0]
    return (-angle if sweep < 0.0 else angle), cross


def _distance(a: Array, b: Array) -> float:
    return hypot(*(a - b))
