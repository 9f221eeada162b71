"""CadQuery's part in `hosts.py`: each operation by its own workplanes and functions."""

import tempfile
from importlib.metadata import version
from pathlib import Path

import cadquery as cq
from cadquery import func

from cadfit.cadquery import from_edge, to_face, to_wire
from cadfit.occt import tube_solid

NAME = f"CadQuery {version('cadquery')}"
face, wire = to_face, to_wire


def extruded(shape, across):
    return func.extrude(shape, across)


def revolved(shape, axis):
    return func.revolve(shape, (axis, 0, 0), (0, 1, 0))


def offset(wire, distance):
    outer, *inner = cq.Workplane(obj=wire).toPending().offset2D(distance).vals()
    return cq.Face.makeFromWires(outer, inner)


def filleted(solid, height, radius):
    return cq.Workplane(obj=solid).faces(">Z").edges().fillet(radius).val()


def lofted(wires, solid):
    return func.loft(wires, cap=solid)


def swept(face, path):
    return func.sweep(face, path)


def disc(centre, normal, radius):
    return cq.Workplane(cq.Plane(tuple(centre), normal=tuple(normal))).circle(radius).toPending()._getFaces()[0]


def tube(fit, radius, tolerance):
    return cq.Solid(tube_solid(fit, radius, tolerance))


def there_and_back(wire):
    with tempfile.TemporaryDirectory() as folder:
        path = str(Path(folder) / "wire.step")
        cq.exporters.export(cq.Workplane(obj=wire), path)
        return [from_edge(edge) for edge in cq.importers.importStep(path).edges().vals()]
