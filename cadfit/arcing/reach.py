"""Which arcs between which places of a curve stay within a tolerance: what `chain` chooses from.

Places (nodes) are chosen densely along a smooth stretch. All arcs through two of them form a family with one number,
the bulge b = tan(sweep / 4); at each curve point between them those within the tolerance form an interval of b, whose
ends are roots of quadratics. Their intersection, turned into angles of the arc's start against the curve's tangent, is
what a pair of nodes offers. Points between nodes are sampled: what is chosen in the end is certified by `within`.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from cadfit.bezier import Array, Ints

_PER_ARC = 20.0  # nodes in the length of an arc, where the curvature changes evenly
_PER_TURN = 36.0  # nodes in a full turn, at least
_LEAST = 24.0  # nodes in a stretch, at least
FARTHEST = 64  # nodes that an arc may span
_MOST = 128  # samples to look at between two nodes
_SAMPLES = 16  # of a piece's density


@dataclass(frozen=True, slots=True, eq=False)
class Nodes:
    """Places of a stretch: `at` (n,) piece and parameter as one number, `rows` (n,) of the samples.

    Samples, at the nodes and between them: their `places` (s,), `points` (s, 2) and, unwrapped, the directions of the
    tangent `angles` (s,).
    """

    at: Array
    rows: Ints
    places: Array
    points: Array
    angles: Array

    def only(self, some: NDArray[np.bool_]) -> Nodes:
        """Return some of the nodes (n,), with all samples."""
        return Nodes(self.at[some], self.rows[some], self.places, self.points, self.angles)


@dataclass(frozen=True, slots=True, eq=False)
class Edges:
    """Pairs of nodes that arcs can join, sorted by where they start; those of node i are rows first[i] to first[i + 1].

    `start`, `end` (e,): the nodes. `low`, `high` (e,): between them, the angle of the arc's start against the curve's
    tangent; `total` (e,): that angle and the same at the end add up to this. `back` (e,): the rows sorted by where
    they end; those of node j are back[into[j]] to back[into[j + 1] - 1].
    """

    first: Ints
    into: Ints
    back: Ints
    start: Ints
    end: Ints
    low: Array
    high: Array
    total: Array


def place_nodes(pieces: Array, tolerance: float, density: float) -> Nodes:
    """Choose nodes along Bézier pieces (m, 4, 2) that follow each other without corners.

    Where the curvature changes by c in a unit of length, an arc within the tolerance e is (124.7 e / c)^(1/3) long: of
    all quadratic splines with even knots the one nearest to a cubic misses it by a Bernoulli polynomial.
    """
    m = len(pieces)
    t = (np.arange(_SAMPLES) + 0.5) / _SAMPLES
    first, second, third = _derivatives(pieces, t)
    speed = np.maximum(np.hypot(first[..., 0], first[..., 1]), 1e-300)
    bend = _cross(first, second) / speed**3
    change = _cross(first, third) / speed**3 - 3.0 * bend * np.einsum("mtd,mtd->mt", first, second) / speed**2
    with np.errstate(over="ignore", invalid="ignore"):
        wanted = np.cbrt(np.abs(change / speed) / (124.7 * tolerance))
        wanted = _PER_ARC * np.nan_to_num(np.minimum(wanted, 1.0 / tolerance), nan=0.0)
    steps = speed / _SAMPLES
    turned = np.minimum(np.abs(bend) * steps, np.pi)
    mass = density * (wanted * steps + _PER_TURN / (2.0 * np.pi) * turned + _LEAST * steps / max(steps.sum(), 1e-300))
    total = np.concatenate([[0.0], np.cumsum(mass.ravel())])
    count = max(int(np.ceil(total[-1])), 2)
    level = np.linspace(0.0, total[-1], 2 * count + 1)
    at = np.interp(level, total, np.arange(m * _SAMPLES + 1) / _SAMPLES)
    at[0], at[-1] = 0.0, m
    at = at[np.concatenate([[True], np.diff(at) > 0.0])]
    at = at if len(at) % 2 else np.delete(at, -2)
    points, tangent = points_at(pieces, at)
    angles = np.unwrap(np.arctan2(tangent[:, 1], tangent[:, 0]))
    return Nodes(at[::2], np.arange(0, len(at), 2), at, points, angles)


def thinned(nodes: Nodes, edges: Edges) -> Nodes | None:
    """Return fewer nodes where arcs reach over many (bends smaller than the tolerance); None where few do."""
    farthest = np.maximum.reduceat(edges.end - edges.start, np.minimum(edges.first[:-1], len(edges.end) - 1))
    far = farthest >= FARTHEST
    if far.mean() < 0.5 or len(nodes.at) < 4 * FARTHEST:
        return None
    share = np.where(far, 2.0 * _PER_ARC / FARTHEST, 1.0)
    whole = np.floor(np.cumsum(share) + 1e-9)
    some = np.diff(whole, prepend=0.0) > 0.0
    some[[0, -1]] = True
    return nodes.only(some) if not some.all() else None


def points_at(pieces: Array, at: Array) -> tuple[Array, Array]:
    """Return points (n, 2) and derivatives (n, 2) at piece and parameter as one number (n,)."""
    k = np.minimum(at.astype(np.intp), len(pieces) - 1)
    t = (at - k)[:, None]
    p, s = pieces[k], 1.0 - t
    points = s**3 * p[:, 0] + 3.0 * s * s * t * p[:, 1] + 3.0 * s * t * t * p[:, 2] + t**3 * p[:, 3]
    legs = np.diff(p, axis=1)
    tangent = s * s * legs[:, 0] + 2.0 * s * t * legs[:, 1] + t * t * legs[:, 2]
    # Where a curve stands still at an end of a piece, it leaves along the next leg.
    still = np.hypot(tangent[:, 0], tangent[:, 1]) <= 1e-12 * np.abs(legs).max(axis=(1, 2))
    around = np.where(t < 0.5, p[:, 2] - p[:, 0], p[:, 3] - p[:, 1])
    return points, np.where(still[:, None], around, tangent)


def feasible(nodes: Nodes, tolerance: float, max_radius: float) -> Edges:
    """Return the pairs of nodes that an arc of at most half a turn can join, staying within the tolerance.

    Arcs with a larger radius than `max_radius` are left out, but for those in whose place a line can be.
    """
    n = len(nodes.at)
    alive, misses = np.arange(n - 1), np.zeros(n - 1, dtype=np.intp)
    found = []
    for step in range(1, min(n, FARTHEST + 1)):
        keep = (misses < 4) & (alive + step < n)
        alive, misses = alive[keep], misses[keep]
        if not len(alive):
            break
        low, high, total = _between(nodes, alive, step, tolerance, max_radius)
        good = low <= high
        found.append((alive[good], alive[good] + step, low[good], high[good], total[good]))
        misses = np.where(good, 0, misses + 1)
    start, end, low, high, total = (np.concatenate(column) for column in zip(*found, strict=True))
    order = np.lexsort((end, start))
    start, end = start[order], end[order]
    back, each = np.argsort(end, kind="stable"), np.arange(n + 1)
    first, into = np.searchsorted(start, each), np.searchsorted(end[back], each)
    return Edges(first, into, back, start, end, low[order], high[order], total[order])


def _between(nodes: Nodes, start: Ints, step: int, tolerance: float, max_radius: float) -> tuple[Array, Array, Array]:
    """Return lowest and highest start angle, and total, of arcs from each of `start` (k,) to the node `step` later."""
    first, last = nodes.rows[start, None], nodes.rows[start + step, None]
    count = min(int((last - first).max()), _MOST)
    rows = first + ((last - first) * np.arange(count + 1)) // count
    points, angles = nodes.points[rows], nodes.angles[rows]
    chord = points[:, -1] - points[:, 0]
    length = np.hypot(chord[:, 0], chord[:, 1])
    half = 0.5 * length
    unit = chord / np.where(length > 0.0, length, 1.0)[:, None]
    offset = points[:, 1:-1] - 0.5 * (points[:, :1] + points[:, -1:])
    x = np.einsum("ksd,kd->ks", offset, unit)
    y = -(unit[:, None, 0] * offset[..., 1] - unit[:, None, 1] * offset[..., 0])  # to the right: left turns bulge there
    c = half[:, None]
    room = c * c + tolerance * tolerance - x * x - y * y
    inner, outer = c * (y - tolerance), c * (y + tolerance)
    root = room * room + 4.0 * inner * outer
    ends = np.minimum((x - c) ** 2, (x + c) ** 2) + y * y <= tolerance * tolerance
    free = ends | (root < 0.0)
    denominator = room + np.sqrt(np.maximum(root, 0.0))
    safe = np.where(denominator > 0.0, denominator, 1e-300)
    with np.errstate(over="ignore"):
        low = np.where(free, -1.0, 2.0 * inner / safe).max(axis=1)
        high = np.where(free, 1.0, 2.0 * outer / safe).min(axis=1)
    flat = np.minimum(half / (2.0 * max_radius), 1.0)
    low = np.where(low > 0.0, np.maximum(low, flat), np.maximum(low, -1.0))
    high = np.where(high < 0.0, np.minimum(high, -flat), np.minimum(high, 1.0))
    direction = np.arctan2(chord[:, 1], chord[:, 0])
    turn = angles - direction[:, None]
    turn -= 2.0 * np.pi * np.round(0.5 * (turn[:, :1] + turn[:, -1:]) / (2.0 * np.pi))
    straying = (np.abs(turn) > 1.7).any(axis=1) | (length == 0.0)
    low = np.where(straying, 1.0, low)
    high = np.where(straying, -1.0, high)
    before, after = -turn[:, 0], -turn[:, -1]
    return before - 2.0 * np.arctan(high), before - 2.0 * np.arctan(low), before + after


def _derivatives(pieces: Array, t: Array) -> tuple[Array, Array, Array]:
    """Return the first three derivatives (m, len(t), 2) by the pieces' own parameters."""
    first, second, third = (np.diff(pieces, n=k, axis=1) for k in (1, 2, 3))
    t, s = t[:, None], 1.0 - t[:, None]
    velocity = 3.0 * (s * s * first[:, None, 0] + 2.0 * s * t * first[:, None, 1] + t * t * first[:, None, 2])
    bend = 6.0 * (s * second[:, None, 0] + t * second[:, None, 1])
    return velocity, bend, np.broadcast_to(6.0 * third, bend.shape)


def _cross(a: Array, b: Array) -> Array:
    return np.asarray(a[..., 0] * b[..., 1] - a[..., 1] * b[..., 0])
