"""Curves made from drawings: contours that are polylines are fitted each by itself, all others taken over as they are.

Imported when a command runs, so that `cadfit --help` answers at once.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np

from cadfit import methods
from cadfit.bezier import Array
from cadfit.bspline import BSpline
from cadfit.files import Curves
from cadfit.files.facts import summary
from cadfit.fitting.deviation import Deviation
from cadfit.fitting.result import Fit
from cadfit.joining import join
from cadfit.methods import How, Made
from cadfit.stages import portion

_STRAIGHT = 1e-12  # of the largest coordinate: poles this near to their chord are on it


@dataclass(frozen=True, slots=True)
class _Contour:
    """A contour made anew, or taken over: then without vertices, and at no distance."""

    name: str
    curve: Curves | Fit
    vertices: int = 0


def made(found: Any, how: How, progress: Callable[[float], None] | None = None) -> Made:
    """Return the curves made from what a file of points or a drawing holds, and what to report.

    Points as `cadfit.methods.made` does. Of a drawing each contour becomes one curve, with its name, in the order of
    the drawing: one that is a polyline of 3 vertices or more is fitted (a triple knot at each corner), others stay.

    Raises ValueError for what is neither, where there is nothing to fit, and naming the contour that cannot be.
    """
    if not isinstance(found, Curves) or all(vertices(curve) is None for curve in found.curves):
        return methods.made(found, how, progress)
    contours = list(_contours(found, how, progress))
    curves = Curves(
        tuple(join(contour.curve.curves) for contour in contours),
        len(contours) == 1 and contours[0].curve.closed,
        _together(contours),
        found.names,
    )
    return curves, _said(contours) | summary(curves)


def vertices(curve: BSpline) -> Array | None:
    """Return the vertices (n, d), 3 or more, of a curve that is straight from knot to knot; None of any other.

    >>> from cadfit.joining import polyline
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


def _contours(found: Curves, how: How, progress: Callable[[float], None] | None) -> Iterator[_Contour]:
    """Yield each contour, fitted or taken over."""
    if how.corners is not None and "," in how.corners and len(found.curves) > 1:
        raise ValueError(f"--corners {how.corners}: rows are for one contour, and it holds {len(found.curves)}")
    n = len(found.curves)
    for k, (curve, name) in enumerate(zip(found.curves, found.names or ("",) * n, strict=True)):
        points = vertices(curve)
        if points is None:
            yield _Contour(name, Curves((curve,), curve.closed))
            continue
        try:
            fitted, _ = methods.made(points, how, portion(progress, k / n, (k + 1) / n))
        except ValueError as error:
            raise ValueError(f"{_called(k, name)}: {error}") from error
        yield _Contour(name, fitted, len(points))


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
    fitted = [k for k, contour in enumerate(contours) if contour.vertices]
    said = {
        "contours": f"{len(fitted)} fitted, {len(contours) - len(fitted)} taken over",
        "points read": str(sum(contour.vertices for contour in contours)),
    }
    far = {k: away.points for k in fitted if (away := contours[k].curve.deviation)}
    worst = max(far, key=far.__getitem__)
    return said | {"worst": _called(worst, contours[worst].name)}
