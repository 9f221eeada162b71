"""The loops of a profile as rational B-spline arcs: one for each face that a solid has round it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TypeAlias

import numpy as np
from scipy.interpolate import BSpline as ScipySpline

from cadfit import bezier
from cadfit.bezier import Array
from cadfit.bspline import DEGREE, BSpline

_NODES, _WEIGHTS = np.polynomial.legendre.leggauss(24)


@dataclass(frozen=True, slots=True, eq=False)
class Arc:
    """A clamped rational B-spline in the plane: `poles` (k, 2), `weights` (k,), `knots` (k + degree + 1,)."""

    poles: Array
    weights: Array
    knots: Array
    degree: int

    def places(self, count: int) -> Array:
        """Return places (count, 2) evenly spaced in the parameter, both ends with them."""
        return self._at(np.linspace(self.knots[0], self.knots[-1], count))[0]

    def quadrature(self) -> tuple[Array, Array]:
        """Return Gauss places (q, 2) and the arc's velocity there, times the weights of the rule (q, 2)."""
        spans = np.unique(self.knots)
        half = 0.5 * np.diff(spans)[:, None]
        u = (spans[:-1, None] + half * (1.0 + _NODES)).ravel()
        places, velocities = self._at(u)
        return places, velocities * (half * _WEIGHTS).ravel()[:, None]

    def _at(self, u: Array) -> tuple[Array, Array]:
        homogeneous = np.column_stack([self.weights[:, None] * self.poles, self.weights])
        spline = ScipySpline.construct_fast(self.knots, homogeneous, self.degree)
        value, slope = spline(u), spline(u, 1)
        places = value[:, :2] / value[:, 2:]
        return places, (slope[:, :2] - places * slope[:, 2:]) / value[:, 2:]


Loop: TypeAlias = tuple[Arc, ...]
"""Two arcs or more that follow each other end to end and close, the material on their left."""


def circle(clockwise: bool = False) -> Loop:
    """Return the unit circle: two rational cubics, exact, smooth within each.

    Halves, since a whole circle has a seam, and quadratic arcs have joints where the kernel sees no tangent. The knot
    in the middle of each changes nothing but where the kernel integrates anew: without it, its volumes are 6e-4 off.
    Source: Piegl and Tiller, The NURBS Book, section 7.5 (a semicircle with positive weights needs degree 3).

    >>> [np.linalg.norm(arc.places(5), axis=1).round(15).tolist() for arc in circle()]
    [[1.0, 1.0, 1.0, 1.0, 1.0], [1.0, 1.0, 1.0, 1.0, 1.0]]
    """
    half = np.array([[1.0, 0.0], [1.0, 0.5], [0.0, 2.0], [-1.0, 0.5], [-1.0, 0.0]])
    if clockwise:
        half = half * [1.0, -1.0]
    weights = np.array([1.0, 2.0 / 3.0, 1.0 / 3.0, 2.0 / 3.0, 1.0])
    knots = np.array([0.0, 0.0, 0.0, 0.0, 0.5, 1.0, 1.0, 1.0, 1.0])
    return Arc(half, weights, knots, 3), Arc(-half, weights, knots, 3)


def arcs(loop: BSpline) -> Loop:
    """Return the arcs of a closed curve: cut at triple knots, straight ones as lines, a single one in two.

    >>> square = [[0, 0], [1, 0], [2, 0], [3, 0], [3, 1], [3, 2], [3, 3], [2, 2], [1, 1], [0, 0]]
    >>> [arc.degree for arc in arcs(BSpline(square, [0, 0, 0, 0, 1, 1, 1, 2, 2, 2, 3, 3, 3, 3]))]
    [1, 1, 1]
    """
    parts = []
    for u in loop.distinct_knots[1:-1][loop.multiplicities[1:-1] == DEGREE].tolist():
        before, loop = loop.split(u)
        parts.append(before)
    parts.append(loop)
    if len(parts) == 1:
        knots = loop.distinct_knots
        parts = [*loop.split(float(knots[len(knots) // 2] if len(knots) > 2 else 0.5 * (knots[0] + knots[1])))]
    return tuple(_arc(part) for part in parts)


def moments(loop: Loop) -> Array:
    """Return the area of a loop and its first moments (the integrals of 1, x and y), negative when clockwise.

    >>> (moments(circle()) / np.pi).round(12) + 0.0
    array([1., 0., 0.])
    """
    (x, y), (dx, dy) = (values.T for values in quadrature(loop))
    return np.array([0.5 * (x * dy - y * dx).sum(), 0.5 * (x * x * dy).sum(), -0.5 * (y * y * dx).sum()])


def quadrature(loop: Loop) -> tuple[Array, Array]:
    """Return Gauss places (q, 2) round a loop, and its velocity there times the weights of the rule (q, 2)."""
    places, velocities = zip(*(arc.quadrature() for arc in loop), strict=True)
    return np.concatenate(places), np.concatenate(velocities)


def outline(loop: Loop, count: int = 32) -> Array:
    """Return places (n, 2) round a loop: the ends of straight arcs, and `count` on each span of the others."""
    counts = [1 if arc.degree == 1 else count * (len(np.unique(arc.knots)) - 1) for arc in loop]
    return np.concatenate([arc.places(n + 1)[:-1] for arc, n in zip(loop, counts, strict=True)])


def _arc(part: BSpline) -> Arc:
    if bezier.distance_to_segment(part.poles, part.poles[0], part.poles[-1]).max() > 1e-13 * part.size:
        return Arc(part.poles, np.ones(len(part.poles)), part.knots, DEGREE)
    return Arc(part.poles[[0, -1]], np.ones(2), np.repeat([0.0, 1.0], 2), 1)
