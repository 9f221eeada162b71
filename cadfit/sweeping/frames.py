"""Rotation-minimizing frames along a path, by double reflection.

Source: Wang, Jüttler, Zheng, Liu, Computation of rotation minimizing frames, ACM Transactions on Graphics 27(1), 2008;
`cadfit.sweeping.spinors` says how it is computed.
"""

from __future__ import annotations

import os
from collections import deque
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, NamedTuple, TypeVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

from cadfit.bezier import Array, Ints
from cadfit.bspline import BSpline
from cadfit.numbers import as_numbers
from cadfit.sweeping.cubics import NOISE, SLOW, horner, limits, may_rest, norms, powers
from cadfit.sweeping.spinors import Complex, across, carried, level, reflected, renamed, running, spinors, turned

if TYPE_CHECKING:
    from concurrent.futures import Future

_T = TypeVar("_T")
SMOOTH = 1e-6  # radians: a smaller break of the tangent is rounding, a larger one is a corner
_LEVEL = 1e-6  # the sine of the least angle between a tangent and `up`
_BLOCK = 16384  # stations whose numbers stay in the cache
_MANY = 4  # blocks: from so many on threads are worth their start
_PLACES = ("origins", "tangents", "normals", "binormals", "lengths")


@dataclass(frozen=True, slots=True, eq=False)
class Frames:
    """Frames at n stations of a path: `origins`, `tangents`, `normals`, `binormals`, (n, 3) each, read-only.

    Tangent, normal and binormal are right-handed unit vectors. `lengths` (n,) is the arc length from the path's start
    (Simpson's rule from station to station). `holonomy` is the angle in radians by which the transported normal of a
    closed path missed its start, counted about the tangent; it has been spread over the frames, so that the seam
    closes. It is 0.0 on an open path. `error` estimates the angle in radians by which the last normal may be off: the
    difference that half steps make, times the square of each step's bend, which is what the extrapolation leaves.
    """

    origins: Array
    tangents: Array
    normals: Array
    binormals: Array
    lengths: Array
    holonomy: float = 0.0
    error: float = 0.0

    def __post_init__(self) -> None:
        for name in _PLACES:
            values = getattr(self, name).view()
            values.flags.writeable = False
            object.__setattr__(self, name, values)

    def rows(self, which: Ints) -> Frames:
        """Return the frames at some of the stations (k,)."""
        return replace(self, **{name: getattr(self, name)[which] for name in _PLACES})

    def __len__(self) -> int:
        return len(self.lengths)


def frames(spline: BSpline, parameters: ArrayLike, up: ArrayLike | None = None) -> Frames:
    """Return the rotation-minimizing frames of a path at the given parameters (n,), in any order.

    `spline` has 2 or 3 dimensions (2D lies in z = 0). The frames turn about the tangent as little as the path's bending
    allows, from a first normal that is horizontal (its binormal points up, toward +z; where the path starts near the
    vertical, toward +y). They are transported through every knot of the path as well as the parameters, each step
    also as two half steps, whose difference takes the error from fourth to sixth order. On a closed path with
    one tangent at the seam the angle left over, `Frames.holonomy`, is spread evenly along the arc length.

    With `up` (3,) there is no transport: every binormal is `up` made square to the tangent, every normal level, as on
    a road without banking. Frenet's frames are `cadfit.frenet`.

    Where the path stands still (a cusp, repeated poles) the tangent is the direction in which it leaves, at the very
    end that in which it arrives. At a corner it is the tangent after the corner. Where the tangent turns straight
    back, every normal is as good as another, and the one given depends on rounding.

    Raises ValueError for a path of another dimension, for one that never moves, for a parameter outside its domain, and
    where the path runs along `up`.
    Source: Wang, Jüttler, Zheng, Liu 2008, sections 4 and 6.1; Richardson's extrapolation of the step angles is ours.

    >>> path = BSpline([[0, 0, 0], [2, 0, 0], [3, 1, 0], [3, 3, 0]], [0, 0, 0, 0, 1, 1, 1, 1])
    >>> f = frames(path, [0.0, 0.5, 1.0])
    >>> np.stack([f.tangents[-1], f.normals[-1], f.binormals[-1]]).round(12) + 0.0
    array([[ 0.,  1.,  0.], [-1.,  0.,  0.], [ 0.,  0.,  1.]])
    """
    path = lifted(spline)
    wanted = as_numbers(parameters, "parameters").reshape(-1)
    if np.isnan(wanted).any():
        raise ValueError("parameters must be numbers, not NaN")
    rises = bool((wanted[1:] > wanted[:-1]).all())
    rising, order = (wanted, None) if rises else np.unique(wanted, return_inverse=True)
    found = _along(path, rising)
    if order is not None:
        found = found.rows(order)
    return found if up is None else upright(found, up, wanted)


