"""Shapes measured: the volume within faces and their area, by Gauss' rule on what the kernel evaluates of each.

The kernel's own integrals do not see every span: on walls of 2,000 sections they were up to 1 % off, on revolved and
extruded splines up to 20 %, however precise they are asked to be.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from itertools import product

import numpy as np
from OCP.Bnd import Bnd_Box
from OCP.BRepAdaptor import BRepAdaptor_Surface
from OCP.BRepBndLib import BRepBndLib
from OCP.BRepCheck import BRepCheck_Analyzer
from OCP.BRepGProp import BRepGProp
from OCP.GeomAbs import GeomAbs_Shape, GeomAbs_SurfaceType
from OCP.gp import gp_Pnt, gp_Vec
from OCP.GProp import GProp_GProps
from OCP.TopAbs import TopAbs_Orientation
from OCP.TopoDS import TopoDS_Face, TopoDS_Shape

from cadfit.bezier import Array
from cadfit.occt.kernel import Reals
from cadfit.occt.shapes import faces

_NODES, _WEIGHTS = np.polynomial.legendre.leggauss(6)


def volume_and_area(shape: TopoDS_Shape) -> tuple[float, float]:
    """Return the volume within the faces of a closed shell and their area, by Gauss' rule between any two knots.

    Each face must be a plane or fill its surface's rectangle, as the walls and ends of our solids do, and as what the
    kernel extrudes, revolves or lofts from wires does; of an open shape the area alone means something.
    """
    volume = area = 0.0
    origin: Array | None = None
    for face in faces(shape):
        places, normals = _plane(face) if _is_plane(face) else _patch(face)
        if origin is None:
            origin = places[0].copy()  # near the shape, so that a far one loses no digits
        flux = float(np.einsum("nd,nd->", places - origin, normals)) / 3.0
        volume += -flux if face.Orientation() == TopAbs_Orientation.TopAbs_REVERSED else flux
        area += float(np.linalg.norm(normals, axis=1).sum())
    return volume, area


def is_valid(shapes: Iterable[TopoDS_Shape]) -> bool:
    """Whether the kernel finds all of the shapes valid."""
    return all(BRepCheck_Analyzer(shape).IsValid() for shape in shapes)


def box(shapes: Iterable[TopoDS_Shape]) -> Array:
    """Return the lowest and the highest corner (2, 3) of the shapes, as near as the kernel finds them."""
    found = Bnd_Box()
    for shape in shapes:
        BRepBndLib.AddOptimal_s(shape, found, False, False)
    return np.array([found.CornerMin().Coord(), found.CornerMax().Coord()])


def _is_plane(face: TopoDS_Face) -> bool:
    return bool(BRepAdaptor_Surface(face).GetType() == GeomAbs_SurfaceType.GeomAbs_Plane)


def _plane(face: TopoDS_Face) -> tuple[Array, Array]:
    """Return a place (1, 3) on a plane face and its normal, as long as the face is large."""
    found = GProp_GProps()
    BRepGProp.SurfaceProperties_s(face, found, 1e-9)
    at, along, across = gp_Pnt(), gp_Vec(), gp_Vec()
    BRepAdaptor_Surface(face).D1(0.0, 0.0, at, along, across)
    return np.array([at.Coord()]), found.Mass() * np.array([along.Crossed(across).Coord()])


def _patch(face: TopoDS_Face) -> tuple[Array, Array]:
    """Return places (n, 3) on a face that fills its surface's rectangle, and normals there as long as their shares."""
    surface = BRepAdaptor_Surface(face)
    u, heights = _places(surface.NbUIntervals, surface.UIntervals)
    v, widths = _places(surface.NbVIntervals, surface.VIntervals)
    at, along, across, rows = gp_Pnt(), gp_Vec(), gp_Vec(), []
    for here in product(u, v):
        surface.D1(*here, at, along, across)
        rows.append((*at.Coord(), *along.Coord(), *across.Coord()))
    values = np.array(rows)
    shares = np.outer(heights, widths).ravel()
    return values[:, :3], shares[:, None] * np.cross(values[:, 3:6], values[:, 6:])


def _places(count: Callable[..., int], ends: Callable[..., None]) -> tuple[list[float], Array]:
    """Return Gauss' places between any two knots, and their weights."""
    knots = Reals(1, count(GeomAbs_Shape.GeomAbs_CN) + 1)
    ends(knots, GeomAbs_Shape.GeomAbs_CN)
    bounds = np.array([*knots])
    half = 0.5 * np.diff(bounds)[:, None]
    return (bounds[:-1, None] + half * (1.0 + _NODES)).ravel().tolist(), (half * _WEIGHTS).ravel()
