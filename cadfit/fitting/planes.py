"""Curves in R^d from planar fits that share one axis: the paper's FC3 and its merge rule, in any dimension.

Source: D. Mukherjee, An error reduced and uniform parameter approximation in fitting of B-spline curves to data
points, sections 2.8 (corresponding coordinate planes), 2.9 (merge rule) and 3.2 (FC3).
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike

from cadfit.bezier import Array
from cadfit.bspline import BSpline
from cadfit.fitting.cardinal import c2_spline, cardinal_pieces
from cadfit.numbers import as_numbers
from cadfit.points.clean import as_contour
from cadfit.stages import Progress, shares


def fit_planes(
    points: ArrayLike,
    tensions: float | Sequence[float] = 0.5,
    common_axis: int = 0,
    closed: bool = False,
    progress: Progress | None = None,
) -> BSpline:
    """Return the C2 spline of the points (n, d), d >= 2, from d - 1 planar cardinal fits, merged.

    Each of the d - 1 planes holds the common axis and one other axis, in rising order; `tensions` is one tension for
    all or one a plane. The merge keeps each plane's tangent directions and gives all planes the mean handle along the
    common axis, so the result is the cardinal spline of the mean tension: with equal tensions,
    `cardinal_spline(points, tension)`. It holds also where the points turn back or stand still along the common axis.
    `progress` is called with the part that is done, from 0 to 1, after each plane; raising from it stops.

    Raises ValueError for bad points (naming the row), fewer than 2 dimensions, an axis the points do not have, a
    tension that is not a finite number, a wrong number of them, or tensions with a zero and a mean other than zero.
    Source: the paper's FC3; the mean over d - 1 planes is its section 2.9.

    >>> from cadfit.fitting.cardinal import cardinal_spline
    >>> points = [[0, 0, 0], [1, 2, 0], [0, 3, 1], [2, 4, 5]]
    >>> fit_planes(points, [0.25, 0.75]).isclose(cardinal_spline(points, 0.5))
    True
    """
    points = as_contour(points, closed)
    d = points.shape[1]
    if d < 2:
        raise ValueError("planar fits need points in at least 2 dimensions")
    common_axis, others = _axes(d, common_axis)
    taus = as_numbers(tensions, "tensions")
    taus = np.full(d - 1, taus) if taus.ndim == 0 else taus
    if taus.shape != (d - 1,) or not np.isfinite(taus).all():
        raise ValueError(f"{d - 1} planes need one finite tension, or {d - 1}, not {tensions!r}")
    if taus.mean() != 0 and np.any(taus == 0):
        raise ValueError(f"a plane of tension 0 has no direction to keep beside others: tensions {taus.tolist()}")
    if closed:  # repeated, so that a plane in which the last point meets the first is not taken to repeat it
        points = np.concatenate([points, points[:1]])
    planes, told = [], shares(progress, d)
    for axis, tau, part in zip(others, taus, told[:-1], strict=True):
        planes.append(cardinal_pieces(points[:, [common_axis, axis]], tau, closed))
        part(1.0)
    ratios = np.divide(taus.mean(), taus, out=np.ones_like(taus), where=taus != 0)
    spline = c2_spline(_merge(planes, others, common_axis, ratios), closed)
    told[-1](1.0)
    return spline


def merge_planes(planes: Sequence[ArrayLike], common_axis: int = 0) -> Array:
    """Return the d-dimensional Bézier pieces (m, 4, d) of d - 1 chains of planar pieces (m, 4, 2), by the merge rule.

    In each planar chain the first coordinate is the common axis' (the same in all at the pieces' ends), the second
    that of one other axis, in rising order. With the handle (e_i, f_i) of plane i from an end pole, and p the mean of
    all e_i, the merged handle has p on the common axis and f_i p / e_i on the plane's own: the direction in each plane
    is kept, the length shared. Where all e_i are zero the handles are kept as they are.

    Raises ValueError for wrong shapes, what is not finite, ends that disagree on the common axis (beyond 1e-12 of the
    largest coordinate), and where one e_i is zero and p is not, as no handle of length p has that direction
    (`fit_planes`, which knows its tensions, has no such case). Source: the paper, section 2.9.

    >>> steep = [[[0, 0], [1, 2], [2, 2], [3, 0]]]
    >>> wide = [[[0, 0], [3, 3], [2, 0], [3, 0]]]
    >>> merge_planes([steep, wide])[0]
    array([[0., 0., 0.],
           [2., 4., 2.],
           [2., 2., 0.],
           [3., 0., 0.]])
    """
    chains = [as_numbers(plane, f"plane {i}") for i, plane in enumerate(planes)]
    if not chains:
        raise ValueError("at least one plane is needed")
    for i, chain in enumerate(chains):
        if chain.ndim != 3 or chain.shape[1:] != (4, 2) or chain.shape != chains[0].shape:
            raise ValueError(f"plane {i} must have the shape (m, 4, 2) like plane 0, not {chain.shape}")
        if not np.isfinite(chain).all():
            piece = int(np.argwhere(~np.isfinite(chain))[0, 0])
            raise ValueError(f"piece {piece} of plane {i} is not finite: {chain[piece].tolist()}")
    rounding = 1e-12 * max(float(np.abs(chain).max(initial=0.0)) for chain in chains)
    for i, chain in enumerate(chains):
        apart = np.abs(chain[:, [0, 3], 0] - chains[0][:, [0, 3], 0]).max(axis=1, initial=0.0)
        if np.any(apart > rounding):
            piece = int(np.argmax(apart > rounding))
            raise ValueError(f"piece {piece} of plane {i} ends elsewhere on the common axis than in plane 0")
    common_axis, others = _axes(len(chains) + 1, common_axis)
    along = np.stack([_handles(chain)[:, :, 0] for chain in chains])  # e_i: (planes, m, 2)
    mean = along.mean(axis=0)
    lost = (along == 0) & (mean != 0)
    if np.any(lost):
        i, piece, end = (int(k) for k in np.argwhere(lost)[0])
        raise ValueError(
            f"plane {i}, piece {piece}: the handle of pole {3 * end} stands still along the common axis, "
            f"where the mean of all planes is {mean[piece, end]:.6g}"
        )
    ratios = np.divide(mean, along, out=np.ones_like(along), where=along != 0)
    return _merge(chains, others, common_axis, ratios)


def _axes(d: int, common_axis: int) -> tuple[int, list[int]]:
    """Return the common axis, checked, and the others."""
    if common_axis not in range(d):
        raise ValueError(f"common_axis must be from 0 to {d - 1}, not {common_axis}")
    return int(common_axis), [axis for axis in range(d) if axis != common_axis]


def _handles(chain: Array) -> Array:
    """Return the handles (m, 2, d) of the pieces' two end poles, both pointing into the piece."""
    return np.stack([chain[:, 1] - chain[:, 0], chain[:, 2] - chain[:, 3]], axis=1)


def _merge(planes: Sequence[Array], others: Sequence[int], common_axis: int, ratios: Array) -> Array:
    """Merge planar chains; `ratios` is p / e_i: one a plane, or (planes, m, 2) for every handle."""
    m = len(planes[0])
    pieces = np.empty((m, 4, len(planes) + 1))
    handles = [_handles(plane) for plane in planes]
    common = np.mean([handle[:, :, 0] for handle in handles], axis=0)
    own = [
        (axis, plane[:, :, 1], handle[:, :, 1] * ratio)
        for axis, plane, handle, ratio in zip(others, planes, handles, ratios, strict=True)
    ]
    for axis, poles, handle in [(common_axis, planes[0][:, :, 0], common), *own]:
        pieces[:, 0, axis], pieces[:, 3, axis] = poles[:, 0], poles[:, 3]
        pieces[:, 1, axis] = poles[:, 0] + handle[:, 0]
        pieces[:, 2, axis] = poles[:, 3] + handle[:, 1]
    return pieces
