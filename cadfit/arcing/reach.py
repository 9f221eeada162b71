"""Which arcs between which nodes of a curve stay within a tolerance: what `chain` chooses from.

All arcs through two nodes form a family with one number, the bulge b = tan(sweep / 4); at each curve point between them
those within the tolerance form an interval of b, whose ends are roots of quadratics. Their intersection, turned into
angles of the arc's start against the curve's tangent, is what a pair of nodes offers. Points between nodes are sampled:
what is chosen in the end is certified.
"""

from __future__ import annotations

from dataclasses import dataclass, fields
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from cadfit.arcing.nodes import PER_ARC, Nodes, Samples
from cadfit.bezier import Array, Ints

FARTHEST = 64  # rows of nodes that an arc may span
_MISSES = 4  # rows one after another that no arc reaches: then none farther on is tried
_MOST = 128  # samples to look at between two nodes
_AT_ONCE = 1 << 13  # samples
_ALL = 1e9  # bulges: any


class Limits(NamedTuple):
    """What arcs must keep to: the distance from the curve, their radii, and the largest sweep (radians)."""

    tolerance: float
    max_radius: float
    min_radius: float = 0.0
    widest: float = np.pi


@dataclass(frozen=True, slots=True, eq=False)
class Links:
    """Pairs of nodes that a line or an arc can join.

    `start`, `end` (e,): the nodes. `low`, `high` (e,): between them, the angle of the arc's start against the curve's
    tangent; `total` (e,): that angle and the same at the end add up to this.

    Where `sweep` (e,) is a number and not NaN, there is one such arc (0: a line), which need not go on in the direction
    of the one before and that of the next: these may be between `low` and `high`, and between `exit_low` and
    `exit_high` (e,). `rank` (e,): of several such, or arcs (0 to 0.5), the one that is preferred has the highest.
    """

    start: Ints
    end: Ints
    low: Array
    high: Array
    total: Array
    exit_low: Array
    exit_high: Array
    sweep: Array
    rank: Array

    @classmethod
    def arcs(cls, start: Ints, end: Ints, low: Array, high: Array, total: Array) -> Links:
        """Return the links of arcs that go on in the direction of the one before."""
        none = np.full(len(start), np.nan)
        return cls(start, end, low, high, total, none, none, none, np.zeros(len(start)))

    def of(self, rows: Ints | NDArray[np.bool_]) -> Links:
        """Return some of the links."""
        return Links(*(getattr(self, each.name)[rows] for each in fields(self)))

    def and_more(self, *others: Links) -> Links:
        """Return these links and others."""
        every = (self, *others)
        return Links(*(np.concatenate([getattr(links, each.name) for links in every]) for each in fields(self)))


@dataclass(frozen=True, slots=True, eq=False)
class Edges:
    """Links of nodes, sorted by where they start, those of node i being rows first[i] to first[i + 1] - 1.

    `back` (e,): the rows sorted by where they end; those of node j are back[into[j]] to back[into[j + 1] - 1]. `place`
    (n,): which row of nodes each node is in.
    """

    nodes: Nodes
    links: Links
    place: Ints
    first: Ints
    into: Ints
    back: Ints

    @classmethod
    def of(cls, nodes: Nodes, links: Links) -> Edges:
        """Return the edges of links between nodes."""
        links = links.of(np.lexsort((links.end, links.start)))
        back, each = np.argsort(links.end, kind="stable"), np.arange(len(nodes.rows) + 1)
        first, into = np.searchsorted(links.start, each), np.searchsorted(links.end[back], each)
        return cls(nodes, links, np.cumsum(np.diff(nodes.rows, prepend=nodes.rows[0]) > 0), first, into, back)


def feasible(nodes: Nodes, limits: Limits) -> Links:
    """Return the pairs of nodes that an arc within the limits can join.

    Arcs with a larger radius than the largest are left out, but for those in whose place a line can be.
    """
    table = nodes.table
    p = len(table)
    ends = np.append(np.flatnonzero(nodes.corners[table[:, 0]]), p - 1)
    stop = ends[np.minimum(np.searchsorted(ends, np.arange(p), side="right"), len(ends) - 1)]
    alive, misses = np.arange(p - 1), np.zeros(p - 1, dtype=np.intp)
    found = []
    for step in range(1, min(p, FARTHEST + 1)):
        keep = (misses < _MISSES) & (alive + step <= stop[alive])
        alive, misses = alive[keep], misses[keep]
        if not len(alive):
            break
        start, end = np.broadcast_arrays(table[alive, :, None], table[alive + step, None, :])
        real = (start >= 0) & (end >= 0)
        of = np.broadcast_to(np.arange(len(alive))[:, None, None], real.shape)[real]
        start, end = start[real], end[real]
        low, high, total = between(nodes, start, end, limits)
        good = low <= high
        found.append((start[good], end[good], low[good], high[good], total[good]))
        reached = np.bincount(of[good], minlength=len(alive)) > 0
        misses = np.where(reached, 0, misses + 1)
    return Links.arcs(*(np.concatenate(column) for column in zip(*found, strict=True)))


