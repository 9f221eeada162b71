"""Points in numpy's own files, .npy and .npz, without pickle."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from cadfit.bezier import Array
from cadfit.files.table import as_table


def read(path: Path, unit: str) -> Array:
    """Return the points of a .npy file; of a .npz file the array called "points", or the only one of rows of numbers.

    Raises ValueError for anything but a 2D array of whole or real numbers.
    """
    with path.open("rb") as file:  # numpy leaves a broken archive open
        try:
            loaded = np.load(file, allow_pickle=False)
            array = loaded if isinstance(loaded, np.ndarray) else _chosen(loaded)
        except Exception as error:  # broken heads and archives fail in many ways: as text, as a zip, when inflated
            raise ValueError(f"{path}: not a readable {path.suffix.lower()} file: {error}") from error
    if array.dtype.kind not in "iuf":
        raise ValueError(f"{path}: points are whole or real numbers, not {array.dtype}")
    return as_table(array, str(path))


def write(path: Path, points: Array, unit: str) -> None:
    """Write the points (n, d) as float64; in a .npz file they are called "points"."""
    with path.open("wb") as file:  # to a name that ends with .NPY numpy would add .npy
        if path.suffix.lower() == ".npz":
            np.savez(file, points=points)
        else:
            np.save(file, points, allow_pickle=False)


def _chosen(archive: Any) -> np.ndarray[Any, Any]:
    if "points" in archive:
        return np.asarray(archive["points"])
    arrays = {name: archive[name] for name in archive.files}
    tables = [array for array in arrays.values() if isinstance(array, np.ndarray) and array.ndim == 2]
    if len(tables) != 1:
        shapes = ", ".join(f"{name} {getattr(array, 'shape', '')}" for name, array in arrays.items())
        raise ValueError(f'which array are the points? Call one "points"; there are: {shapes or "none"}')
    return tables[0]
