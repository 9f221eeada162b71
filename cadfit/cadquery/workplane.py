"""Workplane methods: fitted splines drawn as CadQuery draws its own."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import TypeVar

import cadquery as cq
import numpy as np
from cadquery.cq import CombineMode, CQObject, VectorLike

from cadfit.bezier import Array
from cadfit.bspline import BSpline
from cadfit.cadquery.fits import HowToFit, ProfileOptions, fitted, fitted_profile
from cadfit.cadquery.points import Points, as_array, curve_of, in_one_space, in_world, listed
from cadfit.cadquery.shapes import to_face, to_tube, to_wire
from cadfit.fitting.approximate import Between, Corners, Effort
from cadfit.fitting.cardinal import cardinal_spline
from cadfit.fitting.local import local_spline
from cadfit.occt import CONFUSION
from cadfit.occt.checks import Caps
from cadfit.points.parametrize import Parametrization
from cadfit.stages import Progress, shares
from cadfit.sweeping.laws import Law

T = TypeVar("T", bound=cq.Workplane)


class Workplane(cq.Workplane):
    """
    CadQuery's Workplane with cadfit's methods, for those who want them typed and `cadquery.Workplane` left as it is.

    `register` adds the same methods to `cadquery.Workplane` itself.
    """

    def fitSpline(
        self: T,
        points: Points | None,
        tolerance: float,
        closed: bool | None = None,
        corners: Corners = "auto",
        between: Between = "curve",
        effort: Effort = "best",
        tangents: Sequence[VectorLike] | None = None,
        forConstruction: bool = False,
        includeCurrent: bool = False,
        makeWire: bool = False,
        progress: Progress | None = None,
    ) -> T:
        """
        Draw C2 cubic splines within a certified tolerance of points (2D or 3D), with few poles.

        :param points: points in order, in local coordinates: tuples, Vectors, or an array. Vertices, and with None the
            points on the stack, are taken where they are; so is an Edge or a Wire, which is refitted lighter
        :param tolerance: every point is within this distance of the curve, matched in order
        :param closed: whether the curve returns to its first point, C2 across the seam; None: when the last point
            repeats the first, to the kernel's 1e-7
        :param corners: the points where one edge ends and the next begins, kept exactly: "auto" finds those that stand
            out, an angle in radians those that turn by more; or rows of the points, or None
        :param between: "curve" when the points are samples of something smooth: no wiggles or overshoot between them.
            "polyline" when they are the shape's own vertices: the curve is within the tolerance there, too
        :param effort: "best", or "fast" for a fourth of the time and some 14 % more poles
        :param tangents: the directions at the start and the end, in local coordinates
        :param forConstruction: whether the edges are for reference: they do not become pending
        :param includeCurrent: use the current point as the first one
        :param makeWire: put one wire on the stack instead of the edges, one for each part between corners
        :param progress: a callable that is given the part that is done, from 0 to 1; what it raises stops the work
        :return: a Workplane with the edges or the wire on its stack
        :raises ValueError: for bad points, naming the row, and a tolerance that cannot be held

        This draws a closed outline within 0.02 of 60 points, and extrudes it::

            turn = np.linspace(0, 2 * np.pi, 60, endpoint=False)
            outline = np.column_stack([20 * np.cos(turn), 12 * np.sin(turn)])
            part = Workplane("XZ").fitSpline(outline, 0.02, closed=True).close().extrude(5)
        """
        given, world = gathered(self, points, includeCurrent)
        ends = None if tangents is None else _directions(self, tangents, world)
        how: HowToFit = {"closed": closed, "corners": corners, "between": between, "effort": effort}
        found = fitted(given, tolerance, ends, **how | {"progress": progress})
        return drawn(self, found.curves, world, forConstruction, makeWire)

    def cardinalSpline(
        self: T,
        points: Points | None,
        tension: float = 0.5,
        curvature: float = 0.0,
        closed: bool = False,
        forConstruction: bool = False,
        includeCurrent: bool = False,
        makeWire: bool = False,
    ) -> T:
        """
        Draw the C2 cardinal spline through points (2D or 3D): no system is solved, nothing far away moves.

        :param points: as for :meth:`fitSpline`
        :param tension: the tangent at a point is this times the difference of its neighbours
        :param curvature: the part of the points' second difference to restore there: with 0 the curve is flat at
            every point, 1 follows an arc
        :param closed: whether the curve returns to its first point, C2 across the seam (``periodic`` in
            :meth:`spline`)
        :param forConstruction: whether the edge is for reference: it does not become pending
        :param includeCurrent: use the current point as the first one
        :param makeWire: put a wire on the stack instead of the edge
        :return: a Workplane with the edge or the wire on its stack
        :raises ValueError: for bad points and equal neighbours, naming the row

        See :func:`cadfit.cardinal_spline` for what it does to the curvature.
        """
        given, world = gathered(self, points, includeCurrent)
        return drawn(
            self, [cardinal_spline(as_array(given), tension, curvature, closed)], world, forConstruction, makeWire
        )

    def localSpline(
        self: T,
        points: Points | None,
        parametrization: Parametrization = "centripetal",
        closed: bool = False,
        forConstruction: bool = False,
        includeCurrent: bool = False,
        makeWire: bool = False,
    ) -> T:
        """
        Draw the C2 spline through points (2D or 3D), with derivatives estimated from five neighbours.

        :param points: as for :meth:`fitSpline`
        :param parametrization: "centripetal", "chord" or "uniform"
        :param closed: whether the curve returns to its first point, C2 across the seam (``periodic`` in
            :meth:`spline`)
        :param forConstruction: whether the edge is for reference: it does not become pending
        :param includeCurrent: use the current point as the first one
        :param makeWire: put a wire on the stack instead of the edge
        :return: a Workplane with the edge or the wire on its stack
        :raises ValueError: for bad points and equal neighbours, naming the row

        See :func:`cadfit.local_spline` for its errors and how it takes uneven spacing.
        """
        given, world = gathered(self, points, includeCurrent)
        return drawn(self, [local_spline(as_array(given), closed, parametrization)], world, forConstruction, makeWire)

    def fitProfile(
        self: T,
        points: Points,
        tolerance: float,
        holes: Iterable[Points] = (),
        corners: Corners = "auto",
        between: Between = "curve",
        effort: Effort = "best",
        forConstruction: bool = False,
        progress: Progress | None = None,
    ) -> T:
        """
        Draw a closed outline of points, and holes in it, for each item on the stack, ready to extrude.

        :param points: the outline in order, about the item on the stack as for :meth:`rect`; closed whether the last
            point repeats the first or not. Vertices are taken where they are, and drawn once
        :param tolerance: every point is within this distance of its curve
        :param holes: the outlines of holes, each as `points`
        :param corners: as for :meth:`fitSpline`
        :param between: as for :meth:`fitSpline`
        :param effort: as for :meth:`fitSpline`
        :param forConstruction: whether the wires are for reference: they do not become pending
        :param progress: as for :meth:`fitSpline`
        :return: a Workplane with the wires on its stack, outline before holes
        :raises ValueError: as :meth:`fitSpline`, and where outlines cross themselves or each other, leave their plane,
            or a hole is outside, saying where

        This extrudes a ring of two scanned outlines at two places::

            part = Workplane().pushPoints([(0, 0), (80, 0)]).fitProfile(outer, 0.02, [inner]).extrude(3)
        """
        how: ProfileOptions = {"corners": corners, "between": between, "effort": effort, "progress": progress}
        given = listed(points)
        outer, *inner = fitted_profile(given, tolerance, holes, **how)
        return profiled(self, to_face(outer, inner), in_world(given), forConstruction)

    def fitTube(
        self: T,
        points: Points | None,
        radius: Law,
        tolerance: float,
        thickness: float | None = None,
        caps: Caps = "flat",
        closed: bool | None = None,
        corners: Corners = "auto",
        between: Between = "curve",
        effort: Effort = "best",
        includeCurrent: bool = False,
        combine: CombineMode = True,
        clean: bool = True,
        progress: Progress | None = None,
    ) -> T:
        """
        Make a tube along points (2D or 3D): round, square to its path, mitred at corners.

        :param points: the centreline in order, as for :meth:`fitSpline`
        :param radius: to the outside: a number, a function of the path's parameter, or a 1D spline
        :param tolerance: every point is within this distance of the path, and the wall of the path's exact tube
        :param thickness: of the wall of a hollow tube; solid where left out
        :param caps: how it ends, "flat" or "round"
        :param closed: as for :meth:`fitSpline`
        :param corners: as for :meth:`fitSpline`
        :param between: as for :meth:`fitSpline`
        :param effort: as for :meth:`fitSpline`
        :param includeCurrent: use the current point as the first one
        :param combine: True or "a" to combine the tube with parent solids if found, "cut" or "s" to remove it from
            them, False to keep it separate
        :param clean: call :meth:`clean` afterwards to have a clean shape
        :param progress: as for :meth:`fitSpline`
        :return: a Workplane with the resulting solid on its stack
        :raises ValueError: as :meth:`fitSpline`, and where there is no such solid, naming the place: the path bends
            more tightly than the radius allows, say
        """
        given, world = gathered(self, points, includeCurrent)
        how: HowToFit = {"closed": closed, "corners": corners, "between": between, "effort": effort}
        fitting, making = shares(progress, 2)
        path = fitted(given, tolerance, **how | {"progress": fitting})
        tube = to_tube(path, radius, tolerance, thickness, caps, making)
        return self._combineWithBase(tube if world else tube.moved(self.plane.location), combine, clean)


def gathered(base: cq.Workplane, points: Points | None, includeCurrent: bool) -> tuple[Points, bool]:
    """Return points, the current one first if asked for, and whether they are in the world, not on the workplane."""
    given = base if points is None else listed(points)
    world = in_world(given)
    if not includeCurrent:
        return given, world
    if (shape := curve_of(given)) is not None:
        raise ValueError(f"a {shape.ShapeType()} is refitted as it is: no includeCurrent")
    current = np.array([base._findFromPoint(not world).toTuple()])
    if abs(current[0, 2]) <= CONFUSION:  # on the plane, but for rounding
        current = current[:, :2]
    return np.concatenate(in_one_space(current, as_array(given))), world


def drawn(base: T, curves: Sequence[BSpline], world: bool, forConstruction: bool, makeWire: bool) -> T:
    """Return the workplane with curves that follow each other drawn on it."""
    wire = to_wire(curves)
    if not world:
        wire = wire.moved(base.plane.location)
    edges = wire.Edges()
    for shape in (wire, *edges):
        shape.forConstruction = forConstruction
    if not forConstruction:
        if makeWire:
            base._addPendingWire(wire)
        else:
            for edge in edges:
                base._addPendingEdge(edge)
    return base.newObject([wire] if makeWire else edges)


def profiled(base: T, face: cq.Face, world: bool, forConstruction: bool) -> T:
    """Return the workplane with a face's wires drawn at each item on the stack, or once where it is in the world."""
    if world:
        base = base.newObject([base.plane.origin])
        face = face.moved(base.plane.location.inverse)
    placed: list[CQObject] = []
    for wire in (face.outerWire(), *face.innerWires()):
        wire.forConstruction = forConstruction
        placed += base.eachpoint(wire, True, clean=False).vals()  # cleaning would join edges at corners
    return base.newObject(placed)


def _directions(base: cq.Workplane, tangents: Sequence[VectorLike], world: bool) -> Array:
    """Return directions on the workplane (2, 2 or 3), turned into the world's axes where the points are there."""
    array = as_array(tangents)
    if not world:
        return array
    return as_array([base.plane.toWorldCoords(tuple(row)) - base.plane.origin for row in array.tolist()])
