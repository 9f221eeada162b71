"""Chords between neighbouring points and the parts of a curve over them: how far one strays from the other."""

from __future__ import annotations

from itertools import accumulate

import numpy as np

from cadfit.bezier import Array, Ints, restrict, split
from cadfit.bspline import BSpline
from cadfit.points.measures import blocks

_MOST_INSIDE = 2  # knots inside a chord: three may be one triple knot, at which the tangent breaks


def chord_bounds(spline: BSpline, u: Array, gaps: Array) -> Array:
    """Return a first upper bound (n - 1,) on how far the curve between u[i] and u[i + 1] strays from each chord.

    `u` (n,) not falling; `gaps` (n,) the distances from the curve there to the chords' ends. Infinite for chords with
    more than two knots inside: these are to be cut.

    What the curve leaves its own chord by is zero at both ends and has the curve's second derivative, whose size is at
    most linear between its sizes at the ends and the knots. So it is at most the function that is zero at both ends
    and has minus these sizes for its second derivative: concave, and cubic from knot to knot. With it goes the
    distance of the chords, at most linear. For a plane arc over a parallel chord the sum is exact.

    >>> arc = BSpline([[0.0, 0.0], [1, 1], [2, 1], [3, 0]], [0, 0, 0, 0, 1, 1, 1, 1])
    >>> chord_bounds(arc, np.array([0.0, 1.0]), np.zeros(2))
    array([0.75])
    """
    upper = np.full(len(u) - 1, np.inf)
    for rows in blocks(len(upper)):
        ends = slice(rows.start, rows.stop + 1)
        at, gap, bound = u[ends], gaps[ends], upper[rows]
        first = np.searchsorted(spline.knots, at[:-1], side="right") - 1
        np.minimum(first, len(spline.poles) - 1, out=first)
        last = np.maximum(np.searchsorted(spline.knots, at[1:], side="left") - 1, first)
        bends = _second_derivatives(spline, int(first[0]), int(last[-1]))
        before, after = (_sizes_at(spline, bends, first[0], *ends) for ends in ((first, at[:-1]), (last, at[1:])))
        sizes = np.sqrt(np.einsum("dk,dk->k", bends, bends))
        for inside in range(_MOST_INSIDE + 1):
            chosen = np.flatnonzero(last - first == inside)
            if not len(chosen):
                continue
            knots = first[chosen] + np.arange(1, inside + 1)[:, None]
            places = np.array([at[chosen], *spline.knots[knots], at[chosen + 1]])
            bend = np.array([before[chosen], *sizes[knots - first[0]], after[chosen]])
            bound[chosen] = _largest_over_knots(gap[chosen], gap[chosen + 1], places[1:] - places[:-1], bend)
    return upper


def _second_derivatives(spline: BSpline, first: int, last: int) -> Array:
    """Return the second derivatives (d, last - first + 2) at the knots from number `first` to `last` + 1.

    They are the poles of the second derivative. At a double knot it jumps, from the value of the first to that of the
    second; the middle one of a triple knot belongs to no span.
    """
    t, poles = spline.knots, np.ascontiguousarray(spline.poles[first - 3 : last + 1].T)
    slopes = (poles[:, 1:] - poles[:, :-1]) / (t[first + 1 : last + 4] - t[first - 2 : last + 1])
    widths = t[first + 1 : last + 3] - t[first - 1 : last + 1]
    scales = np.divide(6.0, widths, out=np.zeros_like(widths), where=widths > 0.0)
    return np.asarray((slopes[:, 1:] - slopes[:, :-1]) * scales)


def _sizes_at(spline: BSpline, bends: Array, offset: int, span: Ints, u: Array) -> Array:
    """Return the size (n,) of the second derivative at u (n,), seen from its span; `bends` start at knot `offset`."""
    start = spline.knots[span]
    share = (u - start) / (spline.knots[span + 1] - start)
    left, right = bends.take(span - offset, axis=1), bends.take(span - offset + 1, axis=1)
    right -= left
    right *= share
    right += left
    return np.asarray(np.sqrt(np.einsum("dn,dn->n", right, right)))


def _largest_over_knots(start: Array, end: Array, steps: Array, bend: Array) -> Array:
    """Return the largest values (n,) of the concave functions of `chord_bounds`.

    `start` and `end` (n,) are their values at the ends, `steps` (k, n) the spaces between knots, and `bend` (k + 1, n)
    minus their second derivatives at ends and knots.
    """
    first, last = steps * steps * bend[:-1] / 6.0, steps * steps * bend[1:] / 6.0
    if len(steps) == 1:
        return largest_cubic(start, end, first[0], last[0])
    turns = _running(0.5 * steps * (bend[:-1] + bend[1:]))
    falls = 2.0 * first + last
    falls[1:] += turns[:-1] * steps[1:]
    falls = _running(falls)  # of a function that starts level, at zero
    along = _running(steps)
    inner = start + along[:-1] * ((end - start + falls[-1]) / along[-1]) - falls[:-1]
    values = np.concatenate([start[None], inner, end[None]])
    return np.asarray(largest_cubic(values[:-1], values[1:], first, last).max(axis=0))


