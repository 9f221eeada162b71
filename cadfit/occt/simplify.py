"""Edges and wires refitted lighter, certified against the curves they had."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise

import numpy as np
from OCP.TopoDS import TopoDS_Edge, TopoDS_Wire

from cadfit.bezier import Array, Ints
from cadfit.bspline import BSpline
from cadfit.fitting.approximate import Effort, fit
from cadfit.fitting.deviation import Deviation
from cadfit.fitting.result import Fit
from cadfit.occt.exact import edges_in_order, halved, placed, raised, rational_pieces, straying
from cadfit.occt.kernel import CONFUSION
from cadfit.occt.shapes import from_edge
from cadfit.stages import Progress

_SHARE = 0.04  # of the tolerance is left to the chords between samples
_LEAST, _MOST = 400, 1 << 20  # samples of a curve
_CORNER = float(np.radians(1.0))
_EPS = float(np.finfo(np.float64).eps)


def simplify(
    edge: TopoDS_Edge | TopoDS_Wire, tolerance: float, *, effort: Effort = "best", progress: Progress | None = None
) -> Fit:
    """Return cubic splines, with as few poles as were found, within `tolerance` of an edge or a wire, both ways.

    No place of the edge is farther than the tolerance (a length) from the splines, and no place of the splines from
    the edge, places taken in order. Edges of every kind that is rational or polynomial: lines, circles, ellipses,
    parabolas, hyperbolas, Bézier curves and B-splines of every degree and weights, trimmed, closed, reversed. Corners,
    where the tangent turns by more than one degree, and open ends are kept; where edges of a wire go on smoothly they
    become one curve; closed smooth edges are C2 across the seam. Edges that are cubics already, of no more poles
    than what is found, come back as they are.

    Certified: the kernel converts the edge exactly, to rounding, into rational Bézier pieces; these are halved until
    the hull of each one's poles strays from its chord by no more than a 25th of the tolerance; and the splines are
    fitted to the polyline of those chords, with `between="polyline"`, within what is left. The sum of both bounds
    (`fit.deviation`, `points` the same as `between`) holds for whole curves. `fit.points` are samples of the edge.

    `effort` and `progress` as for `cadfit.fit`. Raises ValueError for other shapes, offset curves and curves on
    surfaces (which are not rational), wires that branch, and a tolerance too small to be certified with a million
    samples, naming it.

    >>> from OCP.BRepBuilderAPI import BRepBuilderAPI_MakeEdge
    >>> from OCP.gp import gp_Ax2, gp_Circ
    >>> circle = BRepBuilderAPI_MakeEdge(gp_Circ(gp_Ax2(), 10.0)).Edge()
    >>> ring = simplify(circle, 1e-2, effort="fast")
    >>> len(ring.spline.poles) <= 12, ring.deviation.between <= 1e-2
    (True, True)
    """
    if not tolerance > 0 or not np.isfinite(tolerance):
        raise ValueError(f"the tolerance must be a positive length, not {tolerance}")
    along = edges_in_order(edge)
    chains = [rational_pieces(each) for each in along]
    pieces = np.concatenate([raised(chain, max(each.shape[1] for each in chains)) for chain in chains])
    closed = _gap(pieces[-1], pieces[0]) <= CONFUSION
    opening = max((_gap(before, after) for before, after in pairwise(pieces)), default=0.0)
    if opening > CONFUSION + 0.1 * tolerance:
        raise ValueError(f"edges of the wire are {opening:.6g} apart where they should meet")
    points, places, stray = _sampled(pieces, tolerance, _LEAST)
    if len(points) > 32 * _LEAST:  # a fit to some of very many points needs some on straight parts, too
        points, places, stray = _sampled(pieces, tolerance, len(points) // 32)
    if closed:
        points[-1] = points[0]
    corners = np.searchsorted(places, _corners(pieces, closed))
    rounding = 64.0 * _EPS * float(np.abs(points).max())
    aside = stray + opening + rounding
    found = fit(
        points, tolerance - aside, closed=closed, corners=corners, between="polyline", effort=effort, progress=progress
    )
    far = max(found.deviation.points, found.deviation.between) + aside
    deviation = Deviation(far, far, found.deviation.rms + aside, found.deviation.worst)
    found = replace(found, deviation=deviation, tolerance=float(tolerance))
    own = _own_splines(along)
    if own and sum(len(spline.poles) for spline in own) <= found.poles:
        return _as_they_were(found, own, places, opening + rounding)
    return found


def _own_splines(along: list[TopoDS_Edge]) -> list[BSpline]:
    """Return the edges' own splines, if all are non-rational cubics or less; else none."""
    try:
        return [from_edge(each) for each in along]
    except ValueError:
        return []


