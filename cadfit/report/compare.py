"""Other ways to a curve at the same tolerance, and curves of any origin, held against points as our fits are."""

from __future__ import annotations

import warnings
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from importlib import import_module
from importlib.util import find_spec
from time import perf_counter
from typing import Any

import numpy as np
from scipy.interpolate import splev, splprep

from cadfit.bezier import Array
from cadfit.bspline import BSpline
from cadfit.fitting.approximate import Effort, fit
from cadfit.fitting.judging import judged, straying
from cadfit.joining import periodic
from cadfit.points.clean import clean
from cadfit.points.measures import lengths_along
from cadfit.report.data import Entry
from cadfit.stages import Progress, stage
from cadfit.workers import within


def fitpack(points: Array, tolerance: float, closed: bool, rounds: int = 20) -> BSpline | None:
    """Return FITPACK's curve of the fewest poles found that keeps the tolerance at its own parameters, or None.

    `scipy.interpolate.splprep` (chord lengths, periodic where closed), its smoothing bisected: it bounds a sum of
    squares, so no single call keeps a distance.
    """
    contour = _contour(points, closed)
    u = lengths_along(contour)
    low, high = np.log(1e-10 * tolerance**2), np.log(4.0 * len(contour) * tolerance**2)
    best: Any = None
    for _ in range(rounds):
        middle = 0.5 * (low + high)
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            try:
                found: Any = splprep(contour.T, u=u, s=np.exp(middle), per=closed)[0]
            except (ValueError, TypeError):
                found = None
        if found is not None and np.linalg.norm(np.array(splev(u, found)).T - contour, axis=1).max() <= tolerance:
            low = middle
            if best is None or len(found[0]) < len(best[0]):
                best = found
        else:
            high = middle
    if best is None:
        return None
    knots, poles = best[0], np.transpose(best[1])
    if closed:  # the first of the m + 3 poles of m spans stands one knot before the start
        return periodic(poles[1 : len(knots) - 6], knots[3:-3])
    return BSpline(poles, knots)


def occt(points: Array, tolerance: float, closed: bool) -> BSpline | None:
    """Return the curve of the CAD kernel's own fit (`cadfit.occt.approximating.approximate`), or None.

    The first point is repeated where closed: the kernel knows no closed fit. Raises ImportError without a kernel.
    """
    from cadfit.occt import KernelError
    from cadfit.occt.approximating import approximate

    try:
        return approximate(_contour(points, closed), tolerance)
    except KernelError:
        return None


METHODS = ("cadfit", "fast", "fitpack", "occt")
LIMIT = 60.0  # seconds that a method of others may take

_THEIRS: dict[str, Callable[[Array, float, bool], BSpline | None]] = {"fitpack": fitpack, "occt": occt}
_NEEDS = {"occt": "cadfit.occt.approximating"}


@dataclass(frozen=True, slots=True)
class Nothing:
    """A method that made no curve of some points, and why not."""

    name: str
    points: int
    reason: str

    def __str__(self) -> str:
        return f"{self.name}: {self.reason}"


def usual(dimension: int) -> list[str]:
    """Return the methods that are compared where none is named: those that are at hand."""
    kernel = ["occt"] if dimension in (2, 3) and find_spec("OCP") is not None else []
    return ["cadfit", "fitpack", *kernel]


def by_method(
    method: str,
    points: Array,
    tolerance: float,
    closed: bool | None = None,
    name: str = "",
    *,
    limit: float = LIMIT,
    progress: Progress | None = None,
) -> Entry | Nothing:
    """Return what a method makes of points (n, d), judged and timed, or why it makes nothing of them.

    The methods of others run in a process of their own, which is ended after `limit` seconds: no one can tell how long
    the kernel will take. `progress` is that of ours.
    """
    name, cleaned = name or method, clean(points, closed)
    if method in _THEIRS:
        with stage(method):
            curve, seconds = _limited(method, cleaned.points, tolerance, cleaned.closed, limit)
        if not isinstance(curve, BSpline):
            return Nothing(name, len(cleaned.points), curve)
        found = judged(curve, points, closed, tolerance, "curve")
        return Entry(name, found, seconds, len(straying(found, tolerance)))
    start = perf_counter()
    effort: Effort = "fast" if method == "fast" else "best"
    made = fit(cleaned.points, tolerance, closed=cleaned.closed, effort=effort, progress=progress)
    # Where our fit splits at corners each part keeps its own room, which it was held to.
    return Entry(name, made, perf_counter() - start, 0)


def _limited(method: str, points: Array, tolerance: float, closed: bool, limit: float) -> tuple[BSpline | str, float]:
    """Return the curve that a method of others makes in a process of its own, or why there is none; and its seconds."""
    needs = _NEEDS.get(method)
    if needs and find_spec("OCP") is None:
        import_module(needs)  # says which extra brings the kernel
    outcome = within(limit, _made, (method, points, tolerance, closed), [needs] if needs else [])
    if outcome is None:
        return f"no answer within {limit:g} s", limit
    if outcome.error is not None:
        return f"{outcome.error}: {outcome.reason}", outcome.seconds
    return outcome.value or "makes no curve of it", outcome.seconds


def _made(task: tuple[str, Array, float, bool]) -> BSpline | None:
    method, points, tolerance, closed = task
    return _THEIRS[method](points, tolerance, closed)


def of_curves(curves: Sequence[BSpline], points: Array, tolerance: float, closed: bool | None, name: str) -> Entry:
    """Return curves, read from a file say, judged against points; those in the plane z = 0 against points in 2D, too.

    Raises ValueError for another dimension than that of the points.
    """
    d = points.shape[1]
    if d == 2 and all(curve.poles.shape[1] == 3 and not curve.poles[:, 2].any() for curve in curves):
        curves = [curve.transformed(np.eye(2, 3)) for curve in curves]
    found = judged(curves, points, closed, tolerance, "curve")
    return Entry(name, found, None, len(straying(found, tolerance)))


def _contour(points: Array, closed: bool) -> Array:
    return np.concatenate([points, points[:1]]) if closed else points
