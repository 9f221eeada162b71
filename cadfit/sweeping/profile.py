"""What is swept: a closed outline in the plane, with holes."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from cadfit.bezier import Array
from cadfit.bspline import BSpline
from cadfit.joining import join, polyline
from cadfit.sweeping.chain import breaks, chain
from cadfit.sweeping.cubics import norms
from cadfit.sweeping.stations import stationed

_NODES, _WEIGHTS = (0.5 * rule for rule in np.polynomial.legendre.leggauss(6))
_MOST_CHECKED = 3000  # corners: all pairs of edges are looked at up to here


@dataclass(frozen=True, slots=True, eq=False)
class Profile:
    """A closed outline in two dimensions and the holes in it, each one B-spline whose last pole is its first.

    The path runs through the origin; x goes along the path's normal and y along its binormal (which points up where
    the path starts level), so who looks along the path sees x to the left. Corners are triple knots, as `cadfit.join`
    and `cadfit.polyline` make them. The outline is turned counterclockwise, holes clockwise. `Profile.of` takes
    polygons, fits and several curves as well.

    Raises TypeError for anything but a BSpline, ValueError for another dimension, a curve that is not closed, and one
    that encloses no area.

    >>> square = Profile.of([[-1, -1], [1, -1], [1, 1], [-1, 1]])
    >>> round(square.area, 12), round(square.reach, 6)
    (4.0, 1.414214)
    """

    outline: BSpline
    holes: tuple[BSpline, ...] = ()

    def __post_init__(self) -> None:
        loops = [_turned(self.outline, 1.0, "the outline")]
        loops += [_turned(hole, -1.0, f"hole {k}") for k, hole in enumerate(self.holes)]
        object.__setattr__(self, "outline", loops[0])
        object.__setattr__(self, "holes", tuple(loops[1:]))

    @classmethod
    def of(cls, outline: Any, *holes: Any) -> Profile:
        """Return the profile of an outline and holes, each a polygon (n, 2), a `BSpline`, a `Fit`, or several curves.

        A polygon's last corner may repeat its first. A `Profile` without holes is returned as it is.

        >>> frame = Profile.of([[0, 0], [4, 0], [4, 4], [0, 4]], [[1, 1], [3, 1], [3, 3], [1, 3]])
        >>> round(frame.area, 12), frame.centroid.round(12).tolist()
        (12.0, [2.0, 2.0])
        """
        if isinstance(outline, cls) and not holes:
            return outline
        return cls(_loop(outline), tuple(map(_loop, holes)))

    @property
    def loops(self) -> tuple[BSpline, ...]:
        """The outline and the holes."""
        return self.outline, *self.holes

    @property
    def area(self) -> float:
        """The area, holes taken off."""
        return float(sum(_moments(loop)[0] for loop in self.loops))

    @property
    def centroid(self) -> Array:
        """The centre of the area (2,)."""
        moments = np.sum([_moments(loop) for loop in self.loops], axis=0)
        return np.asarray(moments[1:] / moments[0])

    @property
    def reach(self) -> float:
        """An upper bound on the distance of the outline from the path, exact for polygons."""
        return float(np.sqrt(np.square(self.outline.pieces()).sum(axis=2).max()))


def polygons(profile: Profile, tolerance: float) -> list[Array]:
    """Return polygons (k, 2) that stand for the outline and the holes, within `tolerance` of each and of its area.

    A chord cuts off a sliver of a bend. A corner of the polygon on the bend is moved outward by the slivers beside it
    over the chords beside it, so that the area is right: the polygon is then twice as far outside as inside, and a
    third of the tolerance is saved. True corners stay.

    Raises ValueError where a polygon passes through itself.

    >>> len(polygons(Profile.of([[0, 0], [1, 0], [0, 1]]), 0.1)[0])
    3
    """
    return [_polygon(loop, tolerance, _moments(loop)[0]) for loop in profile.loops]


def _polygon(loop: BSpline, tolerance: float, area: float) -> Array:
    solid = loop.transformed(np.eye(3, 2))
    whole = chain(solid)
    points, tangents = (rows[:2, :-1] for rows in stationed(whole, 1e-6 * tolerance, 1.5 * tolerance))
    corners = breaks(solid, whole)[0]
    smooth = np.ones(points.shape[1], dtype=bool)
    if len(corners):
        apart = points[:, :, None] - loop(np.where(corners == loop.knots[-1], loop.knots[0], corners)).T[:, None]
        smooth[np.argmin(np.square(apart).sum(axis=0), axis=0)] = False
    chords = np.roll(points, -1, axis=1) - points
    lengths = norms(chords)
    leaving = _cross(tangents, chords) / lengths
    # At a corner the tangent is that after it; the edge before it takes the slope of its other end, as an arc does.
    arriving = np.where(np.roll(smooth, -1), _cross(chords, np.roll(tangents, -1, axis=1)) / lengths, leaving)
    slivers = lengths * lengths * (leaving + arriving) / 12.0
    moves = smooth * (slivers + np.roll(slivers, 1)) / (lengths + np.roll(lengths, 1))
    outward = moves * np.stack([tangents[1], -tangents[0]])
    # The area is a square of the share that is moved; about one is right, and makes it right to the last bit.
    quadratic, linear, constant = _area(outward), _mixed(points, outward), _area(points) - area
    root = linear * linear - 4.0 * quadratic * constant
    share = -2.0 * constant / (linear + np.sqrt(root)) if root > 0.0 and linear > 0.0 else 1.0
    polygon = (points + np.clip(share, 0.0, 1.5) * outward).T
    _refuse_crossings(polygon)
    return np.ascontiguousarray(polygon)


def _loop(shape: Any) -> BSpline:
    """Return one closed B-spline of a polygon, a spline, a fit or several curves."""
    several = isinstance(shape, (list, tuple)) and shape and all(isinstance(each, BSpline) for each in shape)
    if several or isinstance(shape, BSpline) or hasattr(shape, "curves"):
        return join(shape)
    try:
        points = np.asarray(shape, dtype=np.float64)
    except (TypeError, ValueError):
        raise TypeError(f"a profile is a polygon (n >= 3, 2), a spline or a fit, not {shape!r}") from None
    if points.ndim != 2 or points.shape[1] != 2 or len(points) < 3:
        raise ValueError(f"a profile's polygon must have the shape (n >= 3, 2), not {points.shape}")
    if not np.isfinite(points).all():
        row = int(np.argmin(np.isfinite(points).all(axis=1)))
        raise ValueError(f"corner {row} of the profile is not finite: {points[row].tolist()}")
    return polyline(points, closed=True)


def _turned(loop: BSpline, way: float, name: str) -> BSpline:
    """Return the loop running counterclockwise (`way` 1.0) or clockwise (-1.0), checked."""
    if not isinstance(loop, BSpline):
        raise TypeError(
            f"{name} must be a cadfit.BSpline, not {type(loop).__name__}; Profile.of takes polygons and fits"
        )
    if loop.poles.shape[1] != 2:
        raise ValueError(f"{name} of the profile must have 2 dimensions, not {loop.poles.shape[1]}")
    gap = float(np.linalg.norm(loop.poles[-1] - loop.poles[0]))
    if gap > 1e-9 * loop.size:
        raise ValueError(f"{name} of the profile is not closed: its ends are {gap:.6g} apart")
    if gap:
        loop = BSpline(np.concatenate([loop.poles[:-1], loop.poles[:1]]), loop.knots)
    area = _moments(loop)[0]
    if abs(area) <= 1e-12 * loop.size**2:
        raise ValueError(f"{name} of the profile encloses no area")
    return loop if area * way > 0.0 else loop.reversed()


def _moments(loop: BSpline) -> Array:
    """Return the area, and its first moments about the y and the x axis (3,): exact, the integrands are polynomials."""
    poles = loop.pieces()
    t = (0.5 + _NODES)[:, None]
    powers = np.concatenate([(1 - t) ** 3, 3 * (1 - t) ** 2 * t, 3 * (1 - t) * t * t, t**3], axis=1)
    slopes = np.concatenate([(1 - t) ** 2, 2 * (1 - t) * t, t * t], axis=1)
    x, y = np.einsum("gk,mkd->dmg", powers, poles)
    dx, dy = 3.0 * np.einsum("gk,mkd->dmg", slopes, np.diff(poles, axis=1))
    integrands = np.stack([0.5 * (x * dy - y * dx), 0.5 * x * x * dy, -0.5 * y * y * dx])
    return np.asarray((integrands @ _WEIGHTS).sum(axis=1))


def _refuse_crossings(polygon: Array) -> None:
    """Raise for the first two edges of a polygon (k, 2) that cross."""
    n = len(polygon)
    if n > _MOST_CHECKED:
        return
    a, b = polygon.T, np.roll(polygon, -1, axis=0).T
    step = b - a
    from_here = _cross(step[:, :, None], a[:, None] - a[:, :, None])  # of each start from each edge
    other_end = np.roll(from_here, -1, axis=1)
    parted = from_here * other_end < 0.0
    if (crossed := np.argwhere(parted & parted.T)).size:
        i, j = crossed[0].tolist()
        x, y = polygon[i]
        raise ValueError(f"the profile passes through itself: edges {i} and {j}, near ({x:.6g}, {y:.6g})")


def _area(points: Array) -> float:
    return 0.5 * float(_cross(points, np.roll(points, -1, axis=1)).sum())


def _mixed(points: Array, moves: Array) -> float:
    """Return how the area of points (2, k) changes with a share of the moves, at none."""
    after = np.roll(points, -1, axis=1), np.roll(moves, -1, axis=1)
    return 0.5 * float((_cross(points, after[1]) + _cross(moves, after[0])).sum())


def _cross(a: Array, b: Array) -> Array:
    return np.asarray(a[0] * b[1] - a[1] * b[0])
