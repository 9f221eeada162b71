"""Parameters for points on a given curve, in order: where along the curve each point belongs.

A nearest-point search alone would lie where a curve crosses or nearly touches itself: it jumps to the wrong branch.
Here a point may not come before the one preceding it. A dynamic programme over samples of the curve finds the branch,
the same over ever finer windows the least largest distance (points may be out of order along the curve: noise), and
Newton's method the foot point where the order leaves room.
"""

from __future__ import annotations

import numpy as np

from cadfit.bezier import Array, Ints, nearest
from cadfit.bspline import BSpline
from cadfit.points.measures import blocks, lengths_along
from cadfit.stages import Progress, unheard

_ROWS, _SAMPLES, _PAIRS = 1000, 8000, 4_000_000  # the most points, samples and pairs the dynamic programme takes
_NEAREST = 1.0 + 1e-6  # times the least distance there is: so near, it is not worth looking for better
_ROUNDS = 5  # windows a sixth as wide each time: 1/7776 of the samples' spacing at the end


def match(spline: BSpline, points: Array, progress: Progress = unheard) -> tuple[Array, Array]:
    """Return parameters (n,), not falling, of checked points (n, d) along the spline, and their distances from there.

    The largest distance is as small as any ordered parameters make it, to 0.05 %, where the branch found is the right
    one: it is the best for a polyline of samples of the curve (of every point up to 1,000; of 1,000 points and then
    wherever the largest distance stood, for more).

    >>> s = BSpline([[0, 0], [1, 0], [2, 0], [3, 0]], [0, 0, 0, 0, 1, 1, 1, 1])
    >>> u, distance = match(s, np.array([[0.0, 1.0], [1.5, 1.0], [3.0, 1.0]]))
    >>> u.round(9), distance
    (array([0. , 0.5, 1. ]), array([1., 1., 1.]))
    """
    u = _interpolated(spline, points)
    if u is not None:
        distance = distances(spline, points, u)
        if distance.max() <= 64 * np.finfo(np.float64).eps * spline.size:
            return u, distance  # the curve passes through the points: no better foot can be told from rounding
    if len(points) <= _ROWS:
        u = _matched(spline, points, *spline.domain)
        return u, distances(spline, points, u)
    if u is None or not _in_reach(spline, points, u):
        u = _spread(spline, points)
    feet = np.empty(len(u))
    for rows in blocks(len(u)):
        progress(rows.start / len(u))
        feet[rows] = foot_points(spline, points[rows], u[rows])
    behind, ahead = np.maximum.accumulate(feet), np.minimum.accumulate(feet[::-1])[::-1]
    u = 0.5 * (behind + ahead)
    return _recheck_largest(spline, points, u, distances(spline, points, u))


def distances(spline: BSpline, points: Array, u: Array) -> Array:
    """Return the distances (n,) of points (n, d) from the curve at the parameters u (n,)."""
    found = np.empty(len(u))
    for rows in blocks(len(u)):
        gap = spline(u[rows]) - points[rows]
        np.sqrt(np.einsum("nd,nd->n", gap, gap), out=found[rows])
    return found


