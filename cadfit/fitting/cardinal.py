"""Cardinal splines as Bézier pieces and as one C2 B-spline: the paper's algorithm FC2.

Source: D. Mukherjee, An error reduced and uniform parameter approximation in fitting of B-spline curves to data
points. Its formula for a piece's first handle has a slip in one index (p_{k-2} for the point before the piece's
first): the tangent there is tension (p_{k+1} - p_{k-1}) for the piece from p_k.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from cadfit.bezier import Array
from cadfit.bspline import BSpline, periodic
from cadfit.points.clean import as_contour


def cardinal_pieces(points: ArrayLike, tension: float = 0.5, closed: bool = False) -> Array:
    """Return the cardinal spline through the points as Bézier pieces (m, 4, d), a C1 chain (steps 1 and 2 of FC2).

    `points` (n, d), at least 2 (closed: 3), in any dimension; m is n - 1, closed n. The tangent at a point is
    `tension` times the difference of its neighbours, an open curve's end points standing in for the missing ones.
    With `closed` the curve returns to the first point, which may be repeated at the end or not.

    Raises ValueError naming the row for bad points. Source: the paper, sections 2.1 and 2.2.

    >>> cardinal_pieces([[0, 0], [1, 2], [3, 3]])[0]
    array([[0.        , 0.        ],
           [0.16666667, 0.33333333],
           [0.5       , 1.5       ],
           [1.        , 2.        ]])
    """
    points = as_contour(points, closed)
    tangents = cardinal_tangents(points, tension, closed)
    if closed:
        points, tangents = (np.concatenate([a, a[:1]]) for a in (points, tangents))
    handles = tangents / 3.0
    return np.stack([points[:-1], points[:-1] + handles[:-1], points[1:] - handles[1:], points[1:]], axis=1)


def cardinal_tangents(points: Array, tension: float, closed: bool) -> Array:
    """Return the cardinal tangents (n, d), per data interval, of checked points (n, d)."""
    if closed:
        return np.asarray(tension * (np.roll(points, -1, axis=0) - np.roll(points, 1, axis=0)))
    around = np.concatenate([points[:1], points, points[-1:]])
    return np.asarray(tension * (around[2:] - around[:-2]))


def cardinal_spline(points: ArrayLike, tension: float = 0.5, curvature: float = 0.0, closed: bool = False) -> BSpline:
    """Return the C2 B-spline on the control points of the cardinal spline (step 3 of FC2).

    `points` (n, d), at least 2 (closed: 3), in any dimension. No linear system is solved, and a moved point changes
    the curve only from the third point before it to the third after.

    With `curvature=0.0` this is the paper's curve: 3n - 2 poles on the clamped uniform knots 0, 0, 0, 0, 1, 2, ...
    It passes through every point (point k, counted from 0, at the parameter 3k - 1, the ends at the ends) with the
    cardinal direction, and **its second derivative is zero at every inner point**: twelve points on a unit circle give
    curvatures from 0.00 to 1.46. `curvature` says what part of the points' second difference to restore there: 1.0
    gives 0.85 to 1.10 on that circle, and still passes through every point. `local_spline` is smoother still.

    With `closed` the curve is C2 across the seam as well (periodic uniform knots, clamped by knot insertion) and point
    k lies at the parameter 3k; the first point may be repeated at the end or not.

    Raises ValueError naming the row for bad points. Source: the paper, sections 2.3 and 3.1; the second derivative
    and its remedy are ours (the pole triple of a point as polar values on unit knots).

    >>> s = cardinal_spline([[0, 0], [1, 2], [3, 3], [4, 3]])
    >>> s([0, 2, 5, 7])
    array([[0., 0.],
           [1., 2.],
           [3., 3.],
           [4., 3.]])
    """
    points = as_contour(points, closed)
    handles = cardinal_tangents(points, tension, closed) / 3.0
    if closed:
        bends = curvature / 9.0 * (np.roll(points, -1, axis=0) - 2.0 * points + np.roll(points, 1, axis=0))
        triples = point_triples(points, handles, bends, np.ones(len(points)), np.ones(len(points)))
        # Pole 3k is centred on knot 3k; the first point's left pole is the period's last.
        return periodic(np.roll(triples.reshape(-1, points.shape[1]), -1, axis=0), np.arange(3.0 * len(points) + 1))
    bends = curvature / 9.0 * np.diff(points, n=2, axis=0)
    inner = point_triples(points[1:-1], handles[1:-1], bends, np.ones(len(bends)), np.ones(len(bends)))
    poles = np.concatenate(
        [
            [points[0], points[0] + handles[0]],
            inner.reshape(-1, points.shape[1]),
            [points[-1] - handles[-1], points[-1]],
        ]
    )
    last = len(poles) - 3.0
    return BSpline(poles, np.concatenate([[0.0] * 3, np.arange(last + 1.0), [last] * 3]))


def point_triples(values: Array, first: Array, second: Array, before: Array, after: Array) -> Array:
    """Return the three poles (n, 3, d) that give each knot a value, a first and a second derivative.

    `values`, `first`, `second` (n, d), derivatives by the parameter; `before` and `after` (n,) are the knot spacings
    left and right of each, two equal spans on each side. The poles are the polar values at (-2a, -a, 0), (-a, 0, b) and
    (0, b, 2b) of the Taylor polynomial at the knot; its third derivative does not enter.

    >>> one, zero = np.ones((1, 1)), np.zeros((1, 1))
    >>> point_triples(zero, one, zero, one[0], 2 * one[0])[0, :, 0]
    array([-1.        ,  0.33333333,  2.        ])
    """
    a, b = before[:, None], after[:, None]
    return np.stack(
        [
            values - a * first + a * a / 3.0 * second,
            values + (b - a) / 3.0 * first - a * b / 6.0 * second,
            values + b * first + b * b / 3.0 * second,
        ],
        axis=1,
    )


def pieces_to_spline(pieces: ArrayLike) -> BSpline:
    """Return a chain of Bézier pieces (m, 4, d) as one B-spline of the same shape, unit knot spans.

    Where the chain is C1 the knot is double and the joint itself is no pole, so a cardinal spline's m pieces give
    2m + 2 poles; where two pieces are joined only in position (a corner) the knot is triple. "Joined" and "C1" are
    judged to 1e-12 of the largest coordinate.

    Raises ValueError for a wrong shape or where a piece does not start at the end of the one before.

    >>> pieces_to_spline(cardinal_pieces([[0.0], [1.0], [3.0]])).knots
    array([0., 0., 0., 0., 1., 1., 2., 2., 2., 2.])
    """
    pieces = np.asarray(pieces, dtype=np.float64)
    if pieces.ndim != 3 or pieces.shape[1] != 4 or len(pieces) == 0:
        raise ValueError(f"pieces must have the shape (m, 4, d), not {pieces.shape}")
    rounding = 1e-12 * max(float(np.abs(pieces).max()), np.finfo(np.float64).tiny)
    gaps = np.abs(pieces[1:, 0] - pieces[:-1, 3]).max(axis=1, initial=0.0)
    if np.any(gaps > rounding):
        k = int(np.argmax(gaps > rounding))
        raise ValueError(f"piece {k + 1} starts {gaps[k]:.6g} away from the end of piece {k}: the chain is broken")
    kink = (pieces[1:, 1] - pieces[1:, 0]) - (pieces[:-1, 3] - pieces[:-1, 2])
    corner = np.abs(kink).max(axis=1, initial=0.0) > rounding
    keep = np.concatenate([np.ones((len(pieces), 3), dtype=bool), np.append(corner, True)[:, None]], axis=1)
    keep[1:, 0] = False  # the joint is the piece before's to keep
    joints = np.arange(1.0, len(pieces))
    inner = np.repeat(joints, np.where(corner, 3, 2))
    return BSpline(pieces[keep], np.concatenate([[0.0] * 4, inner, [float(len(pieces))] * 4]))
