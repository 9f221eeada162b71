"""Drawings as SVG: paths of cubic Béziers written as they are, in millimetres; read with transforms and units."""

from __future__ import annotations

import re
import warnings
from collections.abc import Sequence
from itertools import count
from pathlib import Path
from typing import Any
from xml.sax.saxutils import quoteattr

import numpy as np

from cadfit.arcing.result import Arcs
from cadfit.bezier import Array
from cadfit.files.contours import ARC_PIECES, Contour, found, segment
from cadfit.files.curves import ArcContours, Curves
from cadfit.files.facts import extremes

_MILLIMETRES = {"mm": 1.0, "m": 1000.0, "inch": 25.4}
_PIXEL = 25.4 / 96.0  # millimetres
_LENGTHS = {"mm": 1.0, "cm": 10.0, "in": 25.4, "pt": 25.4 / 72.0, "pc": 25.4 / 6.0, "px": _PIXEL, "": _PIXEL}
_NUMBER = r"[+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?"
_COUNTS = {"M": 2, "L": 2, "H": 1, "V": 1, "C": 6, "S": 4, "Q": 4, "T": 2, "A": 7, "Z": 0}


def read(path: Path, unit: str) -> Curves:
    """Return the shapes named by their id, in `unit`, y upward; with the vertices of a single polyline.

    Transforms, the view box and units of the drawing are applied (a pixel is 1/96 inch). Cubics, quadratics and lines
    are taken over exactly, arcs as cubics within 1e-9 of their radius. Text and images are named in a warning.

    Raises ValueError with the line for broken XML and path data, and where no shape is in it.
    """
    try:
        from svgelements import SVG, Matrix, Shape
        from svgelements import Path as Outline
    except ImportError as error:
        raise ImportError("SVG files need svgelements: pip install 'cadfit[drawing]'") from error
    width = _checked(path)
    try:
        drawing = SVG.parse(str(path), reify=True)
        box = Matrix(drawing.viewbox_transform) if drawing.viewbox_transform else Matrix()
        contours = []
        for element in drawing.elements():
            if isinstance(element, Shape):
                contours += _contours(Outline(element).reify(), element.id or "")
    except Exception as error:
        raise ValueError(f"{path}: not a readable SVG file: {str(error) or type(error).__name__}") from error
    if not contours:
        raise ValueError(f"{path}: no paths or shapes in it")
    scale = _PIXEL / _MILLIMETRES[unit]
    if width and drawing.width:
        scale *= width / (_PIXEL * float(drawing.width))  # svgelements knows a millimetre to six digits
    origin = np.array([box.e, box.f])
    turned = [Contour((c.pieces - origin) * [scale, -scale], c.name, c.straight) for c in contours]
    if not all(np.isfinite(c.pieces).all() for c in turned):
        raise ValueError(f"{path}: a coordinate is not finite")
    return found(turned)


def write(path: Path, result: Curves | ArcContours, unit: str) -> None:
    """Write curves as cubic Béziers, arcs as elliptical arcs, at their true size, the view box just around them."""
    scale = _MILLIMETRES[unit]
    if isinstance(result, ArcContours):
        t = np.linspace(0.0, 1.0, 65)
        box = np.concatenate([arcs(k, t) for arcs in result.arcs for k in range(len(arcs))])[:, :2]
        drawn = [_of_arcs(arcs) for arcs in result.arcs]
    else:
        box = np.concatenate([extremes(curve) for curve in result.curves])[:, :2]
        drawn = [_of_pieces(curve.pieces()) for curve in result.curves]
    (left, low), (right, high) = box.min(axis=0).tolist(), box.max(axis=0).tolist()
    wide, tall = right - left, high - low
    lines = [
        '<?xml version="1.0" encoding="UTF-8"?>',
        f'<svg xmlns="http://www.w3.org/2000/svg" width="{wide * scale!r}mm" height="{tall * scale!r}mm" '
        f'viewBox="{left!r} {-high!r} {wide!r} {tall!r}">',
    ]
    for name, data in zip(_unique(result.names) or [""] * len(drawn), drawn, strict=True):
        named = f" id={quoteattr(name)}" if name else ""
        lines.append(f'<path{named} d="{data}" fill="none" stroke="#000" stroke-width="{0.002 * max(wide, tall)!r}"/>')
    path.write_text("\n".join([*lines, "</svg>", ""]), encoding="utf-8")


def _unique(names: Sequence[str]) -> list[str]:
    """Return the names, those that stood before with a number, as ids may not repeat."""
    ids: list[str] = []
    taken, seen = set(names), set[str]()
    for name in names:
        new = name
        if name and name in seen:
            new = next(each for k in count(2) if (each := f"{name}-{k}") not in taken)
        taken.add(new)
        seen.add(name)
        ids.append(new)
    return ids


def _of_pieces(pieces: Array) -> str:
    """Return the path data of Bézier pieces (m, 4, d), y downward."""
    flat = pieces[..., :2] * [1.0, -1.0]
    data = [f"M{_numbers(flat[0, 0])}", *(f"C{_numbers(piece[1:])}" for piece in flat)]
    return "".join(data) + "Z" * bool(np.array_equal(flat[0, 0], flat[-1, 3]))


