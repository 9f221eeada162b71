"""What a report holds: of each fit the curve, its points, its course and its figures, as plain numbers."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from cadfit.bezier import Array, Ints
from cadfit.bspline import BSpline
from cadfit.files.facts import continuity
from cadfit.fitting.along import Trace, allowed, largest_rows, off_chords, off_points, trace
from cadfit.fitting.result import Fit
from cadfit.stages import Progress, unheard

MOST_POINTS = 20_000  # shown; a canvas draws as many in a few milliseconds
MOST_SPANS = 10_000
MOST_POLES = 10_000
COLOURS = ["#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9", "#8C510A", "#5E3C99"]

_DIGITS = 10  # of a coordinate, counted from the size of all


@dataclass(frozen=True, slots=True, eq=False)
class Entry:
    """A fit to show, under a name.

    `seconds`: how long it took, where that is to be compared. `strays`: between how many neighbouring points the curve
    leaves the room that `cadfit.fit` leaves it, where that was looked at.
    """

    name: str
    fit: Fit
    seconds: float | None = None
    strays: int | None = None


def figures(entry: Entry, along: Trace) -> dict[str, Any]:
    """Return the figures of an entry: lengths in the caller's unit, None where there is no such figure."""
    fit, bend = entry.fit, np.abs(along.bend)
    sharpest = int(np.argmax(bend))
    bent = bend[sharpest] > 0.0 and fit.points.shape[1] > 1  # along one coordinate it is all rounding
    return {
        "points": len(fit.points),
        "repeats": len(fit.cleaned),
        "dimension": fit.points.shape[1],
        "closed": fit.closed,
        "corners": len(fit.corners),
        "curves": len(fit.curves),
        "poles": fit.poles,
        "spans": sum(len(curve.distinct_knots) - 1 for curve in fit.curves),
        "continuity": min(map(continuity, fit.curves)),
        "tolerance": fit.tolerance,
        "between": fit.between,
        "deviation at points": fit.deviation.points,
        "deviation between": fit.deviation.between,
        "rms": fit.deviation.rms,
        "worst": fit.deviation.worst,
        "length": along.length,
        "smallest radius": float(1.0 / bend[sharpest]) if bent else None,
        "smallest radius at": float(along.s[sharpest]) if bent else None,
        "seconds": entry.seconds,
        "strays": entry.strays,
    }


def page_data(entries: Sequence[Entry], unit: str, progress: Progress = unheard) -> dict[str, Any]:
    """Return what the page draws and says, ready for JSON.

    Coordinates are counted from `centre`, poles and knots (`exact_poles`, `knots`) are the very numbers.
    """
    fits = [entry.fit for entry in entries]
    d = fits[0].points.shape[1]
    if any(fit.points.shape[1] != d for fit in fits):
        raise ValueError(f"fits on one page have one dimension, not {sorted({fit.points.shape[1] for fit in fits})}")
    every = np.concatenate([each for fit in fits for each in (fit.points, *(curve.poles for curve in fit.curves))])
    low, high = every.min(axis=0), every.max(axis=0)
    centre, size = low + 0.5 * (high - low), float(np.linalg.norm(high - low))
    shape = _Shape(centre, size, graph=d == 1)
    progress(0.0)
    sets, shown = _sets(fits, shape), []
    for k, entry in enumerate(entries):
        progress((k + 1) / (len(entries) + 1))
        shown.append(_shown(entry, k, entries, sets, shape))
    progress(1.0)
    domain = max(float(np.ptp(fit.curves[-1].domain[-1:] + fit.curves[0].domain[:1])) for fit in fits)
    return {
        "format": "cadfit report 1",
        "unit": unit,
        "axes": _axes(d),
        "graph": shape.graph,
        "stretch": [2.0 * size / (domain or 1.0) or 1.0] if shape.graph else [],
        "centre": [0.0, *centre.tolist()] if shape.graph else centre.tolist(),
        "sharpest": max((abs(x) for each in shown for x in each["along"]["bend"] or []), default=0.0),
        "tooth": 0.2 * size,
        "sets": [{key: value for key, value in each.items() if key != "chosen"} for each in sets],
        "entries": shown,
    }


@dataclass(frozen=True, slots=True, eq=False)
class _Shape:
    """Where the page's coordinates are counted from and how fine they are; `graph`: values over the parameter."""

    centre: Array
    size: float
    graph: bool

    def rows(self, places: Array, u: Array) -> list[list[float]]:
        """Return places (n, d) at parameters u (n,) as the rows of coordinates that the page draws."""
        fine = np.round(places - self.centre, _decimals(self.size, _DIGITS))
        rows: list[list[float]] = (np.column_stack([u, fine]) if self.graph else fine).tolist()
        return rows


def _decimals(size: float, digits: int) -> int:
    return int(np.clip(digits - np.ceil(np.log10(size)), -290, 290)) if size > 0.0 else 290


def _axes(d: int) -> list[str]:
    if d == 1:
        return ["parameter", "x"]
    return list("xyz"[:d]) if d <= 3 else [f"x{k}" for k in range(1, d + 1)]


def _sets(fits: Sequence[Fit], shape: _Shape) -> list[dict[str, Any]]:
    """Return the points, those shared by several fits once, thinned to those shown."""
    sets: list[dict[str, Any]] = []
    for k, fit in enumerate(fits):
        owner = next((s for s in sets if np.array_equal(fits[s["owners"][0]].points, fit.points)), None)
        if owner is None:
            sets.append({"owners": [k], "colour": "#D55E00" if len(fits) == 1 else "#3B4552"})
        else:
            owner["owners"].append(k)
    for each in sets:
        mine = [fits[k] for k in each["owners"]]
        points = mine[0].points
        corners = np.unique(np.concatenate([fit.corners for fit in mine]))
        rows = _kept_rows(mine, corners)
        each |= {
            "total": len(points),
            "rows": rows.tolist(),
            "at": shape.rows(points[rows], mine[0].parameters[rows]),
            "corners": np.searchsorted(rows, corners).tolist(),
            "chosen": rows,
        }
    return sets


