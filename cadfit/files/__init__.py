"""Points, curves and meshes in files: one module a format, chosen by the suffix of the file's name."""

from __future__ import annotations

import errno
import os
from collections.abc import Sequence
from dataclasses import dataclass
from importlib import import_module
from pathlib import Path
from typing import Any, Literal

import numpy as np

from cadfit.bezier import Array
from cadfit.bspline import BSpline
from cadfit.files.curves import ArcContours as ArcContours
from cadfit.files.curves import Curves as Curves
from cadfit.files.table import as_table
from cadfit.replacing import replacing
from cadfit.stages import Progress, portion, stage, unheard

Kind = Literal["points", "curves", "arcs", "mesh", "solid"]


@dataclass(frozen=True, slots=True)
class Format:
    """One file format: the module here with its `read(path, unit)` and `write(path, result, unit)`, what it takes.

    With `tells` both take `progress` as well.
    """

    module: str
    takes: tuple[Kind, ...]
    dimensions: range = range(1, 1000)
    tells: bool = False


_KERNEL = Format("kernel", ("curves", "solid"), range(2, 4))
_MESH = Format("mesh", ("mesh",))

FORMATS = {
    ".csv": Format("text", ("points", "curves"), range(2, 9), tells=True),
    ".txt": Format("text", ("points",), range(2, 9), tells=True),
    ".xyz": Format("text", ("points",), range(2, 9), tells=True),
    ".dat": Format("text", (), tells=True),  # the airfoil formats, with a name in front: read only
    ".npy": Format("arrays", ("points",), range(2, 9)),
    ".npz": Format("arrays", ("points",), range(2, 9)),
    ".json": Format("jsons", ("points", "curves")),
    ".dxf": Format("dxf", ("curves", "arcs"), range(2, 4)),
    ".svg": Format("svg", ("curves", "arcs"), range(2, 3)),
    **dict.fromkeys((".step", ".stp", ".brep"), _KERNEL),
    **dict.fromkeys((".iges", ".igs"), Format("kernel", ("curves",), range(2, 4))),
    **dict.fromkeys((".stl", ".3mf", ".ply", ".glb", ".obj"), _MESH),
}


def read(path: str | os.PathLike[str], unit: str = "mm", progress: Progress | None = None) -> Any:
    """Return what is in a file: points (n, d), n >= 1, `Curves`, or a `trimesh.Trimesh`; see also `contents`.

    Points: .csv, .txt, .xyz, .dat (comma, semicolon, tab or blanks, `cadfit.files.text`), .npy, .npz, .json. Curves:
    .json, .step, .stp, .brep, .iges, .igs, and the drawings .dxf and .svg (`cadfit.files.contours`), of which a single
    polyline is points. Meshes: .stl, .3mf, .ply, .glb, .obj. A point file has 2 to 8 columns. `unit` is the
    length unit coordinates come back in where the file states its own (STEP, IGES, DXF, SVG). `progress` is called
    with the part that is done, from 0 to 1 (of a text file in steps, of others at the end); raising from it stops it.

    Raises ValueError naming the file, the line (counted from 1) and what was there; OSError for a file that cannot be
    read; ImportError naming the extra that is missing.

    >>> import pathlib, tempfile
    >>> path = pathlib.Path(tempfile.mkdtemp()) / "two.csv"
    >>> _ = path.write_text("x;y\\n1,5;2,5\\n3;4\\n")
    >>> read(path)
    array([[1.5, 2.5],
           [3. , 4. ]])
    """
    found = contents(path, unit, progress)
    vertices = found.vertices if isinstance(found, Curves) else None
    return found if vertices is None else vertices


def contents(path: str | os.PathLike[str], unit: str = "mm", progress: Progress | None = None) -> Any:
    """Return what `read` does, but of a drawing always `Curves`, with names; a single polyline's have `vertices`."""
    form, path = _opened(path), Path(path)
    with stage("reading"):
        module = import_module(f"cadfit.files.{form.module}")
        found = module.read(path, unit, progress or unheard) if form.tells else module.read(path, unit)
    portion(progress, 0.0, 1.0)(1.0)
    return found


