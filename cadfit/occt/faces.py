"""Plane faces between closed curves."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

import numpy as np
from OCP.BRepBuilderAPI import BRepBuilderAPI_MakeFace
from OCP.gp import gp_Ax3, gp_Dir, gp_Pln, gp_Pnt
from OCP.TopoDS import TopoDS_Face

from cadfit.bezier import Array
from cadfit.bspline import BSpline
from cadfit.joining import Splines, splines_of
from cadfit.occt.kernel import CONFUSION, KernelError, building
from cadfit.occt.shapes import to_wire
from cadfit.regions import inside, meeting, signed_area

_EPS = float(np.finfo(np.float64).eps)


def to_face(outer: Splines, holes: Iterable[Splines] = ()) -> TopoDS_Face:
    """Return the plane face inside a closed curve, less the holes.

    `outer` and each of `holes`: a spline, a fit, or splines that follow each other, closed, in 2D or in one plane of
    3D. In 2D the face lies in z = 0 and its normal is +z, whichever way the curves run; in 3D `outer` runs
    counterclockwise about the normal. Poles and knots reach the kernel unchanged, but for the direction of curves that
    run the other way round.

    Raises ValueError saying which curve is not closed and by how much, not in one plane, crosses or touches itself or
    another and where, or which hole is outside; KernelError where the kernel refuses.

    >>> from cadfit import cardinal_spline
    >>> disc = to_face(cardinal_spline([(1, 0), (0, 1), (-1, 0), (0, -1)], curvature=1.0, closed=True))
    """
    if isinstance(holes, BSpline) or hasattr(holes, "curves"):
        raise ValueError("holes must be a list of closed curves, one for each hole, not one curve")
    loops = [splines_of(outer), *(splines_of(hole) for hole in holes)]
    names = ["the outer curve", *(f"hole {k}" for k in range(len(loops) - 1))]
    for name, loop in zip(names, loops, strict=True):
        if (gap := float(np.linalg.norm(loop[-1].poles[-1] - loop[0].poles[0]))) > CONFUSION:
            raise ValueError(f"{name} is not closed: its end is {gap:.6g} away from its start")
    plane = loops[0][0].poles.shape[1] == 2 and all(curve.poles.shape[1] == 2 for loop in loops for curve in loop)
    origin, axes = (np.zeros(3), np.eye(3)) if plane else _plane([_poles(loop) for loop in loops], names)
    flat = [_pieces(loop, origin, axes) for loop in loops]
    areas = [signed_area(pieces) for pieces in flat]
    if not plane and areas[0] < 0:  # the normal for which the outer curve runs counterclockwise
        axes = axes[[1, 0, 2]] * [[1.0], [1.0], [-1.0]]
        flat, areas = [pieces[:, :, ::-1] for pieces in flat], [-area for area in areas]
    _check(flat, names, origin, axes)
    directions = [1.0, *[-1.0] * (len(loops) - 1)]
    wires = [
        to_wire(loop if area * direction > 0 else [curve.reversed() for curve in reversed(loop)])
        for loop, area, direction in zip(loops, areas, directions, strict=True)
    ]
    with building(f"a face with {len(loops) - 1} hole(s)"):
        system = gp_Ax3(gp_Pnt(*origin.tolist()), gp_Dir(*axes[2].tolist()), gp_Dir(*axes[0].tolist()))
        make = BRepBuilderAPI_MakeFace(gp_Pln(system), wires[0], True)
        for wire in wires[1:]:
            make.Add(wire)
        if not make.IsDone():
            raise KernelError(make.Error().name.removeprefix("BRepBuilderAPI_"))
        return make.Face()


def _poles(loop: Sequence[BSpline]) -> Array:
    """Return the poles (n, 3) of a loop, 2D ones in z = 0."""
    poles = [np.column_stack([c.poles, np.zeros((len(c.poles), 3 - c.poles.shape[1]))]) for c in loop]
    return np.concatenate(poles)


def _pieces(loop: Sequence[BSpline], origin: Array, axes: Array) -> Array:
    """Return a loop's Bézier pieces (m, 4, 2) in the plane's coordinates, closed to the last bit."""
    d = loop[0].poles.shape[1]
    pieces = np.concatenate([(curve.pieces() - origin[:d]) @ axes[:2, :d].T for curve in loop])
    pieces[:-1, 3] = pieces[1:, 0]
    pieces[-1, 3] = pieces[0, 0]
    return pieces


def _plane(poles: list[Array], names: list[str]) -> tuple[Array, Array]:
    """Return the middle of the outer curve's poles and three axes, rows, the third across the plane they lie in."""
    origin = poles[0].mean(axis=0)
    size, axes = np.linalg.svd(poles[0] - origin, full_matrices=False)[1:]
    if size[1] <= 1e-9 * size[0]:
        raise ValueError("the outer curve lies on a line: it bounds no area")
    axes[2] = np.cross(axes[0], axes[1])
    for name, those in zip(names, poles, strict=True):
        off = float(np.abs((those - origin) @ axes[2]).max())
        if off > CONFUSION + 64 * _EPS * float(np.abs(those).max()):
            raise ValueError(f"{name} is not planar: it leaves the plane by up to {off:.6g}")
    return origin, axes


def _check(loops: list[Array], names: list[str], origin: Array, axes: Array) -> None:
    """Raise ValueError where loops cross or touch, lie outside the first, or one in another."""
    found = meeting(loops)
    if found:
        first, second, flat = found
        at = ", ".join(f"{value:.6g}" for value in origin + flat @ axes[:2])
        other = "itself" if first == second else names[max(first, second)]
        raise ValueError(f"{names[min(first, second)]} crosses or touches {other} at ({at})")
    for k, loop in enumerate(loops[1:], start=1):
        if not inside(loop, loops[0]):
            raise ValueError(f"{names[k]} is outside the outer curve")
        for j, around in enumerate(loops[1:], start=1):
            if j != k and inside(loop, around):
                raise ValueError(f"{names[k]} is inside {names[j]}")
