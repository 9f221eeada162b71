"""Curves and arcs made from drawings: polylines are fitted each by itself, other contours taken over as they are.

Imported when a command runs, so that `cadfit --help` answers at once.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from cadfit import methods
from cadfit.arcing.approximate import arcs
from cadfit.arcing.result import Arcs
from cadfit.bezier import Array
from cadfit.bspline import BSpline
from cadfit.files import ArcContours, Curves
from cadfit.files.facts import summary
from cadfit.fitting.deviation import Deviation
from cadfit.fitting.result import Fit
from cadfit.joining import join, polyline
from cadfit.methods import How, Made
from cadfit.stages import Progress, portion

_DRAWINGS = (".dxf", ".svg")
_FITTED = 0.25  # of the tolerance: what the fit may take of it, arcs having the rest
_STRAIGHT = 1e-12  # of the largest coordinate: poles this near to their chord are on it


@dataclass(frozen=True, slots=True)
class _Contour:
    """A contour made anew, or taken over: then without vertices, and at no distance."""

    name: str
    curve: Curves | Fit
    vertices: int = 0


def meant(how: How, source: Path, found: Any) -> How:
    """Return how to make curves of what a file holds: between vertices, too, within the tolerance where drawn.

    So where nothing else is said; points of other files are samples of a curve.
    """
    drawn = isinstance(found, Curves) or source.suffix.lower() in _DRAWINGS
    return replace(how, between="polyline") if drawn and how.between is None and how.chosen == "tolerance" else how


def made(found: Any, how: How, progress: Callable[[float], None] | None = None) -> Made:
    """Return the curves made from what a file of points or a drawing holds, and what to report.

    Points as `cadfit.methods.made` does. Of a drawing each contour becomes one curve, with its name, in the order of
    the drawing: one that is a polyline of 3 vertices or more is fitted (a triple knot at each corner), others stay.

    Raises ValueError for what is neither, where there is nothing to fit, and naming the contour that cannot be.
    """
    if not isinstance(found, Curves) or all(vertices(curve) is None for curve in found.curves):
        return methods.made(found, how, progress)
    contours = list(_contours(_parts(found), how, progress))
    curves = Curves(
        tuple(join(contour.curve.curves) for contour in contours),
        len(contours) == 1 and contours[0].curve.closed,
        _together(contours),
        found.names,
    )
    return curves, _said(contours) | summary(curves)


def named(result: Any, held: Any) -> Any:
    """Return what was made, with the name that a drawing has for its one polyline, which is read as points."""
    names = held.names if isinstance(held, Curves) and held.vertices is not None else ()
    if not any(names):
        return result
    if isinstance(result, ArcContours):
        return replace(result, names=names)
    return Curves(result.curves, result.closed, result.deviation, names * len(result.curves))


def vertices(curve: BSpline) -> Array | None:
    """Return the vertices (n, d), 3 or more, of a curve that is straight from knot to knot; None of any other.

    >>> corner = polyline([[0, 0], [3, 0], [3, 4]])
    >>> vertices(corner)
    array([[0., 0.],
           [3., 0.],
           [3., 4.]])
    >>> vertices(corner.split(1.0)[0]) is None
    True
    """
    pieces = curve.pieces()
    away = pieces - pieces[:, :1]
    chord = away[:, 3]
    square = np.einsum("md,md->m", chord, chord)
    along = np.einsum("mid,md->mi", away, chord) / np.where(square > 0.0, square, 1.0)[:, None]
    off = np.abs(away - along[..., None] * chord[:, None]).max()
    straight = off <= _STRAIGHT * np.abs(pieces).max() and (np.diff(along, axis=1) >= -_STRAIGHT).all()
    return np.concatenate([pieces[:, 0], pieces[-1:, 3]]) if straight and len(pieces) > 1 else None


def made_of_arcs(
    found: Any, how: How, progress: Callable[[float], None] | None = None
) -> tuple[ArcContours, dict[str, str]]:
    """Return lines and arcs within the tolerance of what a file of points or a drawing holds, and what to report.

    Polylines are fitted within a quarter of the tolerance, and arcs keep to the fit within what it leaves, so the two
    bounds add up to the tolerance at most; where the tolerance holds between vertices and that takes fewer, arcs and
    lines keep to the polyline itself. Other contours become arcs within the whole tolerance.

    Raises ValueError as `made` does, where no tolerance is given, and as `cadfit.arcs`, naming the contour.
    """
    if how.chosen != "tolerance" or how.tolerance is None:
        raise ValueError("--arcs needs --tolerance, and no other method")
    parts = _parts(found)
    finer = replace(how, tolerance=_FITTED * how.tolerance)
    contours = list(_contours(parts, finer, portion(progress, 0.0, 0.5)))
    drawn: list[Arcs] = []
    for k, contour in enumerate(contours):
        told = portion(progress, 0.5 + 0.5 * k / len(contours), 0.5 + 0.5 * (k + 1) / len(contours))
        with _naming(k, contour.name, len(contours)):
            contours[k], few = _fewest(contour, how.tolerance, how.between == "polyline", told)
        drawn.append(few)
    names = found.names if isinstance(found, Curves) else ()
    return ArcContours(tuple(drawn), names), _said(contours) | _said_of_arcs(contours, drawn)


def _fewest(contour: _Contour, tolerance: float, between: bool, progress: Progress) -> tuple[_Contour, Arcs]:
    """Return the contour whose lines and arcs are fewer, the fit or, where it is the shape, the polyline, and these."""
    sources, made, errors = [contour], [], []
    if between and isinstance(fit := contour.curve, Fit):
        itself = Curves((polyline(fit.points, fit.closed),), fit.closed, Deviation(0.0, 0.0, 0.0, 0))
        sources.append(replace(contour, curve=itself))
    for k, source in enumerate(sources):
        away = source.curve.deviation
        far = 0.0 if away is None else max(away.points, away.between) if between else away.points
        try:
            few = arcs(source.curve, tolerance - far, progress=portion(progress, k / len(sources), 1.0))
            made.append((source, few))
        except ValueError as error:
            errors.append(error)
    if not made:
        raise errors[0]
    return min(made, key=lambda each: len(each[1]))


def _parts(found: Any) -> list[tuple[str, BSpline | None, Array | None]]:
    """Return the name, the curve and the vertices of each contour; those without are taken over."""
    if not isinstance(found, Curves):
        return [("", None, found)]
    names = found.names or ("",) * len(found.curves)
    return [(name, curve, vertices(curve)) for name, curve in zip(names, found.curves, strict=True)]


def _contours(
    parts: list[tuple[str, BSpline | None, Array | None]], how: How, progress: Callable[[float], None] | None
) -> Iterator[_Contour]:
    """Yield each contour, fitted or taken over."""
    n = len(parts)
    if how.corners is not None and "," in how.corners and n > 1:
        raise ValueError(f"--corners {how.corners}: rows are for one contour, and it holds {n}")
    for k, (name, curve, points) in enumerate(parts):
        if curve is not None and points is None:
            yield _Contour(name, Curves((curve,), curve.closed))
            continue
        with _naming(k, name, n):
            fitted, said = methods.made(points, how, portion(progress, k / n, (k + 1) / n))
        yield _Contour(name, fitted, int(said["points read"]))


@contextmanager
def _naming(k: int, name: str, count: int) -> Iterator[None]:
    """Name the contour in what goes wrong in the block, where there are several."""
    try:
        yield
    except ValueError as error:
        if count == 1:
            raise
        raise ValueError(f"{_called(k, name)}: {error}") from error


def _called(k: int, name: str) -> str:
    return f"contour {k} ({name})" if name else f"contour {k}"


def _together(contours: list[_Contour]) -> Deviation:
    """Return the deviation of all contours fitted; the worst is a row of their vertices, one contour after another."""
    each = [(contour.curve.deviation, contour.vertices) for contour in contours if contour.vertices]
    counts = np.array([count for _, count in each])
    points, between, rms, worst = np.transpose([(d.points, d.between, d.rms, d.worst) for d, _ in each if d])
    k = int(np.argmax(points))
    return Deviation(
        float(points.max()),
        float(between.max()),
        float(np.sqrt(np.average(rms**2, weights=counts))),
        int(counts[:k].sum() + worst[k]),
    )


def _said(contours: list[_Contour]) -> dict[str, str]:
    """Return what there is to report of the contours."""
    far = {k: away.points for k, contour in enumerate(contours) if (away := contour.curve.deviation)}
    said = {"points read": str(sum(contour.vertices for contour in contours))}
    if len(contours) == 1:
        return said if far else {"contours": "1 taken over"}
    said |= {"contours": f"{len(far)} fitted, {len(contours) - len(far)} taken over"}
    if not far:
        return said
    worst = max(far, key=far.__getitem__)
    return said | {"worst fit": _called(worst, contours[worst].name)}


def _said_of_arcs(contours: list[_Contour], drawn: list[Arcs]) -> dict[str, str]:
    """Return what there is to report of arcs: distances from points are the fit's and theirs from the fit, added."""
    lines = sum(int(np.count_nonzero(each.is_line)) for each in drawn)
    said = {
        "arcs": str(sum(map(len, drawn)) - lines),
        "lines": str(lines),
        "smallest radius": f"{min(float(each.radii.min()) for each in drawn):.6g}",
        "length": f"{sum(float(each.lengths.sum()) for each in drawn):.7g}",
    }
    sums = [
        (away.points + each.deviation, away.between + each.deviation)
        for contour, each in zip(contours, drawn, strict=True)
        if (away := contour.curve.deviation)
    ]
    if sums:
        points, between = np.max(sums, axis=0)
        said |= {"deviation at points": f"{points:.3g}", "deviation between": f"{between:.3g}"}
    others = [each.deviation for contour, each in zip(contours, drawn, strict=True) if not contour.vertices]
    return said | ({"deviation from what was taken over": f"{max(others):.3g}"} if others else {})