def _interpolated(spline: BSpline, points: Array) -> Array | None:
    """Return the knots at which an interpolating spline of ours meets the points, if the numbers of both fit.

    One, two or three spans a data interval throughout, or three but two in the first and last.
    """
    knots, intervals = spline.distinct_knots, len(points) - 1
    spans = len(knots) - 1
    if intervals and spans % intervals == 0:
        return np.asarray(knots[:: spans // intervals])
    if spans == 3 * intervals - 2:
        return np.asarray(knots[np.clip(3 * np.arange(intervals + 1) - 1, 0, spans)])
    return None


def _in_reach(spline: BSpline, points: Array, u: Array) -> bool:
    """Whether points are nearer to their guessed places than to their neighbours, judged at 1,000 of them."""
    some = np.linspace(0, len(points) - 2, _ROWS).astype(np.intp)
    spacing = np.linalg.norm(points[some + 1] - points[some], axis=1)
    return bool(np.all(distances(spline, points[some], u[some]) <= 0.5 * spacing))


def _matched(spline: BSpline, points: Array, low: float, high: float) -> Array:
    """Return the best ordered parameters between low and high: over samples, then in shrinking windows around them."""
    v, samples = samples_between(spline, low, high, len(points))
    segment, place = best_order(points, samples)
    width = np.diff(v)[segment]
    u = np.maximum.accumulate(v[segment] + place * width)
    for _ in range(_ROUNDS):
        window = np.clip(u[:, None] + width[:, None] * np.linspace(-1.0, 1.0, 15), low, high)
        gap = spline(window) - points[:, None]
        u = window[np.arange(len(u)), best_order_in_windows(window, np.einsum("nkd,nkd->nk", gap, gap))]
        width /= 6.0
    for turn in (slice(0, None, 2), slice(1, None, 2)):  # to the foot, as far as the neighbours leave room
        feet = foot_points(spline, points[turn], u[turn])
        around = np.concatenate([[low], u, [high]])
        feet = np.clip(feet, around[:-2][turn], around[2:][turn])
        nearer = distances(spline, points[turn], feet) < distances(spline, points[turn], u[turn])
        u[turn] = np.where(nearer, feet, u[turn])
    return u


def best_order_in_windows(window: Array, square: Array) -> Ints:
    """Return a column for each row (n,) so that window[row, column] never falls, by the measure of `best_order`.

    `window` (n, k) are parameters rising along each row, whose middle column does not fall; `square` (n, k) the squared
    distances there.

    >>> best_order_in_windows(np.array([[0, 1, 2.0], [0, 1, 2.0]]), np.array([[9, 4, 0.0], [1, 0, 4.0]]))
    array([1, 1])
    """
    before = [np.searchsorted(a, b, side="right") - 1 for a, b in zip(window[:-1], window[1:], strict=True)]
    barred = [np.where(column < 0, np.inf, 0.0) for column in before]
    largest = square[0]
    for row, column, bar in zip(square[1:], before, barred, strict=True):
        largest = np.maximum(row, np.minimum.accumulate(largest)[column] + bar)
    total = np.where(square <= largest.min() * (1.0 + 1e-9), square, np.inf)
    for k, (column, bar) in enumerate(zip(before, barred, strict=True), start=1):
        total[k] += np.minimum.accumulate(total[k - 1])[column] + bar
    chosen = np.empty(len(window), dtype=np.intp)
    last = window.shape[1] - 1
    for k in range(len(window) - 1, -1, -1):
        chosen[k] = int(np.argmin(total[k, : last + 1]))
        last = int(before[k - 1][chosen[k]]) if k else last
    return chosen


def _spread(spline: BSpline, points: Array) -> Array:
    """Return ordered parameters for many points: 1,000 of them matched, the others by length in between."""
    chosen = np.linspace(0, len(points) - 1, _ROWS).astype(np.intp)
    v, samples = samples_between(spline, *spline.domain, _ROWS)
    segment, place = best_order(points[chosen], samples)
    at = np.maximum.accumulate(v[segment] + place * (v[segment + 1] - v[segment]))
    along_points, along_curve = lengths_along(points), lengths_along(samples)
    at_length = np.interp(along_points, along_points[chosen], np.interp(at, v, along_curve))
    return np.asarray(np.interp(at_length, along_curve, v))


def samples_between(spline: BSpline, low: float, high: float, rows: int) -> tuple[Array, Array]:
    """Return parameters and points of the curve between two parameters, for so many rows of points."""
    knots = spline.distinct_knots
    edges = np.concatenate([[low], knots[(knots > low) & (knots < high)], [high]])
    if len(edges) > _SAMPLES // 4:
        edges = edges[np.linspace(0, len(edges) - 1, _SAMPLES // 4).astype(np.intp)]
    mids = spline(np.concatenate([edges[:-1], 0.5 * (edges[:-1] + edges[1:]), edges[1:]])).reshape(
        3, len(edges) - 1, -1
    )
    size = np.linalg.norm(np.diff(mids, axis=0), axis=2).sum(axis=0)
    wanted = min(_SAMPLES, _PAIRS // rows)
    share = size / size.sum() if size.sum() > 0 else np.full(len(size), 1.0 / len(size))
    counts = np.maximum(np.ceil(share * wanted), 2).astype(np.intp)
    within = np.arange(counts.sum()) - np.repeat(np.cumsum(counts) - counts, counts)
    v = np.repeat(edges[:-1], counts) + within * np.repeat(np.diff(edges) / counts, counts)
    v = np.append(np.clip(v, low, high), high)
    return v, spline(v)


def best_order(points: Array, samples: Array) -> tuple[Ints, Array]:
    """Return for each point (n, d) a segment of the polyline `samples` (m, d) and the place on it, in [0, 1].

    The segments, by index, never fall. Of all such choices with the least largest distance, the one of the least sum
    of squares. Dynamic programming over all n m pairs, a row at a time, twice.

    >>> best_order(np.array([[0.2], [2.0], [1.0]]), np.array([[0.0], [1.0], [2.0]]))
    (array([0, 1, 1]), array([0.2, 1. , 0. ]))
    """
    square, place = _squares(points, samples)
    largest = square[0].copy()
    for row in square[1:]:
        np.maximum(row, np.minimum.accumulate(largest, out=largest), out=largest)
    total = np.where(square <= largest.min() * (1.0 + 1e-9), square, np.inf)
    for row in range(1, len(total)):
        total[row] += np.minimum.accumulate(total[row - 1])
    chosen = np.empty(len(points), dtype=np.intp)
    last = total.shape[1] - 1
    for row in range(len(points) - 1, -1, -1):
        chosen[row] = last = int(np.argmin(total[row, : last + 1]))
    return chosen, place[np.arange(len(points)), chosen]


def _squares(points: Array, samples: Array) -> tuple[Array, Array]:
    """Return the squared distances (n, m - 1) of points to the segments of a polyline, and the places on them."""
    centre = samples.mean(axis=0)
    points, starts, along = points - centre, samples[:-1] - centre, np.diff(samples, axis=0)
    length = np.einsum("md,md->m", along, along)
    scale = np.divide(1.0, length, out=np.zeros_like(length), where=length > 0)
    from_start, at_start = np.einsum("md,md->m", starts, along), np.einsum("md,md->m", starts, starts)
    square, ratio = np.empty((2, len(points), len(along)))
    step = max(1, (1 << 17) // len(along))  # rows at a time: they pass through the cache
    for rows in (slice(start, start + step) for start in range(0, len(points), step)):
        some = points[rows]
        place = some @ along.T - from_start
        part = np.clip(place * scale, 0.0, 1.0, out=ratio[rows])
        offset = np.einsum("nd,nd->n", some, some)[:, None] - 2.0 * (some @ starts.T) + at_start
        np.maximum(offset + part * (part * length - 2.0 * place), 0.0, out=square[rows])
    return square, ratio


def foot_points(spline: BSpline, points: Array, u: Array) -> Array:
    """Return the foot points (local minima of distance) that Newton's method reaches from u, each on its own."""
    low, high = spline.domain
    best, rows, target = u.copy(), np.arange(len(u)), np.ascontiguousarray(points.T)
    reach = np.full(len(u), (high - low) / (len(spline.poles) - 3))
    here = trial = u
    square, slope, rate = known = np.full((3, len(u)), np.inf)
    for _ in range(20):
        tried = _slopes(spline, target, trial)
        better = tried[0] < square
        here = np.where(better, trial, here)
        reach = np.where(better, reach, 0.25 * np.minimum(reach, np.abs(trial - here)))
        square, slope, rate = known = np.where(better, tried, known)
        best[rows] = here
        step = np.divide(slope, rate, out=np.zeros_like(slope), where=rate > 0)
        step = np.minimum(np.maximum(step, -reach), reach)
        trial = np.minimum(np.maximum(here - step, low), high)
        # On to those that have much to gain, measured by the larger distances.
        going = slope * (here - trial) > 1e-8 * np.maximum(square, 1e-4 * square.max())
        going &= np.abs(trial - here) > 1e-14 * (high - low)
        if not going.any():
            break
        rows, here, trial, reach = rows[going], here[going], trial[going], reach[going]
        target, known = target[:, going], known[:, going]
        square = known[0]
    return best


def _slopes(spline: BSpline, points: Array, u: Array) -> tuple[Array, Array, Array]:
    """Return the squares (n,) of the distances of points (d, n) from the curve at u, and half their slopes and rates.

    Quickest where parameters are in order: Taylor's polynomial is computed once for neighbours in one span. Where the
    distance curves down, or hardly up, the rate is Gauss and Newton's: toward a minimum, never a maximum.
    """
    span = np.minimum(np.searchsorted(spline.knots, u, side="right"), len(spline.poles)) - 1
    fresh = np.concatenate([[True], span[1:] != span[:-1]])
    which, own, start = np.cumsum(fresh) - 1, span[fresh], spline.knots[span]
    p0, p1, p2, p3 = spline.pieces_of(own).transpose(1, 2, 0)
    width = spline.knots[own + 1] - spline.knots[own]
    square = width * width
    powers = [
        p0,
        (p1 - p0) * (3.0 / width),
        (p0 - 2.0 * p1 + p2) * (3.0 / square),
        (p3 - p0 + 3.0 * (p1 - p2)) / (square * width),
    ]
    base, first, second, third = np.stack(powers).take(which, axis=2)
    x = u - start
    third *= x
    gap = ((third + second) * x + first) * x + base - points
    bend = 2.0 * (third + second)
    velocity = (bend + third) * x + first
    bend += 4.0 * third
    square, slope, flat = (np.einsum("dn,dn->n", *pair) for pair in ((gap, gap), (gap, velocity), (velocity, velocity)))
    rate = flat + np.einsum("dn,dn->n", gap, bend)
    return square, slope, np.where(rate > 0.1 * flat, rate, flat)


def _recheck_largest(spline: BSpline, points: Array, u: Array, distance: Array) -> tuple[Array, Array]:
    """Match anew the stretch around the largest distance, until that does not reduce it; both are changed in place."""
    checked = np.zeros(len(u), dtype=bool)
    for _ in range(64):
        worst = int(np.argmax(distance))
        if checked[worst]:
            break
        rows = slice(max(worst - _ROWS // 2, 0), min(worst + _ROWS // 2, len(u)))
        low = spline.domain[0] if rows.start == 0 else float(u[rows.start])
        high = spline.domain[1] if rows.stop == len(u) else float(u[rows.stop - 1])
        checked[rows] = True
        if low < high and distance[worst] > _NEAREST * _least_distance(spline, points[worst], low, high):
            new = _matched(spline, points[rows], low, high)
            new_distance = distances(spline, points[rows], new)
            if new_distance.max() < distance[rows].max():
                u[rows], distance[rows] = new, new_distance
    return u, distance


def _least_distance(spline: BSpline, point: Array, low: float, high: float) -> float:
    """Return the distance from the point to the spans between two parameters: no order makes it smaller."""
    first, stop = np.searchsorted(spline.knots, low, side="right") - 1, np.searchsorted(spline.knots, high)
    spans = np.arange(first, stop)
    spans = spans[spline.knots[spans + 1] > spline.knots[spans]]
    return float(nearest(spline.pieces_of(spans), point[None])[2][0])
