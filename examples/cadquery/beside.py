"""CadQuery's own way beside cadfit's: what each example measures of a curve, whoever made it."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from itertools import product
from pathlib import Path
from typing import Any

import cadquery as cq
import matplotlib.pyplot as plt
import numpy as np
from OCP.BRepAdaptor import BRepAdaptor_Curve, BRepAdaptor_Surface
from OCP.GeomAbs import GeomAbs_SurfaceType
from rich.console import Console
from rich.table import Table
from scipy.interpolate import BSpline
from scipy.spatial import cKDTree

from cadfit import local_spline
from cadfit.cadquery import from_edge

DATA = Path(__file__).parents[1] / "data"
HOST, OURS = "#D55E00", "#0072B2"  # vermilion and blue, told apart by everyone


def timed(make: Callable[[], Any]) -> tuple[Any, float]:
    """Return what was made, and the seconds it took."""
    start = time.perf_counter()
    made = make()
    return made, time.perf_counter() - start


def kernel_spline(edge: cq.Edge) -> BSpline:
    """Return scipy's spline of an edge's curve, of any degree, with the kernel's very poles and knots."""
    curve = BRepAdaptor_Curve(edge.wrapped).BSpline().Copy()
    if curve.IsPeriodic():
        curve.SetNotPeriodic()
    poles = np.array([pole.Coord() for pole in curve.Poles()])
    return BSpline(np.repeat([*curve.Knots()], [*curve.Multiplicities()]), poles, curve.Degree())


def places(edges: Sequence[cq.Edge], count: int = 40_000) -> np.ndarray:
    """Return about `count` places (m, 3) along edges, as many in each knot span."""
    found = []
    for spline in map(kernel_spline, edges):
        u = np.unique(spline.t[spline.k : -spline.k])  # a periodic curve's knots go on outside of its range
        per_span = count // len(edges) // (len(u) - 1) + 1
        steps = np.diff(u)[:, None] * np.arange(per_span) / per_span
        found.append(spline(np.append((u[:-1, None] + steps).ravel(), u[-1])))
    return np.concatenate(found)


def farthest(points: np.ndarray, polyline: np.ndarray) -> float:
    """Return the largest distance from points (n, 3) to a polyline (m, 3), taken near its nearest vertex."""
    nearest = cKDTree(polyline).query(points)[1]
    best = np.full(len(points), np.inf)
    for first in (nearest - 1, nearest):
        a = polyline[first.clip(0, len(polyline) - 2)]
        chord = polyline[first.clip(0, len(polyline) - 2) + 1] - a
        share = np.einsum("nd,nd->n", points - a, chord) / np.maximum(np.einsum("nd,nd->n", chord, chord), 1e-300)
        best = np.minimum(best, np.linalg.norm(points - a - share.clip(0.0, 1.0)[:, None] * chord, axis=1))
    return float(best.max())


def measured(edges: Sequence[cq.Edge], points: np.ndarray, seconds: float) -> dict[str, float]:
    """Return a curve's poles, how far it is from the points and from their polyline, its length, and its time.

    By many places on both, the nearest counting: more lenient than cadfit's own bounds, which match in order.
    """
    points = np.column_stack([points, np.zeros((len(points), 3 - points.shape[1]))])
    curve = places(edges)
    share = np.linspace(0.0, 1.0, 50, endpoint=False)[:, None]
    chords = np.concatenate([a + share * (b - a) for a, b in zip(points[:-1], points[1:], strict=True)] + [points[-1:]])
    return {
        "poles": sum(len(kernel_spline(edge).c) for edge in edges),
        "at points": farthest(points, curve),
        "between": farthest(curve, chords),
        "length": sum(edge.Length() for edge in edges),
        "ms": 1e3 * seconds,
    }


def round_about(solids: Sequence[cq.Solid], points: np.ndarray, radius: float) -> dict[str, float]:
    """Return the poles of the solids' splines, and how far places on them are from a radius about a curve.

    The curve is the local spline through the points (n, 3); plane faces do not count.
    """
    curve, found, poles = local_spline(points), [], 0
    surfaces = [BRepAdaptor_Surface(face.wrapped) for solid in solids for face in solid.Faces()]
    count = 25 if len(surfaces) < 25 else 3
    for surface in surfaces:
        if surface.GetType() == GeomAbs_SurfaceType.GeomAbs_Plane:
            continue
        if surface.GetType() == GeomAbs_SurfaceType.GeomAbs_BSplineSurface:
            poles += surface.NbUPoles() * surface.NbVPoles()
        u = np.linspace(surface.FirstUParameter(), surface.LastUParameter(), count)
        v = np.linspace(surface.FirstVParameter(), surface.LastVParameter(), count)
        found += [surface.Value(*place).Coord() for place in product(u.tolist(), v.tolist())]
    return {"poles": poles, "off": float(np.abs(curve.nearest(np.array(found))[1] - radius).max())}


def bend(edge: cq.Edge, count: int = 20_001) -> tuple[np.ndarray, np.ndarray]:
    """Return places (count, 2) along a plane edge in z = 0 and the signed curvature there (count,)."""
    spline = kernel_spline(edge)
    u = np.linspace(spline.t[spline.k], spline.t[-spline.k - 1], count)
    (x, y), (a, b) = spline(u, 1)[:, :2].T, spline(u, 2)[:, :2].T
    return spline(u)[:, :2], (x * b - y * a) / np.hypot(x, y) ** 3


def turns(curvature: np.ndarray, least: float) -> int:
    """Return how often the curve changes the side it bends to; where it bends by less than `least` it is straight."""
    signs = np.sign(curvature[np.abs(curvature) > least])
    return int(np.count_nonzero(np.diff(signs)))


def draw(edge: cq.Edge, ax: Any, **style: Any) -> None:
    """Draw an edge that cadfit made, with the plot of its spline; one in z = 0 in the plane."""
    spline = from_edge(edge)
    flat = spline if spline.poles[:, 2].any() else spline.transformed(np.eye(2, 3))
    flat.plot(ax, poles=False, comb=False).lines[-1].set(**style)


def save(figure: Any, folder: str | Path, name: str) -> None:
    """Write a picture, as wide as a page, into the folder."""
    Path(folder).mkdir(parents=True, exist_ok=True)
    figure.savefig(Path(folder) / name, dpi=130)
    plt.close(figure)


def show(title: str, rows: dict[str, dict[str, float]]) -> None:
    """Print a table, a row for each way."""
    table = Table("", *next(iter(rows.values())), title=title, title_justify="left")
    for name, row in rows.items():
        table.add_row(name, *(f"{value:.3g}" if isinstance(value, float) else str(value) for value in row.values()))
    Console(highlight=False, width=130).print(table)