def _of_arcs(arcs: Arcs) -> str:
    ends = arcs.ends[:, :2] * [1.0, -1.0]
    data = [f"M{_numbers(arcs.starts[0, :2] * [1.0, -1.0])}"]
    for end, radius, sweep in zip(ends, arcs.radii.tolist(), arcs.sweeps.tolist(), strict=True):
        flags = f"{int(abs(sweep) > np.pi)} {int(sweep < 0.0)}"  # rounding may leave a small arc more than half a turn
        data.append(f"A{radius!r} {radius!r} 0 {flags} {_numbers(end)}" if sweep else f"L{_numbers(end)}")
    return "".join(data) + "Z" * arcs.closed


def _numbers(values: Array) -> str:
    return " ".join(map(repr, (values + 0.0).ravel().tolist()))


def _checked(path: Path) -> float:
    """Return the drawing's width in millimetres, 0 where it does not say.

    Raises ValueError for what svgelements would pass over, and warns of what is not drawn with curves.
    """
    from lxml import etree

    try:
        root = etree.parse(str(path), etree.XMLParser(resolve_entities=False, no_network=True)).getroot()
    except (etree.XMLSyntaxError, OSError) as error:  # the second for bytes that are not the file's encoding
        raise ValueError(f"{path}: not an SVG file: {error}") from None
    if etree.QName(root).localname != "svg":
        raise ValueError(f"{path}: not an SVG file: its outermost element is {etree.QName(root).localname}")
    others = []
    for element in root.iter(etree.Element):
        kind = etree.QName(element).localname
        if kind == "path" and (wrong := _wrong(element.get("d") or "")):
            raise ValueError(f"{path}: line {element.sourceline}: path data: {wrong}")
        if kind in ("text", "image", "foreignObject"):
            others.append(f"{kind} (line {element.sourceline})")
    if others:
        warnings.warn(f"{path}: not curves, and left out: {', '.join(others)}", stacklevel=3)
    width = re.fullmatch(rf"\s*({_NUMBER})\s*(mm|cm|in|pt|pc|px|)\s*", root.get("width", ""))
    return float(width.group(1)) * _LENGTHS[width.group(2)] if width else 0.0


def _wrong(data: str) -> str:
    """Return what is wrong with path data, or nothing."""
    if junk := re.search(rf"(?!{_NUMBER})[^MmZzLlHhVvCcSsQqTtAa\s,]", re.sub(_NUMBER, " ", data)):
        return f"{junk.group()!r} is no command or number"
    if data.strip() and data.strip()[0] not in "Mm":
        return "it must begin with M"
    for command, numbers in re.findall(r"([A-DF-Za-df-z])([^A-DF-Za-df-z]*)", data):
        width = _COUNTS[command.upper()]
        given = len(re.findall(_NUMBER, numbers))
        if command in "Aa":
            continue  # flags may stand without a blank between: 00 or 11
        if (width == 0 and given) or (width and (given == 0 or given % width)):
            return f"{command} with {given} numbers"
    return ""


def _contours(outline: Any, name: str) -> list[Contour]:
    """Return the contours of a path of svgelements."""
    from svgelements import Arc, Close, CubicBezier, Line, Move, QuadraticBezier

    contours: list[Contour] = []
    pieces: list[Array] = []
    straight = True
    for part in [*outline, Move(0)]:
        if isinstance(part, Move):
            if pieces:
                contours.append(Contour(np.stack(pieces), name, straight))
            pieces, straight = [], True
            continue
        start, end = _point(part.start), _point(part.end)
        if isinstance(part, Line | Close):
            if not np.array_equal(start, end):
                pieces.append(segment(start, end))
            continue
        straight = False
        if isinstance(part, CubicBezier):
            pieces.append(np.stack([start, _point(part.control1), _point(part.control2), end]))
        elif isinstance(part, QuadraticBezier):
            control = _point(part.control)
            pieces.append(np.stack([start, start + (control - start) * 2 / 3, end + (control - end) * 2 / 3, end]))
        elif isinstance(part, Arc):
            pieces += _of_ellipse(part, start, end)
    return contours


def _of_ellipse(arc: Any, start: Array, end: Array) -> list[Array]:
    """Return cubic pieces of an elliptical arc."""
    centre = _point(arc.center)
    axes = np.stack([_point(arc.prx) - centre, _point(arc.pry) - centre])
    angle = arc.get_start_t() + float(arc.sweep) * np.linspace(0.0, 1.0, ARC_PIECES + 1)
    unit = np.column_stack([np.cos(angle), np.sin(angle)])
    handle = 4.0 / 3.0 * np.tan(0.25 * float(arc.sweep) / ARC_PIECES) * np.column_stack([-unit[:, 1], unit[:, 0]])
    points, handles = centre + unit @ axes, handle @ axes
    points[0], points[-1] = start, end
    return [
        np.stack([points[k], points[k] + handles[k], points[k + 1] - handles[k + 1], points[k + 1]])
        for k in range(ARC_PIECES)
    ]


def _point(point: Any) -> Array:
    return np.array([float(point.x), float(point.y)])
