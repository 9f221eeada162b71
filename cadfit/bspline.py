"""The one curve type: a clamped, non-rational cubic B-spline in any dimension."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike
from scipy.interpolate import BSpline as _ScipySpline

from cadfit import bezier
from cadfit.bezier import Array, Ints
from cadfit.numbers import as_number, as_numbers
from cadfit.stages import Progress, portion

if TYPE_CHECKING:
    from matplotlib.axes import Axes

DEGREE = 3
_BLOCK = 1 << 15  # rows


@dataclass(frozen=True, slots=True, eq=False, repr=False)
class BSpline:
    """A clamped cubic B-spline curve: `poles` (n, d) and the full vector of `knots` (n + 4,).

    Lengths are in the caller's unit. The first and the last knot stand four times, interior knots at most three
    times; d is 1 or more, n is 4 or more. Both arrays are copied in and read-only, so a spline never changes: the
    methods return new ones.

    Raises ValueError naming what is wrong: shapes, a value that is not finite, knots that fall, a wrong multiplicity.
    Source: de Boor, A Practical Guide to Splines (1978); Piegl and Tiller, The NURBS Book (1997), chapters 2 to 5.

    >>> s = BSpline([[0, 0], [1, 2], [3, 2], [4, 0]], [0, 0, 0, 0, 1, 1, 1, 1])
    >>> s
    BSpline(4 poles in 2D, 1 span, u in [0.0, 1.0])
    >>> s(0.5)
    array([2. , 1.5])
    """

    poles: Array
    knots: Array

    def __post_init__(self) -> None:
        poles = _frozen(self.poles, "poles")
        knots = _frozen(self.knots, "knots")
        object.__setattr__(self, "poles", poles)
        object.__setattr__(self, "knots", knots)
        if poles.ndim != 2 or poles.shape[1] < 1 or len(poles) < DEGREE + 1:
            raise ValueError(f"poles must have the shape (n >= 4, d >= 1), not {poles.shape}")
        if knots.shape != (len(poles) + DEGREE + 1,):
            raise ValueError(f"{len(poles)} poles need {len(poles) + 4} knots (full vector), not {knots.shape}")
        if not ((knots[:4] == knots[0]).all() and (knots[-4:] == knots[-1]).all() and _rising(knots[3:-3])):
            _check_repeats(knots)

    def __repr__(self) -> str:
        spans = len(self.distinct_knots) - 1
        low, high = self.domain
        n, d = self.poles.shape
        return f"BSpline({n} poles in {d}D, {spans} span{'s'[: spans > 1]}, u in [{low}, {high}])"

    def _repr_html_(self) -> str:
        from cadfit.report.notebook import html_of_spline

        return html_of_spline(self)

    def __reduce__(self) -> tuple[type[BSpline], tuple[Array, Array]]:
        return BSpline, (self.poles, self.knots)

    @property
    def domain(self) -> tuple[float, float]:
        """The first and the last parameter."""
        return float(self.knots[0]), float(self.knots[-1])

    @property
    def distinct_knots(self) -> Array:
        """The knots without repeats, rising (k,): with `multiplicities`, the form OCCT and STEP use."""
        return np.asarray(self.knots[np.concatenate([[True], np.diff(self.knots) > 0])])

    @property
    def multiplicities(self) -> Ints:
        """How often each distinct knot stands (k,); 4 at both ends."""
        starts = np.flatnonzero(np.concatenate([[True], np.diff(self.knots) > 0, [True]]))
        return np.diff(starts)

    @property
    def closed(self) -> bool:
        """Whether the last pole is the first, to the last bit."""
        return bool(np.array_equal(self.poles[0], self.poles[-1]))

    @property
    def size(self) -> float:
        """The diagonal of the box around the poles."""
        return float(np.linalg.norm([np.ptp(column) for column in self.poles.T]))  # numpy is slow along short rows

    def __call__(self, u: ArrayLike) -> Array:
        """Return the points (..., d) at the parameters u (...).

        Raises ValueError for a parameter outside the domain.
        """
        return self.derivative(u, 0)

    def derivative(self, u: ArrayLike, order: int = 1) -> Array:
        """Return the derivatives of the given order (..., d) at the parameters u (...).

        At a knot where the derivative jumps it is the one from the right (at the end of the domain, from the left).
        Raises ValueError for a parameter outside the domain or a negative order.

        >>> BSpline([[0.0], [1.0], [2.0], [3.0]], [0, 0, 0, 0, 1, 1, 1, 1]).derivative([0.0, 1.0])
        array([[3.], [3.]])
        """
        if order < 0:
            raise ValueError(f"the order of a derivative must be 0 or more, not {order}")
        u = self._inside(u)
        if order > DEGREE:
            return np.zeros((*u.shape, self.poles.shape[1]))
        return np.asarray(_ScipySpline.construct_fast(self.knots, self.poles, DEGREE, extrapolate=False)(u, order))

    def curvature(self, u: ArrayLike) -> Array:
        """Return the curvature vectors (..., d) at the parameters u (...): toward the centre, of length 1 / radius.

        Zero where the curve stands still (a cusp), where curvature is not defined.

        >>> s = BSpline([[0, 0], [0, 0], [1, 1], [2, 0]], [0, 0, 0, 0, 1, 1, 1, 1])
        >>> s.curvature(1.0)
        array([-0.33333333, -0.33333333])
        """
        first, second = self.derivative(u, 1), self.derivative(u, 2)
        square = np.einsum("...d,...d->...", first, first)[..., None]
        along = np.einsum("...d,...d->...", first, second)[..., None]
        still = square == 0
        square = np.where(still, 1.0, square)
        return np.where(still, 0.0, (second - along / square * first) / square)

    def pieces(self) -> Array:
        """Return the curve's Bézier pieces (spans, 4, d), one for each non-empty knot span, joined to the last bit.

        >>> BSpline([[0.0], [1.0], [2.0], [4.0], [5.0]], [0, 0, 0, 0, 1, 2, 2, 2, 2]).pieces()[:, :, 0]
        array([[0.  , 1.  , 1.5 , 2.25], [2.25, 3.  , 4.  , 5.  ]])
        """
        out = np.ascontiguousarray(self.pieces_of(np.flatnonzero(self.knots[1:] > self.knots[:-1])))
        out[:-1, 3] = out[1:, 0]
        out[0, 0], out[-1, 3] = self.poles[0], self.poles[-1]
        return out

    def pieces_of(self, spans: Ints) -> Array:
        """Return the Bézier pieces (k, 4, d) of spans (k,), each the index of its first knot: knots[i] < knots[i + 1].

        Source: Piegl and Tiller, section 5.3; here in closed form from the polar values of each span.

        >>> BSpline([[0.0], [1.0], [2.0], [4.0], [5.0]], [0, 0, 0, 0, 1, 2, 2, 2, 2]).pieces_of(np.array([4]))[0, :, 0]
        array([2.25, 3.  , 4.  , 5.  ])
        """
        t0, t1, a, b, t2, t3 = self.knots.take(spans + np.arange(-2, 4)[:, None])
        # Computed with a row for each coordinate: long rows are what numpy is quick at.
        poles = self.poles.take(spans + np.arange(-3, 1)[:, None], axis=0).transpose(0, 2, 1)
        d0, d1, d2, d3 = np.ascontiguousarray(poles)

        def between(p: Array, q: Array, ratio: Array) -> Array:
            return p + ratio * (q - p)

        out = np.empty((4, *d0.shape))
        inner = t2 - t1
        out[1] = between(d1, d2, (a - t1) / inner)
        out[2] = between(d1, d2, (b - t1) / inner)
        out[0] = between(between(d0, d1, (a - t0) / (b - t0)), out[1], (a - t1) / (b - t1))
        out[3] = between(out[2], between(d2, d3, (b - a) / (t3 - a)), (b - a) / (t2 - a))
        return out.transpose(2, 0, 1)

    def insert_knot(self, u: float, times: int = 1) -> BSpline:
        """Return the same curve with the knot u inserted `times` times.

        Raises ValueError when u is not strictly inside the domain or would stand more than three times.
        Source: Boehm, Inserting new knots into B-spline curves, CAD 12(4), 1980.

        >>> s = BSpline([[0.0], [1.0], [2.0], [3.0]], [0, 0, 0, 0, 1, 1, 1, 1]).insert_knot(0.5)
        >>> len(s.poles), s(0.25)
        (5, array([0.75]))
        """
        low, high = self.domain
        if not low < as_number(u, "knot") < high:
            raise ValueError(f"a knot can be inserted strictly inside [{low}, {high}], not at {u}")
        have = int(np.count_nonzero(self.knots == u))
        if times < 0 or have + times > DEGREE:
            raise ValueError(f"the knot {u} stands {have} times; {times} more is not possible (3 is the most)")
        poles, knots = self.poles, self.knots
        for count in range(have, have + times):
            k = int(np.searchsorted(knots, u, side="right"))  # u lies before knots[k]
            i = np.arange(k - DEGREE, k - count)
            ratio = ((u - knots[i]) / (knots[i + DEGREE] - knots[i]))[:, None]
            new = poles[i - 1] + ratio * (poles[i] - poles[i - 1])
            poles = np.concatenate([poles[: k - DEGREE], new, poles[k - count - 1 :]])
            knots = np.insert(knots, k, u)
        return BSpline(poles, knots)

    def split(self, u: float) -> tuple[BSpline, BSpline]:
        """Return the part before and the part after the parameter u; both keep their parameters.

        Raises ValueError when u is not strictly inside the domain.

        >>> left, right = BSpline([[0.0], [1.0], [2.0], [3.0]], [0, 0, 0, 0, 1, 1, 1, 1]).split(0.5)
        >>> left.domain, right.domain, bool(left(0.5) == right(0.5))
        ((0.0, 0.5), (0.5, 1.0), True)
        """
        u = as_number(u, "parameter")
        full = self.insert_knot(u, DEGREE - int(np.count_nonzero(self.knots == u)))
        i = int(np.searchsorted(full.knots, u))
        left = BSpline(full.poles[:i], np.append(full.knots[: i + DEGREE], u))
        right = BSpline(full.poles[i - 1 :], np.concatenate([[u], full.knots[i:]]))
        return left, right

    def reversed(self) -> BSpline:
        """Return the same curve run backwards, on the same domain.

        Spans at its ends too short for the numbers at the other end become the shortest there are.

        >>> BSpline([[0.0], [1.0], [2.0], [4.0]], [0, 0, 0, 0, 1, 1, 1, 1]).reversed().poles[:, 0]
        array([4., 2., 1., 0.])
        """
        low, high = self.domain
        knots = low + high - self.knots[::-1]
        knots[:4], knots[-4:] = low, high
        np.clip(knots[4:-4], np.nextafter(low, high), np.nextafter(high, low), out=knots[4:-4])
        return BSpline(self.poles[::-1], knots)

    def transformed(self, matrix: ArrayLike, offset: ArrayLike = 0.0) -> BSpline:
        """Return the curve under the affine map x -> matrix x + offset.

        `matrix` (k, d) and `offset` (k,) or a number; with k other than d the curve is projected or lifted.
        Raises ValueError when the shapes do not fit.

        >>> flat = BSpline([[0, 0], [1, 1], [2, 1], [3, 0]], [0, 0, 0, 0, 1, 1, 1, 1])
        >>> flat.transformed([[1, 0], [0, 1], [0, 0]], [0, 0, 5]).poles[1]
        array([1., 1., 5.])
        """
        matrix = as_numbers(matrix, "matrix")
        if matrix.ndim != 2 or matrix.shape[1] != self.poles.shape[1]:
            raise ValueError(f"the matrix must have the shape (k, {self.poles.shape[1]}), not {matrix.shape}")
        offset = as_numbers(offset, "offset")
        if offset.shape not in ((), (len(matrix),)):  # numpy would stretch the poles to it
            raise ValueError(f"the offset must be a number or have the shape ({len(matrix)},), not {offset.shape}")
        return BSpline(self.poles @ matrix.T + offset, self.knots)

    def length(self, accuracy: float = 1e-9, progress: Progress | None = None) -> float:
        """Return the arc length, with an estimated relative error of at most `accuracy` (see `bezier.lengths`).

        `progress` is called with the part that is done, from 0 to 1; raising from it stops. Raises ValueError when
        `accuracy` is not above 0.

        >>> BSpline([[0, 0], [1, 0], [2, 0], [3, 0]], [0, 0, 0, 0, 1, 1, 1, 1]).length()
        3.0
        """
        if not as_number(accuracy, "accuracy") > 0.0:
            raise ValueError(f"the accuracy must be above 0, not {accuracy}")
        found = float(bezier.lengths(self.pieces(), accuracy, progress).sum())
        portion(progress, 0.0, 1.0)(1.0)
        return found

    def nearest(self, points: ArrayLike, progress: Progress | None = None) -> tuple[Array, Array]:
        """Return the parameters (...) and distances (...) of the curve's nearest places to `points` (..., d).

        The search over the whole curve is branch and bound, so it does not settle in a local minimum (its limits:
        `bezier.nearest`). `progress`: as in `length`. Raises ValueError when the points have another dimension than the
        curve.

        >>> s = BSpline([[0, 0], [1, 0], [2, 0], [3, 0]], [0, 0, 0, 0, 1, 1, 1, 1])
        >>> s.nearest([1.5, 2.0])
        (array(0.5), array(2.))
        """
        points = as_numbers(points, "points")
        d = self.poles.shape[1]
        if points.ndim == 0 or points.shape[-1] != d:
            raise ValueError(f"points must have the shape (..., {d}), not {points.shape}")
        if not np.isfinite(points).all():
            raise ValueError("points must be finite")
        shape = points.shape[:-1]
        piece, t, distance = bezier.nearest(self.pieces(), points.reshape(-1, d), progress)
        portion(progress, 0.0, 1.0)(1.0)
        spans = self.distinct_knots
        u = spans[piece] + t * (spans[piece + 1] - spans[piece])
        return np.clip(u, *self.domain).reshape(shape), distance.reshape(shape)

    def isclose(self, other: BSpline, tolerance: float = 1e-9) -> bool:
        """Return whether poles and knots agree, poles to `tolerance` times the size, knots times the domain.

        >>> s = BSpline([[0.0], [1.0], [2.0], [3.0]], [0, 0, 0, 0, 1, 1, 1, 1])
        >>> s.isclose(s.reversed().reversed()), s.isclose(s.reversed())
        (True, False)
        """
        if self.poles.shape != other.poles.shape:
            return False
        low, high = self.domain
        apart = np.linalg.norm(self.poles - other.poles, axis=1).max()
        off = np.abs(self.knots - other.knots).max()
        return bool(apart <= tolerance * self.size and off <= tolerance * (high - low))

    def plot(self, ax: Axes | None = None, **options: Any) -> Axes:
        """Draw the curve, its poles and its curvature comb through matplotlib (see `cadfit.plotting.plot_spline`)."""
        from cadfit.plotting import plot_spline

        return plot_spline(self, ax, **options)

    def plot_comb(self, ax: Axes | None = None, **options: Any) -> Axes:
        """Draw the curve and its curvature comb (see `cadfit.plotting.plot_comb`)."""
        from cadfit.plotting import plot_comb

        return plot_comb(self, ax, **options)

    def _inside(self, u: ArrayLike) -> Array:
        u = as_numbers(u, "parameters")
        low, high = self.domain
        if u.size and not (u.min() >= low and u.max() <= high):
            bad = u[~((u >= low) & (u <= high))].flat[0]
            raise ValueError(f"the parameter {bad} is outside [{low}, {high}]")
        return u


def _frozen(values: ArrayLike, name: str) -> Array:
    if type(values) is np.ndarray and values.dtype == np.float64 and values.base is None:  # a np.matrix stays 2D
        array = values if not values.flags.writeable else values.copy()  # read-only and its own: nothing to copy
    else:
        array = as_numbers(values, name)
        array = array if isinstance(values, (list, tuple)) else array.copy()
    if not all(np.isfinite(rows).all() for rows in _in_blocks(np.atleast_1d(array), 0)):
        where = tuple(int(k) for k in np.argwhere(~np.isfinite(array))[0])
        raise ValueError(f"{name} must be finite: entry {where} is {array[where]}")
    array.setflags(write=False)
    return array


def _in_blocks(array: Array, overlap: int) -> Iterator[Array]:
    """Yield so many rows at a time that what is made of them stays in the cache, each time some of the next ones."""
    return (array[start : start + _BLOCK + overlap] for start in range(0, len(array) - overlap, _BLOCK))


def _rising(knots: Array) -> bool:
    return all((some[1:] > some[:-1]).all() for some in _in_blocks(knots, 1))


def _check_repeats(knots: Array) -> None:
    falls = knots[1:] < knots[:-1]
    if falls.any():
        row = int(np.argmax(falls))
        raise ValueError(f"knots must not fall: knot {row} is {knots[row]}, knot {row + 1} is {knots[row + 1]}")
    if not (knots[0] == knots[3] < knots[4] and knots[-5] < knots[-4] == knots[-1]):
        raise ValueError("the first and the last knot must stand exactly four times (a clamped spline)")
    interior = knots[4:-4]
    crowded = interior[3:] == interior[:-3]
    if crowded.any():
        raise ValueError(f"the interior knot {interior[np.argmax(crowded)]} stands more than three times")


def own(array: Array) -> Array:
    """Make a new array read-only, so that a `BSpline` takes it without a copy; for arrays no one else writes to."""
    array.setflags(write=False)
    return array
