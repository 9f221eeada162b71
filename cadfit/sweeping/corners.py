"""Corners of a path: the smooth legs between them, and the mitres where these meet."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from cadfit.bezier import Array, Ints
from cadfit.bspline import BSpline

SHARPEST = math.radians(150.0)  # a path that turns more than this turns back: a mitre would stick out 4 times the reach


def legs_between(path: BSpline, corners: Array) -> list[BSpline]:
    """Return the parts of a path between parameters (n,), rising; one at an end of the domain parts nothing.

    >>> bent = BSpline([[0.0], [1.0], [2.0], [3.0]], [0, 0, 0, 0, 1, 1, 1, 1])
    >>> [leg.domain for leg in legs_between(bent, np.array([0.25, 1.0]))]
    [(0.0, 0.25), (0.25, 1.0)]
    """
    legs, rest = [], path
    for u in corners.tolist():
        if u < path.domain[1]:
            leg, rest = rest.split(u)
            legs.append(leg)
    return [*legs, rest]


def carried_over(normal: Array, before: Array, after: Array) -> Array:
    """Return a normal carried from one tangent to the next by the smallest turn, all (3,); about itself straight back.

    >>> carried_over(np.array([0.0, 1, 0]), np.array([1.0, 0, 0]), np.array([0.0, 1, 0])).round(12) + 0.0
    array([-1.,  0.,  0.])
    """
    if turns_back(before, after):
        return normal
    return np.asarray(normal - (normal @ after) / (1.0 + before @ after) * (before + after))


def turns_back(before: Array, after: Array) -> bool:
    """Return whether a path turns straight back, so that no smallest turn is defined."""
    return bool(before @ after <= -1.0 + 1e-12)


def pivoted(
    ring: Array, normal: Array, centre: Array, before: Array, after: Array, tolerance: float
) -> tuple[Array, Array]:
    """Return rings (m, k, 3), and their tangents (m, 3), that turn a ring on the spot from one tangent to the next.

    The first and the last are not among them. `normal` is the axis where the path turns straight back. They are as
    many as keep the chords of the outermost point within the tolerance, and no step is above 45 degrees.
    """
    axis = normal if turns_back(before, after) else np.cross(before, after)
    axis = axis / np.linalg.norm(axis)
    across = np.cross(axis, before)
    angle = float(np.arctan2(after @ across, after @ before)) % (2.0 * math.pi)
    arms = ring - centre
    reach = float(np.linalg.norm(arms, axis=1).max())
    steps = math.ceil(max(angle / (0.25 * math.pi), angle * math.sqrt(reach / (8.0 * tolerance))) - 1e-9)
    angles = angle / steps * np.arange(1, steps)
    cos, sin = np.cos(angles)[:, None, None], np.sin(angles)[:, None, None]
    along = arms @ axis
    turned = cos * arms + sin * np.cross(axis, arms) + (1.0 - cos) * (along[:, None] * axis)
    return centre + turned, cos[:, 0] * before + sin[:, 0] * across


def mitre(ring: Array, centre: Array, before: Array, after: Array) -> Array:
    """Return a ring (k, 3), square on the tangent `before`, moved along it into the plane halfway to `after`.

    The ring carried over to `after` and moved back along that lands on the same points: the legs meet exactly.

    >>> mitre(np.array([[0.0, 1, 0], [0, 0, 1]]), np.zeros(3), np.array([1.0, 0, 0]), np.array([0.0, 1, 0]))
    array([[-1.,  1.,  0.], [ 0.,  0.,  1.]])
    """
    plane = before + after
    return np.asarray(ring - np.outer((ring - centre) @ plane / (before @ plane), before))


def overtaken(rings: Array, mitred: Array, tangents: Array, following: Ints) -> int:
    """Return how many rings (n, k, 3), counted from the corner, a mitre overtakes: those to leave out.

    `mitred` (k, 3) is the corner's ring; `tangents` (n, 3) lead away from the corner; `following` (k,) is as
    in `loops_around`. All n where none is clear of the mitre: there is no room for it.
    """
    free = clear_of(mitred, rings, tangents, following)
    return int(np.argmax(free)) if free.any() else len(rings)


def clear_of(mitred: Array, rings: Array, tangents: Array, following: Ints) -> NDArray[np.bool_]:
    """Return whether each ring (n, k, 3) is ahead of a mitre, and of its plane, and the wall to it without a fold.

    The wall folds where a fibre that runs aslant, as with a twist, leaves the mitre's edge on the wrong side: within
    the wall, that side is where the tangent points, less what of it runs along the edge.
    """
    middle = mitred.mean(axis=0)
    size = float(np.abs(mitred - middle).max())
    fibres, edges = rings - mitred, mitred[following] - mitred
    plane = np.cross(mitred - middle, edges).sum(axis=0)
    plane *= np.sign(plane @ tangents[0]) / np.linalg.norm(plane)
    ahead = np.einsum("nkd,nd->nk", fibres, tangents)
    free = np.minimum(ahead, (rings - middle) @ plane).min(axis=1) > 1e-9 * size
    slopes, squares = tangents @ edges.T, np.square(edges).sum(axis=1)
    for ends in (np.arange(len(following)), following):
        along = np.einsum("nkd,kd->nk", fibres[:, ends], edges)
        free &= (ahead[:, ends] * squares > along * slopes).all(axis=1)
    return np.asarray(free)
