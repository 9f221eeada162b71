"""Drawings as DXF, through ezdxf: curves as SPLINE entities, arcs as polylines with bulges; with layers and units."""

from __future__ import annotations

import warnings
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

import numpy as np

try:
    import ezdxf
except ImportError as error:
    raise ImportError("DXF files need ezdxf: pip install 'cadfit[drawing]'") from error
from ezdxf.path import Curve4To, LineTo, make_path

from cadfit.arcing.result import Arcs
from cadfit.bspline import DEGREE, BSpline
from cadfit.files.contours import ARC_PIECES, Contour, found, segment
from cadfit.files.curves import ArcContours, Curves

_CODES = {"mm": 4, "m": 6, "inch": 1}
_MILLIMETRES = {1: 25.4, 2: 304.8, 4: 1.0, 5: 10.0, 6: 1000.0, 10: 914.4, 13: 0.001, 14: 100.0}  # of $INSUNITS
_CONTOURS = {"LINE", "LWPOLYLINE", "POLYLINE", "ARC", "CIRCLE", "ELLIPSE"}


def read(path: Path, unit: str) -> Curves:
    """Return the contours of the model space named by layer, in `unit`; with the vertices of a single polyline.

    Polynomial splines of degree 3 or less and lines are taken over exactly, arcs, circles, ellipses and bulges as
    cubics within 1e-9 of their radius. Blocks are taken apart. 2D where all lies in z = 0. A drawing that states no
    unit ($INSUNITS) is taken as it is. Other entities are named in a warning.

    Raises ValueError naming the entity and its handle for splines that no cubic equals, numbers that are not finite,
    a file that is not DXF, and where no contour is in it.
    """
    try:
        drawing = ezdxf.readfile(path)  # type: ignore[attr-defined]
    except OSError as error:
        if error.filename is not None:
            raise
        raise ValueError(f"{path}: not a DXF file: {error}") from error
    except StopIteration:  # its loader wanted more
        raise ValueError(f"{path}: not a readable DXF file: it is cut short") from None
    except Exception as error:  # ezdxf's own errors, and those its loaders meet in broken files
        raise ValueError(f"{path}: not a readable DXF file: {str(error) or type(error).__name__}") from error
    contours: list[Contour] = []
    others: list[str] = []
    for entity in _entities(drawing.modelspace(), others):
        name = f"{entity.dxftype()} (handle {entity.dxf.handle})"
        try:
            contours += _contours(entity)
        except Exception as error:
            raise ValueError(f"{path}: {name}: {str(error) or type(error).__name__}") from error
    if others:
        warnings.warn(f"{path}: not curves, and left out: {', '.join(others)}", stacklevel=2)
    if not contours:
        raise ValueError(f"{path}: no curves in its model space")
    scale = _MILLIMETRES.get(drawing.units, 0.0) / _MILLIMETRES[_CODES[unit]] or 1.0
    flat = all((contour.pieces[..., 2] == 0.0).all() for contour in contours)
    matrix = scale * np.eye(3)[: 2 if flat else 3]
    return found([
        Contour(c.pieces @ matrix.T, c.name, c.straight, c.spline.transformed(matrix) if c.spline else None)
        for c in contours
    ])  # fmt: skip


def write(path: Path, result: Curves | ArcContours, unit: str) -> None:
    """Write each curve as a SPLINE with its very poles and knots, contours of arcs as LWPOLYLINEs with bulges.

    Layers are the names, the unit is that of the coordinates.
    """
    drawing = ezdxf.new("R2010", units=_CODES[unit])  # type: ignore[attr-defined]
    drawn: Sequence[Arcs | BSpline] = result.arcs if isinstance(result, ArcContours) else result.curves
    for each, name in zip(drawn, result.names or [""] * len(drawn), strict=True):
        if name and name not in drawing.layers:
            drawing.layers.add(name)
        attributes = {"layer": name or "0"}
        if isinstance(each, Arcs):
            _add_arcs(drawing.modelspace(), each, attributes)
        else:
            _add_spline(drawing.modelspace(), each, attributes)
    drawing.saveas(path)


