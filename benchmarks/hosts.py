"""What build123d makes of fitted curves: extrude, revolve, offset, fillet, loft, sweep, and STEP there and back.

Some 200 real curves of a corpus ($CADFIT_CORPUS, or ../shared/corpus beside the repository), of at most 1,000 points,
brought to a size of 100 and fitted within 0.1. Plane closed ones are profiles: faces, then solids. The others are
paths: they make shells, and a tube of radius 0.2 is swept along them. An operation succeeds when it ends within 10
seconds of processor time, the result is valid and its area or volume, of its triangles, is right to 1 %. Each curve has
a process of its own, since the kernel may hang or fall. `python benchmarks/hosts.py 1` takes one of each kind.
"""

from __future__ import annotations

import multiprocessing
import resource
import signal
import sys
import tempfile
from collections import Counter, defaultdict
from pathlib import Path
from time import process_time

import numpy as np
from build123d import (
    Axis,
    Circle,
    Face,
    Kind,
    Plane,
    Shell,
    Solid,
    Vector,
    Wire,
    export_step,
    import_step,
)  # fmt: skip
from rich.progress import track

import cadfit
from cadfit.build123d import from_edge, to_edge, to_face, to_wire
from cadfit.regions import polygon, signed_area

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "tests"))
from corpus_data import ABSENT, PRESENT, curves

SECONDS = 10  # of processor time, for an operation
OPERATIONS = ("made", "extrude", "revolve", "offset", "fillet", "loft", "sweep", "STEP")


class Wrong(Exception):
    """A result that is not valid, or not of the right size."""


def area(shape):
    """Return the area of a shape's triangles: the kernel's own integral is up to 20 % off on extruded splines."""
    return 0.5 * float(np.linalg.norm(np.cross(*legs_of(corners_of(shape))), axis=1).sum())


def volume(shape):
    """Return the volume inside a shape's triangles."""
    corners = corners_of(shape)
    return float(abs(np.einsum("nd,nd->n", corners[:, 0], np.cross(corners[:, 1], corners[:, 2])).sum()) / 6.0)


def corners_of(shape):
    """Return the corners of a shape's triangles (n, 3, 3), which stray by 0.01 at most."""
    vertices, triangles = shape.tessellate(0.01, 0.1)
    return np.array([tuple(vertex) for vertex in vertices])[np.array(triangles)]


def legs_of(corners):
    return corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]


def held(shape, size, wanted, share=0.01):
    """Raise Wrong unless a shape is valid and its size the wanted one."""
    if not shape.is_valid:
        raise Wrong("not valid")
    if abs(size - wanted) > share * wanted:
        raise Wrong("another size")
    return shape


def solid_of(shape, wanted, share=0.01):
    return held(shape, volume(shape), wanted, share)


def profile(fit):
    """Yield operations on a plane closed curve, as names and functions."""
    curve = cadfit.join(fit.curves)
    face = to_face(fit)
    outer, inside, length = face.outer_wire(), abs(signed_area(curve.pieces())), curve.length()
    low, middle = curve.poles.min(axis=0), face.center()

    def made():
        held(face, area(face), inside)
        held(face, inside, abs(signed_area(polygon(fit.points))), 0.1 * length / inside)
        held(outer, float(outer.is_closed), 1.0)

    def extruded():
        return solid_of(Solid.extrude(face, Vector(0, 0, 5)), 5 * inside)

    def revolved():
        axis = Axis((float(low[0]) - 20.0, 0, 0), (0, 1, 0))
        return solid_of(Solid.revolve(face, 360, axis), 2 * np.pi * (middle.X - low[0] + 20.0) * inside)

    def offset():
        wire = outer.offset_2d(0.2, kind=Kind.ARC)
        wider = Face(wire)
        return held(wider, area(wider), inside + 0.2 * length, 0.2 * length / inside)

    def filleted():
        solid = Solid.extrude(face, Vector(0, 0, 5))
        rim = [edge for edge in solid.edges() if abs(edge.center().Z - 5) < 1e-6]
        return solid_of(solid.fillet(0.05, rim), 5 * inside)

    def lofted():
        above = Wire(outer.wrapped).moved(Plane((0, 0, 20)).location)
        return solid_of(Solid.make_loft([outer, above]), 20 * inside)

    def swept():
        path = to_edge(cadfit.local_spline([(0, 0, 0), (0, 5, 20), (0, 5, 40)]))
        start = Face(face.wrapped).moved(Plane(middle).location.inverse())
        lying = start.moved(Plane(path @ 0, z_dir=path % 0).location)
        return solid_of(Solid.sweep(lying, path), inside * path.length)

    return dict(zip(OPERATIONS, (made, extruded, revolved, offset, filleted, lofted, swept), strict=False))


