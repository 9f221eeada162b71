"""Sketch methods: fitted splines as a sketch's edges, and fitted profiles as its faces."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import TypeVar

import cadquery as cq
from cadquery.cq import VectorLike
from cadquery.sketch import Modes

from cadfit.bspline import BSpline
from cadfit.cadquery.fits import HowToFit, ProfileOptions, fitted, fitted_profile
from cadfit.cadquery.points import Points, as_array
from cadfit.cadquery.shapes import to_face, to_wire
from cadfit.fitting.approximate import Between, Corners, Effort
from cadfit.fitting.cardinal import cardinal_spline
from cadfit.fitting.local import local_spline
from cadfit.points.parametrize import Parametrization
from cadfit.stages import Progress

T = TypeVar("T", bound=cq.Sketch)


class Sketch(cq.Sketch):
    """
    CadQuery's Sketch with cadfit's methods, for those who want them typed and `cadquery.Sketch` left as it is.

    `register` adds the same methods to `cadquery.Sketch` itself.
    """

    def fitSpline(
        self: T,
        pts: Points,
        tolerance: float,
        closed: bool | None = None,
        corners: Corners = "auto",
        between: Between = "curve",
        effort: Effort = "best",
        tangents: Sequence[VectorLike] | None = None,
        tag: str | None = None,
        forConstruction: bool = False,
        progress: Progress | None = None,
    ) -> T:
        """
        Construct C2 spline edges within a certified tolerance of points, one for each part between corners.

        :param pts: points in order: tuples, Vectors, Vertices or an array
        :param tag: names all of the edges

        The other parameters are those of :meth:`Workplane.fitSpline`.
        """
        how: HowToFit = {"closed": closed, "corners": corners, "between": between, "effort": effort}
        found = fitted(pts, tolerance, tangents, **how | {"progress": progress})
        return sketched(self, found.curves, tag, forConstruction)

    def cardinalSpline(
        self: T,
        pts: Points,
        tension: float = 0.5,
        curvature: float = 0.0,
        closed: bool = False,
        tag: str | None = None,
        forConstruction: bool = False,
    ) -> T:
        """
        Construct a C2 cardinal spline edge through points; see :meth:`Workplane.cardinalSpline`.
        """
        return sketched(self, [cardinal_spline(as_array(pts), tension, curvature, closed)], tag, forConstruction)

    def localSpline(
        self: T,
        pts: Points,
        parametrization: Parametrization = "centripetal",
        closed: bool = False,
        tag: str | None = None,
        forConstruction: bool = False,
    ) -> T:
        """
        Construct a C2 spline edge through points from local estimates; see :meth:`Workplane.localSpline`.
        """
        return sketched(self, [local_spline(as_array(pts), closed, parametrization)], tag, forConstruction)

    def fitProfile(
        self: T,
        pts: Points,
        tolerance: float,
        holes: Iterable[Points] = (),
        corners: Corners = "auto",
        between: Between = "curve",
        effort: Effort = "best",
        angle: float = 0,
        mode: Modes = "a",
        tag: str | None = None,
        progress: Progress | None = None,
    ) -> T:
        """
        Construct the face within a closed outline of points, less holes, for each item selected.

        :param pts: the outline in order, closed whether its last point repeats the first or not
        :param holes: the outlines of holes, each as `pts`
        :param angle: turns the face, in degrees
        :param mode: how to combine: "a", "s", "i", "r" or "c", as for :meth:`polygon`

        The other parameters are those of :meth:`Workplane.fitSpline`.
        """
        how: ProfileOptions = {"corners": corners, "between": between, "effort": effort, "progress": progress}
        outer, *inner = fitted_profile(pts, tolerance, holes, **how)
        return self.face(to_face(outer, inner), angle, mode, tag)


def sketched(base: T, curves: Sequence[BSpline], tag: str | None, forConstruction: bool) -> T:
    """Return the sketch with curves that follow each other added to its edges."""
    edges = to_wire(curves).Edges()
    for edge in edges:
        base.edge(edge, None, forConstruction)
    if tag:
        base._tag(edges, tag)
    return base
