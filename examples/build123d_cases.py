"""What people brought to build123d's tracker, by the host's own way and by cadfit's: deviation, poles, time.

A closed noisy circle, a local spline that does not overshoot, an airfoil that turns wavy, a tube along 1,000 points.
Needs build123d. Writes out/case_circle.png, case_local.png, case_airfoil.png and case_tube.png (or into the folder
given).
"""

import sys
from itertools import product
from pathlib import Path
from time import process_time

import matplotlib.pyplot as plt
import numpy as np
from build123d import Circle, Edge, Plane, Spline, export_step, import_step, sweep
from OCP.BRepAdaptor import BRepAdaptor_Curve, BRepAdaptor_Surface
from OCP.gp import gp_Pnt, gp_Vec

import cadfit
from cadfit.bezier import distance_to_segment
from cadfit.build123d import CardinalSpline, FitSpline, FitTube, LocalSpline

DATA = Path(__file__).parent / "data"
BLUE, VERMILION = "#0072B2", "#D55E00"


def timed(make):
    """Return what is made, and the seconds of processor time that took."""
    start = process_time()
    made = make()
    return made, process_time() - start


def samples(line, n=20_000):
    """Return n points of an edge, or of each edge of a wire, as the kernel evaluates them."""
    found = []
    for edge in line.edges():
        curve = BRepAdaptor_Curve(edge.wrapped)
        u = np.linspace(curve.FirstParameter(), curve.LastParameter(), n)
        found.append(np.array([curve.Value(t).Coord() for t in u.tolist()]))
    return np.concatenate(found)