def _running(rows: Array) -> Array:
    """Return the running sums of a few long rows, for which numpy's own go column by column."""
    return np.array([*accumulate(rows)])


def largest_cubic(start: Array, end: Array, first: Array, last: Array) -> Array:
    """Return the largest value over t in [0, 1] of (1 - t) start + t end + t (1 - t) ((2 - t) first + (1 + t) last).

    With `first` and `last` the sizes of a cubic's second derivative at both ends times width^2 / 6, the last term is
    how far the cubic leaves its chord at most; with `start` and `end` the distances to a convex set at the ends, the
    first two bound the chord's. The sum is concave in t.
    """
    a, b = 2.0 * first + last, last - first
    rise, turn = end - start + a, 2.0 * (a - b)  # the slope is rise - turn t - 3 b t^2
    square = turn * turn + 12.0 * b * rise
    bottom = turn + np.sqrt(np.maximum(square, 0.0))
    t = np.divide(2.0 * rise, bottom, out=np.ones_like(rise), where=(bottom > 0) & (square >= 0))
    t = np.clip(t, 0.0, 1.0)
    largest = start + t * (end - start) + t * (1.0 - t) * (a + b * t)
    return np.asarray(np.maximum(largest, np.maximum(start, end)))


def pieces_over(spline: BSpline, knots: Array, points: Array, u: Array, chords: Ints) -> tuple[Array, Array, Ints]:
    """Return the Bézier pieces (4, 1 + d, k) of the curve over some chords, seen from these; their lengths; the chords.

    Seen from a chord: the first coordinate runs along it from its start, the others are what is across. The pieces
    stand in the last place: long rows are what numpy is quick at.
    """
    first, stop = _knots_inside(knots, u[chords], u[chords + 1])
    counts = stop - first + 1
    chord = np.repeat(chords, counts)
    within = np.arange(len(chord)) - np.repeat(np.cumsum(counts) - counts, counts)
    knot = np.minimum(np.repeat(first, counts) + within, len(knots) - 1)
    low = np.where(within == 0, u[chord], knots[knot - 1])
    high = np.where(within == np.repeat(counts, counts) - 1, u[chord + 1], knots[knot])
    span = np.searchsorted(spline.knots, knots[knot], side="left") - 1
    start, width = spline.knots[span], knots[knot] - spline.knots[span]
    pieces = spline.pieces_of(span)
    part = (low > start) | (high < knots[knot])
    if part.any():
        ends = ((side[part] - start[part]) / width[part] for side in (low, high))
        pieces[part] = restrict(pieces[part], *ends)
    pieces = pieces.transpose(1, 2, 0)
    here = np.ascontiguousarray(points[chord].T)
    direction = points[chord + 1].T - here
    length = np.sqrt(np.einsum("dk,dk->k", direction, direction))
    direction = np.divide(direction, length, out=np.zeros_like(here), where=length > 0)
    seen = np.empty((4, len(here) + 1, len(length)))
    np.subtract(pieces, here, out=seen[:, 1:])
    seen[:, 0] = np.einsum("pdk,dk->pk", seen[:, 1:], direction)
    seen[:, 1:] -= seen[:, :1] * direction
    return seen, length, chord


def _knots_inside(knots: Array, low: Array, high: Array) -> tuple[Ints, Ints]:
    """Return the range of the distinct knots strictly between low and high (empty: first == stop)."""
    first = np.searchsorted(knots, low, side="right")
    return first, np.maximum(np.searchsorted(knots, high, side="left"), first)


def halves(pieces: Array) -> Array:
    """Return the first and then the second halves of pieces (4, d, k), as (4, d, 2 k)."""
    return np.concatenate([half.transpose(1, 2, 0) for half in split(pieces.transpose(2, 0, 1))], axis=2)


def segment_bounds(pieces: Array, length: Array) -> tuple[Array, Array]:
    """Return the distances (2, k) of the ends of pieces from their segments, and an upper bound (k,) over each piece.

    Across the segment the bound is `largest_cubic`; beyond the segment's ends, the hull of the poles.
    """
    along, across = pieces[:, 0], pieces[:, 1:]
    beyond = np.maximum(np.maximum(-along, along - length), 0.0)
    size = np.sqrt(np.einsum("pdk,pdk->pk", across[::3], across[::3]))
    bend = across[:2] - 2.0 * across[1:3] + across[2:]
    aside = largest_cubic(*size, *np.sqrt(np.einsum("pdk,pdk->pk", bend, bend)))
    return np.hypot(size, beyond[::3]), np.hypot(aside, beyond.max(axis=0))
