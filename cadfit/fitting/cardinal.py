"""Cardinal splines as Bézier pieces and as one C2 B-spline: the paper's algorithm FC2.

Source: D. Mukherjee, An error reduced and uniform parameter approximation in fitting of B-spline curves to data
points. Its formula for a piece's first handle has a slip in one index (p_{k-2} for the point before the piece's
first): the tangent there is tension (p_{k+1} - p_{k-1}) for the piece from p_k.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from cadfit.bezier import Array
from cadfit.bspline import BSpline, own
from cadfit.joining import periodic
from cadfit.numbers import as_number, as_numbers
from cadfit.points.clean import as_contour

_BLOCK = 1 << 12  # points: what is computed for them stays in the cache, and takes no fresh memory


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
    return _pieces(_control_points(points, tension, closed))


def _control_points(points: ArrayLike, tension: float, closed: bool) -> Array:
    """Return the cardinal spline's 3m + 1 control points, each joint once."""
    if not np.isfinite(as_number(tension, "tension")):
        raise ValueError(f"the tension must be a finite number, not {tension}")
    points = as_contour(points, closed)
    joints = np.concatenate([points, points[:1]]) if closed else points
    share = tension / 3.0
    last, d = len(joints) - 1, points.shape[1]
    control = np.empty((3 * last + 1, d))
    for start in range(1, last, _BLOCK):
        stop = min(start + _BLOCK, last)
        here, triples = joints[start:stop], control[3 * start - 1 : 3 * stop - 1].reshape(-1, 3, d)
        handles = share * (joints[start + 1 : stop + 1] - joints[start - 1 : stop - 1])
        triples[:, 0] = here - handles
        triples[:, 1] = here
        handles += here
        triples[:, 2] = handles
    first = share * (joints[1] - joints[-2 if closed else 0])
    control[0], control[1] = joints[0], joints[0] + first
    control[-2], control[-1] = joints[-1] - (first if closed else share * (joints[-1] - joints[-2])), joints[-1]
    return control