def judged(line, seconds, points):
    """Return how far samples of a line are from points (n, 2 or 3), and the reverse; poles, length and time."""
    curve = samples(line)[:, : points.shape[1]]
    gaps = [distance_to_segment(point, curve[:-1], curve[1:]).min() for point in points]
    some = curve[:: max(1, len(curve) // 5000)]
    chords = [distance_to_segment(place, points[:-1], points[1:]).min() for place in some]
    poles = sum(BRepAdaptor_Curve(edge.wrapped).NbPoles() for edge in line.edges())
    length = float(np.linalg.norm(np.diff(curve, axis=0), axis=1).sum())
    return {"at points": max(gaps), "between": max(chords), "poles": poles, "length": length, "seconds": seconds}


def noisy_circle(seed=1, n=501):
    """A circle of radius 50 at n points, its radius measured with noise of 0.05, closed."""
    angle = 2.0 * np.pi * np.arange(n) / n
    radius = 50.0 + np.random.default_rng(seed).normal(scale=0.05, size=n)
    circle = radius[:, None] * np.column_stack([np.cos(angle), np.sin(angle)])
    return np.concatenate([circle, circle[:1]])


def circle_case():
    """At a tolerance of 0.01: the host's approximation as it comes, smoothed, and fits."""
    points = noisy_circle()
    ways = {
        "make_spline_approx": lambda: Edge.make_spline_approx(tuples(points), 0.01),
        "smoothing (1, 1, 1)": lambda: Edge.make_spline_approx(tuples(points), 0.01, smoothing=(1, 1, 1)),
        "FitSpline": lambda: FitSpline(points, 0.01),
        "FitSpline at 0.25": lambda: FitSpline(points, 0.25),
    }
    made = {name: timed(way) for name, way in ways.items()}
    return points, made, {name: judged(*each, points) for name, each in made.items()}


def local_case():
    """Nine points, three of them close together: how far curves leave their box, and where a moved point is felt."""
    points = np.array([(-12, 0), (-8, 1), (-4, 0), (0, 0), (1, 0.1), (8, 4), (8.2, 4.1), (8.3, 3.9), (16, 0)])
    moved = points.copy()
    moved[-1, 1] += 1.0
    ways = {
        "Spline": lambda places: Spline(*tuples(places)),
        "LocalSpline": LocalSpline,
        "CardinalSpline": lambda places: CardinalSpline(places, curvature=1.0),
    }
    made = {name: timed(lambda way=way: way(points)) for name, way in ways.items()}
    found = {name: judged(*each, points) for name, each in made.items()}
    low, high = points.min(axis=0), points.max(axis=0)
    for name, way in ways.items():
        before, after = samples(made[name][0])[:, :2], samples(way(moved))[:, :2]
        found[name]["overshoot"] = max((low - before).max(), (before - high).max())
        start = before[before[:, 0] < 1.0][::20]  # four points and more before the one that moved
        found[name]["felt far off"] = max(distance_to_segment(place, after[:-1], after[1:]).min() for place in start)
    return points, made, found


def airfoil_case():
    """RAE 2822 with a chord of 200, its published digits cut to 0.02: how often the curvature changes its sign."""
    exact = 200.0 * cadfit.read(DATA / "rae2822.dat")
    points = np.round(exact / 0.02) * 0.02
    ways = {
        "Spline": lambda: Spline(*tuples(points)),
        "make_spline_approx": lambda: Edge.make_spline_approx(tuples(points), 0.02),
        "FitSpline": lambda: FitSpline(points, 0.02),
    }
    made = {name: timed(way) for name, way in ways.items()}
    found = {name: judged(*each, points) for name, each in made.items()}
    for name, (line, _) in made.items():
        found[name]["inflections"] = int(np.count_nonzero(np.diff(np.sign(curvature(line)))))
    return points, made, found


def curvature(line, n=5000):
    """Return the signed curvature (n,) of an edge in the XY plane, but for 2 % of it at either end."""
    (edge,) = line.edges()
    curve, at, first, second = BRepAdaptor_Curve(edge.wrapped), gp_Pnt(), gp_Vec(), gp_Vec()
    low, high = curve.FirstParameter(), curve.LastParameter()
    found = []
    for share in np.linspace(0.02, 0.98, n).tolist():
        curve.D2(low + share * (high - low), at, first, second)
        found.append((first.X() * second.Y() - first.Y() * second.X()) / first.Magnitude() ** 3)
    return np.array(found)


def tube_case(folder):
    """A ring of 1,000 points, its radius 1,000 and the tube's 2.5: how far off, volumes, also from a STEP file."""
    turn = np.linspace(0.0, 2.0 * np.pi, 1000)
    points = 1000.0 * np.column_stack([np.cos(turn), np.sin(turn), 0.0 * turn])
    points[-1] = points[0]

    def swept():
        path = Spline(*tuples(points))
        return sweep(Plane(origin=path @ 0, z_dir=path % 0) * Circle(2.5), path=path)

    made = {"sweep": timed(swept), "FitTube": timed(lambda: FitTube(points, 2.5, 0.01))}
    found, exact = {}, 2.0 * np.pi * 1000.0 * np.pi * 2.5**2
    for name, (part, seconds) in made.items():
        path = folder / f"case_tube_{name}.step"
        export_step(part, path)
        back = import_step(path)
        found[name] = {
            **off_the_ring(part),
            "volume": part.volume / exact,
            "valid": part.is_valid,
            "volume read back": back.volume / exact,
            "valid read back": back.is_valid,
            "bytes": path.stat().st_size,
            "seconds": seconds,
        }
    return points, made, found


def off_the_ring(part, ring=1000.0, radius=2.5, n=200):
    """Return how far n by n places on each face of a tube are from the exact ring, and the poles of its faces."""
    surfaces = [BRepAdaptor_Surface(face.wrapped) for face in part.faces()]
    found = []
    for surface in surfaces:
        u = np.linspace(surface.FirstUParameter(), surface.LastUParameter(), n).tolist()
        v = np.linspace(surface.FirstVParameter(), surface.LastVParameter(), n).tolist()
        found += [surface.Value(*place).Coord() for place in product(u, v)]
    x, y, z = np.transpose(found)
    off = np.abs(np.hypot(np.hypot(x, y) - ring, z) - radius).max()
    return {"off": float(off), "poles": sum(surface.NbUPoles() * surface.NbVPoles() for surface in surfaces)}


def tuples(points):
    return [tuple(place) for place in points.tolist()]


def drawn(points, made, title, window, height):
    """Return a picture of lines over their points, and of what the window shows of it."""
    figure, rows = plt.subplots(1, len(made), figsize=(9.0, height), layout="constrained", sharex=True, sharey=True)
    for ax, (name, (line, _)) in zip(rows, made.items(), strict=True):
        if ours(name):
            line.fit.plot(ax, points=False, poles=False)
        else:
            ax.plot(*samples(line)[:, :2].T, color=VERMILION, linewidth=2.0)
        ax.plot(*points.T, ".", color="0.35", markersize=4.0, zorder=3)
        ax.set(aspect="equal", xlabel="", ylabel="")
        ax.set_title(name, fontsize="medium")
    rows[0].set(xlim=window[0], ylim=window[1])
    figure.suptitle(title, fontsize="medium")
    return figure


def ours(name):
    return name.startswith(("Fit", "Local", "Cardinal"))


def airfoil_picture(made):
    figure, rows = plt.subplots(len(made), 1, figsize=(8.0, 5.0), layout="constrained", sharex=True)
    for ax, (name, (line, _)) in zip(rows, made.items(), strict=True):
        ax.plot(np.linspace(2, 98, 5000), curvature(line), color=BLUE if ours(name) else VERMILION, linewidth=1.2)
        ax.axhline(0.0, color="0.6", linewidth=0.8)
        ax.set(ylim=(-0.03, 0.06), ylabel="curvature, 1/mm")
        ax.set_title(name, fontsize="medium")
    rows[-1].set_xlabel("% of the parameter, from the trailing edge over the top and back")
    return figure


def tube_picture(found):
    figure, ax = plt.subplots(figsize=(8.0, 2.6), layout="constrained")
    names = [f"{name}{after}" for name in found for after in ("", ", from STEP")]
    bars = [each[key] for each in found.values() for key in ("volume", "volume read back")]
    good = [each[key] for each in found.values() for key in ("valid", "valid read back")]
    ax.barh(names, bars, color=[BLUE if "Fit" in name else VERMILION for name in names], height=0.6)
    for row, (bar, valid) in enumerate(zip(bars, good, strict=True)):
        ax.text(max(bar, 0.0) + 0.02, row, "valid" if valid else "not valid", va="center", fontsize="small")
    ax.axvline(1.0, color="0.4", linewidth=0.8, linestyle="--")
    ax.set(xlabel="Solid.volume, in that of the exact ring", xlim=(-1.15, 1.3))
    ax.invert_yaxis()
    return figure


def main(folder):
    folder = Path(folder)
    folder.mkdir(parents=True, exist_ok=True)
    found, pictures = {}, {}
    points, made, found["circle"] = circle_case()
    pictures["circle"] = drawn(points, made, "a circle with noise of 0.05, tolerance 0.01", ((37, 53), (-1, 15)), 3.4)
    points, made, found["local"] = local_case()
    window = ((-13, 17), (-8, 10))
    pictures["local"] = drawn(points, made, "through nine points, three of them close together", window, 2.5)
    points, made, found["airfoil"] = airfoil_case()
    pictures["airfoil"] = airfoil_picture(made)
    points, made, found["tube"] = tube_case(folder)
    pictures["tube"] = tube_picture(found["tube"])
    for name, figure in pictures.items():
        figure.savefig(folder / f"case_{name}.png", dpi=130)
        plt.close(figure)
    for name, rows in found.items():
        print(name)
        for way, said in rows.items():
            print(f"  {way:18}", "  ".join(f"{key} {value:.4g}" for key, value in said.items()))
    return found


if __name__ == "__main__":
    main(*sys.argv[1:] or ["out"])