def _as_they_were(found: Fit, own: list[BSpline], places: Array, error: float) -> Fit:
    """Return a fit whose curves are the edges' own, no heavier than those found; a piece is a span of their knots."""
    knots = [spline.distinct_knots - spline.domain[0] for spline in own]
    starts = np.cumsum([0.0, *(each[-1] for each in knots)])
    own = [
        BSpline(each.poles, each.knots - each.domain[0] + start) for each, start in zip(own, starts[:-1], strict=True)
    ]
    joints = np.cumsum([0, *(len(each) - 1 for each in knots)])
    every = np.concatenate([each[:-1] + start for each, start in zip(knots, starts[:-1], strict=True)] + [starts[-1:]])
    parameters = np.interp(places, np.arange(len(every)), every)[: len(found.points)]
    corners = np.searchsorted(places, joints[(1 - found.closed * (len(own) > 1)) : -1])
    deviation = Deviation(error, error, error, 0)
    return replace(found, curves=tuple(own), deviation=deviation, parameters=parameters, corners=corners)


def _gap(before: Array, after: Array) -> float:
    """Return how far the end of one piece is from the start of another."""
    return float(np.linalg.norm(placed(after[0]) - placed(before[-1])))


def _corners(pieces: Array, closed: bool) -> Ints:
    """Return the pieces (m, p + 1, 4) at whose start the curve turns by more than the least corner, rising."""
    legs = np.diff(placed(pieces), axis=1)
    sizes = np.linalg.norm(legs, axis=2)
    counts = sizes > 1e-9 * sizes.max()
    row = np.arange(len(legs))
    first = legs[row, counts.argmax(axis=1)]
    last = legs[row, -1 - counts[:, ::-1].argmax(axis=1)]
    before = np.roll(last, 1, axis=0)
    cosine = np.einsum("md,md->m", before, first) / np.linalg.norm(before, axis=1) / np.linalg.norm(first, axis=1)
    turned = np.arccos(np.clip(cosine, -1.0, 1.0)) > _CORNER
    turned[0] &= closed
    return np.flatnonzero(turned)


def _polygons(pieces: Array) -> Array:
    """Return the lengths of the control polygons of pieces (m,), which bound their own."""
    return np.asarray(np.linalg.norm(np.diff(placed(pieces), axis=1), axis=2).sum(axis=1))


def _sampled(pieces: Array, tolerance: float, least: int) -> tuple[Array, Array, float]:
    """Return points (n, 3) along pieces, their places (n,) counted in pieces, and how far the curve strays from them.

    No two neighbours are farther apart than a `least` part of the whole. Raises ValueError when a million are too few.
    """
    width, end = 1.0, pieces[-1, -1:]
    start = np.arange(float(len(pieces)))
    points, places, worst = [end], [np.array([float(len(pieces))])], 0.0
    length = _polygons(pieces).sum()
    while len(pieces):
        stray = straying(pieces)
        flat = (stray <= _SHARE * tolerance) & (_polygons(pieces) * least <= length)
        worst = max(worst, float(stray[flat].max(initial=0.0)))
        points.append(pieces[flat, 0])
        places.append(start[flat])
        if 2 * np.count_nonzero(~flat) > _MOST:
            may_do = float(stray.max()) / _SHARE
            raise ValueError(f"a tolerance of {tolerance:g} is too small to be certified here; {may_do:.3g} may do")
        width *= 0.5
        pieces, start = halved(pieces[~flat]), (start[~flat, None] + [0.0, width]).ravel()
    order = np.argsort(np.concatenate(places))
    return placed(np.concatenate(points)[order]), np.concatenate(places)[order], worst
