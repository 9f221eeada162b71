"""Faces with shared edges around rails: closed shells and solids, made without sewing, boolean or search."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from OCP.BRep import BRep_Builder, BRep_Tool
from OCP.BRepBuilderAPI import BRepBuilderAPI_MakeEdge, BRepBuilderAPI_MakeVertex
from OCP.BRepLib import BRepLib
from OCP.Geom import Geom_Curve, Geom_Plane, Geom_Surface
from OCP.Geom2d import Geom2d_Line
from OCP.gp import gp_Ax3, gp_Dir, gp_Dir2d, gp_Pnt, gp_Pnt2d
from OCP.TopAbs import TopAbs_Orientation
from OCP.TopExp import TopExp
from OCP.TopoDS import TopoDS_Edge, TopoDS_Face, TopoDS_Shell, TopoDS_Solid, TopoDS_Vertex, TopoDS_Wire

from cadfit.bezier import Array
from cadfit.bspline import DEGREE, BSpline
from cadfit.occt import geometry
from cadfit.occt.kernel import CONFUSION
from cadfit.occt.profiles import Loop, outline

Ring = list[TopoDS_Edge]

_ALONG, _ACROSS = gp_Dir2d(0.0, 1.0), gp_Dir2d(1.0, 0.0)
_SMOOTH_EDGE = 1e-5  # radians: faces that meet at a smaller angle are one surface to whoever draws them


def wall(loop: Loop, rails: Sequence[BSpline], closed: bool, flat_ends: bool) -> tuple[list[TopoDS_Face], Ring, Ring]:
    """Return the faces a loop sweeps out along rails (n, 9), and the edges of its first and last ring.

    A face for each arc and rail, outward to the right of the loop; where both are straight, a plane with straight
    edges. Neighbours share their edges, so with `closed` (two rails or more) the last rail ends on the first ring.
    `flat_ends`: plane faces, or none, are put on the ends.
    """
    stands = [rail.poles[0] for rail in rails] + ([] if closed else [rails[-1].poles[-1]])
    corners = np.array([arc.poles[0] for arc in loop])
    places = [swept(stand, corners) for stand in stands]
    vertices = [[_vertex(place) for place in row] for row in places]
    quads = [[_plane(places[k], places[(k + 1) % len(places)], j) for j in range(len(loop))] for k in range(len(rails))]
    plane = [
        [quad if _straight(rail) and arc.degree == 1 else None for quad, arc in zip(row, loop, strict=True)]
        for row, rail in zip(quads, rails, strict=True)
    ]
    rings = []
    for k, (stand, around) in enumerate(zip(stands, vertices, strict=True)):
        beside = [plane[row % len(rails)] for row in (k - 1, k) if closed or 0 <= row < len(rails)]
        straight = [
            all(row[j] is not None for row in beside) and (flat_ends or len(beside) == 2) for j in range(len(loop))
        ]
        rings.append(_ring(loop, stand, around, straight))
    faces = []
    for row, rail in enumerate(rails):
        above = (row + 1) % len(rings)
        poles = swept(rail.poles, corners)  # (rail's, corners, 3)
        sides = []
        for j in range(len(loop)):
            ends = vertices[row][j], vertices[above][j]
            if plane[row][j] is not None and plane[row][j - 1] is not None:
                sides.append(BRepBuilderAPI_MakeEdge(*ends).Edge())
            else:
                sides.append(_edge(geometry.curve(poles[:, j], rail.knots, DEGREE), *ends, rail.domain))
        for j, arc in enumerate(loop):
            edges = rings[row][j], sides[(j + 1) % len(sides)], rings[above][j], sides[j]
            grid = swept(rail.poles, arc.poles).transpose(1, 0, 2)
            weights = np.broadcast_to(arc.weights[:, None], grid.shape[:2])
            surface = plane[row][j] or geometry.surface(grid, (arc.knots, rail.knots), (arc.degree, DEGREE), weights)
            faces.append(_patch(surface, edges))
    return faces, rings[0], rings[-1]


def _straight(rail: BSpline) -> bool:
    """Return whether a rail is a straight line run through evenly."""
    steps = np.diff(rail.poles, axis=0)
    return len(steps) == DEGREE and bool(np.abs(steps - steps[0]).max() <= 1e-13 * np.abs(rail.poles).max())


def _plane(below: Array, above: Array, j: int) -> Geom_Plane | None:
    """Return the plane, seen from outside, of the corners j and j + 1 of two rings (k, 3), None where there is none."""
    k = (j + 1) % len(below)
    normal = np.cross(above[k] - below[j], above[j] - below[k])
    size = float(np.linalg.norm(normal))
    ends = np.array([below[j], below[k], above[j], above[k]])
    middle = ends.mean(axis=0)
    if size == 0.0 or np.abs((ends - middle) @ normal).max() > 1e-13 * size * np.abs(ends).max():
        return None
    return Geom_Plane(gp_Pnt(*middle.tolist()), gp_Dir(*normal.tolist()))


def swept(rail: Array, places: Array) -> Array:
    """Return the poles (..., k, 3) that places (k, 2) of a profile have for poles (..., 9) of a rail.

    >>> swept(np.array([5.0, 0, 0, 1, 0, 0, 0, 1, 0]), np.array([[2.0, 3.0]]))
    array([[7., 3., 0.]])
    """
    origin, f, g = np.split(rail[..., None, :], 3, axis=-1)
    return np.asarray(origin + places[:, :1] * f + places[:, 1:] * g)


def dome(loop: Loop, stand: Array, ring: Ring, outward: bool) -> list[TopoDS_Face]:
    """Return the faces of a round end over a ring, set up at the end (9,) of a rail; `outward`: it looks forward.

    Each place of the ring runs in a quarter of an ellipse to the apex, as far beyond the path's end as the ring's
    farthest place is beside it: over a circle, half a ball. Source: `cadfit.sweeping.caps.dome`.
    """
    origin, f, g = stand.reshape(3, 3)
    axis = np.cross(f, g)
    rise = height(loop) * axis / np.sqrt(np.linalg.norm(axis)) * (1.0 if outward else -1.0)
    knots, bend = np.repeat([0.0, 1.0], 3), np.array([1.0, np.sqrt(0.5), 1.0])
    order = slice(None) if outward else slice(None, None, -1)  # from low to high along the path
    apex = _vertex(origin + rise)

    def quarters(poles: Array) -> Array:  # (k, 3, 3)
        ring_poles = swept(stand, poles)
        return np.stack([ring_poles, ring_poles + rise, np.broadcast_to(origin + rise, ring_poles.shape)], axis=1)

    meridians = []
    for poles, edge in zip(quarters(np.array([arc.poles[0] for arc in loop])), ring, strict=True):
        start, end = (TopExp.FirstVertex_s(edge), apex)[order]
        meridians.append(_edge(geometry.curve(poles[order], knots, 2, bend), start, end, (0.0, 1.0)))
    faces = []
    for k, arc in enumerate(loop):
        weights = arc.weights[:, None] * bend
        surface = geometry.surface(quarters(arc.poles)[:, order], (arc.knots, knots), (arc.degree, 2), weights)
        point = TopoDS_Edge()
        builder = BRep_Builder()
        builder.MakeEdge(point)
        builder.Add(point, apex.Oriented(TopAbs_Orientation.TopAbs_FORWARD))
        builder.Add(point, apex.Oriented(TopAbs_Orientation.TopAbs_REVERSED))
        builder.Degenerated(point, True)
        low, high = (ring[k], point)[order]
        faces.append(_patch(surface, (low, meridians[(k + 1) % len(meridians)], high, meridians[k])))
    return faces


def height(loop: Loop) -> float:
    """Return how far a loop reaches from the path, which is how high its dome is."""
    return float(np.linalg.norm(outline(loop), axis=1).max())


def cap(stand: Array, rings: Sequence[Ring], outward: bool) -> TopoDS_Face:
    """Return the plane face within rings at the end (9,) of a rail; `outward`: it looks forward along the path."""
    origin, f, g = stand.reshape(3, 3)
    normal = np.cross(f, g) * (1.0 if outward else -1.0)
    axes = gp_Ax3(gp_Pnt(*origin.tolist()), gp_Dir(*normal.tolist()), gp_Dir(*f.tolist()))
    face, builder = TopoDS_Face(), BRep_Builder()
    builder.MakeFace(face, Geom_Plane(axes), CONFUSION)
    for ring in rings:
        builder.Add(face, _wire(ring if outward else [_back(edge) for edge in ring[::-1]]))
    return face


def solid(shells: Sequence[Sequence[TopoDS_Face]]) -> TopoDS_Solid:
    """Return the solid bounded by closed shells, given as their faces, the outer one first."""
    out, builder = TopoDS_Solid(), BRep_Builder()
    builder.MakeSolid(out)
    for faces in shells:
        shell = TopoDS_Shell()
        builder.MakeShell(shell)
        for face in faces:
            builder.Add(shell, face)
        shell.Closed(True)
        builder.Add(out, shell)
    BRepLib.EncodeRegularity_s(out, _SMOOTH_EDGE)
    return out


def _ring(loop: Loop, stand: Array, vertices: Sequence[TopoDS_Vertex], straight: Sequence[bool]) -> Ring:
    """Return the edges of a loop set up at (9,), between the vertices at its arcs' starts."""
    ring = []
    for arc, start, end, line in zip(loop, vertices, [*vertices[1:], vertices[0]], straight, strict=True):
        if line:
            ring.append(BRepBuilderAPI_MakeEdge(start, end).Edge())
        else:
            curve = geometry.curve(swept(stand, arc.poles), arc.knots, arc.degree, arc.weights)
            ring.append(_edge(curve, start, end, (float(arc.knots[0]), float(arc.knots[-1]))))
    return ring


