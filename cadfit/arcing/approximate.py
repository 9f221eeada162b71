"""Curves to lines and arcs within a tolerance."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from cadfit.arcing.result import AXES, Arcs
from cadfit.arcing.rounding import rounded
from cadfit.arcing.stretch import Chain, apart, fewest, joined
from cadfit.bezier import Array, Ints
from cadfit.bspline import BSpline, own
from cadfit.fitting.approximate import fit
from cadfit.numbers import as_number, rounded_up
from cadfit.stages import Progress, portion

_CORNER = 1e-3  # radians: what two pieces must turn at least for their joint to be one
_LARGEST = 100.0  # times the size of the curve: the radius from which lines take the place of arcs
_CURVES = 0.8  # of the time, about: where curves are fitted to vertices
_FITTED = 0.25  # of the tolerance: a polyline's curve is fitted within
_SHARES = (1.0, 0.9, 0.7, 0.4)  # of what rounding at its worst leaves of the tolerance
_SPARED = 1.0 - 1e-9  # joining chains rounds
_EPS = float(np.finfo(np.float64).eps)


def arcs(
    curve: BSpline | Sequence[BSpline] | ArrayLike | Any,
    tolerance: float,
    *,
    max_radius: float | None = None,
    decimals: int | None = None,
    plane: str = "xy",
    closed: bool | None = None,
    progress: Progress | None = None,
) -> Arcs:
    """Return lines and arcs within `tolerance` of a curve, certified both ways, as few as are found.

    `curve`: a `BSpline`, several that follow each other end to end, anything with `curves` (a `Fit`, `Curves`), or the
    vertices (n, d) of a polyline, to which curves are fitted within a quarter of the tolerance first (`cadfit.fit` with
    between="polyline"; `closed` as there). `tolerance`: a length, in the curve's unit. Arcs turn by half a turn at most
    and each begins in the direction in which the one before ends, but for corners, where the curve turns by more than
    1e-3 radians at a knot or from one curve to the next: these, and open ends, are kept exactly. A closed curve stays
    closed, and smooth where it is; then it may start at another of its knots. `max_radius` (None: 100 times the curve's
    size): an arc of length L with a larger radius becomes the line between its ends; directions there differ by up to L
    / (2 max_radius). `decimals`: round ends and centres to so many, as controllers do, and certify what comes of it;
    the directions at joints and the radii at both ends of an arc then agree as far as rounding lets them (centres are
    chosen for that). `plane`: "xy", "zx" or "yz", that of the arcs of a curve in 3D, whose third coordinate must not
    change. `progress` is called with the part that is done, from 0 to 1; raising from it stops the work.

    Raises ValueError for a tolerance that is not positive or that float64 or `decimals` cannot hold, curves that do not
    follow each other, a third coordinate that changes, and where the curve turns back so that no smooth path follows.
    Source: ours, among joints on the curve; arc splines with the fewest segments are treated by Maier, Optimal arc
    spline approximation, CAGD 31, 2014.

    >>> quarter = BSpline([[4, 0], [4, 2.2], [2.2, 4], [0, 4]], [0, 0, 0, 0, 1, 1, 1, 1])
    >>> few = arcs(quarter, 0.01)
    >>> len(few), few.deviation <= 0.01, float(few.radii[0].round(1))
    (1, True, 4.0)
    """
    tolerance = as_number(tolerance, "tolerance")
    curves, off = _curves(curve, tolerance, closed, portion(progress, 0.0, _CURVES))
    portion(progress, _CURVES, 1.0)(0.0)
    pieces, breaks, is_closed = _pieces(curves)
    flat, level = _flat(pieces, plane)
    size = float(np.linalg.norm(np.ptp(flat.reshape(-1, 2), axis=0)))
    least = 256.0 * _EPS * float(np.abs(flat).max())
    if not least <= tolerance < np.inf:
        raise ValueError(
            f"the tolerance must be at least {rounded_up(least)} for a curve of this size, not {tolerance}"
        )
    largest = _LARGEST * size if max_radius is None else as_number(max_radius, "largest radius")
    if not largest > 0.0:
        raise ValueError(f"the largest radius must be positive, not {max_radius}")
    smooth = is_closed and not breaks
    edges = [*breaks, breaks[0] + len(flat)] if is_closed and breaks else [0, *breaks, len(flat)]
    stretches = [flat[np.arange(a, b) % len(flat)] for a, b in zip(edges[:-1], edges[1:], strict=True)]
    if decimals is None:
        chain, first, stretches = _chained(stretches, _SPARED * (tolerance - off), largest, smooth, is_closed)
        far = _far(chain, stretches, tolerance - off) + off
    else:
        chain, first, far = _rounded(stretches, tolerance, off, largest, smooth, is_closed, decimals)
    starts, ends = (_lifted(joints, level, plane, pieces.shape[2]) for joints in (chain.joints[:-1], chain.joints[1:]))
    corners = first[1 if not is_closed or (smooth and len(first) == 1) else 0 :]
    arrays = (own(array) for array in (starts, ends, chain.centres, chain.sweeps))
    portion(progress, _CURVES, 1.0)(1.0)
    return Arcs(*arrays, plane, own(corners), far, float(tolerance), is_closed)  # type: ignore[call-arg, arg-type]


def _curves(curve: Any, tolerance: float, closed: bool | None, progress: Progress) -> tuple[list[BSpline], float]:
    """Return the curves, and how far they are from what was given."""
    if isinstance(curve, BSpline):
        return [curve], 0.0
    given = getattr(curve, "curves", curve)
    if isinstance(given, Sequence) and len(given) and all(isinstance(each, BSpline) for each in given):
        return list(given), 0.0
    fitted = fit(curve, _FITTED * tolerance, closed=closed, between="polyline", effort="fast", progress=progress)
    return list(fitted.curves), max(fitted.deviation.points, fitted.deviation.between)


def _chained(
    stretches: list[Array], tolerance: float, largest: float, smooth: bool, closed: bool
) -> tuple[Chain, Ints, list[Array]]:
    """Return the chains of all stretches as one, the rows at which they begin, and the stretches.

    Where no smooth path follows a stretch, it is parted where it turns within the tolerance: these are corners.
    """
    chains: list[Chain] = []
    while len(chains) < len(stretches):
        k = len(chains)
        try:
            chain, stretches[k] = fewest(stretches[k], tolerance, largest, smooth)
            chains.append(chain)
        except LookupError as error:
            at, hairpins = error.args
            if not len(hairpins):
                x, y = stretches[k][min(int(at), len(stretches[k]) - 1), 0]
                raise ValueError(
                    f"no smooth path of arcs within {tolerance:.6g} follows the curve near {x:.6g}, {y:.6g}"
                ) from None
            parts = apart(stretches[k], hairpins)
            if smooth:  # from one of its corners on
                parts = [*parts[1:-1], np.concatenate([parts[-1], parts[0]])]
            stretches, smooth = [*stretches[:k], *parts, *stretches[k + 1 :]], False
    return *joined(chains, [len(pieces) for pieces in stretches], closed), stretches


def _rounded(
    stretches: list[Array], tolerance: float, off: float, largest: float, smooth: bool, closed: bool, decimals: int
) -> tuple[Chain, Ints, float]:
    """Return a chain with rounded coordinates that is within the tolerance all the same, its stretches' rows, how far.

    Raises ValueError where the step of the last decimal is too large for that.
    """
    step = 10.0**-decimals
    for share in _SHARES:
        spared = share * (tolerance - off - step)
        if spared <= 0.0:
            break
        chain, first, parts = _chained(stretches, spared, largest, smooth, closed)
        chain, first = rounded(chain, first, decimals)
        far = _far(chain, parts, tolerance - off) + off
        if far <= tolerance:
            return chain, first, far
    raise ValueError(f"a tolerance of {tolerance:g} cannot be held with {decimals} decimals")


def _far(chain: Chain, stretches: list[Array], tolerance: float) -> float:
    """Return the largest bound: at most the tolerance where all distances are, near to them where they are small."""
    pieces = np.concatenate(stretches)
    return float(np.minimum(chain.bounds(pieces, 0.9 * tolerance), chain.bounds(pieces, None)).max())


def _flat(pieces: Array, plane: str) -> tuple[Array, float]:
    """Return the pieces in the plane, (m, 4, 2), and the third coordinate."""
    d = pieces.shape[2]
    if plane not in AXES or d not in (2, 3) or (d == 2 and plane != "xy"):
        raise ValueError(
            f"arcs are for curves in 2D, and in 3D for the planes {', '.join(AXES)}, not {d}D and {plane!r}"
        )
    if d == 2:
        return pieces, 0.0
    third = pieces[..., ({0, 1, 2} - set(AXES[plane])).pop()]
    if np.ptp(third) > 1e-12 * np.abs(pieces).max():
        raise ValueError(f"the curve does not lie in a plane parallel to {plane}: it rises by {np.ptp(third):.6g}")
    return np.ascontiguousarray(pieces[..., list(AXES[plane])]), float(third[0, 0])


def _lifted(points: Array, level: float, plane: str, d: int) -> Array:
    if d == 2:
        return points
    out = np.full((len(points), 3), level)
    out[:, list(AXES[plane])] = points
    return out


def _pieces(curves: list[BSpline]) -> tuple[Array, list[int], bool]:
    """Return the Bézier pieces (m, 4, d) of curves, the pieces that a corner is before, and whether they close."""
    pieces = np.concatenate([each.pieces() for each in curves])
    pieces = pieces[np.abs(np.diff(pieces, axis=1)).max(axis=(1, 2)) > 0.0]
    size = float(np.linalg.norm(np.ptp(pieces.reshape(-1, pieces.shape[2]), axis=0)))
    gap = np.linalg.norm(pieces[1:, 0] - pieces[:-1, 3], axis=1)
    if (gap > 1e-9 * size).any():
        raise ValueError(f"the curves do not follow each other: a gap of {gap.max():.6g}")
    closed = bool(np.linalg.norm(pieces[0, 0] - pieces[-1, 3]) <= 1e-9 * size)
    out, into = _legs(pieces), _legs(pieces[:, ::-1])
    turn = np.arccos(np.clip(np.einsum("md,md->m", out, -np.roll(into, 1, axis=0)), -1.0, 1.0))
    breaks = np.flatnonzero(turn > _CORNER)
    return pieces, [int(k) for k in breaks if closed or k > 0], closed


def _legs(pieces: Array) -> Array:
    """Return the unit directions (m, d) in which pieces leave their first pole."""
    away = pieces[:, 1:] - pieces[:, :1]
    length = np.linalg.norm(away, axis=2)
    k = np.argmax(length > 1e-12 * length.max(axis=1, keepdims=True), axis=1)
    rows = np.arange(len(pieces))
    return np.asarray(away[rows, k] / length[rows, k, None])
