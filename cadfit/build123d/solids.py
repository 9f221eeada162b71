"""A sketch object and a part object: faces inside fitted outlines, tubes along fitted paths."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace

import numpy as np
from build123d import Align, BasePartObject, BaseSketchObject, Edge, Mode, RotationLike, Solid, Wire

from cadfit import occt
from cadfit.build123d.fits import PointsOrEdge, fitted
from cadfit.build123d.shapes import to_face
from cadfit.fitting.approximate import Between, Corners, Effort
from cadfit.fitting.result import Fit
from cadfit.occt.checks import Caps
from cadfit.stages import Progress, shares
from cadfit.sweeping.laws import Law


class FitProfile(BaseSketchObject):
    """Sketch Object: Fit Profile

    Create the face inside a closed outline of points, less holes, each curve within a certified
    tolerance of its points; ready to extrude, revolve, loft or sweep.

    Args:
        points (VectorLike | Vertex sequence, array, Edge or Wire): the outline in order, closed
            whether the last point repeats the first or not; an edge or a wire is refitted
        tolerance (float): every point is within this distance of its curve
        holes (Iterable, optional): the outlines of holes, each as `points`. Defaults to ()
        corners ("auto" | float | Iterable[int], optional): as for FitSpline. Defaults to "auto"
        between ("curve" | "polyline", optional): as for FitSpline. Defaults to "curve"
        effort ("best" | "fast", optional): as for FitSpline. Defaults to "best"
        rotation (float, optional): angle to rotate object. Defaults to 0
        align (Align | tuple[Align, Align], optional): align MIN, CENTER, or MAX of object.
            Defaults to None: where the points are
        progress (Callable[[float], None], optional): is given the part that is done, from 0 to 1;
            what it raises stops the work. Defaults to None
        mode (Mode, optional): combination mode. Defaults to Mode.ADD

    Attributes:
        fit (cadfit.Fit): the outline's splines, their deviation, poles, what was cleaned
        hole_fits (tuple[cadfit.Fit, ...]): the same of the holes

    Raises:
        ValueError: bad points, naming the row; outlines that leave the sketch's plane or cross
            themselves or each other, and where; holes outside the outline

    >>> FitProfile([(0, 0), (4, 0), (4, 3), (0, 3)], 0.01, between="polyline").area
    12.0
    """

    fit: Fit
    hole_fits: tuple[Fit, ...]

    def __init__(
        self,
        points: PointsOrEdge,
        tolerance: float,
        holes: Iterable[PointsOrEdge] = (),
        corners: Corners = "auto",
        between: Between = "curve",
        effort: Effort = "best",
        rotation: float = 0,
        align: Align | tuple[Align, Align] | None = None,
        progress: Progress | None = None,
        mode: Mode = Mode.ADD,
    ):
        outlines = [("the outline", points), *((f"hole {k}", hole) for k, hole in enumerate(holes))]
        parts = shares(progress, len(outlines))
        found = [
            _outline(name, each, tolerance, corners, between, effort, told)
            for (name, each), told in zip(outlines, parts, strict=True)
        ]
        self.fit, *inner = found
        self.hole_fits = tuple(inner)
        super().__init__(to_face(self.fit, self.hole_fits), rotation, align, mode)


class FitTube(BasePartObject):
    """Part Object: Fit Tube

    Create the tube along points: round, square to its path, mitred at corners.

    Args:
        points (VectorLike | Vertex sequence, array, Edge or Wire): the centre line in order; an
            edge or a wire is refitted
        radius (float | function | 1D BSpline): to the outside; a function of the path's parameter
        tolerance (float): every point is within this distance of the path, and the wall of the
            path's exact tube
        thickness (float, optional): of the wall of a hollow tube. Defaults to None: a solid one
        caps ("flat" | "round", optional): how it ends. Defaults to "flat"
        closed (bool, optional): as for FitSpline. Defaults to None
        corners ("auto" | float | Iterable[int], optional): as for FitSpline. Defaults to "auto"
        between ("curve" | "polyline", optional): as for FitSpline. Defaults to "curve"
        effort ("best" | "fast", optional): as for FitSpline. Defaults to "best"
        rotation (RotationLike, optional): angles to rotate about axes. Defaults to (0, 0, 0)
        align (Align | tuple[Align, Align, Align] | None, optional): align MIN, CENTER, or MAX of
            object. Defaults to None: where the points are
        progress (Callable[[float], None], optional): is given the part that is done, from 0 to 1;
            what it raises stops the work. Defaults to None
        mode (Mode, optional): combination mode. Defaults to Mode.ADD

    Attributes:
        fit (cadfit.Fit): the path's splines, their deviation, poles, what was cleaned

    Raises:
        ValueError: bad points, naming the row; no such solid, naming the place: the path bends
            more tightly than the radius allows, say

    >>> bar = FitTube([(0, 0, 0), (0, 0, 3), (0, 0, 5)], 1.0, 0.001)
    >>> round(bar.volume / 5, 3), bar.is_valid
    (3.142, True)
    """

    fit: Fit

    def __init__(
        self,
        points: PointsOrEdge,
        radius: Law,
        tolerance: float,
        thickness: float | None = None,
        caps: Caps = "flat",
        closed: bool | None = None,
        corners: Corners = "auto",
        between: Between = "curve",
        effort: Effort = "best",
        rotation: RotationLike = (0, 0, 0),
        align: Align | tuple[Align, Align, Align] | None = None,
        progress: Progress | None = None,
        mode: Mode = Mode.ADD,
    ):
        fitting, making = shares(progress, 2)
        self.fit = fitted(points, tolerance, closed, corners, between, effort, progress=fitting)
        try:
            solid = Solid(occt.tube_solid(self.fit, radius, tolerance, thickness=thickness, caps=caps, progress=making))
        except occt.KernelError as error:  # a path no tube fits round, which is a wrong value to the user
            raise ValueError(f"no tube: {str(error).removeprefix('no solid: ')}") from error
        super().__init__(solid, rotation, align, mode)


def _outline(
    name: str,
    points: PointsOrEdge,
    tolerance: float,
    corners: Corners,
    between: Between,
    effort: Effort,
    progress: Progress,
) -> Fit:
    """Return the closed fit, in 2D, to an outline in the sketch's plane."""
    try:
        closed = None if isinstance(points, Edge | Wire) else True
        found = fitted(points, tolerance, closed, corners, between, effort, progress=progress)
    except ValueError as error:
        raise ValueError(f"{name}: {error}") from None
    heights = found.points[:, 2:]
    if heights.size and np.abs(heights).max() > occt.CONFUSION:
        row = int(np.argmax(np.abs(heights[:, 0]) > occt.CONFUSION))
        raise ValueError(
            f"{name} leaves the sketch's plane: row {row} of its points has z = {heights[row, 0]:.6g}. Give local "
            "coordinates, and place the sketch: BuildSketch(plane), or plane * FitProfile(...)"
        )
    flat = np.eye(2, found.points.shape[1])
    return replace(found, curves=tuple(curve.transformed(flat) for curve in found.curves), points=found.points[:, :2])
