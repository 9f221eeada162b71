"""Where a sweep passes through itself: bends tighter than the profile, corners without room, parts that touch."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from cadfit.bezier import Array, Ints
from cadfit.sweeping.triangles import crossing

_APART = 0.5 * np.pi  # parts of a path between which it turns less do not meet, unless a bend is too tight
_MOST_SAMPLES = 200_000
_MOST_PAIRS = 500_000  # of places near each other; where there are more, only the nearest
_ASKED = 500  # places that are asked how many others are near
_PAIRS_AT_FIRST, _PAIRS_AT_ONCE = 1 << 5, 1 << 12
_AT_ONCE = 1 << 20  # triangles whose boxes are looked at in one go


@dataclass(frozen=True, slots=True, eq=False)
class Crossing:
    """A place where a sweep passes through itself.

    `kind`: "bend" (the path bends more tightly than the profile reaches), "cusp" (it turns on the spot), "corner" (a
    leg is too short for its mitres) or "near" (distant parts touch). `parameter` and `position` (3,) are on the path.
    `reach`: how far the profile reaches there, a tube's radius; `largest`: the reach that would do, 0.0 where none
    does. `other`: the parameter of the other part that touches, or of the leg's end.
    """

    kind: Literal["bend", "cusp", "corner", "near"]
    parameter: float
    position: Array
    reach: float
    largest: float
    other: float | None = None

    def said(self, what: str) -> str:
        """Return the line to say of it, where `what` is what the reach is called: "radius" or "reach"."""
        place = ", ".join(f"{value:g}" for value in np.round(self.position, 12) + 0.0)
        why = {
            "bend": f"the path bends there with a radius of {self.largest:.4g}, below the {what} of {self.reach:g}",
            "cusp": f"the path turns there on the spot, with a radius of 0, below the {what} of {self.reach:g}",
            "corner": f"the leg that starts there is too short for its mitres at a {what} of {self.reach:g}",
            "near": f"the part at the parameter {self.other or 0.0:g} is too near for a {what} of {self.reach:g}",
        }[self.kind]
        remedy = f"a {what} below {self.largest:.4g} would do" if self.largest > 0.0 else f"so no {what} would do"
        return f"it passes through itself at the parameter {self.parameter:g}, near ({place}): {why}; {remedy}"


class SelfIntersectionError(ValueError):
    """A sweep passes through itself and was asked to say so: `crossings` are where."""

    def __init__(self, crossings: list[Crossing], line: str) -> None:
        super().__init__(line)
        self.crossings = crossings


class SelfIntersectionWarning(UserWarning):
    """A sweep passes through itself; the mesh is as asked for, closed, and wrong there."""


def near_parts(centres: Array, tangents: Array, closed: bool, reach: float) -> Array:
    """Return pairs (p, 2) of places, as distances along the polyline of `centres`, that are less than 2 reaches apart.

    `centres`, `tangents` (n, 3), those of a closed path without the first repeated. Only places count between which
    the path turns by a right angle or more. Places are sampled 4 reaches apart, and near others half of one.
    """
    ends = np.concatenate([centres, centres[:1]]) if closed else centres
    ways = np.concatenate([tangents, tangents[:1]]) if closed else tangents
    turns = np.concatenate([[0.0], np.cumsum(_lengths(ways))])  # chords of the angles: a little less than these
    if turns[-1] < _APART:
        return np.empty((0, 2))
    s = np.concatenate([[0.0], np.cumsum(_lengths(ends))])
    unit = max(0.5 * reach, s[-1] / (8 * _MOST_SAMPLES))
    marks = np.arange(0, int(s[-1] / unit) + 9, 8)
    for spacing in (8, 1):
        samples = np.minimum(unit * marks, s[-1])
        places = np.column_stack([np.interp(samples, s, ends[:, k]) for k in range(3)])
        found = _pairs(places, 2.0 * reach + spacing * unit)
        turned = np.interp(samples, s, turns)
        between = np.abs(turned[found[:, 0]] - turned[found[:, 1]])
        if closed:
            between = np.minimum(between, turns[-1] - between)
        found = found[between >= _APART]
        if not len(found):
            return np.empty((0, 2))
        # Finer ones only about those that are near others.
        finer = marks[np.unique(found)][:, None] + np.arange(-8, 9)
        marks = np.unique(np.clip(finer, 0, int(s[-1] / unit) + 1))
    nearest = np.argsort(_lengths_between(places, found), kind="stable")
    return np.asarray(samples[found[nearest]])


def _pairs(places: Array, distance: float) -> Ints:
    """Return the rows (p, 2) of places (n, 3) within a distance, or a shorter one where these would be too many."""
    tree = cKDTree(places)
    some = places[:: max(1, len(places) // _ASKED)]
    least = 1e-3 * distance
    while (
        len(places) ** 2 > 2 * _MOST_PAIRS
        and distance > least
        and tree.query_ball_point(some, distance, return_length=True).mean() * len(places)
        > 2 * _MOST_PAIRS + len(places)
    ):
        distance *= 0.7
    return np.asarray(tree.query_pairs(distance, output_type="ndarray"))


def _lengths_between(places: Array, pairs: Ints) -> Array:
    return np.asarray(np.linalg.norm(places[pairs[:, 0]] - places[pairs[:, 1]], axis=1))


def _lengths(rows: Array) -> Array:
    """Return the distances (n - 1,) from row to row (n, 3)."""
    steps = rows[1:] - rows[:-1]
    return np.asarray(np.sqrt(np.einsum("nd,nd->n", steps, steps)))


def touching(points: Array, centres: Array, tangents: Array, closed: bool, reach: float) -> list[tuple[int, int]]:
    """Return pairs of rings i < j whose walls, up to the next ring, pass through each other, those nearest first.

    Of the parts that come near each other the nearest are looked at first, and no more of them once some do.
    `points` (n, k, 3) are the rings of one outline, no farther than `reach` from their centres. Rings closer than a
    tenth of a reach are passed over, and walls between which the path turns by less than a right angle not compared.
    """
    pairs = near_parts(centres, tangents, closed, reach)
    if not len(pairs):
        return []
    s, rows = _thinned(centres, tangents, closed, 0.1 * reach)
    rings = np.concatenate([points, points[:1]])[rows] if closed else points[rows]
    start, some = 0, _PAIRS_AT_FIRST
    while start < len(pairs):
        steps = _steps_between(pairs[start : start + some], s, 0.5 * reach, closed)
        start, some = start + some, min(2 * some, _PAIRS_AT_ONCE)
        both = _meeting(rings, steps)
        if len(both):
            middles = 0.5 * (rings[1:] + rings[:-1]).mean(axis=1)
            apart = np.linalg.norm(middles[both[:, 0]] - middles[both[:, 1]], axis=1)
            return [(int(rows[a]), int(rows[b])) for a, b in both[np.argsort(apart)].tolist()]
    return []


def _meeting(rings: Array, steps: Ints) -> Ints:
    """Return those pairs (p, 2) of steps from ring to ring (n, k, 3) whose walls pass through each other."""
    used, numbers = np.unique(steps, return_inverse=True)
    slabs = np.concatenate([rings[used], rings[used + 1]], axis=1)
    low, high = slabs.min(axis=1), slabs.max(axis=1)
    i, j = numbers.reshape(-1, 2).T
    near = ((low[i] <= high[j]) & (low[j] <= high[i])).all(axis=1)
    i, j = i[near], j[near]
    triangles = _wall_triangles(rings[used], rings[used + 1])
    lowest, highest = triangles.min(axis=2), triangles.max(axis=2)
    found = [np.empty((0, 2), dtype=np.intp)]
    chunk = max(1, _AT_ONCE // triangles.shape[1])
    for start in range(0, len(i), chunk):
        a, b = i[start : start + chunk], j[start : start + chunk]
        # Of each wall, the triangles that reach into the other wall's box; then all of these against each other.
        mine = ((lowest[a] <= high[b][:, None]) & (low[b][:, None] <= highest[a])).all(axis=2)
        theirs = ((lowest[b] <= high[a][:, None]) & (low[a][:, None] <= highest[b])).all(axis=2)
        pair, first, second = _each_with_each(mine, theirs)
        ends = a[pair], first, b[pair], second
        meet = ((lowest[ends[:2]] <= highest[ends[2:]]) & (lowest[ends[2:]] <= highest[ends[:2]])).all(axis=1)
        hit = crossing(*(triangles[ends[k][meet], ends[k + 1][meet]] for k in (0, 2)))
        found.append(used[np.column_stack([a, b])[np.unique(pair[meet][hit])]])
    return np.concatenate(found)


def _thinned(centres: Array, tangents: Array, closed: bool, step: float) -> tuple[Array, Ints]:
    """Return distances along the centres, and the rows of rings at least a step apart or a fifth of a radian turned."""
    ends = np.concatenate([centres, centres[:1]]) if closed else centres
    ways = np.concatenate([tangents, tangents[:1]]) if closed else tangents
    gone = np.linalg.norm(np.diff(ends, axis=0), axis=1) / step + np.linalg.norm(np.diff(ways, axis=0), axis=1) / 0.2
    cells = np.floor(np.concatenate([[0.0], np.cumsum(gone)]))
    rows = np.flatnonzero(np.concatenate([[True], cells[1:] > cells[:-1]]))
    rows = rows if rows[-1] == len(ends) - 1 else np.append(rows, len(ends) - 1)
    lengths = np.linalg.norm(np.diff(ends, axis=0), axis=1)
    return np.concatenate([[0.0], np.cumsum(lengths)])[rows], rows


def _steps_between(pairs: Array, s: Array, window: float, closed: bool) -> Ints:
    """Return the pairs (p, 2), first below second, of steps within a window about pairs of places; no neighbours."""
    low = np.clip(np.searchsorted(s, pairs - window, side="right") - 1, 0, len(s) - 2)
    high = np.clip(np.searchsorted(s, pairs + window, side="left"), 1, len(s) - 1)
    counts = high - low
    owner, within = _shared_out(counts.prod(axis=1))
    i = low[owner, 0] + within // counts[owner, 1]
    j = low[owner, 1] + within % counts[owner, 1]
    keys = np.unique(np.minimum(i, j) * len(s) + np.maximum(i, j))
    steps = np.column_stack([keys // len(s), keys % len(s)])
    between = steps[:, 1] - steps[:, 0]
    return np.asarray(steps[(between > 1) & ~(closed & (between == len(s) - 2))])


def _each_with_each(mine: NDArray[np.bool_], theirs: NDArray[np.bool_]) -> tuple[Ints, Ints, Ints]:
    """Return for each row of two masks (p, t) all pairs of places where they hold: the row, the first, the second."""
    (row_a, first), (row_b, second) = np.nonzero(mine), np.nonzero(theirs)
    many = np.bincount(row_b, minlength=len(theirs))
    begin = np.cumsum(many) - many
    owner, within = _shared_out(many[row_a])
    return row_a[owner], first[owner], second[begin[row_a[owner]] + within]


def _shared_out(counts: Ints) -> tuple[Ints, Ints]:
    """Return owner and number within the owner of so many things each."""
    owner = np.repeat(np.arange(len(counts)), counts)
    return owner, np.arange(len(owner)) - (np.cumsum(counts) - counts)[owner]


def _wall_triangles(first: Array, second: Array) -> Array:
    """Return the triangles (n, 2 k, 3, 3) between rings (n, k, 3) and the next."""
    a, b = first, np.roll(first, -1, axis=1)
    c, d = second, np.roll(second, -1, axis=1)
    return np.concatenate([np.stack([a, b, d], axis=2), np.stack([a, d, c], axis=2)], axis=1)
