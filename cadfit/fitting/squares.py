"""Least squares over spans: moments of the points of each, put into normal equations, solved in a narrow band.

On a span every function in question is a cubic of the local parameter x: the poles' basis functions, and those of knots
that move. So of the points only the sums of x^0 to x^6 matter; what depends on the functions is done once for a span.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache, lru_cache

import numpy as np
from scipy.linalg.lapack import dpbsv

from cadfit.bezier import Array, Ints

_FEW = 200  # spans: layouts of so many are small, and kept


@dataclass(frozen=True, slots=True, eq=False)
class Band:
    """Where the spans' `local` equations go in LAPACK's lower band form of the normal equations, and in their right.

    Span s touches blocks s to s + 3 of q unknowns each. Open: the first and the last block are held, and left out.
    Closed: blocks count modulo m, and are folded (0, m - 1, 1, m - 2, ...), which makes the cyclic band a plain one of
    twice the width, so that no bordered solve is needed. What is left out goes to one more entry, behind the others.
    """

    entries: Ints  # (m, unknowns of a span, again): where to, in the flat band; of a symmetric pair, one is left out
    rows: Ints  # (m, unknowns of a span): whose right side
    shape: tuple[int, int]  # of the band
    order: Ints  # (blocks,): the place of each block that is not left out


def band(m: int, closed: bool, d: int, knots: bool) -> Band:
    """Return the layout for m spans (closed: 4 or more) of poles in d dimensions, `knots` being unknown, too."""
    return (_band if m <= _FEW else _large_band)(m, closed, d, knots)


@lru_cache(maxsize=512)
def _band(m: int, closed: bool, d: int, knots: bool) -> Band:
    q, blocks = d + knots, m if closed else m + 3
    place = np.arange(blocks) - (not closed)
    if closed:
        place = np.where(2 * place < blocks, 2 * place, 2 * (blocks - place) - 1)
    count = blocks if closed else blocks - 2
    touched = (np.arange(m)[:, None] + np.arange(4)) % blocks  # (m, 4)
    used = np.ones((m, 4), dtype=bool) if closed else (place[touched] >= 0) & (place[touched] < count)
    block, part = np.repeat(np.arange(4), d), np.tile(np.arange(d), 4)
    if knots:  # of the knot before the span, its start, and its end, kept with poles 0 to 2
        block, part = np.append(block, np.arange(3)), np.append(part, [d] * 3)
    unknown = place[touched[:, block]] * q + part  # (m, unknowns of a span)
    one, other = unknown[:, :, None], unknown[:, None, :]
    low, high = np.minimum(one, other), np.maximum(one, other)
    kept = used[:, block, None] & used[:, None, block] & np.tri(len(block), dtype=bool)
    width = int((high - low)[kept].max(initial=0)) + 1
    entries = np.where(kept, (high - low) * (count * q) + low, width * count * q)
    rows = np.where(used[:, block], unknown, count * q)
    order = place if closed else place[1:-1]
    return Band(entries.ravel(), rows.ravel(), (width, count * q), order)


_large_band = lru_cache(maxsize=8)(_band.__wrapped__)  # of the last few numbers of spans: they take megabytes


@cache
def _rows(e: int, d: int) -> tuple[Ints, Ints]:
    """Return which row of the sums in `moments` each of its squares (4 k, 4 k), and of its pulls (4, d), is."""
    k = d if e > 1 else 1
    power, part = np.repeat(np.arange(4), k), np.tile(np.arange(k), 4)
    lower = np.zeros((k, k), dtype=np.intp)  # which entry of a lower triangle, stored in a row
    i, j = np.tril_indices(k)
    lower[i, j] = lower[j, i] = np.arange(len(i))
    both, entry = np.add.outer(power, power), lower[np.ix_(part, part)]
    squares = np.where(both < 4, both * (d + e) + d + entry, 4 * (d + e) + (both - 4) * e + entry)
    return squares, np.add.outer((d + e) * np.arange(4), np.arange(d))


def moments(x: Array, first: Array, d: int, starts: Ints, closed: bool) -> tuple[Array, Array]:
    """Return each span's sums of products of two powers of x times points' metrics, and of powers times their pulls.

    Points starts[s] to starts[s + 1] belong to span s; closed, those of the last to the first. `first` are the pulls,
    (d, n), metric times residual, and behind them the metrics, (d (d + 1) / 2, n), the lower triangles of the weights
    of the points' residuals. They give squares (m, 4 d, 4 d), power p of coordinate c being number p d + c, and pulls
    (m, 4 d, 1). Metrics that are one number, (1, n), give squares (m, 4, 4) for any coordinate, and the pulls
    (m, 4, d) of all.
    """
    n, e = len(x) + 1, len(first) - d
    terms = np.empty((7 * e + 4 * d, n))
    low, high = terms[: 4 * (d + e)].reshape(4, d + e, n), terms[4 * (d + e) :].reshape(3, e, n)
    low[0, :, :-1], low[0, :, -1] = first, 0.0  # one more behind the last: spans without points may start there
    x = np.append(x, 0.0)
    for k in range(1, 4):
        np.multiply(low[k - 1], x, out=low[k])
    for k in range(3):
        np.multiply(high[k - 1] if k else low[3, d:], x, out=high[k])
    sums = np.add.reduceat(terms, starts[:-1], axis=1)
    empty = starts[:-1] == starts[1:]
    if empty.any():
        sums[:, empty] = 0.0
    if closed:
        sums[:, 0] += sums[:, -1]
        sums = sums[:, :-1]
    squares, pulls = _rows(e, d)
    spans = sums.T
    return spans.take(squares, axis=1), spans.take(pulls, axis=1).reshape(len(spans), len(squares), -1)


def local(squares: Array, pulls: Array, functions: Array) -> tuple[Array, Array]:
    """Return each span's part of the normal equations, (m, unknowns, unknowns), and of their right, (m, unknowns, k).

    `squares` and `pulls` as `moments`; `functions` (m, 4 d or 4, unknowns): the polynomials that unknowns count with.
    """
    across = functions.swapaxes(1, 2)
    return across @ (squares @ functions), across @ pulls


def for_all(functions: Array, d: int, more: int = 0) -> Array:
    """Return functions (m, 4 powers, 4) of poles as functions (m, 4 d, 4 d + more) of their d coordinates, zeros last.

    >>> for_all(np.arange(1.0, 17.0).reshape(1, 4, 4), 2)[0, :2]
    array([[1., 0., 2., 0., 3., 0., 4., 0.],
           [0., 1., 0., 2., 0., 3., 0., 4.]])
    """
    out = np.zeros((len(functions), 4, d, 4 * d + more))
    for c in range(d):
        out[:, :, c, c : 4 * d : d] = functions
    return out.reshape(len(functions), 4 * d, -1)


def solve(matrices: Array, sides: Array, layout: Band, d: int, damping: Array, held: list[tuple[int, Array]]) -> Array:
    """Return the unknowns (blocks not left out, q) that satisfy the normal equations made of `local` ones.

    `damping` (q,) is added to the diagonal, relative to its mean over all d coordinates (so that a turn of the axes
    changes nothing) or over the knots. `held`: blocks, and the unit directions (d,) that their poles may move in.
    """
    size, unknowns = layout.shape
    matrix = _gathered(matrices, layout.entries, size * unknowns).reshape(layout.shape)
    right = _gathered(sides, layout.rows, unknowns)
    diagonal = matrix[0].reshape(-1, len(damping))
    scale = np.add.reduce(diagonal) / len(diagonal)
    scale[:d] = np.add.reduce(scale[:d]) / d
    for block, direction in held:
        first = int(layout.order[block]) * len(damping)
        for c in range(len(direction)):
            for e in range(c + 1):
                matrix[c - e, first + e] += 1e8 * scale[0] * ((c == e) - direction[c] * direction[e])
    return _damped(matrix, right, scale, damping).reshape(-1, len(damping))[layout.order]


def solve_alike(matrix: Array, sides: Array, layout: Band, damping: float) -> Array:
    """Return as `solve` the poles (blocks not left out, d) where all coordinates have the same `local` matrix.

    `matrix` (m, 4, 4), `sides` (m, 4, d); `damping` is added to the diagonal, relative to its mean.
    """
    size, unknowns = layout.shape
    banded = _gathered(matrix, layout.entries, size * unknowns).reshape(layout.shape)
    right = [_gathered(side, layout.rows, unknowns) for side in sides.transpose(2, 0, 1)]
    scale = np.add.reduce(banded[0]) / unknowns
    return _damped(banded, np.column_stack(right), np.array([scale]), np.array([damping]))[layout.order]


def _gathered(values: Array, places: Ints, count: int) -> Array:
    """Return the sums (count,) of what goes to each place; the one behind them takes what is left out."""
    return np.asarray(np.bincount(places, values.ravel(), count + 1)[:-1], dtype=np.float64)


def _damped(matrix: Array, right: Array, scale: Array, damping: Array) -> Array:
    """Return the solution of banded equations, `damping` times scale added to the diagonal, and more if need be.

    `matrix` (width, unknowns): LAPACK's lower band, its first row overwritten. `right` (unknowns,) or (unknowns, k).
    `scale` and `damping` (q,): of q unknowns in turn.
    """
    diagonal, ridge = matrix[0].reshape(-1, len(damping)), damping
    for _ in range(8):
        diagonal += ridge * scale + 1e-300
        _, found, failed = dpbsv(matrix, right, lower=1)
        if not failed:
            break
        ridge = np.maximum(100.0 * ridge, 1e-14)  # not positive definite in float64
    return np.asarray(found)
