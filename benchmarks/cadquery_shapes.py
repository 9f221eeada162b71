"""What CadQuery makes of fitted curves: faces, solids, offsets, fillets, lofts and sweeps of real ones, counted.

A few curves of each family of the corpus, scaled to a size of 100 and fitted within 0.1. Closed plane curves become
profiles, the others paths. A shape counts where the kernel finds it valid and its area or volume, where known, is what
the curve's own pieces say. Each step has its own process, for the kernel may crash or never end.

    .venv-cadquery/bin/python benchmarks/cadquery_shapes.py [curves of each family] [seconds]
"""

from __future__ import annotations

import sys
import tempfile
import time
from collections import Counter, defaultdict
from pathlib import Path

import cadquery as cq
import numpy as np
from OCP.BRepGProp import BRepGProp
from OCP.GProp import GProp_GProps

import cadfit
from cadfit.cadquery import draw, from_edge, to_face, to_wire
from cadfit.occt import tube_solid
from cadfit.regions import signed_area

from limited import limited

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "tests"))
from corpus_data import ABSENT, PRESENT, curves

SIZE, TOLERANCE, PATIENCE = 100.0, 0.1, 10.0


def volume(shape):
    found = GProp_GProps()
    BRepGProp.VolumePropertiesGK_s(shape.wrapped, found, 1e-5, False, False, False, False, False)
    return found.Mass()


def area(face):
    found = GProp_GProps()
    BRepGProp.SurfaceProperties_s(face.wrapped, found, 1e-6)
    return found.Mass()


def held(shape, value=None, wanted=None, within=2e-3):
    """Return nothing where a shape is valid and a value as wanted, else what is wrong."""
    if not shape.isValid():
        return "invalid"
    if value is not None and not abs(value - wanted) <= within * abs(wanted):
        return f"off by {value / wanted - 1.0:+.1%}"
    return None


def fitted(points, closed):
    return cadfit.fit(points, TOLERANCE, closed=closed, effort="fast")


def area_of(fit):
    return abs(signed_area(np.concatenate([curve.pieces() for curve in fit.curves])))


def drawn(fit, plane="XY", **where):
    return cq.Workplane(plane, **where).invoke(draw(fit, makeWire=True))


def face(fit):
    made, (x, y) = to_face(fit), fit.points.T
    polygon = 0.5 * abs(np.sum(x * np.roll(y, -1) - y * np.roll(x, -1)))
    strays = max(fit.deviation.points, fit.deviation.between) * sum(curve.length() for curve in fit.curves)
    if not abs(area_of(fit) - polygon) <= strays:
        return f"area {area_of(fit):.6g}, of the polygon {polygon:.6g}"
    return held(made, area(made), area_of(fit))


def extrude(fit):
    made = drawn(fit).extrude(10).val()
    return held(made, volume(made), 10.0 * area_of(fit))


def revolve(fit):
    around = cq.Workplane("XZ").center(2 * SIZE, 0).invoke(draw(fit, makeWire=True))
    made = around.revolve(360, (-2 * SIZE, 0), (-2 * SIZE, 1)).val()
    places = np.concatenate([curve(np.linspace(*curve.domain, 20_001)[:-1]) for curve in fit.curves])
    (x, y), (a, b) = places.T, np.roll(places, -1, axis=0).T
    cross = x * b - a * y
    middle = ((x + a) * cross).sum() / (3.0 * cross.sum())
    return held(made, volume(made), 2.0 * np.pi * (2 * SIZE + middle) * area_of(fit))


def offset(fit):
    made = drawn(fit).offset2D(1.0).vals()
    wrong = [problem for wire in made if (problem := held(wire))]
    return wrong[0] if wrong else None


def fillet(fit):
    return held(drawn(fit).extrude(10).faces(">Z").edges().fillet(0.2).val())


def loft(fit):
    smaller = [curve.transformed(0.8 * np.eye(2)) for curve in fit.curves]
    return held(drawn(fit).workplane(10).invoke(draw(smaller, makeWire=True)).loft().val())


def sweep(fit):
    path = cq.Workplane("XZ").spline([(0, 0), (5, 60), (30, 120)], tangents=[(0, 1), (1, 1)])
    return held(drawn(fit).sweep(path).val())


def step(fit):
    with tempfile.TemporaryDirectory() as folder:
        path = str(Path(folder) / "curve.step")
        cq.exporters.export(cq.Workplane(obj=to_wire(fit)), path)
        edges = cq.importers.importStep(path).edges().vals()
    back = [from_edge(edge) for edge in edges]
    if sorted(len(curve.poles) for curve in back) != sorted(len(curve.poles) for curve in fit.curves):
        return "other poles"
    return None


def edge(fit):
    return held(to_wire(fit))


def along(fit):
    first = fit.curves[0]
    places = np.column_stack([[first(first.domain[0])], np.zeros((1, 3 - first.poles.shape[1]))])[0]
    way = np.append(first.derivative(first.domain[0]), np.zeros(3 - first.poles.shape[1]))
    start = cq.Workplane(cq.Plane(tuple(places), normal=tuple(way)))
    made = start.circle(0.1).sweep(drawn(fit), transition="round").val()
    return held(made, volume(made), 0.01 * np.pi * sum(curve.length() for curve in fit.curves), 0.01)


def tube(fit):
    tube_solid(fit, 0.1)  # checked by itself, or an error
    return


PROFILES = {
    "face": face, "extrude": extrude, "revolve": revolve, "offset2D": offset, "fillet": fillet, "loft": loft,
    "sweep": sweep, "STEP": step,
}  # fmt: skip
PATHS = {"wire": edge, "circle swept along": along, "tube": tube, "STEP": step}


def tried(make, fit):
    """Return "" where it succeeds, else what is wrong."""
    try:
        return make(fit) or ""
    except Exception as error:
        return f"{type(error).__name__}: {str(error)[:70]}"


def main(each=10, seconds=3600):
    if not PRESENT:
        print(ABSENT)
        return
    good, total, wrong = Counter(), Counter(), defaultdict(Counter)
    end = time.monotonic() + float(seconds)
    found, seen = [], Counter()
    for parameter in curves(int(each), 1000):  # the first of each family, then the second, ..., as far as the time goes
        family = parameter.id.split("-")[0]
        found.append((seen[family], len(found), parameter))
        seen[family] += 1
    for _, _, parameter in sorted(found):
        if time.monotonic() > end:
            break
        shape = parameter.values[0]
        points = (shape.points - shape.points.mean(axis=0)) * (SIZE / shape.size)
        fit, _ = limited(PATIENCE, fitted, points, shape.closed)
        kind = "profile" if shape.closed and points.shape[1] == 2 else "path"
        for name, make in (PROFILES if kind == "profile" else PATHS).items():
            said = limited(PATIENCE, tried, make, fit)[0] if fit else "no fit"
            total[kind, name] += 1
            good[kind, name] += said == ""
            if said != "":
                wrong[kind, name][said if said is not None else "crashed or took over 10 s"] += 1
                print(parameter.id, name, said, file=sys.stderr, flush=True)
            if name == "face" and said != "":
                break  # an outline that crosses itself is no profile
    print("| | of | succeed | else |", "| --- | ---: | ---: | --- |", sep="\n")
    for kind, name in total:
        reasons = "; ".join(f"{count} {reason}" for reason, count in wrong[kind, name].most_common(3))
        print(f"| {kind}: {name} | {total[kind, name]} | {good[kind, name]} | {reasons} |")


if __name__ == "__main__":
    main(*sys.argv[1:])