def write(path: str | os.PathLike[str], result: Any, unit: str = "mm", progress: Progress | None = None) -> None:
    """Write points, curves or a mesh to a file; an old file stays whole until the new one is complete.

    `result`: points (n, d) for .csv, .txt, .xyz, .npy, .npz and .json; a `BSpline`, several, `Curves` or anything else
    with `curves`, `closed` and `deviation` for .step, .stp, .brep, .iges, .igs, .dxf, .svg, .json and .csv (the poles,
    one a row, curves apart by a blank line); `Arcs`, several or `ArcContours` for .dxf and .svg; a `trimesh.Trimesh`
    for .stl, .3mf, .ply, .glb and .obj; a shape of the kernel, such as `cadfit.occt.tube_solid` makes, for .step, .stp
    and .brep. `unit` ("mm", "m", "inch") is the unit of the coordinates, for STEP, IGES, DXF and SVG. JSON, CSV and NPY
    read back bit for bit. `progress`: as in `read`.

    Raises ValueError for an unknown suffix or one that cannot hold the result, saying which can; OSError naming a
    path that cannot be written; ImportError naming the extra that is missing.

    >>> import pathlib, tempfile
    >>> path = pathlib.Path(tempfile.mkdtemp()) / "line.json"
    >>> write(path, BSpline([[0, 0], [1, 0], [2, 0], [3, 0]], [0, 0, 0, 0, 1, 1, 1, 1]))
    >>> read(path).curves
    (BSpline(4 poles in 2D, 1 span, u in [0.0, 1.0]),)
    """
    path = Path(path)
    _format(path)
    kind, result = _sorted_out(result, str(path))
    check(path, kind, _dimension(kind, result))
    form = FORMATS[path.suffix.lower()]
    module = import_module(f"cadfit.files.{form.module}")
    with stage("writing"), replacing(path) as beside:
        try:
            if form.tells:
                module.write(beside, result, unit, progress or unheard)
            else:
                module.write(beside, result, unit)
        except ValueError as error:
            raise ValueError(f"{path}: {error}") from error
    portion(progress, 0.0, 1.0)(1.0)


def describe(path: str | os.PathLike[str], unit: str = "mm", progress: Progress | None = None) -> dict[str, str]:
    """Return names and values that say what is in a file: points, curves or a mesh, as `read`, or the kernel's faces.

    Raises as `read`.
    """
    from cadfit.files.facts import facts

    found = None
    if _opened(path).module == "kernel":
        with stage("reading"):
            found = import_module("cadfit.files.kernel").solids(Path(path), unit)
    if found is None:
        found = read(path, unit, progress)
    with stage("measuring"):
        return facts(found)


def check(path: str | os.PathLike[str], kind: Kind, dimension: int | None = None) -> None:
    """Raise ValueError unless the suffix of `path` can hold that kind of result, in that many coordinates.

    Raises ImportError naming the extra that writing it needs, where that is missing.

    >>> check("out.stl", "curves")
    Traceback (most recent call last):
    ValueError: out.stl: .stl does not hold curves; these do: .csv .json .dxf .svg .step .stp .brep .iges .igs
    """
    form = _format(path)
    suffix = Path(path).suffix.lower()
    if kind not in form.takes:
        others = " ".join(other for other, each in FORMATS.items() if kind in each.takes)
        raise ValueError(f"{path}: {suffix} does not hold {kind}; these do: {others}")
    if dimension is not None and dimension not in form.dimensions:
        low, high = form.dimensions[0], form.dimensions[-1]
        raise ValueError(f"{path}: {suffix} holds {kind} of {low} to {high} coordinates, not {dimension}; .json does")
    import_module(f"cadfit.files.{form.module}")


def _opened(path: str | os.PathLike[str]) -> Format:
    """Return the format of a file that is there; raises OSError in the system's words, and ValueError, where not."""
    path = Path(path)
    if path.is_dir():  # before the suffix: a folder has none
        raise IsADirectoryError(errno.EISDIR, os.strerror(errno.EISDIR), str(path))
    form = _format(path)
    if not path.exists():  # before a kernel or a mesh library says so in its own words
        raise FileNotFoundError(errno.ENOENT, os.strerror(errno.ENOENT), str(path))
    return form


def _dimension(kind: Kind, result: Any) -> int:
    if kind in ("curves", "arcs"):
        return int(result.dimension)
    return 3 if kind in ("mesh", "solid") else int(result.shape[1])


def _format(path: str | os.PathLike[str]) -> Format:
    suffix = Path(path).suffix.lower()
    if suffix not in FORMATS:
        raise ValueError(f"{path}: unknown suffix {suffix!r}; known are {' '.join(FORMATS)}")
    return FORMATS[suffix]


def _sorted_out(result: Any, where: str) -> tuple[Kind, Array | Curves | Any]:
    """Say what a result is, and give it in the one form the formats write."""
    if isinstance(result, BSpline):
        return "curves", Curves((result,), result.closed)
    if hasattr(result, "curves"):
        names = getattr(result, "names", ())
        return "curves", Curves(tuple(result.curves), result.closed, result.deviation, names)
    if isinstance(result, ArcContours):
        return "arcs", result
    if hasattr(result, "sweeps"):
        return "arcs", ArcContours((result,))
    if hasattr(result, "vertices") and hasattr(result, "faces"):
        return "mesh", result
    if hasattr(result, "ShapeType"):  # the kernel's own name for what a shape is
        return "solid", result
    if isinstance(result, Sequence) and result and all(isinstance(each, BSpline) for each in result):
        joined = np.array_equal(result[0].poles[0], result[-1].poles[-1])
        return "curves", Curves(tuple(result), joined)
    if isinstance(result, Sequence) and result and all(hasattr(each, "sweeps") for each in result):
        return "arcs", ArcContours(tuple(result))
    return "points", as_table(result, where)