def _along(path: BSpline, wanted: Array) -> Frames:
    """Return the frames at parameters (n,), rising, carried through the path's knots as well."""
    u, is_wanted = _with_knots(path, wanted)
    vectors = origins, tangents, normals, binormals = np.empty((4, 3, len(wanted)))
    lengths = np.empty(len(wanted))
    ends: list[tuple[Array, Complex, complex]] = []
    length, error, done = 0.0, 0.0, 0
    for rows, points, steps in _blocks(path, u):
        psi = steps.psi
        # The first station is the last of the block before, where its spinor may have been another.
        factor = ends[-1][2] * renamed(ends[-1][1], psi[:, 0]) if ends else level(psi[:, 0])
        factors: Complex = running(np.multiply, factor, steps.turns)
        along = running(np.add, length, steps.lengths)
        length, error = along[-1], error + steps.error
        ends += [(steps.tangents[:, k], psi[:, k], factors[k]) for k in (0, -1)]
        placed = points, steps.tangents, *across(psi, factors / steps.squares)
        kept = np.flatnonzero(is_wanted[rows])
        filled = slice(done, done + len(kept))
        for found, out in (along, lengths), *zip(placed, vectors, strict=True):
            found.take(kept, axis=-1, out=out[..., filled], mode="clip")  # nothing to clip, but quicker
        done = filled.stop - int(is_wanted[rows][-1])  # which the next block starts with
    (leaving, first, begun), (arriving, last, factor) = ends[0], ends[-1]
    angle = 0.0
    if path.closed and np.linalg.norm(arriving - leaving) <= SMOOTH:
        angle = -float(np.angle(factor * renamed(last, first) / begun))
        for start in range(0, len(wanted), _BLOCK):
            rows = slice(start, start + _BLOCK)
            turns = angle / length * lengths[rows]
            normals[:, rows], binormals[:, rows] = turned(normals[:, rows], binormals[:, rows], turns)
    return Frames(origins.T, tangents.T, normals.T, binormals.T, lengths, angle, error)


def _with_knots(path: BSpline, wanted: Array) -> tuple[Array, NDArray[np.bool_]]:
    """Return parameters, rising, with the path's knots put between them, and whether each was wanted."""
    knots = path.distinct_knots
    places = np.searchsorted(wanted, knots)
    added = np.append(wanted, np.inf)[places] != knots
    u = np.insert(wanted, places[added], knots[added])
    path(u[[0, -1]])  # refuses what is outside
    return u, np.insert(np.ones(len(wanted), dtype=bool), places[added], False)


def _blocks(path: BSpline, u: Array) -> Iterator[tuple[slice, Array, _Steps]]:
    """Return, block by block, rows of stations u (n,) that stay in the cache, their places (3, k), and the steps there.

    The last row of one is the first of the next. Where the path may stand still, what comes long before and after
    tells its direction, so there all rows are one block.
    """
    knots = path.distinct_knots
    first = np.searchsorted(u, knots[:-1])
    owner = np.repeat(np.arange(len(first)), np.diff([*first, len(u)]))
    poles = path.pieces().transpose(1, 2, 0)
    legs, widths = poles[1:] - poles[:-1], knots[1:] - knots[:-1]
    coefficients = powers(poles[0], legs)
    size = len(u) if len(u) <= _BLOCK or may_rest(legs / widths) else _BLOCK

    def block(start: int) -> tuple[slice, Array, _Steps]:
        rows = slice(start, start + size + 1)
        mine = owner[rows]
        points, velocities = horner(coefficients.take(mine, axis=2), (u[rows] - knots[mine]) / widths[mine])
        return rows, points, _steps(points, velocities / widths[mine], u[rows])

    starts = range(0, len(u) - 1, size)
    return map(block, starts) if len(starts) < _MANY else _ahead(block, starts)


def _ahead(work: Callable[[int], _T], items: Iterable[int]) -> Iterator[_T]:
    """Yield what the work makes of the items, in order; threads work on a few at once, for numpy lets them."""
    from concurrent.futures import ThreadPoolExecutor

    count = min(os.cpu_count() or 1, _MANY)
    with ThreadPoolExecutor(count) as pool:
        begun: deque[Future[_T]] = deque()
        for item in items:
            begun.append(pool.submit(work, item))
            if len(begun) > 2 * count:
                yield begun.popleft().result()
        yield from (future.result() for future in begun)


class _Steps(NamedTuple):
    """Stations on a path, and the steps between them.

    Unit `tangents` (3, n), spinors `psi` (2, n) along them and the squares (n,) of their lengths; factors `turns`
    (n - 1,) that carry the frames on, `lengths` (n - 1,), and the angle by which the turns together may be off.
    """

    tangents: Array
    psi: Complex
    squares: Array
    turns: Complex
    lengths: Array
    error: float


