"""The ways of the command line to make curves from the points of a file, and what to report of them.

Imported when a command runs, so that `cadfit --help` answers at once.
"""

from __future__ import annotations

import shlex
import warnings
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

import cadfit
from cadfit.bezier import Array
from cadfit.bspline import BSpline
from cadfit.files import Curves
from cadfit.files.facts import summary
from cadfit.fitting.judging import judged
from cadfit.fitting.result import Fit
from cadfit.points.clean import check_size
from cadfit.stages import stage

_OPTIONS = {  # those of each method; the first method that has one of those given is meant where none is named
    "tolerance": ("tolerance", "between", "corners", "effort"),
    "dominant": ("fraction", "square_error"),
    "cardinal": ("tension", "curvature"),
    "local": (),
    "interpolate": (),
}
_RULES = {"curve": "at the points; no wiggle between", "polyline": "at the points and between"}

Made = tuple[Curves | Fit, dict[str, str]]


@dataclass(frozen=True, slots=True)
class How:
    """How curves are to be made: the command line's options, None where one was not given."""

    method: str | None = None
    closed: bool | None = None
    tension: float | None = None
    curvature: float | None = None
    tolerance: float | None = None
    between: str | None = None
    corners: str | None = None
    effort: str | None = None
    fraction: float | None = None
    square_error: float | None = None

    @property
    def chosen(self) -> str:
        """The method: what the other options ask for where none is named.

        Raises ValueError where options do not go together.
        """
        given = {method: [o for o in options if getattr(self, o) is not None] for method, options in _OPTIONS.items()}
        method = self.method or next((method for method in given if given[method]), "local")
        allowed = {*_OPTIONS[method], *(["curvature"] if method == "dominant" else [])}
        if strangers := [f"--{o.replace('_', '-')}" for options in given.values() for o in options if o not in allowed]:
            raise ValueError(f"{' and '.join(strangers)} cannot go with --method {method}")
        if method == "tolerance" and self.tolerance is None:
            raise ValueError("how far may the curve be from the points? --tolerance says it")
        return method

    def check(self) -> None:
        """Raise ValueError where options do not go together, or say nothing that a method knows."""
        if self.chosen == "tolerance":
            corners_of(self.corners or "auto")


def made(found: Any, how: How, progress: Callable[[float], None] | None = None) -> Made:
    """Return the curves made from what a file of points holds, a `Fit` where not all are met, and what to report.

    Raises ValueError for what is not points, and as the methods do.
    """
    if not isinstance(found, np.ndarray):
        raise ValueError(f"points are needed, and it holds {'curves' if isinstance(found, Curves) else 'a mesh'}")
    method = how.chosen
    if method == "tolerance":
        return _within(found, how, progress)
    return _dominant(found, how, progress) if method == "dominant" else _through(found, how, method)


def _within(points: Array, how: How, progress: Callable[[float], None] | None) -> Made:
    """Fit within the tolerance."""
    assert how.tolerance is not None
    fit = cadfit.fit(
        points,
        how.tolerance,
        closed=how.closed,
        corners=corners_of("auto" if how.corners is None else how.corners),
        between="polyline" if how.between == "polyline" else "curve",
        effort="fast" if how.effort == "fast" else "best",
        progress=progress,
    )
    said = {
        "points read": str(len(points)),
        "repeats dropped": str(len(fit.cleaned)),
        "tolerance": f"{fit.tolerance:g}, {_RULES[how.between or 'curve']}",
        "corners": str(len(fit.corners)),
    }
    return fit, said | summary(fit)


def write_report(
    path: Path,
    source: Path,
    points: Array,
    curves: Curves | Fit,
    how: How,
    unit: str,
    command: Sequence[str],
    progress: Callable[[float], None] | None = None,
) -> None:
    """Write the page of curves made from the points of a file by a command."""
    from cadfit.report import Entry, write

    fit = curves if isinstance(curves, Fit) else judged(curves.curves, points, how.closed)
    calls = [shlex.join(["cadfit", *command]), *filter(None, [fit.call])]
    write([Entry("fit", fit)], path, source.name, unit, calls, source, progress=progress)


def corners_of(text: str) -> Any:
    """Return what `cadfit.fit` takes for corners written as auto, none, an angle in degrees, or rows with commas.

    Raises ValueError for anything else.

    >>> corners_of("auto"), corners_of("none"), round(corners_of("180"), 4), corners_of("3,17"), corners_of("5,")
    ('auto', None, 3.1416, [3, 17], [5])
    """
    if text in ("auto", "none"):
        return "auto" if text == "auto" else None
    try:
        found = [int(row) for row in text.split(",") if row.strip()] if "," in text else float(text)
    except ValueError:
        raise ValueError(
            f"--corners must be auto, none, an angle in degrees, or rows with commas (3,17 or 5,), not {text!r}"
        ) from None
    if isinstance(found, list):
        return found
    if not 0.0 < found <= 180.0:
        raise ValueError(f"--corners: an angle must be above 0 and at most 180 degrees, not {text}")
    return float(np.radians(found))


def _dominant(points: Array, how: How, progress: Callable[[float], None] | None) -> Made:
    """Put a curve through the dominant points."""
    if (how.fraction is None) == (how.square_error is None):
        raise ValueError("--method dominant needs one of --fraction and --square-error")
    curvature = 1.0 if how.curvature is None else how.curvature
    fit = cadfit.fit_dominant(
        points, None, how.fraction, how.square_error, closed=how.closed, curvature=curvature, progress=progress
    )
    if how.closed is None and fit.closed:
        _warn_of_corner_at_seam(fit.points)
    dominant = (len(fit.spline.distinct_knots) + (-1 if fit.closed else 4)) // 3
    said = {"points read": str(len(points)), "repeats dropped": str(len(fit.cleaned)), "dominant": str(dominant)}
    return fit, said | summary(fit)


def _through(points: Array, how: How, method: str) -> Made:
    """Put a curve through all points."""
    cleaned = cadfit.clean(points, how.closed)
    check_size(cleaned.points)
    if how.closed is None and cleaned.closed:
        _warn_of_corner_at_seam(cleaned.points)
    with stage("a curve through the points"):
        spline = _interpolant(cleaned.points, how, method, cleaned.closed)
    curves = Curves((spline,), cleaned.closed, cadfit.deviation(spline, cleaned.points, cleaned.closed))
    said = {"points read": str(len(points)), "repeats dropped": str(len(cleaned.dropped)), "method": method}
    return curves, said | summary(curves)


def _interpolant(points: Array, how: How, method: str, closed: bool) -> BSpline:
    if method == "cardinal":
        tension = 0.5 if how.tension is None else how.tension
        return cadfit.cardinal_spline(points, tension, how.curvature or 0.0, closed)
    if method == "local":
        return cadfit.local_spline(points, closed)
    return cadfit.interpolate(points, closed=closed)


def _warn_of_corner_at_seam(points: Array) -> None:
    """Say so where a contour taken for closed turns sharply at its seam, as an airfoil does at its trailing edge."""
    before, after = points[0] - points[-1], points[1] - points[0]
    turn = np.degrees(np.arccos(np.clip(before @ after / np.sqrt((before @ before) * (after @ after)), -1.0, 1.0)))
    if turn > 60.0:
        warnings.warn(
            f"the last row repeats the first, so the curve is closed and smooth there, though the points turn by "
            f"{turn:.0f} degrees; --open keeps that corner sharp, --closed says it is meant, and so does --tolerance, "
            "which keeps all corners",
            stacklevel=2,
        )
