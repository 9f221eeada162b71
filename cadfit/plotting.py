"""Pictures of curves: points, poles, the curve and its curvature comb, through matplotlib.

matplotlib is the extra `cadfit[plot]`, imported when something is drawn.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from cadfit.bezier import Array
from cadfit.bspline import BSpline
from cadfit.points.clean import as_points

if TYPE_CHECKING:
    from matplotlib.axes import Axes

# Okabe and Ito's colours, which stay apart for colour-blind eyes and in print.
CURVE, POINTS, COMB, POLES = "#0072B2", "#D55E00", "#009E73", "#666666"

_FINENESS = 1e-4  # of the size: a tenth of a pixel in a picture of 1,000
_TOOTH = 0.2  # of the size: the longest tooth where no scale is given


def plot_spline(
    spline: BSpline,
    ax: Axes | None = None,
    points: ArrayLike | None = None,
    poles: bool = True,
    comb: bool = True,
    count: int = 300,
    scale: float | None = None,
) -> Axes:
    """Draw a spline in 2D or 3D with its points, its poles and its curvature comb, and return the Axes.

    `points` (n, d) are drawn as dots, the poles as a grey polygon. `count` and `scale` are those of `curvature_comb`.
    Without `ax` a new figure is made through pyplot; for a spline in 3D, `ax` must be a 3D one. One unit is as long on
    every axis. What is drawn is labelled "curvature comb", "curve", "poles" and "points", for `ax.legend()`.

    Raises ValueError for another dimension, points of another dimension than the curve's, a 2D spline on 3D axes or
    the other way round, and as `curvature_comb`; ImportError naming the extra `cadfit[plot]` without matplotlib.

    >>> import matplotlib
    >>> matplotlib.use("agg")
    >>> ax = plot_spline(BSpline([[0, 0], [1, 1], [2, 1], [3, 0]], [0, 0, 0, 0, 1, 1, 1, 1]), points=[[0, 0], [3, 0]])
    >>> [text.get_text() for text in ax.legend().get_texts()]
    ['curvature comb', 'curve', 'poles', 'points']
    """
    d = spline.poles.shape[1]
    if d not in (2, 3):
        raise ValueError(f"curves in 2D or 3D can be drawn, not in {d}D: transform the spline first")
    dots = None if points is None else as_points(points, least=1)
    if dots is not None and dots.shape[1] != d:
        raise ValueError(f"the points have {dots.shape[1]} coordinates, the curve {d}")
    ax = _axes(d) if ax is None else ax
    if hasattr(ax, "get_zlim") != (d == 3):
        raise ValueError(f"a {d}D spline needs {d}D axes" + ': subplot_kw={"projection": "3d"}' * (d == 3))

    u = _smooth_parameters(spline)
    curve = spline(u)
    if comb:
        feet, tips = curvature_comb(spline, count, scale)
        scale = _scale(spline, u, scale)
        teeth = np.stack([feet, tips, np.full_like(feet, np.nan)], axis=1).reshape(-1, d)  # NaN lifts the pen
        ax.plot(*teeth.T, color=COMB, linewidth=0.4, alpha=0.6)
        ax.plot(*(curve - scale * spline.curvature(u)).T, color=COMB, linewidth=0.9, label="curvature comb")
    ax.plot(*curve.T, color=CURVE, linewidth=1.6, label="curve")
    if poles:
        squares: dict[str, Any] = {"marker": "s", "markersize": 2.6, "markerfacecolor": "white", "markeredgewidth": 0.6}
        ax.plot(*spline.poles.T, color=POLES, linewidth=0.6, label="poles", zorder=2.5, **squares)
    if dots is not None:
        ax.plot(*dots.T, color=POINTS, linestyle="none", marker="o", markersize=3.0, label="points", zorder=3)
    ax.set_aspect("equal")
    return ax


def curvature_comb(spline: BSpline, count: int = 300, scale: float | None = None) -> tuple[Array, Array]:
    """Return the teeth of the curvature comb: their feet on the curve and their tips, (count, d) each.

    The feet are equally far apart along the curve. A tooth is `scale` times the curvature long and points away from the
    centre of curvature, so combs stand outside of a convex contour (a negative scale puts them inside). `scale` is in
    the square of the curve's unit; None makes the longest tooth a fifth of the curve's size.

    Raises ValueError for fewer than 2 teeth or a scale that is not finite.

    >>> arc = BSpline([[0, 0], [1, 1], [2, 1], [3, 0]], [0, 0, 0, 0, 1, 1, 1, 1])
    >>> feet, tips = curvature_comb(arc, count=3, scale=1.0)
    >>> feet[1], tips[1]
    (array([1.5 , 0.75]), array([1.5       , 1.41666667]))
    """
    if count < 2:
        raise ValueError(f"a comb has at least 2 teeth, not {count}")
    u = _smooth_parameters(spline)
    along = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(spline(u), axis=0), axis=1))])
    at = np.interp(np.linspace(0.0, along[-1], count), along, u)
    feet = spline(at)
    return feet, feet - _scale(spline, u, scale) * spline.curvature(at)


def _scale(spline: BSpline, u: Array, scale: float | None) -> float:
    """Return how long a tooth is for a curvature of 1."""
    if scale is None:
        largest = float(np.linalg.norm(spline.curvature(u), axis=1).max())
        return _TOOTH * spline.size / largest if largest > 0 else 0.0
    if not np.isfinite(scale):
        raise ValueError(f"the scale of a comb must be finite, not {scale}")
    return float(scale)


def _smooth_parameters(spline: BSpline) -> Array:
    """Return parameters between which the curve is straight to the eye, the knots among them.

    Cut into k equal parts, a cubic Bézier piece strays from its chords by at most 3/4 of its largest second difference
    of poles over k^2.
    """
    pieces, knots = spline.pieces(), spline.distinct_knots
    bends = np.linalg.norm(np.diff(pieces, n=2, axis=1), axis=2).max(axis=1)
    fineness = _FINENESS * max(spline.size, np.finfo(np.float64).tiny)
    counts = np.ceil(np.sqrt(0.75 * bends / fineness)).astype(np.intp)
    counts = np.maximum(counts, 8)  # the comb bends more than the curve
    within = np.arange(counts.sum()) - np.repeat(np.cumsum(counts) - counts, counts)
    u = np.repeat(knots[:-1], counts) + within * np.repeat(np.diff(knots) / counts, counts)
    return np.append(u, knots[-1])


def _axes(d: int) -> Any:
    """Return new axes in d dimensions."""
    try:
        from matplotlib import pyplot
    except ImportError as error:
        raise ImportError("pictures need matplotlib: pip install 'cadfit[plot]'") from error
    return pyplot.subplots(subplot_kw={"projection": "3d"} if d == 3 else None)[1]
