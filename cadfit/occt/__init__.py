"""Curves to the CAD kernel and back: edges, wires, STEP and BREP files.

The kernel is OpenCASCADE through OCP (7.8 to 8), which comes with the host the user has: `cadfit[build123d]` or
`cadfit[cadquery]`. Importing this module without it is an ImportError that names the two.

Example::

    edge = to_edge(spline)
    write_step("part.step", [edge, other_spline], unit="mm")
    splines = [from_edge(edge) for edge in edges(read_step("part.step"))]
"""

try:
    import OCP  # noqa: F401
except ImportError as error:
    raise ImportError(
        "cadfit.occt needs the CAD kernel OCP, which comes with a host: "
        "pip install 'cadfit[build123d]' or 'cadfit[cadquery]' (one of the two)"
    ) from error

from cadfit.occt.exchange import UNITS, read_brep, read_iges, read_step, write_brep, write_iges, write_step
from cadfit.occt.faces import to_face
from cadfit.occt.hostpoints import points_of
from cadfit.occt.kernel import CONFUSION, KernelError
from cadfit.occt.measuring import volume
from cadfit.occt.shapes import edges, faces, from_edge, to_edge, to_wire
from cadfit.occt.simplify import simplify
from cadfit.occt.solids import sweep_solid, tube_solid

__all__ = [
    "CONFUSION",
    "UNITS",
    "KernelError",
    "edges",
    "faces",
    "from_edge",
    "points_of",
    "read_brep",
    "read_iges",
    "read_step",
    "simplify",
    "sweep_solid",
    "to_edge",
    "to_face",
    "to_wire",
    "tube_solid",
    "volume",
    "write_brep",
    "write_iges",
    "write_step",
]
