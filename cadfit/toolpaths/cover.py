"""A smooth stretch of a path, in a plane, covered with the longest lines and arcs that stay within a tolerance."""

from __future__ import annotations

from collections.abc import Callable
from math import cos, radians
from typing import NamedTuple

import numpy as np

from cadfit.bezier import Array
from cadfit.toolpaths.biarcs import Piece, Point, Rules, arc_from, biarc
from cadfit.toolpaths.tangents import directions

_LINE_KINK = cos(radians(0.5))  # a line may turn off the path's direction by so much
_ARC_KINK = cos(radians(3.0))  # where an arc ends the next begins, without a kink: so far off the path's direction

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
    tangents, inward = directions(points, least)
    far = np.sqrt(np.einsum("nd,nd->n", inward, inward))
    nodes = points + np.where(far <= _MOST_MOVED * tolerance, 1.0, 0.0)[:, None] * inward
    written = [rules.rounded((float(x), float(y))) for x, y in nodes]
    for end, kept in zip((0, -1), exact, strict=True):
        if kept:
            written[end] = (float(points[end, 0]), float(points[end, 1]))
    headings = [(float(x), float(y)) for x, y in tangents]
    n, at, heading, last_reach = len(points), 0, headings[0], [2, 2, 3]
    steps: list[Step] = []
    while at < n - 1:
        best = _chord(points, written, at)
        for kind, make in enumerate((_line, _arc, _biarc)):

            def tried(last: int, make: Callable[..., Step | None] = make) -> Step | None:
                return make(points, written, headings, at, last, heading, tolerance, rules)  # noqa: B023

            found = _farthest(tried, at, n - 1, last_reach[kind], 3 if kind == 2 else 2)
            if found is not None:
                last_reach[kind] = found.last - at
                best = max(best, found, key=lambda step: ((step.last - step.first) / len(step.pieces), step.last))
        steps.append(best)
        at = best.last
        heading = headings[at] if best.last - best.first == 1 else best.pieces[-1].direction(True)
    return _as_they_were(steps, points, written, rules)


def _as_they_were(steps: list[Step], points: Array, written: list[Point], rules: Rules) -> list[Step]:
    """Return the steps with the vertices between two chords where they were: moving them gained nothing."""
    chord = [step.last - step.first == 1 for step in steps]
    for k in range(len(steps) - 1):
        if chord[k] and chord[k + 1]:
            x, y = points[steps[k].last]
            written[steps[k].last] = rules.rounded((float(x), float(y)))
    return [_chord(points, written, step.first) if kept else step for step, kept in zip(steps, chord, strict=True)]


def _farthest(tried: Callable[[int], Step | None], at: int, end: int, guess: int, least: int) -> Step | None:
    """Return the step to the farthest vertex that can be had, if one is at least so many chords away."""
    if at + least > end:
        return None
    reach = max(guess, least)
    found, low, high = None, at + least - 1, end + 1  # low can be had (or is no step), high cannot
    while high - low > 1:
        last = min(at + reach, end) if low < at + reach < high else (low + high) // 2
        step = tried(last)
        if step is None:
            if found is None and last > at + least:
                reach = max((last - at) // 2, least)
            high = last
        else:
            found, low = step, last
            reach = (last - at) * 2
    return found


def _chord(points: Array, written: list[Point], at: int) -> Step:
    piece = Piece(written[at], written[at + 1])
    return Step(at, at + 1, (piece,), piece.deviation(points[at : at + 2]))


def _line(
    points: Array,
    written: list[Point],
    headings: list[Point],
    at: int,
    last: int,
    heading: Point,
    room: float,
    rules: Rules,
) -> Step | None:
    piece = Piece(written[at], written[last])
    x, y = piece.direction(False)
    if at > 0 and x * heading[0] + y * heading[1] < _LINE_KINK:
        return None
    if last < len(points) - 1 and x * headings[last][0] + y * headings[last][1] < _LINE_KINK:
        return None
    far = piece.deviation(points[at : last + 1])
    return Step(at, last, (piece,), far) if far <= room else None


def _arc(
    points: Array,
    written: list[Point],
    headings: list[Point],
    at: int,
    last: int,
    heading: Point,
    room: float,
    rules: Rules,
) -> Step | None:
    piece = arc_from(written[at], heading, written[last], rules)
    if piece is None or piece.centre is None:
        return None
    x, y = piece.direction(True)
    if last < len(points) - 1 and x * headings[last][0] + y * headings[last][1] < _ARC_KINK:
        return None
    far = piece.deviation(points[at : last + 1])
    return Step(at, last, (piece,), far) if far <= room else None


def _biarc(
    points: Array,
    written: list[Point],
    headings: list[Point],
    at: int,
    last: int,
    heading: Point,
    room: float,
    rules: Rules,
) -> Step | None:
    pair = biarc(written[at], heading, written[last], headings[last], rules)
    if pair is None:
        return None
    part = points[at : last + 1]
    halves = _halves(part, pair[0])
    if halves is None:
        return None
    far = max(piece.deviation(half) for piece, half in zip(pair, halves, strict=True))
    return Step(at, last, pair, far) if far <= room else None


def _halves(points: Array, first: Piece) -> tuple[Array, Array] | None:
    """Return the polyline in two parts, cut where it passes the end of a piece: at the normal nearest to it."""
    end, along = np.array(first.end), np.array(first.direction(True))
    gap = points - end
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
