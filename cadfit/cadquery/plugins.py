"""cadfit's curves for `invoke`, and its methods for CadQuery's own classes."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Protocol, TypeVar, Unpack, cast

import cadquery as cq

from cadfit.bspline import BSpline
from cadfit.cadquery.fits import FitOptions, ProfileOptions, fitted, fitted_profile
from cadfit.cadquery.points import Points, in_world, listed
from cadfit.cadquery.shapes import to_face
from cadfit.cadquery.sketch import Sketch, sketched
from cadfit.cadquery.workplane import Workplane, drawn, profiled
from cadfit.fitting.result import Fit
from cadfit.joining import Splines, splines_of

Base = TypeVar("Base", bound=cq.Workplane | cq.Sketch)


class Drawing(Protocol):
    """What `invoke` takes: a function that draws on a Workplane or in a Sketch, and returns it."""

    def __call__(self, base: Base, /) -> Base:
        """Return the workplane or the sketch with the curves drawn."""
        ...


class FitDrawing(Drawing, Protocol):
    """A drawing of a fit."""

    fit: Fit
    """What is drawn: its curves, its deviation from the points, what was cleaned."""


class ProfileDrawing(Drawing, Protocol):
    """A drawing of a profile."""

    fits: tuple[Fit, ...]
    """What is drawn: the outline's fit, then the holes'."""


def draw(curves: Splines, forConstruction: bool = False, makeWire: bool = False, tag: str | None = None) -> Drawing:
    """
    Return what `invoke` takes to draw ready curves, in local coordinates.

    :param curves: a spline, a fit, or splines that follow each other
    :param forConstruction: whether they are for reference: they do not become pending
    :param makeWire: on a Workplane, put one wire on the stack instead of the edges
    :param tag: names the result

    Here are splines through points, from cadfit's own functions::

        part = Workplane().invoke(draw(cadfit.local_spline(points, closed=True))).close().extrude(2)
    """
    return _drawing(splines_of(curves), False, forConstruction, makeWire, tag)


def fit_spline(
    points: Points,
    tolerance: float,
    forConstruction: bool = False,
    makeWire: bool = False,
    tag: str | None = None,
    **options: Unpack[FitOptions],
) -> FitDrawing:
    """
    Return what `invoke` takes to draw C2 splines within a certified tolerance of points.

    :param points: points in order, as for :meth:`Workplane.fitSpline`
    :param tolerance: every point is within this distance of the curve
    :param options: `closed`, `corners`, `between`, `effort`, `tangents`, `progress`, as for :meth:`Workplane.fitSpline`
    :return: a function for `invoke`, with the fit made as `.fit`
    :raises ValueError: for bad points, naming the row, and a tolerance that cannot be held

    The points are fitted once, wherever the result is drawn::

        outline = fit_spline(points, 0.02)
        print(outline.fit.deviation.points, outline.fit.poles)
        part = Workplane("XZ").invoke(outline).close().extrude(300)
        sketch = Sketch().invoke(outline).assemble()
    """
    given = listed(points)
    found = fitted(given, tolerance, **options)
    drawing = cast(FitDrawing, _drawing(found.curves, in_world(given), forConstruction, makeWire, tag))
    drawing.fit = found
    return drawing


def fit_profile(
    points: Points,
    tolerance: float,
    holes: Iterable[Points] = (),
    forConstruction: bool = False,
    tag: str | None = None,
    **options: Unpack[ProfileOptions],
) -> ProfileDrawing:
    """
    Return what `invoke` takes to draw a closed outline and its holes: wires on a Workplane, a face in a Sketch.

    :param points: the outline in order, as for :meth:`Workplane.fitProfile`
    :param tolerance: every point is within this distance of its curve
    :param holes: the outlines of holes, each as `points`
    :param forConstruction: whether the wires are for reference: they do not become pending; nothing to a Sketch
    :param tag: names the result
    :param options: `corners`, `between`, `effort` and `progress`, as for :meth:`Workplane.fitSpline`
    :return: a function for `invoke`, with the fits made as `.fits`, the outline's before the holes'
    :raises ValueError: as :meth:`Workplane.fitProfile`
    """
    given = listed(points)
    outer, *inner = found = fitted_profile(given, tolerance, holes, **options)
    face, world = to_face(outer, inner), in_world(given)

    def drawing(base: Base, /) -> Base:
        if isinstance(base, cq.Sketch):
            return base.face(face, tag=tag)
        made = profiled(base, face, world, forConstruction)
        return made.tag(tag) if tag else made

    whole = cast(ProfileDrawing, drawing)
    whole.fits = found
    return whole


def _drawing(curves: Sequence[BSpline], world: bool, forConstruction: bool, makeWire: bool, tag: str | None) -> Drawing:
    def drawing(base: Base, /) -> Base:  # a plain function of one argument: `invoke` counts them in its code
        if isinstance(base, cq.Sketch):
            return sketched(base, curves, tag, forConstruction)
        made = drawn(base, curves, world, forConstruction, makeWire)
        return made.tag(tag) if tag else made

    return drawing


def register(names: Sequence[str] | None = None) -> None:
    """
    Add cadfit's methods to `cadquery.Workplane` and `cadquery.Sketch`, for this process.

    :param names: which ones; all of them where left out
    :raises ValueError: where either class has another method of that name, naming it, and for a name that is not
        ours; then nothing was added

    They are `fitSpline`, `cardinalSpline`, `localSpline`, `fitProfile`, and for Workplane `fitTube`. Calling it again
    changes nothing. Type checkers do not see methods that are added; our own :class:`Workplane` and :class:`Sketch`
    have them typed.
    """
    ours = {(host, name): method for host, source in _SOURCES for name, method in _methods(source).items()}
    known = {name for _, name in ours}
    if strangers := [name for name in names or () if name not in known]:
        raise ValueError(f"cadfit has no method {strangers[0]!r} to register: they are {', '.join(sorted(known))}")
    wanted = {key: method for key, method in ours.items() if names is None or key[1] in names}
    for (host, name), method in wanted.items():
        if getattr(host, name, method) is not method:
            raise ValueError(f"cadquery.{host.__name__} already has a {name}; leave it out: register([...])")
    for (host, name), method in wanted.items():
        setattr(host, name, method)


_SOURCES: tuple[tuple[type, type], ...] = ((cq.Workplane, Workplane), (cq.Sketch, Sketch))


def _methods(source: type) -> dict[str, object]:
    return {name: value for name, value in vars(source).items() if callable(value) and not name.startswith("_")}
