"""Curves of any origin held against points, as a fit is."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike

from cadfit.bezier import Array, Ints
from cadfit.bspline import BSpline, own
from cadfit.fitting.checking import chain_of, room_of
from cadfit.fitting.deviation import deviation, straying_chords, unrolled
from cadfit.fitting.matching import distances, match
from cadfit.fitting.result import Fit
from cadfit.joining import join
from cadfit.points.clean import clean

_SEAM = 1e-9  # of a curve's size: ends nearer than this meet


def judged(
    curves: BSpline | Sequence[BSpline],
    points: ArrayLike,
    closed: bool | None = None,
    tolerance: float | None = None,
    between: str | None = None,
    call: str = "",
) -> Fit:
    """Return curves, however they were made, as a `Fit` of points (n, d): with the certified deviation from them.

    The points are cleaned as `fit` cleans them. Where they close and the curves' ends do not meet, the first point is
    put at the end once more, and the fit is open. `tolerance`, `between` and `call` are only noted.
    Raises ValueError as `deviation` and `clean`.

    >>> arc = BSpline([[0, 0], [1, 1], [2, 1], [3, 0]], [0, 0, 0, 0, 1, 1, 1, 1])
    >>> judged(arc, [[0, 0], [1.5, 1], [3, 0]], tolerance=0.3)
    Fit(open, 1 curve, 4 poles for 3 points, deviation 0.25)
    """
    chain = (curves,) if isinstance(curves, BSpline) else tuple(curves)
    whole, cleaned = join(chain), clean(points, closed)
    given, meets = cleaned.points, np.linalg.norm(whole.poles[0] - whole.poles[-1]) <= _SEAM * whole.size
    around = bool(cleaned.closed and meets)
    if cleaned.closed and not around:
        given = np.concatenate([given, given[:1]])
    found = deviation(chain, given, around)
    u = _around(whole, given) if around else match(whole, given)[0]
    none = np.zeros(0, dtype=np.intp)
    return Fit(chain, found, tolerance, around, own(given.copy()), own(u), none, cleaned.dropped, between, call)


def straying(fit: Fit, tolerance: float) -> Ints:
    """Return the rows of the points after which the curve leaves the room that `cadfit.fit` would leave it there.

    The tolerance, and 1.5 times what the centripetal cardinal curve through the points does between them.
    """
    spline, points, u = join(fit.curves), fit.points, fit.parameters
    room = room_of(chain_of(points, fit.closed, False), tolerance)
    if fit.closed:
        spline, points, u = unrolled(spline, points, u)
    return straying_chords(spline, points, u, distances(spline, points, u), room)


def _around(whole: BSpline, points: Array) -> Array:
    """Return the parameters of points round a closed curve, which starts at the place nearest to the first."""
    low, high = whole.domain
    start = float(whole.nearest(points[0])[0])
    inside = low < start < high
    turned = join(whole.split(start)[::-1]) if inside else whole
    u = match(turned, np.concatenate([points, points[:1]]))[0][:-1]
    u = np.concatenate([turned.domain[:1], u[1:]])
    return np.where(u > high, u - (high - low), u) if inside else u
