"""build123d's part in `hosts.py`: each operation by its own functions."""

import tempfile
from importlib.metadata import version
from pathlib import Path

from build123d import Axis, Circle, Face, Kind, Plane, Shell, Solid, Vector, Wire, export_step, import_step

from cadfit.build123d import from_edge, to_face, to_wire
from cadfit.occt import tube_solid

NAME = f"build123d {version('build123d')}"
face, wire = to_face, to_wire


def extruded(shape, across):
    return (Solid if isinstance(shape, Face) else Shell).extrude(shape, Vector(across))


def revolved(shape, axis):
    return (Solid if isinstance(shape, Face) else Shell).revolve(shape, 360, Axis((axis, 0, 0), (0, 1, 0)))


def offset(wire, distance):
    return Face(Wire(wire.offset_2d(distance, kind=Kind.ARC)))


def filleted(solid, height, radius):
    rim = [edge for edge in solid.edges() if abs(edge.center().Z - height) < 1e-6]
    return solid.fillet(radius, rim)


def lofted(wires, solid):
    return (Solid if solid else Shell).make_loft(wires)


def swept(face, path):
    return Solid.sweep(face, path)


def disc(centre, normal, radius):
    return (Plane(tuple(centre), z_dir=tuple(normal)) * Circle(radius)).faces()[0]


def tube(fit, radius, tolerance):
    return Solid(tube_solid(fit, radius, tolerance))


def there_and_back(wire):
    with tempfile.TemporaryDirectory() as folder:
        export_step(wire, Path(folder) / "wire.step")
        return [from_edge(edge) for edge in import_step(Path(folder) / "wire.step").edges()]
