"""A DXF spline with kinks: `importers.importDXF` drops it without a word.

CadQuery issue 1014. A leaf, one cubic spline all round: at a kink an inner knot stands four times, which the kernel
refuses. The importer hides that, and what is left is the hole. Here the same file is read with ezdxf (CadQuery brings
it), and the spline taken apart at its kinks, exactly: an edge for each smooth part; the circle is refitted, within
0.001. Writes out/leaf.dxf and out/cq_dxf_kinks.png.
"""

import sys
from pathlib import Path

import cadquery as cq
import ezdxf
import matplotlib.pyplot as plt
import numpy as np

from cadfit import BSpline
from cadfit.cadquery import from_edge, simplify, to_face

from beside import draw, kernel_spline, save, show, timed

TOLERANCE = 1e-3
# Six cubic arcs, three to a side; where two meet is a kink.
TEETH = np.array(
    [[0, 0], [14, 2], [18, 10], [20, 16], [26, 17], [30, 22], [32, 30], [37, 30], [42, 34], [44, 44],
     [34, 42], [30, 37], [30, 32], [22, 30], [17, 26], [16, 20], [10, 18], [2, 14], [0, 0]]
)  # fmt: skip


def write(path):
    """Write the leaf as CAD programs do: one SPLINE, where it kinks a knot of four and two control points."""
    drawing = ezdxf.new()
    parts = [TEETH[k : k + 4] for k in range(0, len(TEETH) - 1, 3)]
    spline = drawing.modelspace().add_spline(dxfattribs={"degree": 3})
    spline.control_points = [(*point, 0.0) for part in parts for point in part.tolist()]
    spline.knots = np.repeat(np.arange(len(parts) + 1.0), 4)
    drawing.modelspace().add_circle((14, 14), 1.5)
    drawing.saveas(path)


def splines(entity):
    """Return the smooth parts of a DXF SPLINE of degree 3: an inner knot stands three times or more at a kink."""
    poles = np.array([tuple(point) for point in entity.control_points])
    knots = np.array(list(entity.knots))
    distinct, first, often = np.unique(knots, return_index=True, return_counts=True)
    cuts = [k for k in range(1, len(distinct) - 1) if often[k] >= 3]
    found, pole, start = [], 0, 0
    for k in [*cuts, len(distinct) - 1]:
        inner = knots[start : first[k]]
        vector = np.concatenate([inner, np.repeat(distinct[k], 4)])
        vector = np.concatenate([np.repeat(vector[0], 4 - np.count_nonzero(vector == vector[0])), vector])
        count = len(vector) - 4
        found.append(BSpline(poles[pole : pole + count], vector))
        pole += count - (often[k] == 3)  # at three, both parts share the pole; at four, each has its own
        start = first[k]
    return found


def kept(path, faces, seconds):
    """Return what came of a file: poles of the splines, and how far places of its curves, by ezdxf, are from edges."""
    edges = [edge for face in faces for edge in face.Edges()]
    whole = cq.Compound.makeCompound(edges)
    drawn = ezdxf.readfile(path).modelspace()
    places = [cq.Vertex.makeVertex(*place) for entity in drawn for place in entity.flattening(0.01)]
    return {
        "faces": len(faces),
        "edges": len(edges),
        "area": sum(face.Area() for face in faces),
        "poles": sum(len(kernel_spline(edge).c) for edge in edges if edge.geomType() == "BSPLINE"),
        "off": max(place.distance(whole) for place in places),
        "ms": 1e3 * seconds,
    }


def main(folder):
    Path(folder).mkdir(parents=True, exist_ok=True)
    path = Path(folder) / "leaf.dxf"
    write(path)
    host, host_seconds = timed(lambda: cq.importers.importDXF(str(path)))

    def ours():
        entities = ezdxf.readfile(path).modelspace()
        (outline,) = [splines(entity) for entity in entities.query("SPLINE")]
        circles = [cq.Edge.makeCircle(e.dxf.radius, cq.Vector(*e.dxf.center)) for e in entities.query("CIRCLE")]
        return to_face(outline, [from_edge(simplify(circle, TOLERANCE, "fast")) for circle in circles])

    face, seconds = timed(ours)
    wire, part = face.outerWire(), cq.Workplane(obj=face).wires().toPending().extrude(2)
    rows = {
        "importers.importDXF": kept(path, host.faces().vals(), host_seconds),
        "ezdxf, to_face": kept(path, [face], seconds),
    }
    show("a leaf with teeth and a hole, from DXF", rows)

    figure, row = plt.subplots(1, 2, figsize=(8.0, 4.2), layout="constrained")
    for ax, edges, title in [
        (row[0], [], f"importDXF: {rows['importers.importDXF']['edges']} edge, the hole"),
        (row[1], wire.Edges(), f"cadfit: {len(wire.Edges())} edges, one for each smooth part"),
    ]:
        angle = np.linspace(0.0, 2.0 * np.pi, 60)
        ax.plot(14 + 1.5 * np.cos(angle), 14 + 1.5 * np.sin(angle), color="black", linewidth=1.2)
        for edge in edges:
            draw(edge, ax)
        ax.plot(*TEETH[::3].T, "s", color="black", markersize=4, fillstyle="none")
        ax.set(aspect="equal", title=title, xlim=(-4, 48), ylim=(-4, 48))
    save(figure, folder, "cq_dxf_kinks.png")
    rows["ezdxf, to_face"] |= {"valid": wire.isValid() and face.isValid() and part.val().isValid()}
    return rows


if __name__ == "__main__":
    main(*sys.argv[1:] or ["out"])
