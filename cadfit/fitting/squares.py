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

_HANKEL = np.add.outer(np.arange(4), np.arange(4))  # which power a product of two powers is


@dataclass(frozen=True, slots=True, eq=False)
class Band:
    """Where the spans' `local` equations go in LAPACK's lower band form of the normal equations, and in their right.

    Span s touches blocks s to s + 3 of q unknowns each. Open: the first and the last block are held, and left out.
    Closed: blocks count modulo m, and are folded (0, m - 1, 1, m - 2, ...), which makes the cyclic band a plain one of
    twice the width, so that no bordered solve is needed. What is left out goes to one more entry, behind the others.
    """

    entries: Ints  # (pairs of a span's unknowns, m): where to, in the flat band
    rows: Ints  # (unknowns of a span, m): whose right side
    shape: tuple[int, int]  # of the band
    order: Ints  # (blocks,): the place of each block that is not left out


@lru_cache(maxsize=1024)
def band(m: int, closed: bool, d: int, knots: bool) -> Band:
    """Return the layout for m spans (closed: 4 or more) of poles in d dimensions, `knots` being unknown, too."""
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
    i, j = pairs(len(block))
    low, high = np.sort(np.stack([unknown[:, i], unknown[:, j]]), axis=0)
    kept = used[:, block[i]] & used[:, block[j]]
    width = int((high - low)[kept].max(initial=0)) + 1
    entries = np.where(kept, (high - low) * (count * q) + low, width * count * q)
    rows = np.where(used[:, block], unknown, count * q)
    order = place if closed else place[1:-1]
    return Band(entries.T.ravel(), rows.T.ravel(), (width, count * q), order)


@cache
def pairs(k: int) -> tuple[Ints, Ints]:
    """Return the rows and columns of the lower triangle of a k by k matrix."""
    return np.tril_indices(k)


@cache
def _symmetric(d: int) -> Ints:
    """Return which entry of a lower triangle, stored in a row, each entry (d, d) of the symmetric matrix is."""
    i, j = pairs(d)
    out = np.zeros((d, d), dtype=np.intp)
    out[i, j] = out[j, i] = np.arange(len(i))
    return out


@cache
def _of_poles(d: int) -> Ints:
    """Return where in (4, 4, d (d + 1) / 2), in a row, the lower triangle of the four poles' coordinates lies."""
    i, j = pairs(4 * d)
    return np.asarray((i // d * 4 + j // d) * len(pairs(d)[0]) + _symmetric(d)[i % d, j % d])


def moments(x: Array, metric: Array, pull: Array, starts: Ints) -> tuple[Array, Array]:
    """Return the sums (4, 4, d (d + 1) / 2, spans) of products of two powers of x, and those (4, d, spans) of one.

    The first are weighted by `metric` (d (d + 1) / 2, n), the lower triangles of the weights of the points' residuals,
    the second by `pull` (d, n), metric times residual. Points starts[s] to starts[s + 1] belong to span s.
    """
    n, e, d = len(x), len(metric), len(pull)
    terms = np.empty((7 * e + 4 * d, n))
    squares, pulls = terms[: 7 * e].reshape(7, e, n), terms[7 * e :].reshape(4, d, n)
    for powers, first in ((squares, metric), (pulls, pull)):
        powers[0] = first
        for k in range(1, len(powers)):
            np.multiply(powers[k - 1], x, out=powers[k])
    sums = np.add.reduceat(terms, np.minimum(starts[:-1], n - 1), axis=1)
    sums[:, starts[:-1] == starts[1:]] = 0.0
    return sums[: 7 * e].reshape(7, e, -1)[_HANKEL], sums[7 * e :].reshape(4, d, -1)


def local(squares: Array, pulls: Array, functions: Array, moves: Array | None) -> tuple[Array, Array]:
    """Return each span's part of the normal equations, (pairs of unknowns, m), and of their right side, (unknowns, m).

    `squares` and `pulls` as `moments`. `functions` (4 powers, 4, m): those that four poles (4 d unknowns) count with;
    or (4 powers, 7, m): those of three knots behind them, each along its direction `moves` (d, 3, m). Where the metric
    is one number, squares (4, 4, 1, m), the matrix is that of any one coordinate.
    """
    d, m = pulls.shape[1:]
    poles = functions[:, :4]
    half = np.einsum("pqem,qbm->pbem", squares, poles)
    matrix = np.einsum("pam,pbem->abem", poles, half).reshape(-1, m)[_of_poles(d if squares.shape[2] > 1 else 1)]
    side = np.einsum("pam,pcm->acm", poles, pulls).reshape(4 * d, m)
    if moves is None:
        return matrix, side
    knots = functions[:, 4:]
    half = np.einsum("pqem,qkm->pkem", squares, knots)[:, :, _symmetric(d)]  # (4, 3, d, d, m)
    half = np.einsum("pkcem,ekm->pkcm", half, moves)
    mixed = np.einsum("pam,pkcm->kacm", poles, half).reshape(3, 4 * d, m)
    moved = knots[:, :, None] * moves.swapaxes(0, 1)
    square = np.einsum("plcm,pkcm->klm", moved, half)
    below = [part for k in range(3) for part in (mixed[k], square[k, : k + 1])]
    return np.concatenate([matrix, *below]), np.concatenate([side, np.einsum("pkcm,pcm->km", moved, pulls)])


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
    """Return as `solve` the poles (blocks not left out, d) where all coordinates have the same `local` matrix."""
    size, unknowns = layout.shape
    banded = _gathered(matrix, layout.entries, size * unknowns).reshape(layout.shape)
    each = sides.reshape(4, -1, sides.shape[1]).swapaxes(0, 1)
    right = [_gathered(side, layout.rows, unknowns) for side in each]
    scale = np.add.reduce(banded[0]) / unknowns
    return _damped(banded, np.column_stack(right), np.array([scale]), np.array([damping]))[layout.order]


def _gathered(values: Array, places: Ints, count: int) -> Array:
    """Return the sums (count,) of what goes to each place; the one behind them takes what is left out."""
    return np.asarray(np.bincount(places, values.ravel(), count + 1)[:-1], dtype=np.float64)


def _damped(matrix: Array, right: Array, scale: Array, damping: Array) -> Array:
    """Return the solution of the banded equations, `damping` times scale added to the diagonal, and more if need be."""
    diagonal, ridge = matrix[0].reshape(-1, len(damping)), damping
    for _ in range(8):
        diagonal += ridge * scale + 1e-300
        _, found, failed = dpbsv(matrix, right, lower=1)
        if not failed:
            break
        ridge = np.maximum(100.0 * ridge, 1e-14)  # not positive definite in float64
    return np.asarray(found)
