"""What others make of the same points and tolerance: poles, and what the curve really keeps.

FITPACK: `scipy.interpolate.splprep` (chord lengths, periodic where closed) with its smoothing bisected until no point
is farther than the tolerance. OCCT: `GeomAPI_PointsToBSpline` (degree 3, C2, the tolerance), the first point repeated
where closed. Each answers with its curve, or None where it fails.
"""

from __future__ import annotations

import warnings
from typing import NamedTuple

import numpy as np
from scipy.interpolate import splprep

import cadfit
from cadfit.fitting.checking import chain_of, room_of
from cadfit.fitting.deviation import straying_chords
from cadfit.fitting.matching import match
from cadfit.report.compare import fitpack as fitpack
from cadfit.report.compare import occt as occt


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


def splprep_once(points, tolerance, closed):
    """One call, at the smoothing that a tolerance suggests: what the timings are taken against."""
    points = contour(points, closed)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        return splprep(points.T, s=len(points) * (tolerance / 2.0) ** 2, per=closed)


def judged(curve, points, tolerance, closed):
    """A peer's curve with how far it is from the points and between them."""
    points = contour(points, closed)
    if closed:
        start, _ = curve.nearest(points[0])
        if curve.closed and curve.domain[0] < start < curve.domain[1]:
            curve = cadfit.join(curve.split(float(start))[::-1])
    far = cadfit.deviation(curve, points)
    room = room_of(chain_of(points[: len(points) - closed], closed, False), tolerance)
    strayed = straying_chords(curve, points, *match(curve, points), room)
    return Peer(len(curve.poles), far.points, far.between, not len(strayed))