def _steps(points: Array, velocities: Array, u: Array) -> _Steps:
    """Return the steps between places (3, n) at parameters u (n,), between two of which the path is one cubic."""
    thirds = (u[1:] - u[:-1]) / 3.0
    leaving, arriving = thirds * velocities[:, :-1], thirds * velocities[:, 1:]  # its Bézier handles there
    chords = points[:, 1:] - points[:, :-1]
    tops = 0.5 * chords - 0.25 * (leaving + arriving)  # a third of the velocity halfway, as the handles are at the ends
    bulge = 0.375 * (leaving - arriving)  # of the halfway point over the middle of the chord
    halves = 0.5 * chords + bulge, 0.5 * chords - bulge
    speeds, sizes = norms(velocities), norms(tops)
    handles = thirds * speeds[:-1], thirds * speeds[1:]
    lengths = 0.5 * (handles[0] + handles[1]) + 2.0 * sizes
    if min(handles[0].min(), handles[1][-1]) <= SLOW * handles[0].max():
        velocities = limits(leaving, arriving, chords, points)
        speeds = norms(velocities)
        # A chord hardly longer than its rounding has no direction to reflect in, nor a way through the middle.
        short = norms(chords) <= 1e3 * NOISE * np.abs(points).max()
        chords[:, short] = tops[:, short] = sizes[short] = 0.0
    tangents = velocities / speeds
    psi, squares = spinors(tangents, 1.0)
    middle, _ = spinors(tops, sizes)
    start, end = psi[:, :-1], psi[:, 1:]
    whole = carried(start, chords, end)
    twice = reflected(start, halves[0], middle) * reflected(middle, halves[1], end)
    twice = np.where(twice == 0.0, whole, twice)
    # One step's phase is off by c h^5, that of two half steps by c h^5 / 16: Richardson gives 16 / 15 of the one less
    # 1 / 15 of the other, which for phases as near as these is the direction of this sum.
    twice *= 1.0 / np.abs(twice)
    whole *= 1.0 / np.abs(whole)
    bends = tangents[:, 1:] - tangents[:, :-1]
    error = 2.0 / 15.0 * float(np.einsum("n,dn,dn->", np.abs(twice - whole), bends, bends))
    steps = 16.0 * twice - whole
    return _Steps(tangents, psi, squares, steps / steps.conj(), lengths, error)


def vector(up: ArrayLike) -> Array:
    """Return `up` as three numbers; raises ValueError for what is no direction."""
    try:
        axis = np.asarray(up, dtype=np.float64)
    except (TypeError, ValueError):  # text, or rows of different lengths
        axis = np.empty(0)
    if axis.shape != (3,) or not np.isfinite(axis).all() or not axis.any():
        raise ValueError(f"`up` must be a vector of three finite numbers, not all zero, and not {up!r}")
    return axis


def upright(along: Frames, up: ArrayLike, parameters: Array) -> Frames:
    """Return frames turned about their tangents so that every binormal lies in a plane with `up`, on its side.

    Raises ValueError where a tangent is along `up`, with its parameter (`parameters` (n,) are those of the frames).

    >>> path = BSpline([[0, 0, 0], [0, 1, 0], [0, 2, 0], [0, 3, 3]], [0, 0, 0, 0, 1, 1, 1, 1])
    >>> upright(frames(path, [0.0]), [1, 0, 9], np.zeros(1)).binormals.round(3) + 0.0
    array([[0.11 , 0.   , 0.994]])
    """
    axis = vector(up)
    axis = axis / np.abs(axis).max()  # so that its square is a number
    axis = axis / np.linalg.norm(axis)
    normals = np.cross(axis, along.tangents)
    sizes = np.linalg.norm(normals, axis=1)
    if sizes.size and sizes.min() < _LEVEL:
        worst = int(np.argmin(sizes))
        x, y, z = along.origins[worst]
        raise ValueError(
            f"the path runs along `up` at the parameter {parameters[worst]:g}, near ({x:g}, {y:g}, {z:g}): "
            "no side of it is up there"
        )
    normals /= sizes[:, None]
    binormals = np.cross(along.tangents, normals)
    return Frames(along.origins, along.tangents, normals, binormals, along.lengths)


def lifted(spline: BSpline) -> BSpline:
    """Return the path in three dimensions: a 2D spline is laid in z = 0.

    Raises TypeError for anything but a BSpline, ValueError for another dimension.

    >>> lifted(BSpline([[0, 0], [1, 1], [2, 1], [3, 0]], [0, 0, 0, 0, 1, 1, 1, 1])).poles[1]
    array([1., 1., 0.])
    """
    if not isinstance(spline, BSpline):
        raise TypeError(f"the path must be a cadfit.BSpline, not {type(spline).__name__}")
    d = spline.poles.shape[1]
    if d not in (2, 3):
        raise ValueError(f"the path must have 2 or 3 dimensions, not {d}")
    return spline if d == 3 else spline.transformed(np.eye(3, 2))