def _vertex(place: Array) -> TopoDS_Vertex:
    return BRepBuilderAPI_MakeVertex(gp_Pnt(*place.tolist())).Vertex()


def _edge(curve: Geom_Curve, start: TopoDS_Vertex, end: TopoDS_Vertex, domain: tuple[float, float]) -> TopoDS_Edge:
    edge, builder = TopoDS_Edge(), BRep_Builder()
    builder.MakeEdge(edge, curve, CONFUSION)
    builder.Add(edge, start.Oriented(TopAbs_Orientation.TopAbs_FORWARD))
    builder.Add(edge, end.Oriented(TopAbs_Orientation.TopAbs_REVERSED))
    builder.Range(edge, *domain)
    return edge


def _patch(surface: Geom_Surface, edges: tuple[TopoDS_Edge, TopoDS_Edge, TopoDS_Edge, TopoDS_Edge]) -> TopoDS_Face:
    """Return the face of a plane or a whole surface between edges that run with its parameters: low, last, high, first.

    On a plane the kernel finds the edges by itself.
    """
    face, builder = TopoDS_Face(), BRep_Builder()
    builder.MakeFace(face, surface, CONFUSION)
    low, last, high, first = edges
    if isinstance(surface, Geom_Plane):
        builder.Add(face, _wire([low, last, _back(high), _back(first)]))
        return face
    u0, u1, v0, v1 = surface.Bounds()
    lines = [(low, 0.0, v0, _ACROSS), (last, u1, 0.0, _ALONG), (high, 0.0, v1, _ACROSS), (first, u0, 0.0, _ALONG)]
    for edge, u, v, along in lines:
        builder.UpdateEdge(edge, Geom2d_Line(gp_Pnt2d(u, v), along), face, CONFUSION)
        if BRep_Tool.Degenerated_s(edge):
            builder.Range(edge, face, u0, u1)
    builder.Add(face, _wire([low, last, _back(high), _back(first)]))
    return face


def _back(edge: TopoDS_Edge) -> TopoDS_Edge:
    return edge.Oriented(TopAbs_Orientation.TopAbs_REVERSED)


def _wire(edges: Sequence[TopoDS_Edge]) -> TopoDS_Wire:
    wire, builder = TopoDS_Wire(), BRep_Builder()
    builder.MakeWire(wire)
    for edge in edges:
        builder.Add(wire, edge)
    wire.Closed(True)
    return wire
