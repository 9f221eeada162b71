"""Lines and arcs of three curves, in CadQuery's environment: python benchmarks/arcs.py

The number of lines and arcs of `cadfit.arcs`, of OCCT's `Geom2dConvert_ApproxArcsSegments` and of CadQuery's DXF export
with approx="arc" (a face is what it takes: the S and the spiral are closed by a line, which is not counted), each with
the largest distance found by samples, in tolerances; a peer that misses the tolerance is marked.
"""

import tempfile
from pathlib import Path
from time import perf_counter

import numpy as np
from scipy.spatial import cKDTree

import cadfit

TOLERANCES = (0.1, 0.01, 0.001)


def curves():
    """A flower 209 mm around, an S and a spiral, as splines within 1e-6 mm of them."""
    t = np.linspace(0, 2 * np.pi, 2000, endpoint=False)
    r = 28.2 * (1 + 0.15 * np.cos(6 * t))
    x = np.linspace(0, 1, 400)
    a = np.linspace(0, 6 * np.pi, 1500)
    points = {
        "flower": (np.column_stack([r * np.cos(t), r * np.sin(t)]), True),
        "S": (np.column_stack([40 * x, 15 * np.sin(2 * np.pi * x**1.2)]), False),
        "spiral": ((2 + 1.5 * a)[:, None] * np.column_stack([np.cos(a), np.sin(a)]), False),
    }
    return {name: cadfit.fit(p, 1e-6, closed=c, effort="fast").spline for name, (p, c) in points.items()}


def ours(spline, tolerance):
    found = cadfit.arcs(spline, tolerance)
    return len(found), [found(k, np.linspace(0, 1, 200)) for k in range(len(found))]


def occt(spline, tolerance):
    from OCP.Geom2d import Geom2d_BSplineCurve
    from OCP.Geom2dAdaptor import Geom2dAdaptor_Curve
    from OCP.Geom2dConvert import Geom2dConvert_ApproxArcsSegments
    from OCP.gp import gp_Pnt2d

    try:
        from OCP.collections import Array1_double as Reals
        from OCP.collections import Array1_gp_Pnt2d as Points
        from OCP.collections import Array1_int as Integers
    except ImportError:
        from OCP.TColgp import TColgp_Array1OfPnt2d as Points
        from OCP.TColStd import TColStd_Array1OfInteger as Integers
        from OCP.TColStd import TColStd_Array1OfReal as Reals
    poles, knots = Points(1, len(spline.poles)), Reals(1, len(spline.distinct_knots))
    times = Integers(1, len(spline.distinct_knots))
    for k, pole in enumerate(spline.poles.tolist()):
        poles.SetValue(k + 1, gp_Pnt2d(*pole))
    for k, (knot, often) in enumerate(zip(spline.distinct_knots.tolist(), spline.multiplicities.tolist(), strict=True)):
        knots.SetValue(k + 1, knot)
        times.SetValue(k + 1, often)
    adaptor = Geom2dAdaptor_Curve(Geom2d_BSplineCurve(poles, knots, times, 3))
    found = Geom2dConvert_ApproxArcsSegments(adaptor, tolerance, 0.1).GetResult()
    parts = []
    for k in range(1, found.Length() + 1):
        part = found.Value(k)
        places = np.linspace(part.FirstParameter(), part.LastParameter(), 200)
        parts.append(np.array([part.Value(u).Coord() for u in places.tolist()]))
    return found.Length(), parts


def cadquery(spline, tolerance):
    import cadquery
    import ezdxf

    from cadfit.occt import to_edge

    edges = [cadquery.Edge(to_edge(spline))]
    if not spline.closed:
        ends = [cadquery.Vector(*spline.poles[k]) for k in (-1, 0)]
        edges.append(cadquery.Edge.makeLine(*ends))
    wire = cadquery.Wire.assembleEdges(edges)
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "a.dxf"
        plane = cadquery.Workplane().newObject([wire])
        cadquery.exporters.exportDXF(plane, str(path), approx="arc", tolerance=tolerance)
        entities = list(ezdxf.readfile(path).modelspace())
    parts = []
    for entity in entities:
        tool = entity.construction_tool() if entity.dxftype() == "ARC" else None
        if tool is None:
            a, b = np.array(entity.dxf.start)[:2], np.array(entity.dxf.end)[:2]
            parts.append(a + np.linspace(0, 1, 200)[:, None] * (b - a))
        else:
            parts.append(np.array([[p.x, p.y] for p in tool.vertices(tool.angles(200))]))
    if not spline.closed:
        far = [np.abs(part[[0, -1]] - spline.poles[[0, -1]]).max() for part in parts]
        back = [np.abs(part[[0, -1]] - spline.poles[[-1, 0]]).max() for part in parts]
        del parts[int(np.argmin(np.minimum(far, back)))]
    return len(parts), parts


def judged(spline, tolerance, make):
    """Return the number, the largest distance both ways by samples in tolerances, and the seconds."""
    start = perf_counter()
    count, parts = make(spline, tolerance)
    taken = perf_counter() - start
    _, there = spline.nearest(np.concatenate([part[::8] for part in parts]))
    dense = np.concatenate(parts)
    on_curve = spline(np.linspace(*spline.domain, 5000))
    spacing = max(np.linalg.norm(np.diff(part, axis=0), axis=1).max() for part in parts)
    back = np.sqrt(np.maximum(cKDTree(dense).query(on_curve)[0] ** 2 - (spacing / 2) ** 2, 0.0)).max()
    return count, max(there.max(), back) / tolerance, taken


def table():
    lines = [
        "| curve | tolerance | cadfit | off | time | OCCT | off | OCCT / ours | CadQuery | off | CadQuery / ours |",
        "| --- | ---: | ---: | ---: | ---: | ---: | ---: | ---: | ---: | ---: | ---: |",
    ]
    for name, spline in curves().items():
        for tolerance in TOLERANCES:
            n, off, taken = judged(spline, tolerance, ours)
            row = f"| {name} | {tolerance} | {n} | {off:.2f} | {taken:.2f} s |"
            for peer in (occt, cadquery):
                count, missed, _ = judged(spline, tolerance, peer)
                row += f" {count} | {missed:.2f} | {count / n:.2f}{' (misses)' * bool(missed > 1.01)} |"
            lines.append(row)
    return "\n".join(lines)


if __name__ == "__main__":
    print(table())
