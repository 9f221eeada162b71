"""Curves through the CAD kernel: .step, .stp and .brep."""

from __future__ import annotations

from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np

from cadfit import occt
from cadfit.bspline import BSpline
from cadfit.files.curves import Curves


def read(path: Path, unit: str) -> Curves:
    """Return the edges of a file as `Curves`, in the order they are found; 3D, in `unit` (BREP: as the numbers are).

    Raises ValueError naming the first edge that no non-rational cubic equals, and where there is no edge.
    """
    shapes = occt.read_brep(path) if path.suffix.lower() == ".brep" else occt.read_step(path, unit)
    curves = []
    for k, edge in enumerate(occt.edges(shapes)):
        try:
            curves.append(occt.from_edge(edge))
        except ValueError as error:
            raise ValueError(f"{path}: edge {k}: {error}") from error
    if not curves:
        raise ValueError(f"{path}: no edges in it")
    return Curves(tuple(curves), all(_meet(a, b) for a, b in pairwise([*curves, curves[0]])))


def write(path: Path, result: Curves | Any, unit: str) -> None:
    """Write each curve as an edge, several that follow each other end to end as one wire; a kernel's shape as it is."""
    shapes = result
    if isinstance(result, Curves):
        curves = result.curves
        chained = len(curves) > 1 and all(_meet(a, b) for a, b in pairwise(curves))
        shapes = occt.to_wire(curves) if chained else curves
    if path.suffix.lower() == ".brep":
        occt.write_brep(path, shapes)
    else:
        occt.write_step(path, shapes, unit)


def _meet(before: BSpline, after: BSpline) -> bool:
    return bool(np.linalg.norm(before.poles[-1] - after.poles[0]) <= occt.CONFUSION)
