"""Cubic parts of a path, all at once: places and velocities on them, and where a path that stands still heads.

Arrays of vectors are (3, n) here, coefficients of n cubics (4, 3, n): numpy is quickest along long rows.
"""

from __future__ import annotations

import numpy as np

from cadfit.bezier import Array

SLOW = 1e-9  # of the largest handle: a shorter one is looked at closely, for it may have no direction
NOISE = 64.0 * np.finfo(np.float64).eps  # of the largest coordinate: what rounding leaves of a difference


def norms(vectors: Array) -> Array:
    """Return the lengths (n,) of vectors (3, n)."""
    return np.asarray(np.sqrt(np.einsum("dn,dn->n", vectors, vectors)))


def powers(origins: Array, legs: Array) -> Array:
    """Return the coefficients (4, 3, m) of the powers of t, from where cubics start and their three Bézier legs.

    >>> powers(np.zeros((3, 1)), np.ones((3, 3, 1)))[:, 0, 0]
    array([0., 3., 0., 0.])
    """
    first, second, third = legs
    bend = second - first
    return np.stack([origins, 3.0 * first, 3.0 * bend, third - second - bend])


def may_rest(legs: Array) -> bool:
    """Return whether some cubics, of three legs each (3, 3, m), are not known to keep above `SLOW`.

    The velocity is a mean of the legs, so no part of it is below the least that a leg has in one direction.
    """
    ahead = legs.sum(axis=0)
    least = np.einsum("kdn,dn->kn", legs, ahead).min(axis=0)
    return bool((least <= SLOW * norms(ahead) * np.sqrt(np.einsum("kdn,kdn->kn", legs, legs).max())).any())


def horner(coefficients: Array, t: Array) -> tuple[Array, Array]:
    """Return the values and the derivatives (3, n) of cubics at t (n,), by Horner's rule for both in one, in place.

    >>> horner(np.array([1.0, 2.0, 3.0, 4.0]).reshape(4, 1, 1), np.array([10.0]))
    (array([[4321.]]), array([[1262.]]))
    """
    points, line, square, velocities = coefficients
    velocities *= t
    square += velocities
    velocities += square
    square *= t
    line += square
    velocities *= t
    velocities += line
    line *= t
    points += line
    return points, velocities


def limits(leaving: Array, arriving: Array, chords: Array, points: Array) -> Array:
    """Return the directions (3, m + 1) of the ends of Bézier pieces, the limit where the path stands still.

    `leaving` and `arriving` (3, m) are the handles, P1 - P0 and P3 - P2 of each piece, `chords` P3 - P0, `points`
    (3, m + 1) the ends. The direction in which a piece leaves its start is that of the first pole that is not there,
    the second, the third or the last. An end whose next piece is one point has the direction in which the path
    arrives, and where that is a point as well, that of the end before it, or of the first to have one.
    """
    noise = NOISE * np.abs(points).max()
    out = np.zeros_like(points)
    out[:, 1:] = first_moving(arriving, chords - leaving, chords, noise)
    ahead = first_moving(leaving, chords - arriving, chords, noise)
    np.copyto(out[:, :-1], ahead, where=ahead.any(axis=0))
    known = out.any(axis=0)
    if not known.any():
        raise ValueError("the path never moves: all its poles are one point")
    last = np.maximum.accumulate(np.where(known, np.arange(len(out.T)), np.argmax(known)))
    return np.asarray(out[:, last])


def first_moving(first: Array, second: Array, third: Array, noise: float = 0.0) -> Array:
    """Return the first of three vectors that is not zero up to rounding, of each n of them; zero when all are noise.

    >>> first_moving(np.zeros((3, 1)), np.array([[1e-20], [0], [0]]), np.array([[0], [2.0], [0]])).ravel()
    array([0., 2., 0.])
    """
    vectors = np.stack([first, second, third])
    sizes = np.sqrt(np.einsum("kdn,kdn->kn", vectors, vectors))
    longest = sizes.max(axis=0)
    moving = (sizes > 1e-12 * longest) & (longest > noise)
    chosen = vectors[moving.argmax(axis=0), :, np.arange(first.shape[1])].T
    return np.where(moving.any(axis=0), chosen, 0.0)
