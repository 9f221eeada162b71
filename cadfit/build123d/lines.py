"""Line objects: fitted splines that are drawn as build123d draws its own."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np
from build123d import BaseEdgeObject, BaseLineObject, Mode, VectorLike

from cadfit.build123d.fits import Points, PointsOrEdge, as_array, fitted, passed
from cadfit.build123d.shapes import to_edge, to_wire
from cadfit.fitting.approximate import Between, Corners, Effort
from cadfit.fitting.cardinal import cardinal_spline
from cadfit.fitting.local import local_spline
from cadfit.fitting.result import Fit
from cadfit.points.clean import clean
from cadfit.points.parametrize import Parametrization, parametrize
from cadfit.stages import Progress


class FitSpline(BaseLineObject):
    """Line Object: Fit Spline

    Create smooth splines within a certified tolerance of points, with few poles: a wire of one
    edge (`edge()` is it), or of several where corners split it.

    Args:
        points (VectorLike | Vertex sequence, array, Edge or Wire): points in order, or an edge
            or a wire to be refitted lighter (`simplify`)
        tolerance (float): every point is within this distance of the curve
        closed (bool, optional): return to the first point, smooth across the seam. Defaults to
            None: if the last point repeats the first
        corners ("auto" | float | Iterable[int], optional): where one edge ends and the next
            begins, kept exactly: "auto" finds those that stand out, a number of radians those
            that turn by more; or indices of the points, or None. Defaults to "auto"
        between ("curve" | "polyline", optional): "curve" if the points are samples of something
            smooth: no wiggles or overshoot between them; "polyline" if they are the shape's own
            vertices: within the tolerance between them, too. Defaults to "curve"
        effort ("best" | "fast", optional): "fast" takes a fourth of the time and some 14 % more
            poles. Defaults to "best"
        tangents (Iterable[VectorLike], optional): directions at start and end. Defaults to None
        progress (Callable[[float], None], optional): is given the part that is done, from 0 to 1;
            what it raises stops the work. Defaults to None
        mode (Mode, optional): combination mode. Defaults to Mode.ADD

    Attributes:
        fit (cadfit.Fit): the splines, their deviation from the points, poles, what was cleaned

    Raises:
        ValueError: bad points, naming the row; a tolerance that cannot be held

    >>> turn = np.linspace(0, 2 * np.pi, 100, endpoint=False)
    >>> ring = FitSpline(np.column_stack([5 * np.cos(turn), 5 * np.sin(turn)]), 0.001, closed=True)
    >>> round(ring.length / 10, 3), ring.is_closed, ring.fit.deviation.points <= 0.001
    (3.142, True, True)
    """

    fit: Fit

    def __init__(
        self,
        points: PointsOrEdge,
        tolerance: float,
        closed: bool | None = None,
        corners: Corners = "auto",
        between: Between = "curve",
        effort: Effort = "best",
        tangents: Iterable[VectorLike] | None = None,
        progress: Progress | None = None,
        mode: Mode = Mode.ADD,
    ):
        self.fit = fitted(points, tolerance, closed, corners, between, effort, tangents, progress)
        super().__init__(to_wire(self.fit), mode=mode)


class CardinalSpline(BaseEdgeObject):
    """Line Object: Cardinal Spline

    Create the C2 cardinal spline through points: no system is solved, nothing far away moves.

    Args:
        points (VectorLike | Vertex sequence, or array): points in order
        tension (float, optional): the tangent at a point is this times the difference of its
            neighbours. Defaults to 0.5
        curvature (float, optional): the part of the points' second difference to restore there:
            with 0 the curve is flat at every point, with 1 it follows an arc. Defaults to 0
        closed (bool, optional): return to the first point, smooth across the seam. Defaults to
            None: if the last point repeats the first
        mode (Mode, optional): combination mode. Defaults to Mode.ADD

    Attributes:
        fit (cadfit.Fit): the spline, its deviation from the polyline, what was cleaned

    Raises:
        ValueError: bad points, naming the row

    >>> CardinalSpline([(0, 0), (2, 1), (4, 0)]).fit.poles
    7
    """

    fit: Fit

    def __init__(
        self,
        points: Points,
        tension: float = 0.5,
        curvature: float = 0.0,
        closed: bool | None = None,
        mode: Mode = Mode.ADD,
    ):
        cleaned = clean(as_array(points), closed)
        spline = cardinal_spline(cleaned.points, tension, curvature, cleaned.closed)
        low, high = spline.domain
        at = 3.0 * np.arange(len(cleaned.points)) - (not cleaned.closed)
        self.fit = passed(spline, cleaned, np.clip(at, low, high))
        super().__init__(to_edge(spline), mode=mode)


class LocalSpline(BaseEdgeObject):
    """Line Object: Local Spline

    Create the C2 spline through points with derivatives estimated from five neighbours: no
    system is solved, nothing far away moves, and uneven spacing does not overshoot.

    Args:
        points (VectorLike | Vertex sequence, or array): points in order
        closed (bool, optional): return to the first point, smooth across the seam. Defaults to
            None: if the last point repeats the first
        parametrization ("centripetal" | "chord" | "uniform", optional): how parameters follow
            the spacing. Defaults to "centripetal"
        mode (Mode, optional): combination mode. Defaults to Mode.ADD

    Attributes:
        fit (cadfit.Fit): the spline, its deviation from the polyline, what was cleaned

    Raises:
        ValueError: bad points, naming the row

    >>> arch = LocalSpline([(0, 0), (1, 2), (1, 2), (4, 2), (5, 0)])
    >>> arch @ 1, arch.fit.cleaned
    (Vector(5, 0, 0), array([2]))
    """

    fit: Fit

    def __init__(
        self,
        points: Points,
        closed: bool | None = None,
        parametrization: Parametrization = "centripetal",
        mode: Mode = Mode.ADD,
    ):
        cleaned = clean(as_array(points), closed)
        spline = local_spline(cleaned.points, cleaned.closed, parametrization)
        at = parametrize(cleaned.points, parametrization, cleaned.closed)[: len(cleaned.points)]
        self.fit = passed(spline, cleaned, at)
        super().__init__(to_edge(spline), mode=mode)