def path(fit):
    """Return operations on a curve that is a path, by their names."""
    curve = cadfit.join(fit.curves)
    wire, length = to_wire(fit), curve.length()
    plane = fit.points.shape[1] == 2

    def made():
        held(wire, float(wire.is_closed), float(fit.closed)) if fit.closed else held(wire, 1.0, 1.0)

    def extruded():
        across = Vector(0, 0, 5) if plane else Vector(3, 4, 5)
        shell = Shell.extrude(wire, across)
        return held(shell, area(shell), strip(curve, np.array(tuple(across))))

    def revolved():
        low = float(curve.poles[:, 0].min())
        shell = Shell.revolve(wire, 360, Axis((low - 20.0, 0, 0), (0, 1, 0)))
        return held(shell, area(shell), turned(curve, low - 20.0))

    def offset():
        wider = wire.offset_2d(0.2, kind=Kind.ARC, closed=True)
        return held(Face(wider), area(Face(wider)), 0.2 * length, 0.5)

    def lofted():
        shell = Shell.make_loft([wire, Wire(wire.wrapped).moved(Plane((0, 0, 20)).location)])
        return held(shell, area(shell), strip(curve, np.array([0.0, 0.0, 20.0])))

    def swept():
        circle = Plane(wire @ 0, z_dir=wire % 0) * Circle(0.2)
        return solid_of(Solid.sweep(circle.faces()[0], wire), np.pi * 0.04 * length)

    found = {"made": made, "extrude": extruded, "revolve": revolved, "loft": lofted}
    return found | ({"offset": offset} if plane else {}) | {"sweep": swept}


def sampled(curve, n=20_001):
    """Return places (n, 3) of a curve, and the lengths between them with their middles."""
    u = np.linspace(*curve.domain, n)
    places = np.zeros((n, 3))
    places[:, : curve.poles.shape[1]] = curve(u)
    return np.diff(places, axis=0), 0.5 * (places[1:] + places[:-1])


def strip(curve, across):
    legs, _ = sampled(curve)
    return float(np.linalg.norm(np.cross(legs, across), axis=1).sum())


def turned(curve, axis):
    """Return the area of a curve turned about the line x = axis, z = 0."""
    legs, middles = sampled(curve)
    radial = np.hypot(middles[:, 0] - axis, middles[:, 2])
    rate = ((middles[:, 0] - axis) * legs[:, 0] + middles[:, 2] * legs[:, 2]) / radial
    return float(2 * np.pi * (radial * np.hypot(rate, legs[:, 1])).sum())


def there_and_back(fit):
    """Export the fit's wire with the host's own exporter, and hold what is read back to its poles, at STEP's digits."""
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "curve.step"
        export_step(to_wire(fit), file)
        back = [from_edge(edge) for edge in import_step(file).edges()]
    if len(back) != len(fit.curves):
        raise Wrong("other edges")
    for ours in fit.curves:
        poles = np.zeros((len(ours.poles), 3))
        poles[:, : ours.poles.shape[1]] = ours.poles
        if not any(len(each.poles) == len(poles) and np.abs(each.poles - poles).max() < 1e-9 for each in back):
            raise Wrong("other poles")


def tried(points, closed, send):
    """Send (operation, reason why not, or None) for all operations on the fit to points."""
    points = (points - points.mean(axis=0)) * (100.0 / np.linalg.norm(np.ptp(points, axis=0)))
    fit = cadfit.fit(points, 0.1, closed=closed, effort="fast")
    try:
        operations = profile(fit) if closed and points.shape[1] == 2 else path(fit)
    except ValueError as error:
        send(("made", "crosses itself" if "crosses" in str(error) else str(error)[:60]))
        operations = path(fit)
        del operations["made"]
    for name, operation in ({"STEP": lambda: there_and_back(fit)} | operations).items():
        resource.setrlimit(resource.RLIMIT_CPU, (int(process_time()) + SECONDS + 1, resource.RLIM_INFINITY))
        send((name, "begun"))
        try:
            operation()
            send((name, None))
        except Exception as error:
            send((name, str(error) if isinstance(error, Wrong) else type(error).__name__))


def results(points, closed):
    """Return the reasons by operation, from a process that ends when it takes too long over one."""
    receive, send = multiprocessing.Pipe(duplex=False)
    process = multiprocessing.get_context("fork").Process(target=tried, args=(points, closed, send.send))
    process.start()
    send.close()
    found = {}
    try:
        while True:
            name, reason = receive.recv()
            found[name] = reason
    except EOFError:
        process.join()
    last = f"no end in {SECONDS} s" if process.exitcode == -signal.SIGXCPU else "the kernel fell"
    return {name: last if reason == "begun" else reason for name, reason in found.items()}


def table(per_family=9) -> str:
    if not PRESENT:
        return ABSENT
    shapes = [p.values[0] for p in curves(per_family=per_family, max_points=1000)]
    counts = defaultdict(Counter)
    for shape in track(shapes, "build123d", disable=None):
        kind = "profile" if shape.closed and shape.points.shape[1] == 2 else "path"
        for name, reason in results(shape.points, shape.closed).items():
            counts[name, kind][reason] += 1
    rows = ["| operation | profiles | paths | what failed |", "| --- | ---: | ---: | --- |"]
    for name in OPERATIONS:
        cells, failed = [], []
        for kind in ("profile", "path"):
            count = counts[name, kind]
            total = count.total()
            cells.append(f"{count[None]} of {total}" if total else "–")
            failed += [f"{n} {kind}s: {reason}" for reason, n in count.most_common() if reason is not None]
        rows.append(f"| {name} | {cells[0]} | {cells[1]} | {'; '.join(failed)} |")
    return "\n".join(rows)


if __name__ == "__main__":
    print(table(*map(int, sys.argv[1:])))
