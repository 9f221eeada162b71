"""What others make of the same points and tolerance: poles, and what the curve really keeps.

FITPACK: `scipy.interpolate.splprep` (chord lengths, periodic where closed) with its smoothing bisected until no point
is farther than the tolerance. OCCT: `GeomAPI_PointsToBSpline` (degree 3, C2, the tolerance), the first point repeated
where closed. Each answers with its curve, or None where it fails.
"""

from __future__ import annotations

import warnings
from typing import NamedTuple

import numpy as np
from OCP.GeomAbs import GeomAbs_Shape
from OCP.GeomAPI import GeomAPI_PointsToBSpline
from OCP.gp import gp_Pnt
from scipy.interpolate import splev, splprep

import cadfit
from cadfit.fitting.checking import chain_of, room_of
from cadfit.fitting.deviation import straying_chords
from cadfit.fitting.matching import match

try:
    from OCP.collections import Array1_gp_Pnt as Points
except ImportError:
    from OCP.TColgp import TColgp_Array1OfPnt as Points


class Peer(NamedTuple):
    """A peer's curve: how many poles it has, how far it is from the points and from their chords.

    `kept`: whether between the points it keeps the rule that `cadfit.fit` keeps.
    """

    poles: int
    points: float
    between: float
    kept: bool


def contour(points, closed):
    return np.vstack([points, points[:1]]) if closed else points


def chord_lengths(points):
    return np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(points, axis=0), axis=1))])


def splprep_once(points, tolerance, closed):
    """One call, at the smoothing that a tolerance suggests: what the timings are taken against."""
    points = contour(points, closed)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        return splprep(points.T, s=len(points) * (tolerance / 2.0) ** 2, per=closed)


def fitpack(points, tolerance, closed, rounds=20):
    """FITPACK's curve of the fewest poles whose distance at its own parameters is within the tolerance."""
    points = contour(points, closed)
    u = chord_lengths(points)
    low, high = np.log(1e-10 * tolerance**2), np.log(4.0 * len(points) * tolerance**2)
    best = None
    for _ in range(rounds):
        middle = 0.5 * (low + high)
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            try:
                found = splprep(points.T, u=u, s=np.exp(middle), per=closed)[0]
            except (ValueError, TypeError):
                found = None
        if found is not None and np.linalg.norm(np.array(splev(u, found)).T - points, axis=1).max() <= tolerance:
            low = middle
            if best is None or len(found[0]) < len(best[0]):
                best = found
        else:
            high = middle
    if best is None:
        return None
    knots, poles = best[0], np.transpose(best[1])
    if closed:  # the first of the m + 3 poles of m spans stands one knot before the start
        return cadfit.periodic(poles[1 : len(knots) - 6], knots[3:-3])
    return cadfit.BSpline(poles, knots)


def occt(points, tolerance, closed):
    points = contour(points, closed)
    flat = points.shape[1]
    array = Points(1, len(points))
    for k, row in enumerate(points.tolist(), 1):
        array.SetValue(k, gp_Pnt(*row, *[0.0] * (3 - flat)))
    make = GeomAPI_PointsToBSpline(array, 3, 3, GeomAbs_Shape.GeomAbs_C2, tolerance)
    if not make.IsDone():
        return None
    curve = make.Curve()
    poles = [curve.Pole(k) for k in range(1, curve.NbPoles() + 1)]
    knots = [[curve.Knot(k)] * curve.Multiplicity(k) for k in range(1, curve.NbKnots() + 1)]
    return cadfit.BSpline(np.array([[p.X(), p.Y(), p.Z()] for p in poles])[:, :flat], np.concatenate(knots))


def judged(curve, points, tolerance, closed):
    """A peer's curve with how far it is from the points and between them."""
    points = contour(points, closed)
    if closed:
        start, _ = curve.nearest(points[0])
        if curve.closed and curve.domain[0] < start < curve.domain[1]:
            curve = cadfit.join(curve.split(float(start))[::-1])
    far = cadfit.deviation(curve, points)
    room = room_of(chain_of(points[: len(points) - closed], closed, False), tolerance)
    strayed = straying_chords(curve, points, match(curve, points)[0], room)
    return Peer(len(curve.poles), far.points, far.between, not len(strayed))
