"""How a fit and a curve show themselves in a notebook: a small picture and the key figures, without a script."""

from __future__ import annotations

from collections.abc import Sequence
from html import escape

import numpy as np

from cadfit.bezier import Array
from cadfit.bspline import BSpline
from cadfit.files.facts import continuity
from cadfit.fitting.result import Fit

_WIDTH, _HEIGHT, _MARGIN = 300.0, 190.0, 12.0
_MOST = 400  # points and spans drawn: beyond, every few
_MOST_MEASURED = 50_000  # poles
_SEEN = np.array([[np.sqrt(0.5), np.sqrt(0.5), 0.0], [-np.sqrt(1 / 6), np.sqrt(1 / 6), 2 * np.sqrt(1 / 6)]])


def html_of_fit(fit: Fit) -> str:
    """Return a fit's picture and figures as HTML."""
    far = fit.deviation
    rows = {
        "points": f"{len(fit.points):,}" + (f", {len(fit.cleaned):,} repeats dropped" if len(fit.cleaned) else ""),
        "poles": f"{fit.poles:,}" + (f" in {len(fit.curves)} curves" if len(fit.curves) > 1 else ""),
        "tolerance": f"{fit.tolerance:g}" if fit.tolerance is not None else "–",
        "off at points": f"≤ {far.points:.4g}, at point {far.worst}",
        "off between": f"≤ {far.between:.4g}",
        **_length(fit.curves),
    }
    return _html(fit.curves, fit.points, f"Fit, {'closed' if fit.closed else 'open'}", rows)


def html_of_spline(spline: BSpline) -> str:
    """Return a spline's picture and figures as HTML."""
    low, high = spline.domain
    rows = {
        "poles": f"{len(spline.poles):,} in {spline.poles.shape[1]}D",
        "spans": f"{len(spline.distinct_knots) - 1:,}, {continuity(spline)}",
        "parameters": f"{low:.6g} to {high:.6g}",
        **_length([spline]),
    }
    return _html([spline], None, f"BSpline, {'closed' if spline.closed else 'open'}", rows)


def _length(curves: Sequence[BSpline]) -> dict[str, str]:
    """Return the length as a row; none of very many spans, where it would take seconds that were not asked for."""
    if sum(len(curve.poles) for curve in curves) > _MOST_MEASURED:
        return {}
    return {"length": f"{sum(curve.length(1e-6) for curve in curves):.6g}"}


def _html(curves: Sequence[BSpline], points: Array | None, title: str, rows: dict[str, str]) -> str:
    cells = "".join(
        f'<tr><td style="text-align:left;opacity:.7">{escape(name)}</td>'
        f'<td style="text-align:left">{escape(value)}</td></tr>'
        for name, value in rows.items()
    )
    table = f'<table><caption style="text-align:left;font-weight:600">{escape(title)}</caption>{cells}</table>'
    return f'<div style="display:flex;gap:16px;align-items:center">{_picture(curves, points)}{table}</div>'


def _picture(curves: Sequence[BSpline], points: Array | None) -> str:
    """Return an SVG of curves, poles and points; of three coordinates or more the first three, from a corner."""
    d = curves[0].poles.shape[1]
    if d == 1:
        return ""
    view = np.eye(2) if d == 2 else _SEEN
    pieces = np.concatenate([curve.pieces() for curve in curves])
    poles = np.concatenate([curve.poles for curve in curves])
    few_poles = len(poles) <= _MOST

    def seen(places: Array) -> Array:
        return np.asarray((places[..., : view.shape[1]] - pieces[0, 0, : view.shape[1]]) @ view.T * [1.0, -1.0])

    ends = seen(poles if few_poles else pieces.reshape(-1, d))
    low, size = ends.min(axis=0), np.ptp(ends, axis=0)
    scale = min((np.array([_WIDTH, _HEIGHT]) - 2 * _MARGIN) / np.maximum(size, 1e-300)) if size.any() else 1.0
    shift = 0.5 * (np.array([_WIDTH, _HEIGHT]) - scale * size) - scale * low

    def at(places: Array) -> Array:
        return np.asarray(scale * seen(places) + shift)

    drawn = [f'<path d="{_path(at(pieces))}" fill="none" stroke="#0072B2" stroke-width="1.8"/>']
    if few_poles:
        for curve in curves:
            line = " ".join(f"{x:.1f},{y:.1f}" for x, y in at(curve.poles).tolist())
            drawn.insert(0, f'<polyline points="{line}" fill="none" stroke="#999" stroke-width="0.7"/>')
    if points is not None:
        few = at(points[:: -(-len(points) // _MOST)])
        dots = "".join(f"M{x:.1f} {y:.1f}h0" for x, y in few.tolist())
        drawn.append(f'<path d="{dots}" stroke="#D55E00" stroke-width="3" stroke-linecap="round"/>')
    box = f'viewBox="0 0 {_WIDTH:g} {_HEIGHT:g}" width="{_WIDTH:g}" height="{_HEIGHT:g}"'
    style = "background:#fff;border:1px solid #e1e6eb;border-radius:6px"
    return f'<svg xmlns="http://www.w3.org/2000/svg" {box} style="{style}">{"".join(drawn)}</svg>'


def _path(pieces: Array) -> str:
    """Return Bézier pieces (m, 4, 2) as steps of an SVG path; where there are many, every few as a straight one."""
    every = -(-len(pieces) // _MOST)
    start = "M{:.1f} {:.1f}".format(*pieces[0, 0])
    if every == 1:
        return start + "".join("C" + " ".join(f"{v:.2f}" for v in piece[1:].ravel()) for piece in pieces)
    return start + "".join(f"L{x:.1f} {y:.1f}" for x, y in [*pieces[every - 1 :: every, 3].tolist(), pieces[-1, 3]])
