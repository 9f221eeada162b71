"""What there is to say of what a file holds, in words."""

from __future__ import annotations

from typing import Any

import numpy as np

from cadfit.bezier import Array, evaluate
from cadfit.bspline import DEGREE, BSpline
from cadfit.files.curves import Curves
from cadfit.fitting.result import Fit
from cadfit.points.measures import chord_lengths


def facts(found: Any) -> dict[str, str]:
    """Return names and values that describe points (n, d), `Curves`, a `trimesh.Trimesh`, or the kernel's `Solids`.

    Lengths are in the unit of the coordinates; a curve's length to 1e-6, its box that of the curve, not of its poles.

    >>> facts(np.array([[0.0, 0.0], [3.0, 4.0]]))["length"]
    '5'
    """
    if isinstance(found, Curves):
        return _of_curves(found)
    if hasattr(found, "shapes"):
        return _of_solids(found)
    return _of_points(found) if isinstance(found, np.ndarray) else _of_mesh(found)


def _of_points(points: Array) -> dict[str, str]:
    n, d = points.shape
    steps = chord_lengths(points)
    return {
        "kind": "points",
        "points": str(n),
        "dimension": str(d),
        "repeats": str(int(np.count_nonzero(steps == 0))),
        "closed": _yes(n > 3 and np.array_equal(points[0], points[-1])),
        "length": f"{steps.sum():.7g}",
        **_box(points),
    }


def _of_curves(found: Curves) -> dict[str, str]:
    several = {"curves": str(len(found.curves))} if found.curves[1:] else {}
    return {
        "kind": "curves" if several else "curve",
        **several,
        "degree": str(DEGREE),
        "dimension": str(found.dimension),
        "continuity": min(map(continuity, found.curves)) + (" within each" if several else ""),
        **summary(found),
        **_box(np.concatenate([extremes(curve) for curve in found.curves])),
    }


def summary(found: Curves | Fit) -> dict[str, str]:
    """Return the few facts to report of curves just made."""
    curves = found.curves
    said = {
        "poles": str(sum(len(curve.poles) for curve in curves)),
        "spans": str(sum(len(curve.distinct_knots) - 1 for curve in curves)),
        "closed": _yes(found.closed),
        "length": f"{sum(curve.length(1e-6) for curve in curves):.7g}",
    }
    if (away := found.deviation) is not None:
        said |= {"deviation at points": f"{away.points:.3g}", "deviation between": f"{away.between:.3g}"}
    return said


def _of_mesh(mesh: Any) -> dict[str, str]:
    return {
        "kind": "mesh",
        "vertices": str(len(mesh.vertices)),
        "faces": str(len(mesh.faces)),
        "watertight": _yes(mesh.is_watertight),
        "volume": f"{mesh.volume:.7g}" if mesh.is_watertight else "none: not watertight",
        **_box(mesh.bounds),
    }


def _of_solids(found: Any) -> dict[str, str]:
    from cadfit import occt
    from cadfit.occt.measuring import box, is_valid
    from cadfit.occt.shapes import solids

    whole = solids(found.shapes)
    within = f"{sum(map(occt.volume, whole)) * found.scale**3:.7g}" if whole else "none: faces alone"
    return {
        "kind": {0: "faces", 1: "solid"}.get(len(whole), "solids"),
        **({"solids": str(len(whole))} if whole[1:] else {}),
        "faces": str(len(occt.faces(found.shapes))),
        "edges": str(len(occt.edges(found.shapes))),
        "valid": _yes(is_valid(found.shapes)),
        "volume": within,
        **_box(found.scale * box(found.shapes)),
    }


def continuity(curve: BSpline) -> str:
    """Return how smooth the curve is by its knots: each time a knot stands, one derivative less is continuous."""
    inner = curve.multiplicities[1:-1]
    return f"C{DEGREE - inner.max()}" if len(inner) else "smooth"


def extremes(curve: BSpline) -> Array:
    """Return points (k, d) of the curve, or with coordinates of several, that span its box.

    The ends of the Bézier pieces, and each coordinate where its derivative, a quadratic with the coefficients of
    `slopes`, is zero.
    """
    pieces = curve.pieces()
    slopes = np.diff(pieces, axis=1)
    a = slopes[:, 0] - 2.0 * slopes[:, 1] + slopes[:, 2]
    b = slopes[:, 1] - slopes[:, 0]
    c = slopes[:, 0]
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        q = -(b + np.copysign(np.sqrt(b * b - a * c), b))
        roots = [np.nan_to_num(np.clip(root, 0.0, 1.0)) for root in (q / a, c / q)]
    d = pieces.shape[2]
    turns = [np.stack([evaluate(pieces[:, :, j : j + 1], t[:, j])[:, 0] for j in range(d)], axis=1) for t in roots]
    return np.concatenate([pieces[:, 0], pieces[-1:, 3], *turns])


def _box(points: Array) -> dict[str, str]:
    low, high = (" ".join(f"{value:.7g}" for value in corner) for corner in (points.min(axis=0), points.max(axis=0)))
    return {"from": low, "to": high}


def _yes(answer: object) -> str:
    return "yes" if answer else "no"
