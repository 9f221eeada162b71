"""Contours of a drawing: Bézier pieces end to end as splines, separate pieces joined where they meet."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.spatial import cKDTree

from cadfit.bezier import Array
from cadfit.bspline import BSpline
from cadfit.files.curves import Curves

ARC_PIECES = 36
"""Cubic pieces for an arc, a circle or an ellipse. Each spans 10 degrees at most, and lies outside the arc by at most
(4/27) sin(a)^6 / cos(a)^2 of the radius, a being a quarter of its angle: 1.0e-9."""

_MEET = 1e-6  # of the drawing's size: ends no farther apart are one


@dataclass(frozen=True, slots=True, eq=False)
class Contour:
    """Bézier pieces (m, 4, d) end to end, the name of their layer or element, whether all are straight, and the spline.

    The last, where the drawing has one, is what the contour becomes unless others are joined to it.
    """

    pieces: Array
    name: str
    straight: bool
    spline: BSpline | None = None

    @property
    def ends(self) -> tuple[Array, Array]:
        """The first and the last point."""
        return self.pieces[0, 0], self.pieces[-1, 3]


def segment(start: Array, end: Array) -> Array:
    """Return the straight Bézier piece (4, d) from one point to another, at even speed."""
    return np.stack([start, start + (end - start) / 3.0, end - (end - start) / 3.0, end])


def found(contours: Sequence[Contour]) -> Curves:
    """Return what a drawing holds; its vertices as well, if it is one polyline.

    Contours of one name whose ends meet are joined, in the order of the drawing, the later ones turned round where that
    is needed. A contour becomes one spline, with triple knots where its pieces meet.
    """
    whole = _chained(contours)
    vertices = None
    if len(whole) == 1 and whole[0].straight:
        vertices = np.concatenate([whole[0].pieces[:, 0], whole[0].pieces[-1:, 3]])
    splines = tuple(contour.spline or _spline(contour.pieces) for contour in whole)
    closed = len(whole) == 1 and splines[0].closed
    return Curves(splines, closed, names=tuple(contour.name for contour in whole), vertices=vertices)


def _spline(pieces: Array) -> BSpline:
    poles = np.concatenate([pieces[:, :3].reshape(-1, pieces.shape[2]), pieces[-1:, 3]])
    return BSpline(poles, np.repeat(np.arange(len(pieces) + 1.0), [4, *[3] * (len(pieces) - 1), 4]))


def _chained(contours: Sequence[Contour]) -> list[Contour]:
    """Return the contours with those joined that meet at ends where no third one does; ends that meet become equal."""
    everything = np.concatenate([contour.pieces.reshape(-1, contour.pieces.shape[2]) for contour in contours])
    gap = _MEET * float(np.linalg.norm(np.ptp(everything, axis=0)))
    ends = np.concatenate([contour.ends for contour in contours])
    open_ended = np.repeat(np.linalg.norm(ends[::2] - ends[1::2], axis=1) > gap, 2)
    near = defaultdict(list)
    for a, b in cKDTree(ends).query_pairs(gap):
        if open_ended[a] and open_ended[b] and contours[a // 2].name == contours[b // 2].name:
            near[a].append(b)
            near[b].append(a)
    partner = {divmod(a, 2): divmod(b[0], 2) for a, b in near.items() if len(b) == 1 and len(near[b[0]]) == 1}
    whole, used = [], set[int]()
    for k in range(len(contours)):
        if k not in used:
            start, around = (k, 0), {k}
            while start in partner and partner[start][0] not in around:  # back to where the chain begins
                other, end = partner[start]
                around.add(other)
                start = (other, 1 - end)
            whole.append(_walk(contours, partner, start, used, gap))
    return whole


def _walk(
    contours: Sequence[Contour],
    partner: dict[tuple[int, int], tuple[int, int]],
    start: tuple[int, int],
    used: set[int],
    gap: float,
) -> Contour:
    """Return the chain that begins with an end of a contour, to where nothing goes on or all is used."""
    parts: list[Array] = []
    k, end = start
    name, straight = contours[k].name, True
    while k not in used:
        used.add(k)
        pieces = contours[k].pieces if end == 0 else contours[k].pieces[::-1, ::-1]
        straight = straight and contours[k].straight
        pieces = pieces.copy()
        if parts:
            pieces[0, 0] = parts[-1][-1, 3]
        parts.append(pieces)
        if (k, 1 - end) not in partner:
            break
        k, end = partner[k, 1 - end]
    pieces = np.concatenate(parts)
    if np.linalg.norm(pieces[0, 0] - pieces[-1, 3]) <= gap and len(pieces) > 1:
        pieces[-1, 3] = pieces[0, 0]
    alone = contours[k].spline if len(parts) == 1 and end == 0 else None
    return Contour(pieces, name, straight, alone)
