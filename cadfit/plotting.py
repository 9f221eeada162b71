"""Pictures of curves and fits: points, poles, the curve, its curvature comb, the deviation, through matplotlib.

matplotlib is the extra `cadfit[plot]`, imported when something is drawn.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from cadfit.bezier import Array
from cadfit.bspline import BSpline
from cadfit.fitting.along import allowed, off_chords, off_points, trace
from cadfit.fitting.result import Fit
from cadfit.points.clean import as_points
from cadfit.points.measures import lengths_along

if TYPE_CHECKING:
    from matplotlib.axes import Axes

# Okabe and Ito's colours, which stay apart for colour-blind eyes and in print.
CURVE, POINTS, COMB, POLES, CORNERS = "#0072B2", "#D55E00", "#009E73", "#666666", "#222222"

_FINENESS = 1e-4  # of the size: a tenth of a pixel in a picture of 1,000
_TOOTH = 0.2  # of the size: the longest tooth where no scale is given


def plot_fit(
    fit: Fit, ax: Axes | None = None, *, points: bool = True, poles: bool = True, comb: bool = False, unit: str = ""
) -> Axes:
    """Draw a fit in 2D or 3D, its points, curves, poles and corners, and return the Axes.

    `comb` adds the curvature combs, on one scale for all curves. `unit` is written at the axes. One unit is as long on
    every axis. Without `ax` a new figure is made through pyplot, with a legend and the key figures as its title.

    Raises ValueError for another dimension or axes of another, ImportError naming the extra `cadfit[plot]`.

    >>> import cadfit, matplotlib
    >>> matplotlib.use("agg")
    >>> cadfit.fit([[0, 0], [1, 0.1], [2, 0], [3, 0.1], [4, 0]], 0.15).plot(unit="mm").get_title()
    '4 poles for 5 points: off by at most 0.0706 mm'
    """
    d = fit.points.shape[1]
    own, ax = ax is None, _fitting_axes(d, ax)
    scale = _scale(fit.curves, None) if comb else None
    for k, curve in enumerate(fit.curves):
        _draw(curve, ax, poles, comb, 300, scale, named=k == 0)
    if points:
        _draw_points(fit.points, ax)
    if len(fit.corners):
        marks: dict[str, Any] = {"marker": "D", "markersize": 6.0, "fillstyle": "none", "color": CORNERS, "zorder": 4}
        ax.plot(*fit.points[fit.corners].T, linestyle="none", label="corners", **marks)
    _name_axes(ax, d, unit)
    ax.set_aspect("equal")
    if own:
        several = f"{len(fit.curves)} curves of " if fit.curves[1:] else ""
        off = f"off by at most {fit.deviation.points:.3g}{unit and ' ' + unit}"
        ax.set_title(f"{several}{fit.poles} poles for {len(fit.points)} points: {off}", fontsize="medium")
        ax.legend(fontsize="small")
    return ax


def plot_deviation(fit: Fit, ax: Axes | None = None, *, unit: str = "") -> Axes:
    """Draw how far a fit is from its points, over the length along it, and return the Axes.

    A dot for each point, bounded by the tolerance; a line for the curve's distance from the segments between the
    points, bounded by what `cadfit.fit` allows there, with `between="polyline"` the tolerance; and a ring round the
    point that is farthest. Any dimension. `unit` is written at the axes. Raises ImportError naming the extra
    `cadfit[plot]`.

    >>> import cadfit, matplotlib
    >>> matplotlib.use("agg")
    >>> ax = cadfit.fit([[0, 0], [1, 0.1], [2, 0], [3, 0.1], [4, 0]], 0.15).plot_deviation()
    >>> [text.get_text() for text in ax.legend().get_texts()]
    ['between points', 'allowed there', 'points', 'tolerance 0.15', 'point 2: 0.0706']
    """
    ax = _new_axes(2, (6.4, 3.2)) if ax is None else ax
    along = trace(fit.curves)
    off = np.linalg.norm(off_points(fit), axis=1)
    u, between, chords = off_chords(fit)
    ax.plot(along.at(u), between, color=CURVE, linewidth=0.9, label="between points")
    s, top = along.at(fit.parameters), 1.08 * max(off.max(), between.max(), fit.tolerance or 0.0)
    if fit.between == "curve" and (room := allowed(fit)) is not None:
        ax.plot(along.at(u), room[chords], color=POLES, linewidth=0.7, label="allowed there")
    ax.plot(s, off, linestyle="none", marker="o", markersize=_dot(len(s)), color=POINTS, label="points", zorder=3)
    if fit.tolerance is not None:
        ax.axhline(fit.tolerance, color=CORNERS, linewidth=1.0, linestyle="--", label=f"tolerance {fit.tolerance:g}")
    worst = fit.deviation.worst
    ring: dict[str, Any] = {"marker": "o", "markersize": 8.0, "fillstyle": "none", "color": CORNERS, "zorder": 4}
    said = f"point {worst}: {fit.deviation.points:.3g}"
    ax.plot(s[worst], off[worst], linestyle="none", label=said, **ring)
    of_unit = f" ({unit})" if unit else ""
    ax.set(xlabel=f"length along the curve{of_unit}", ylabel=f"deviation{of_unit}", xlim=(0.0, along.length))
    ax.set_ylim(0.0, top or None)
    ax.legend(fontsize="small", ncols=5, loc="lower right", bbox_to_anchor=(1.0, 1.0), frameon=False)
    return ax


def plot_comb(
    curves: BSpline | Sequence[BSpline], ax: Axes | None = None, *, count: int = 300, scale: float | None = None
) -> Axes:
    """Draw one curve or several in 2D or 3D with their curvature combs, on one scale, and return the Axes.

    `count` and `scale` are those of `curvature_comb`. Raises as `plot_spline`.

    >>> import matplotlib
    >>> matplotlib.use("agg")
    >>> ax = BSpline([[0, 0], [1, 1], [2, 1], [3, 0]], [0, 0, 0, 0, 1, 1, 1, 1]).plot_comb()
    >>> [text.get_text() for text in ax.legend().get_texts()]
    ['curvature comb', 'curve']
    """
    curves = [curves] if isinstance(curves, BSpline) else list(curves)
    ax = _fitting_axes(curves[0].poles.shape[1], ax)
    scale = _scale(curves, scale)
    for k, curve in enumerate(curves):
        _draw(curve, ax, False, True, count, scale, named=k == 0)
    ax.set_aspect("equal")
    return ax


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
    dots = None if points is None else as_points(points, least=1)
    if dots is not None and dots.shape[1] != d and d in (2, 3):
        raise ValueError(f"the points have {dots.shape[1]} coordinates, the curve {d}")
    ax = _fitting_axes(d, ax)
    _draw(spline, ax, poles, comb, count, scale)
    if dots is not None:
        _draw_points(dots, ax)
    ax.set_aspect("equal")
    return ax


def _draw(
    spline: BSpline, ax: Any, poles: bool, comb: bool, count: int, scale: float | None, named: bool = True
) -> None:
    """Draw a spline; the legend names its parts where `named`."""
    u = _smooth_parameters(spline)
    curve = spline(u)
    name = (lambda label: label) if named else (lambda _: None)
    if comb:
        feet, tips = curvature_comb(spline, count, scale)
        scale = _scale([spline], scale)
        teeth = np.stack([feet, tips, np.full_like(feet, np.nan)], axis=1)  # NaN lifts the pen
        ax.plot(*teeth.reshape(-1, feet.shape[1]).T, color=COMB, linewidth=0.4, alpha=0.6)
        ax.plot(*(curve - scale * spline.curvature(u)).T, color=COMB, linewidth=0.9, label=name("curvature comb"))
    ax.plot(*curve.T, color=CURVE, linewidth=1.6, label=name("curve"))
    if poles:
        squares: dict[str, Any] = {"marker": "s", "markersize": 2.6, "markerfacecolor": "white", "markeredgewidth": 0.6}
        ax.plot(*spline.poles.T, color=POLES, linewidth=0.6, label=name("poles"), zorder=2.5, **squares)


def _draw_points(points: Array, ax: Any) -> None:
    size = _dot(len(points))
    ax.plot(*points.T, color=POINTS, linestyle="none", marker="o", markersize=size, label="points", zorder=3)


def _dot(n: int) -> float:
    """Return how large a dot is in typographic points where there are n: many would hide the curve."""
    return float(np.clip(20.0 / np.sqrt(n), 1.0, 3.0))


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
    along = lengths_along(spline(u))
    at = np.interp(np.linspace(0.0, along[-1], count), along, u)
    feet = spline(at)
    return feet, feet - _scale([spline], scale) * spline.curvature(at)


def _scale(curves: Sequence[BSpline], scale: float | None) -> float:
    """Return how long a tooth is for a curvature of 1."""
    if scale is None:
        largest = max(float(np.linalg.norm(one.curvature(_smooth_parameters(one)), axis=1).max()) for one in curves)
        low, high = (bound([bound(one.poles, axis=0) for one in curves], axis=0) for bound in (np.min, np.max))
        return _TOOTH * float(np.linalg.norm(high - low)) / largest if largest > 0 else 0.0
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


def _fitting_axes(d: int, ax: Axes | None) -> Any:
    """Return axes for d dimensions, new ones where none are given."""
    if d not in (2, 3):
        raise ValueError(f"curves in 2D or 3D can be drawn, not in {d}D: transform the spline first")
    ax = _new_axes(d) if ax is None else ax
    if hasattr(ax, "get_zlim") != (d == 3):
        raise ValueError(f"a {d}D spline needs {d}D axes" + ': subplot_kw={"projection": "3d"}' * (d == 3))
    return ax


def _new_axes(d: int, size: tuple[float, float] | None = None) -> Any:
    """Return new axes in d dimensions."""
    try:
        from matplotlib import pyplot
    except ImportError as error:
        raise ImportError("pictures need matplotlib: pip install 'cadfit[plot]'") from error
    kind = {"projection": "3d"} if d == 3 else None
    return pyplot.subplots(subplot_kw=kind, figsize=size, layout="constrained")[1]


def _name_axes(ax: Any, d: int, unit: str) -> None:
    """Name the axes x, y and z, with the unit."""
    for name in "xyz"[:d]:
        ax.set(**{f"{name}label": f"{name} ({unit})" if unit else name})