def cardinal_spline(points: ArrayLike, tension: float = 0.5, curvature: float = 0.0, closed: bool = False) -> BSpline:
    """Return the C2 B-spline on the control points of the cardinal spline (step 3 of FC2).

    `points` (n, d), at least 2 (closed: 3), in any dimension. No linear system is solved, and a moved point changes
    the curve only from the second point before it to the second after.

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
    if not np.isfinite(as_number(curvature, "curvature")):
        raise ValueError(f"the curvature must be a finite number, not {curvature}")
    control = _control_points(points, tension, closed)
    if curvature:
        _restore_curvature(control, curvature / 9.0, closed)
    return _uniform_spline(control, closed)


def _restore_curvature(control: Array, share: float, closed: bool) -> None:
    """Give the joints that part of their second differences, in place: the triple p + c/3, p - c/6, p + c/3."""
    joints = control[0::3].copy()
    bends = share * np.diff(joints, n=2, axis=0)
    control[3:-1:3] -= bends / 6.0
    control[2:-2:3] += bends / 3.0
    control[4::3] += bends / 3.0
    if closed:
        bend = share * (joints[1] - 2.0 * joints[0] + joints[-2])
        control[[0, -1]] -= bend / 6.0
        control[[1, -2]] += bend / 3.0


def c2_spline(pieces: ArrayLike, closed: bool = False) -> BSpline:
    """Return the C2 B-spline on the control points of a C1 chain of Bézier pieces (m, 4, d): step 3 of FC2.

    The 3m + 1 control points become the poles, on the clamped uniform knots 0, 0, 0, 0, 1, 2, ..., 3m - 2 (closed:
    periodic, the joints at 0, 3, 6, ...). Where the chain is C1 the spline passes through the joint with the chain's
    direction and second derivative zero; it is not the same shape as the chain (`pieces_to_spline` is).

    Raises ValueError for a wrong shape, a piece that does not start at the end of the one before, and `closed` for a
    chain that does not return. Source: the paper, section 2.3.

    >>> c2_spline(cardinal_pieces([[0.0], [1.0], [3.0]])).knots
    array([0., 0., 0., 0., 1., 2., 3., 4., 4., 4., 4.])
    """
    pieces = _chain(pieces)
    if closed and np.abs(pieces[-1, 3] - pieces[0, 0]).max() > _rounding(pieces):
        raise ValueError("the chain does not return to its start: it is not closed")
    return _uniform_spline(np.concatenate([pieces[:, :3].reshape(-1, pieces.shape[2]), pieces[-1:, 3]]), closed)


def _pieces(control: Array) -> Array:
    """Return the Bézier pieces (m, 4, d) of 3m + 1 control points."""
    return np.stack([control[0:-1:3], control[1::3], control[2::3], control[3::3]], axis=1)


def _uniform_spline(control: Array, closed: bool) -> BSpline:
    if closed:
        return periodic(control[:-1], np.arange(float(len(control))))
    knots = np.arange(-3.0, len(control) + 1.0)
    knots[:3], knots[-3:] = 0.0, len(control) - 3.0
    return BSpline(own(control), own(knots))


def point_triples(values: Array, first: Array, second: Array, before: Array, after: Array) -> Array:
    """Return the three poles of each knot (n, 3, d) that give it a value, a first and a second derivative.

    `values`, `first`, `second` (d, n), a row a coordinate, derivatives by the parameter; `before` and `after` (n,) are
    the knot spacings left and right of each, two equal spans on each side. The poles are the polar values at
    (-2a, -a, 0), (-a, 0, b) and (0, b, 2b) of the Taylor polynomial at the knot; its third derivative does not enter.

    >>> one, zero = np.ones((1, 1)), np.zeros((1, 1))
    >>> point_triples(zero, one, zero, one[0], 2 * one[0])[0, :, 0]
    array([-1.        ,  0.33333333,  2.        ])
    """
    triples = np.empty((3, *values.shape))
    left, middle, right = triples
    third = second * (1.0 / 3.0)
    np.multiply(before, third, out=left)
    np.subtract(first, left, out=left)
    left *= before
    np.subtract(values, left, out=left)
    np.multiply(after, third, out=right)
    right += first
    right *= after
    right += values
    np.multiply((after - before) / 3.0, first, out=middle)
    middle += values
    third *= 0.5 * before * after
    middle -= third
    return triples.transpose(2, 0, 1)


def pieces_to_spline(pieces: ArrayLike) -> BSpline:
    """Return a chain of Bézier pieces (m, 4, d) as one B-spline of the same shape, unit knot spans.

    Where the chain is C1 the knot is double and the joint itself is no pole, so a cardinal spline's m pieces give
    2m + 2 poles; where two pieces are joined only in position (a corner) the knot is triple. "Joined" and "C1" are
    judged to 1e-12 of the largest coordinate.

    Raises ValueError for a wrong shape or where a piece does not start at the end of the one before.

    >>> pieces_to_spline(cardinal_pieces([[0.0], [1.0], [3.0]])).knots
    array([0., 0., 0., 0., 1., 1., 2., 2., 2., 2.])
    """
    pieces = _chain(pieces)
    kink = (pieces[1:, 1] - pieces[1:, 0]) - (pieces[:-1, 3] - pieces[:-1, 2])
    corner = np.abs(kink).max(axis=1, initial=0.0) > _rounding(pieces)
    keep = np.concatenate([np.ones((len(pieces), 3), dtype=bool), np.append(corner, True)[:, None]], axis=1)
    keep[1:, 0] = False  # the joint is the piece before's to keep
    joints = np.arange(1.0, len(pieces))
    inner = np.repeat(joints, np.where(corner, 3, 2))
    return BSpline(pieces[keep], np.concatenate([[0.0] * 4, inner, [float(len(pieces))] * 4]))


def _chain(pieces: ArrayLike) -> Array:
    """Return a chain of Bézier pieces, checked."""
    pieces = as_numbers(pieces, "pieces")
    if pieces.ndim != 3 or pieces.shape[1] != 4 or pieces.size == 0:
        raise ValueError(f"pieces must have the shape (m, 4, d), not {pieces.shape}")
    gaps = np.abs(pieces[1:, 0] - pieces[:-1, 3]).max(axis=1, initial=0.0)
    if np.any(gaps > _rounding(pieces)):
        k = int(np.argmax(gaps > _rounding(pieces)))
        raise ValueError(f"piece {k + 1} starts {gaps[k]:.6g} away from the end of piece {k}: the chain is broken")
    return pieces


def _rounding(pieces: Array) -> float:
    return 1e-12 * max(float(np.abs(pieces).max()), float(np.finfo(np.float64).tiny))