def _kept_rows(fits: Sequence[Fit], corners: Ints) -> Ints:
    """Return the rows of the points that are shown: all, or of each stretch the farthest from each curve."""
    n = len(fits[0].points)
    if n <= MOST_POINTS:
        return np.arange(n)
    most = (MOST_POINTS - len(corners) - 2) // len(fits)
    farthest = [largest_rows(np.linalg.norm(off_points(fit), axis=1), most - 1) for fit in fits]
    worst = [fit.deviation.worst for fit in fits]
    return np.unique(np.concatenate([*farthest, worst, corners, [0, n - 1]]).astype(np.intp))


def _shown(entry: Entry, k: int, entries: Sequence[Entry], sets: list[dict[str, Any]], shape: _Shape) -> dict[str, Any]:
    fit = entry.fit
    own = next(number for number, each in enumerate(sets) if k in each["owners"])
    rows, along = sets[own]["chosen"], trace(fit.curves)
    off = off_points(fit)
    u, between, chords = off_chords(fit)
    room = allowed(fit) if fit.between == "curve" else None
    spans = [len(curve.distinct_knots) - 1 for curve in fit.curves]
    course = _course(fit.curves, along, spans, shape)
    joints = np.array([curve.domain[0] for curve in fit.curves[1:]])
    few_poles = fit.poles <= MOST_POLES
    far = np.linalg.norm(off[rows], axis=1)
    return {
        "name": entry.name,
        "colour": COLOURS[k % len(COLOURS)],
        "set": own,
        "figures": figures(entry, along),
        "tolerance": fit.tolerance,
        "length": along.length,
        **course,
        "joints": _short(along.at(joints), 8),
        "exact_poles": [curve.poles.tolist() for curve in fit.curves] if few_poles else [],
        "knots": [curve.knots.tolist() for curve in fit.curves] if few_poles else [],
        "poles": [row for curve in fit.curves for row in shape.rows(curve.poles, _pulls(curve))] if few_poles else [],
        "pole_counts": [len(curve.poles) for curve in fit.curves] if few_poles else [],
        "s": _short(along.at(fit.parameters[rows]), 9),
        "off": _short(far, 6),
        "off_vectors": _vectors(off[rows], shape.graph),
        "between": {
            "s": _short(along.at(u), 9),
            "off": _short(between, 5),
            "room": None if room is None else _short(room[chords], 4),
        },
        "worst": {
            "row": fit.deviation.worst,
            "shown": int(np.searchsorted(rows, fit.deviation.worst)),
            "off": float(np.linalg.norm(off[fit.deviation.worst])),
        },
    }


def _course(curves: Sequence[BSpline], along: Trace, spans: list[int], shape: _Shape) -> dict[str, Any]:
    """Return the curve as a chain of Bézier poles, three a span and one, and the samples along it.

    With more spans than are shown the chain is of straight pieces between samples, the sharpest of each stretch.
    """
    first = np.cumsum(spans)[:-1]
    if sum(spans) <= MOST_SPANS:
        pieces = np.concatenate([curve.pieces() for curve in curves])
        knots = np.concatenate([curve.distinct_knots[:-1] for curve in curves] + [curves[-1].distinct_knots[-1:]])
        low, high = knots[along.span], knots[along.span + 1]
        t, span = (along.u - low) / (high - low), along.span
    else:
        rows = np.union1d(largest_rows(np.abs(along.bend), MOST_SPANS), [0, len(along.s) - 1])
        first = np.searchsorted(along.span[rows], first)
        ends, knots = along.places[rows], along.u[rows]
        pieces = np.stack([ends[:-1] + part * np.diff(ends, axis=0) for part in np.arange(4) / 3.0], axis=1)
        pick = np.repeat(rows, 2)[1:-1]
        along = Trace(along.u[pick], along.s[pick], along.places[pick], along.curvature[pick], along.span[pick])
        span, t = np.repeat(np.arange(len(pieces)), 2), np.tile([0.0, 1.0], len(pieces))
    thirds = np.concatenate([np.linspace(a, b, 4)[:3] for a, b in zip(knots[:-1], knots[1:], strict=True)])
    poles = np.concatenate([pieces[:, :3].reshape(-1, pieces.shape[2]), pieces[-1:, 3]])
    return {
        "chain": shape.rows(poles, np.append(thirds, knots[-1])),
        "first_spans": first.tolist(),
        "along": {
            "s": _short(along.s, 10),
            "span": span.tolist(),
            "t": np.round(t, 9).tolist(),
            "bend": None if shape.graph else _short(along.bend, 6),
            "curvature": None if shape.graph else [_short(row, 5) for row in along.curvature],
        },
    }


def _pulls(curve: BSpline) -> Array:
    """Return the parameters (n,) at which the poles pull: the means of three knots."""
    return (curve.knots[1:-3] + curve.knots[2:-2] + curve.knots[3:-1]) / 3.0


def _vectors(off: Array, graph: bool) -> list[list[float]]:
    return [[0.0, *_short(row, 5)] if graph else _short(row, 5) for row in off]


def _short(values: Array, digits: int) -> list[float]:
    """Return numbers to so many significant digits: what a picture needs, at half the bytes."""
    return [float(f"{value:.{digits}g}") for value in values.tolist()]