def thinned(nodes: Nodes, links: Links) -> Nodes | None:
    """Return fewer nodes where arcs reach over many (bends smaller than the tolerance); None where few do."""
    farthest = np.zeros(len(nodes.rows), dtype=np.intp)
    np.maximum.at(farthest, links.start, links.end - links.start)
    far = farthest >= FARTHEST
    if far.mean() < 0.5 or len(nodes.rows) < 4 * FARTHEST:
        return None
    share = np.where(far, 2.0 * PER_ARC / FARTHEST, 1.0)
    whole = np.floor(np.cumsum(share) + 1e-9)
    some = np.diff(whole, prepend=0.0) > 0.0
    some[[0, -1]] = True
    return nodes.only(some) if not some.all() else None


def between(nodes: Nodes, start: Ints, end: Ints, limits: Limits) -> tuple[Array, Array, Array]:
    """Return lowest and highest start angle, and total, of arcs from nodes `start` (k,) to nodes `end` (k,)."""
    samples, k = nodes.samples, len(start)
    first, last = nodes.rows[start], nodes.rows[end]
    count = min(int((last - first).max()), _MOST)
    at_once = max(_AT_ONCE // count, 1)
    parts = []
    for a in range(0, k, at_once):
        some = slice(a, a + at_once)
        rows = first[some, None] + ((last - first)[some, None] * np.arange(count + 1)) // count
        ends = nodes.spots[start[some]], nodes.spots[end[some]]
        parts.append(_spanned(samples, rows, *ends, limits))
    low, high, direction = (np.concatenate(each) for each in zip(*parts, strict=True))
    before, after = samples.angles[first], samples.angles[last]
    return (
        direction - before - 2.0 * np.arctan(high),
        direction - before - 2.0 * np.arctan(low),
        2.0 * direction - before - after,
    )


def _spanned(samples: Samples, rows: Ints, a: Array, b: Array, limits: Limits) -> tuple[Array, Array, Array]:
    """Return the lowest and highest bulges (k,) of arcs from a to b (k, 2) near samples (k, s), and the chords' angles.

    With c half the chord, a point (x, y) in its frame is within the tolerance e of the arc of bulge B where
    c (y + e) B^2 + r B - c (y - e) >= 0 and c (y - e) B^2 + r B - c (y + e) <= 0, r = c^2 + e^2 - x^2 - y^2.
    """
    chord = b - a
    length = np.hypot(chord[:, 0], chord[:, 1])
    c, e = 0.5 * length[:, None], limits.tolerance
    unit = chord / np.where(length > 0.0, length, 1.0)[:, None]
    inside = samples.points[rows[:, 1:-1]]
    if not inside.shape[1]:
        inside = samples.points[rows].mean(axis=1, keepdims=True)
    offset = inside - 0.5 * (a + b)[:, None]
    x = np.einsum("ksd,kd->ks", offset, unit)
    y = unit[:, 1, None] * offset[..., 0] - unit[:, 0, None] * offset[..., 1]  # to the right: left turns bulge there
    side = np.where(y.sum(axis=1) < 0.0, -1.0, 1.0)
    y *= side[:, None]
    room = c * c + e * e - x * x - y * y
    inner, outer = c * (y - e), c * (y + e)
    square = room * room + 4.0 * inner * outer
    free = (np.minimum((x - c) ** 2, (x + c) ** 2) + y * y <= e * e) | (square < 0.0)
    root = np.sqrt(np.maximum(square, 0.0))
    beyond = room < 0.0  # where arcs of more than half a turn come round
    below = beyond & (y < -e)
    denominator = np.where(below, room - root, room + root)
    denominator = np.where(np.abs(denominator) > 1e-300, denominator, 1e-300)
    with np.errstate(over="ignore"):
        near, far = 2.0 * inner / denominator, 2.0 * outer / denominator
    low = np.where(free, -_ALL, np.where(below, far, near))
    high = np.where(free | (beyond & (np.abs(y) <= e)), _ALL, np.where(below, near, far))
    most = np.tan(0.25 * limits.widest)
    low, high = np.maximum(low.max(axis=1), -most), np.minimum(high.min(axis=1), most)
    low, high = np.where(side > 0.0, low, -high), np.where(side > 0.0, high, -low)
    low, high = _of_radius(low, high, 0.5 * length, limits)
    angles = samples.angles[rows[:, [0, -1]]]
    direction = np.arctan2(chord[:, 1], chord[:, 0])
    direction += 2.0 * np.pi * np.round((angles.mean(axis=1) - direction) / (2.0 * np.pi))
    straying = np.abs(angles - direction[:, None]).max(axis=1) > 1.7 + 0.5 * (limits.widest - np.pi)
    low = np.where(straying | (length == 0.0), _ALL, low)
    return low, high, direction


def _of_radius(low: Array, high: Array, half: Array, limits: Limits) -> tuple[Array, Array]:
    """Return bulges (k,) without those of too large radii, but for 0, and without those of too small ones."""
    flat = np.minimum(half / (2.0 * limits.max_radius), 1.0)
    low = np.where(low > 0.0, np.maximum(low, flat), low)
    high = np.where(high < 0.0, np.minimum(high, -flat), high)
    share = np.clip(half / limits.min_radius, 1e-9, 1.0) if limits.min_radius > 0.0 else np.ones(len(half))
    least = np.where(share < 1.0, share / (1.0 + np.sqrt(1.0 - share * share)), _ALL)  # up to half a turn
    most = 1.0 / least  # and beyond
    left, right = low > least, high < -least
    high = np.where(left, high, np.minimum(high, least))
    low = np.where(right, low, np.maximum(low, -least))
    return np.where(left, np.maximum(low, most), low), np.where(right, np.minimum(high, -most), high)