def _add_spline(space: Any, curve: BSpline, attributes: dict[str, Any]) -> None:
    flat = curve.poles.shape[1] == 2
    poles = np.column_stack([curve.poles, np.zeros(len(curve.poles))]) if flat else curve.poles
    spline = space.add_spline(degree=DEGREE, dxfattribs=attributes)
    spline.control_points, spline.knots = poles.tolist(), curve.knots.tolist()
    spline.dxf.flags = 8 * flat + curve.closed


def _add_arcs(space: Any, arcs: Arcs, attributes: dict[str, Any]) -> None:
    if arcs.plane != "xy":
        raise ValueError(f"polylines with bulges lie in the plane xy, not in {arcs.plane}")
    rows = np.column_stack([arcs.starts[:, :2], np.tan(0.25 * arcs.sweeps)])
    if not arcs.closed:
        rows = np.concatenate([rows, [[*arcs.ends[-1, :2], 0.0]]])
    level = {"elevation": float(arcs.starts[0, 2])} if arcs.starts.shape[1] == 3 else {}
    space.add_lwpolyline(rows.tolist(), format="xyb", close=arcs.closed, dxfattribs=attributes | level)


def _entities(parents: Any, others: list[str]) -> Iterator[Any]:
    """Yield the contours in a layout or block, blocks taken apart; note what is none."""
    for entity in parents:
        kind = entity.dxftype()
        if kind == "INSERT":
            yield from _entities(entity.virtual_entities(), others)
        elif kind in _CONTOURS or kind == "SPLINE":
            yield entity
        else:
            others.append(f"{kind} (handle {entity.dxf.handle})")


def _contours(entity: Any) -> list[Contour]:
    """Return the contours of an entity: one, or several of a polyline that is not in one piece."""
    layer = str(entity.dxf.layer)
    if entity.dxftype() == "SPLINE":
        spline = _cubic(entity)
        return [Contour(spline.pieces(), layer, False, spline)]
    contours = []
    for path in make_path(entity, segments=ARC_PIECES).sub_paths():
        start, straight, pieces = np.array(path.start.xyz), True, []
        for command in path.commands():
            end = np.array(command.end.xyz)
            if isinstance(command, Curve4To):
                straight = False
                pieces.append(np.array([start, command.ctrl1.xyz, command.ctrl2.xyz, end]))
            elif isinstance(command, LineTo) and not np.array_equal(start, end):
                pieces.append(segment(start, end))
            start = end
        if pieces:
            contours.append(Contour(np.stack(pieces), layer, straight))
    if not all(np.isfinite(contour.pieces).all() for contour in contours):
        raise ValueError("a coordinate is not finite")
    return contours


def _cubic(entity: Any) -> BSpline:
    """Return the spline of a SPLINE entity; raises ValueError where no cubic equals it."""
    if not len(entity.control_points):
        raise ValueError("given by fit points alone, which do not say what the curve is")
    tool = entity.construction_tool()
    weights = np.array(tool.weights() or [1.0])
    if tool.degree > DEGREE or np.ptp(weights) > 0.0:
        what = "a rational spline" if tool.degree <= DEGREE else f"a spline of degree {tool.degree}"
        raise ValueError(f"{what}, which no cubic equals")
    knots = np.array(entity.knots)  # those of the tool are rounded
    if tool.degree == DEGREE:
        return BSpline(np.array([p.xyz for p in tool.control_points]), knots)
    if tool.degree < 1 or len(set(knots[: tool.degree + 1])) > 1 or len(set(knots[-tool.degree - 1 :])) > 1:
        raise ValueError("a spline whose ends are not clamped")
    pieces = [np.array([p.xyz for p in each]) for each in tool.bezier_decomposition()]
    if tool.degree == 1:
        cubic = [segment(*each) for each in pieces]
    else:
        cubic = [np.stack([a, a + 2.0 / 3.0 * (b - a), c + 2.0 / 3.0 * (b - c), c]) for a, b, c in pieces]
    joined = np.concatenate([*(piece[:3] for piece in cubic), cubic[-1][3:]])
    return BSpline(joined, np.repeat(np.arange(len(cubic) + 1.0), [4, *[3] * (len(cubic) - 1), 4]))
