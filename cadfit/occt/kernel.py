"""The kernel itself: the differences of its versions, its failures."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

import OCP
from OCP.TopoDS import TopoDS

try:  # All that differs between the versions: OCP 8 gathers the collections, and its casts lost their suffix.
    from OCP.collections import Array1_double as Reals
    from OCP.collections import Array1_gp_Pnt as Points
    from OCP.collections import Array1_int as Integers
    from OCP.collections import Array2_double as RealGrid
    from OCP.collections import Array2_gp_Pnt as PointGrid
    from OCP.collections import HArray1_StepVisual_LayeredItem as LayeredItems
    from OCP.collections import IndexedMap_TopoDS_Shape_TopTools_ShapeMapHasher as Shapes

    as_edge, as_face, as_vertex, as_wire = TopoDS.Edge, TopoDS.Face, TopoDS.Vertex, TopoDS.Wire
except ImportError:
    from OCP.StepVisual import StepVisual_HArray1OfLayeredItem as LayeredItems
    from OCP.TColgp import TColgp_Array1OfPnt as Points
    from OCP.TColgp import TColgp_Array2OfPnt as PointGrid
    from OCP.TColStd import TColStd_Array1OfInteger as Integers
    from OCP.TColStd import TColStd_Array1OfReal as Reals
    from OCP.TColStd import TColStd_Array2OfReal as RealGrid
    from OCP.TopTools import TopTools_IndexedMapOfShape as Shapes

    as_edge, as_face, as_vertex, as_wire = TopoDS.Edge_s, TopoDS.Face_s, TopoDS.Vertex_s, TopoDS.Wire_s

PASSES_BACKSLASHES = not OCP.__version__.startswith("7.8.")
"""Whether STEP's texts are written as they are: 7.8 doubles each backslash."""

__all__ = [
    "CONFUSION",
    "PASSES_BACKSLASHES",
    "Integers",
    "KernelError",
    "LayeredItems",
    "PointGrid",
    "Points",
    "RealGrid",
    "Reals",
    "Shapes",
    "as_edge",
    "as_face",
    "as_vertex",
    "as_wire",
    "building",
]

CONFUSION = 1e-7
"""The distance below which the kernel takes two points for one (its Precision::Confusion), in its own unit."""


class KernelError(RuntimeError):
    """The kernel refused or failed; the message says what was being built."""


@contextmanager
def building(what: str) -> Iterator[None]:
    """Turn the kernel's exceptions, which share no base with Python's, into a KernelError that says what was built."""
    try:
        yield
    except (ValueError, TypeError, OSError):
        raise
    except Exception as error:
        raise KernelError(f"{what}: {str(error) or type(error).__name__}") from error
