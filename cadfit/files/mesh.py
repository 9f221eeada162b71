"""Meshes through trimesh: .stl, .3mf, .ply, .glb, .obj."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

_MILLIMETRES = {"mm": 1.0, "m": 1000.0, "inch": 25.4}
_STATED = {"micron": 1e-3, "centimeter": 10.0, "inch": 25.4, "foot": 304.8, "meter": 1000.0}  # 3MF's names
_SINGLE = (".stl", ".ply", ".glb")  # these hold 32-bit numbers


def read(path: Path, unit: str) -> Any:
    """Return the `trimesh.Trimesh` of a mesh file, the parts of a scene in one; a 3MF's coordinates in the unit.

    Raises ValueError when the file is not what its suffix says or has no faces.
    """
    import trimesh

    unreadable = f"{path}: not a readable {path.suffix.lower()} file"
    try:
        mesh = trimesh.load_mesh(path)
    except ModuleNotFoundError as error:
        if error.name != "charset_normalizer":  # which trimesh asks about bytes that are no mesh of its
            raise
        raise ValueError(f"{unreadable}: cut short, or of another kind") from error
    except Exception as error:  # each of trimesh's readers has its own ways to fail on a broken file
        raise ValueError(f"{unreadable}: {str(error) or type(error).__name__}") from error
    if not isinstance(mesh, trimesh.Trimesh) or len(mesh.faces) == 0:
        raise ValueError(f"{unreadable}: no faces in it")
    if path.suffix.lower() == ".3mf":
        factor = _STATED.get(str(mesh.units), 1.0) / _MILLIMETRES[unit]
        if factor != 1.0:
            mesh.apply_scale(factor)  # type: ignore[no-untyped-call]
    return mesh


def write(path: Path, mesh: Any, unit: str) -> None:
    """Write a `trimesh.Trimesh`; `unit` is that of its coordinates, for 3MF, which is written in millimetres.

    Raises ValueError when different vertices would become one in the 32-bit numbers of STL, PLY and GLB, as they do
    far from the origin.
    """
    suffix = path.suffix.lower()
    vertices = np.asarray(mesh.vertices)
    if suffix in _SINGLE and (lost := _distinct(vertices) - _distinct(vertices.astype(np.float32))):
        raise ValueError(
            f"{suffix} holds 32-bit numbers, in which {lost} of {len(vertices)} vertices would fall on others: "
            "move the mesh to the origin, or write .3mf or .obj"
        )
    if "uv" in getattr(mesh, "face_attributes", {}):
        if suffix in (".glb", ".obj"):
            from cadfit.sweeping.texture import textured

            mesh = textured(mesh)
        else:  # the others have no place for it
            mesh = mesh.copy()
            del mesh.face_attributes["uv"]
    if suffix == ".3mf" and unit != "mm":
        mesh = mesh.copy()
        mesh.apply_scale(_MILLIMETRES[unit])
    options = {}
    if suffix == ".obj":  # trimesh writes 8 decimals, whatever the size
        size = float(np.abs(vertices).max(initial=1e-300))
        options["digits"] = int(np.clip(16 - np.floor(np.log10(size)), 0, 300))
    mesh.export(path, file_type=suffix[1:], **options)


def _distinct(vertices: Any) -> int:
    return len(np.unique(np.ascontiguousarray(vertices), axis=0))
