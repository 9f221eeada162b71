"""Least squares over spans: sums over the points of each, put into normal equations, solved in a narrow band."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from scipy.linalg.lapack import dpbsv

from cadfit.bezier import Array, Ints

_A, _B = np.tril_indices(4)  # pairs of the four poles of a span


@dataclass(frozen=True, slots=True, eq=False)
class Band:
    """Where the sums of `gathered` go in LAPACK's lower band form of the normal equations, and in their right side.

    Span s touches blocks s to s + 3 of q unknowns each. Open: the first and the last block are held, and left out.
    Closed: blocks count modulo m, and are folded (0, m - 1, 1, m - 2, ...), which makes the cyclic band a plain one of
    twice the width, so that no bordered solve is needed. What is left out goes to one more entry, behind the others.
    """

    source: Ints  # (k,): the sums that go into the matrix
    entries: Ints  # (k, m): where to, in the flat band
    right: Ints  # (4 q - knots,): the sums that go into the right side
    rows: Ints  # likewise, (.., m): which unknown's
    shape: tuple[int, int]  # of the band
    order: Ints  # (blocks,): the place of each block that is not left out


@lru_cache(maxsize=256)
def band(m: int, closed: bool, d: int, knots: bool) -> Band:
    """Return the layout for m spans (closed: 4 or more) of poles in d dimensions, `knots` being unknown, too."""
    q, blocks = d + knots, m if closed else m + 3
    place = np.arange(blocks) - (not closed)
    if closed:
        place = np.where(2 * place < blocks, 2 * place, 2 * (blocks - place) - 1)
    count = blocks if closed else blocks - 2
    touched = (np.arange(m)[:, None] + np.arange(4)) % blocks  # (m, 4)
    used = np.ones((m, 4), dtype=bool) if closed else (place[touched] >= 0) & (place[touched] < count)
    block, part, right = _unknowns(d, knots)
    unknown = place[touched[:, block]] * q + part  # (m, unknowns of a span)
    i, j, source = _pairs(d, knots)
    low, high = np.sort(np.stack([unknown[:, i], unknown[:, j]]), axis=0)
    width = int((high - low)[used[:, block[i]] & used[:, block[j]]].max()) + 1
    kept = used[:, block[i]] & used[:, block[j]]
    entries = np.where(kept, (high - low) * (count * q) + low, width * count * q)
    rows = np.where(used[:, block], unknown, count * q)
    order = place if closed else place[1:-1]
    return Band(source, entries.T.ravel(), right, rows.T.ravel(), (width, count * q), order)


def _unknowns(d: int, knots: bool) -> tuple[Ints, Ints, Ints]:
    """Return the block, the part and the sum on the right side of each unknown of a span: 4 d of poles, 3 of knots."""
    block, part = np.repeat(np.arange(4), d), np.tile(np.arange(d), 4)
    first = 10 * (d * (d + 1) // 2)
    right = first + np.arange(4 * d)
    if knots:
        block, part = np.append(block, np.arange(3)), np.append(part, [d] * 3)
        right = np.append(right, first + 4 * d + 12 * d + 6 + np.arange(3))
    return block, part, right


def _pairs(d: int, knots: bool) -> tuple[Ints, Ints, Ints]:
    """Return pairs of unknowns of a span, each pair once, and the sum that belongs to it."""
    pair = np.zeros((4, 4), dtype=np.intp)
    pair[_A, _B] = pair[_B, _A] = np.arange(10)
    metric = np.zeros((d, d), dtype=np.intp)
    c, e = np.tril_indices(d)
    metric[c, e] = metric[e, c] = np.arange(len(c))
    i, j = np.tril_indices(4 * d)
    source = pair[i // d, j // d] * len(c) + metric[i % d, j % d]
    if knots:
        first = 10 * len(c) + 4 * d
        mixed_i, mixed_j = np.repeat(4 * d + np.arange(3), 4 * d), np.tile(np.arange(4 * d), 3)
        mixed = first + (mixed_j // d * 3 + mixed_i - 4 * d) * d + mixed_j % d
        k, low = np.tril_indices(3)
        i, j = np.concatenate([i, mixed_i, 4 * d + k]), np.concatenate([j, mixed_j, 4 * d + low])
        source = np.concatenate([source, mixed, first + 12 * d + np.arange(6)])
    return i, j, source


def gathered(
    basis: Array, metric: Array, pull: Array, starts: Ints, moves: Array | None, through: Array | None
) -> Array:
    """Return the sums (k, spans) over the points of each span that make up its part of the normal equations.

    `basis` (4, n): how each point depends on the four poles. `metric` (d (d + 1) / 2, n): the lower triangle of the
    weight of its residual. `pull` (d, n): metric times residual. Points starts[s] to starts[s + 1] belong to span s.
    `moves` (3, d, n): how each point depends on three knots, `through` (3, d, n) metric times that, where they move.
    """
    n = basis.shape[1]
    d = len(pull)
    poles = basis[_A] * basis[_B]
    parts = [(poles[:, None] * metric).reshape(-1, n), (basis[:, None] * pull).reshape(-1, n)]
    if moves is not None and through is not None:
        k, low = np.tril_indices(3)
        parts += [
            (basis[:, None, None] * through).reshape(12 * d, n),
            np.einsum("kdn,kdn->kn", moves[k], through[low]),
            np.einsum("kdn,dn->kn", moves, pull),
        ]
    terms = np.concatenate(parts)
    sums = np.add.reduceat(terms, np.minimum(starts[:-1], n - 1), axis=1)
    sums[:, starts[:-1] == starts[1:]] = 0.0
    return np.asarray(sums)


def solve(sums: Array, layout: Band, d: int, damping: Array, held: list[tuple[int, Array]]) -> Array:
    """Return the unknowns (blocks not left out, q) that satisfy the normal equations.

    `sums` (k, m) as `gathered`. `damping` (q,) is added to the diagonal, relative to its mean over all coordinates (so
    that a turn of the axes changes nothing) or over the knots. `held`: blocks, and the unit directions (d,) that their
    poles may move in.
    """
    size, unknowns = layout.shape
    matrix = np.bincount(layout.entries, sums[layout.source].ravel(), size * unknowns + 1)[:-1].reshape(layout.shape)
    right = np.bincount(layout.rows, sums[layout.right].ravel(), unknowns + 1)[:-1]
    diagonal = matrix[0].reshape(-1, len(damping))
    scale = diagonal.mean(axis=0)
    scale[:d] = scale[:d].mean()
    for block, direction in held:
        first = int(layout.order[block]) * len(damping)
        for c in range(len(direction)):
            for e in range(c + 1):
                matrix[c - e, first + e] += 1e8 * scale[0] * ((c == e) - direction[c] * direction[e])
    ridge = damping
    for _ in range(8):
        diagonal += ridge * scale + 1e-300
        _, found, failed = dpbsv(matrix, right, lower=1)
        if not failed:
            break
        ridge = np.maximum(100.0 * ridge, 1e-14)  # not positive definite in float64
    return np.asarray(found.reshape(-1, len(damping))[layout.order])
