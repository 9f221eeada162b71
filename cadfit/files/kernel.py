"""Curves through the CAD kernel: .step, .stp, .brep, .iges and .igs."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np

from cadfit import occt
from cadfit.bspline import BSpline
from cadfit.files.curves import Curves

_IGES = (".iges", ".igs")


def read(path: Path, unit: str) -> Curves:
    """Return the edges of a file as `Curves`, in the order they are found; 3D, in `unit` (BREP: as the numbers are).

    Raises ValueError naming the first edge that no non-rational cubic equals, and where there is no edge.
    """
    shapes, scale = _shapes(path, unit)
    curves = []
    for k, edge in enumerate(occt.edges(shapes)):
        try:
            curve = occt.from_edge(edge)
            curves.append(curve if scale == 1.0 else curve.transformed(scale * np.eye(3)))
        except ValueError as error:
            raise ValueError(f"{path}: edge {k}: {error}") from error
    if not curves:
        raise ValueError(f"{path}: no edges in it")
    return Curves(tuple(curves), all(_meet(a, b) for a, b in pairwise([*curves, curves[0]])))


@dataclass(frozen=True, slots=True, eq=False)
class Solids:
    """The kernel's shapes of which some have faces, and what their lengths are to be multiplied with."""

    shapes: tuple[Any, ...]
    scale: float


def solids(path: Path, unit: str) -> Solids | None:
    """Return the shapes of a file, where they have faces, else None: then there are curves for `read`."""
    shapes, scale = _shapes(path, unit)
    return Solids(shapes, scale) if occt.faces(shapes) else None


def write(path: Path, result: Curves | Any, unit: str) -> None:
    """Write each curve as an edge, several that follow each other as one wire; a kernel's shape as it is.

    In IGES curves are edges, in millimetres.
    """
    shapes: Any = result
    names: tuple[str, ...] = ()
    suffix = path.suffix.lower()
    if isinstance(result, Curves):
        curves, names = result.curves, result.names
        chained = len(curves) > 1 and all(_meet(a, b) for a, b in pairwise(curves))
        shapes = occt.to_wire(curves) if chained and suffix not in _IGES else curves
    if suffix == ".brep":
        occt.write_brep(path, shapes)
    elif suffix in _IGES:
        scale = occt.UNITS[unit]
        occt.write_iges(path, [c if scale == 1.0 else c.transformed(scale * np.eye(c.poles.shape[1])) for c in shapes])
    else:
        occt.write_step(path, shapes, unit, names)


def _shapes(path: Path, unit: str) -> tuple[tuple[Any, ...], float]:
    """Return the shapes of a file, and what their lengths are to be multiplied with for the unit."""
    suffix = path.suffix.lower()
    if suffix in _IGES:
        return (occt.read_iges(path),), 1.0 / occt.UNITS[unit]
    return (occt.read_brep(path),) if suffix == ".brep" else occt.read_step(path, unit), 1.0


def _meet(before: BSpline, after: BSpline) -> bool:
    return bool(np.linalg.norm(before.poles[-1] - after.poles[0]) <= occt.CONFUSION)
