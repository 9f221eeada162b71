"""Where along a path the rings of a tube stand: as few as one chord tolerance allows.

Everything is decided on Bézier pieces, from bounds that hold over a whole piece. With q the hodograph (a quadratic
Bézier with poles D0, D1, D2, a third of the velocity), q x q' is a quadratic Bézier too, with poles 2 D0 x D1,
D0 x D2 and 2 D1 x D2, so it is bounded by its poles; and |q| is at least its smallest component along a direction.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from cadfit import bezier
from cadfit.bezier import Array, Ints
from cadfit.bspline import BSpline
from cadfit.sweeping.frames import SMOOTH

STEEPEST = np.pi / 4  # the most a ring may turn against the next, radians
_FEW = 6.0  # a piece that needs no more parts than this is cut at once


@dataclass(frozen=True, slots=True, eq=False)
class Chain:
    """A path cut into Bézier pieces (m, 4, 3), of which piece k runs from `starts[k]` to `starts[k] + widths[k]`."""

    pieces: Array
    starts: Array
    widths: Array

    def __len__(self) -> int:
        return len(self.pieces)

    def __getitem__(self, which: Ints | NDArray[np.bool_]) -> Chain:
        return Chain(self.pieces[which], self.starts[which], self.widths[which])


def chain(path: BSpline) -> Chain:
    """Return the path's own Bézier pieces, one a knot span.

    >>> len(chain(BSpline([[0, 0, 0], [1, 0, 0], [2, 0, 0], [3, 0, 0]], [0, 0, 0, 0, 1, 1, 1, 1])))
    1
    """
    knots = path.distinct_knots
    return Chain(path.pieces(), knots[:-1], np.diff(knots))


def stationed(whole: Chain, radius: float, tolerance: float) -> Chain:
    """Return a path cut where the rings of a tube are to stand.

    Between two rings the centre line and the outermost fibre of a tube of that radius stray from their chords by at
    most `tolerance`: with l the piece's length and k its largest curvature, both bounded from above, by
    (1 + k radius) k l^2 / 8. No ring turns more than 45 degrees against the next. A straight span is one piece.
    Pieces shorter than a thousandth of the tolerance, as next to a cusp, are not cut further, and pieces that are one
    point are left out. The number of pieces grows as the square root of 1 / tolerance.

    >>> straight = BSpline([[0, 0, 0], [1, 0, 0], [2, 0, 0], [9, 0, 0]], [0, 0, 0, 0, 1, 1, 1, 1])
    >>> len(stationed(chain(straight), 1.0, 1e-6))
    1
    """
    todo, done = whole, []
    while len(todo):
        length, curvature = _bounds(todo.pieces)
        turn = length * curvature
        needed = np.maximum(np.sqrt((length + radius * turn) * turn / (8.0 * tolerance)), turn / STEEPEST)
        needed[length <= 1e-3 * tolerance] = 1.0
        # The bounds of a long piece are loose: it is halved and looked at again.
        few = needed <= _FEW
        counts = np.maximum(np.ceil(needed[few] - 1e-9), 1.0).astype(np.intp)
        done.append(_cut(todo[few], counts))
        todo = _cut(todo[~few], np.full(len(todo) - len(counts), 2))
    every = done[0]
    if len(done) > 1:
        parts = ([c.pieces for c in done], [c.starts for c in done], [c.widths for c in done])
        every = Chain(*(np.concatenate(part) for part in parts))
        every = every[np.argsort(every.starts, kind="stable")]
    legs = np.abs(every.pieces[:, 1:] - every.pieces[:, :-1]).max(axis=(1, 2))
    apart = legs > 1e-12 * legs.max()
    return every if apart.all() else every[apart]


def tightest(whole: Chain, limit: float) -> tuple[float, float]:
    """Return the parameter and the radius of a path's tightest bend, (nan, inf) where none is as tight as `limit`.

    Branch and bound over the pieces; the radius is right to 0.1 %, and 0.0 at a cusp inside a piece.

    >>> straight = BSpline([[0, 0, 0], [1, 0, 0], [2, 0, 0], [9, 0, 0]], [0, 0, 0, 0, 1, 1, 1, 1])
    >>> tightest(chain(straight), 5.0)
    (nan, inf)
    """
    where, sharpest = np.nan, (1.0 - 1e-9) / limit
    smallest = 1e-9 * float(np.ptp(whole.pieces, axis=(0, 1)).max())
    todo = whole
    while len(todo):
        length, bound = _bounds(todo.pieces)
        candidates = bound > 1.001 * sharpest
        tiny = candidates & (length <= smallest)
        if tiny.any():
            return float(todo.starts[tiny][0]), 0.0
        todo = todo[candidates]
        if len(todo):
            at, curvature = _sampled(todo)
            if curvature.max() >= sharpest:
                where, sharpest = float(at[curvature.argmax()]), float(curvature.max())
            todo = _cut(todo, np.full(len(todo), 2))
    return where, (np.inf if np.isnan(where) else 1.0 / sharpest)


def breaks(whole: Chain, closed: bool) -> tuple[Array, Array]:
    """Return the parameters and the angles (radians) of the joints where a path's tangent breaks, the seam's too.

    At a triple knot that is a corner; elsewhere the path has come to rest there and turns on the spot, a cusp.

    >>> bent = [[0, 0, 0], [1, 0, 0], [2, 0, 0], [3, 0, 0], [3, 1, 0], [3, 2, 0], [3, 3, 0]]
    >>> breaks(chain(BSpline(bent, [0, 0, 0, 0, 1, 1, 1, 2, 2, 2, 2])), closed=False)
    (array([1.]), array([1.57079633]))
    """
    pieces = whole.pieces
    leaving = np.roll(pieces, -1, axis=0)
    cosines, sines = _angle(pieces[:, 3] - pieces[:, 2], leaving[:, 1] - leaving[:, 0])
    suspect = sines >= SMOOTH * cosines  # so is a joint where either is zero
    suspect[-1] &= closed
    at = np.flatnonzero(suspect)
    cosines, sines = _angle(_end_direction(pieces[at, ::-1]), -_end_direction(leaving[at]))
    angles = np.arctan2(sines, cosines)
    broken = angles > SMOOTH
    return (whole.starts[at] + whole.widths[at])[broken], angles[broken]


def _angle(a: Array, b: Array) -> tuple[Array, Array]:
    """Return cosine and sine of the angles between rows, both times the lengths."""
    return np.einsum("nd,nd->n", a, b), np.sqrt(np.square(_cross(a.T, b.T)).sum(axis=0))


def _cross(a: Array, b: Array) -> Array:
    """Return the cross products (3, n) of vectors (3, n)."""
    return np.stack([a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]])


def _bounds(pieces: Array) -> tuple[Array, Array]:
    """Return upper bounds on the length and on the curvature of every piece; infinite where it may stand still.

    A part of a k-th of a piece's width has a bound on the length at most a k-th, and on the curvature no larger.
    """
    d = np.ascontiguousarray((pieces[:, 1:] - pieces[:, :-1]).transpose(1, 2, 0))  # (leg, axis, piece)
    longest = np.sqrt(np.einsum("kdm,kdm->km", d, d).max(axis=0))
    crossed = [2.0 * _cross(d[0], d[1]), _cross(d[0], d[2]), 2.0 * _cross(d[1], d[2])]
    turning = np.sqrt(np.maximum.reduce([np.einsum("dm,dm->m", c, c) for c in crossed]))
    middle = d[0] + d[1] + d[2]
    sizes = np.sqrt(np.einsum("dm,dm->m", middle, middle))
    slowest = np.einsum("kdm,dm->km", d, middle).min(axis=0) / np.where(sizes > 0.0, sizes, 1.0)
    safe = slowest > 1e-3 * longest
    curvature = np.where(safe, turning / (3.0 * np.where(safe, slowest, 1.0) ** 3), np.inf)
    # Straight up to rounding, and never back, is straight, even where it starts from rest.
    curvature[(turning <= 1e-14 * longest**2) & (slowest >= -1e-14 * longest)] = 0.0
    return 3.0 * longest, curvature


def _sampled(chain: Chain) -> tuple[Array, Array]:
    """Return the curvature at the start, the middle and the end of every piece, zero where it stands still."""
    left, right = bezier.split(chain.pieces)
    first = np.stack([left[:, 1] - left[:, 0], left[:, 3] - left[:, 2], right[:, 3] - right[:, 2]])
    second = np.stack([left[:, 2] - left[:, 1], left[:, 2] - left[:, 1], right[:, 2] - right[:, 1]])
    speed = np.linalg.norm(first, axis=2)
    moving = speed > 1e-9 * speed.max()
    area = np.linalg.norm(np.cross(first, second), axis=2)
    curvature = np.where(moving, 2.0 / 3.0 * area / np.where(moving, speed, 1.0) ** 3, 0.0)
    at = chain.starts + np.array([[0.0], [0.5], [1.0]]) * chain.widths
    return at.ravel(), curvature.ravel()


def _cut(chain: Chain, counts: Ints) -> Chain:
    """Return every piece in so many parts of equal width."""
    if counts.max(initial=1) == 1:
        return chain
    owner = np.repeat(np.arange(len(chain)), counts)
    count = counts[owner]
    part = np.arange(len(owner)) - (np.cumsum(counts) - counts)[owner]
    widths = chain.widths[owner] / count
    pieces = bezier.restrict(chain.pieces[owner], part / count, (part + 1) / count)
    return Chain(pieces, chain.starts[owner] + part * widths, widths)


def _end_direction(pieces: Array) -> Array:
    """Return the direction (k, 3) to each piece's first pole from the next pole that is not there as well."""
    offsets = pieces[:, :1] - pieces[:, 1:]
    sizes = np.linalg.norm(offsets, axis=2)
    apart = sizes > 1e-12 * sizes.max(axis=1, keepdims=True)
    return np.asarray(offsets[np.arange(len(offsets)), apart.argmax(axis=1)])
