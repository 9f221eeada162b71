"""The main job: published points to curves and a tube that CAD opens, and everything opened again to prove it.

Writes to out/demo/, or to the folder given as first argument. What `make demo` runs.
docs/pictures/protein.png is a copy of a picture this writes; those beside it, of the example of the same name.
"""

import sys
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
from rich.console import Console
from rich.table import Column, Table

import cadfit

DATA = Path(__file__).parent / "data"
CHORD = 200.0  # mm: the airfoil's coordinates are parts of its chord
WITHIN = 0.02  # mm: what the airfoil may be off, where it is to have few poles
RADIUS, TOLERANCE = 0.75, 0.03  # of the tube, in ångström like its centreline; written as mm


def airfoil(folder):
    # The last point repeats the first, so the contour is closed as published; but the trailing edge is sharp, and a
    # curve smooth all the way round would round it off. So it is fitted from the edge to the edge: C2 everywhere else,
    # and one closed edge to CAD. Chord-length parameters are the most exact for smooth points spaced as unevenly as
    # these, and show in the comb: one change of sign, where the lower side turns hollow, and no wiggles.
    points = CHORD * cadfit.clean(cadfit.read(DATA / "rae2822.dat"), closed=False).points
    spline = cadfit.local_spline(points, parametrization="chord")
    cadfit.write(folder / "airfoil.step", spline, unit="mm")
    picture_of_airfoil(folder / "airfoil.png", spline, points)
    return points, spline


def light(folder, points):
    # Within a tolerance, at the points and between them, instead of through them: with as few poles as that takes.
    fit = cadfit.fit(points, WITHIN)
    cadfit.write(folder / "airfoil_light.step", fit.spline, unit="mm")
    return fit.spline


def protein(folder):
    # Points all as far apart: the default, centripetal parameters.
    points = cadfit.clean(cadfit.read(DATA / "1a8o_ca.csv")).points
    spline = cadfit.local_spline(points)
    mesh = cadfit.tube(spline, RADIUS, TOLERANCE)
    cadfit.write(folder / "protein.step", spline)
    cadfit.write(folder / "protein.stl", mesh)
    cadfit.write(folder / "protein.3mf", mesh)
    picture_of_protein(folder / "protein.png", spline, points, mesh)
    return points, spline


def picture_of_airfoil(path, spline, points):
    figure, (nose, whole) = plt.subplots(1, 2, figsize=(8.5, 3.1), width_ratios=[1, 2.35], layout="constrained")
    spline.plot(nose, points=points, count=3000, scale=4)
    nose.set(xlim=(-3.5, 6), ylim=(-5.2, 5.2), title="nose of RAE 2822")
    spline.plot(whole, points=points, poles=False, count=240, scale=4000)
    whole.set(xlim=(-12, 214), ylim=(-40, 60), title="whole contour, its comb 1000 times as long")
    whole.legend(*nose.get_legend_handles_labels(), loc="upper right", ncols=4, fontsize="small", columnspacing=1.2)
    figure.savefig(path, dpi=160)
    plt.close(figure)


def picture_of_protein(path, spline, points, mesh):
    figure, (left, right) = plt.subplots(
        1, 2, figsize=(7.6, 3.7), subplot_kw={"projection": "3d"}, layout="constrained"
    )
    spline.plot(left, points=points, count=600, scale=2.5)
    left.legend(loc="lower left", fontsize="small")
    right.plot_trisurf(*mesh.vertices.T, triangles=mesh.faces, color="#56B4E9", linewidth=0, antialiased=False)
    for ax in (left, right):
        ax.view_init(18, 32)
        # One unit as long on every axis, and less margin.
        ax.set_box_aspect(np.ptp(np.reshape(ax.get_w_lims(), (3, 2)), axis=1), zoom=1.4)
        ax.set_axis_off()
    figure.savefig(path, dpi=160, bbox_inches="tight")
    plt.close(figure)


def step_says(path, spline):
    """Open a STEP file through the kernel, and compare its one edge with the spline that was written."""
    from OCP.BRepAdaptor import BRepAdaptor_Curve

    (edge,) = cadfit.occt.edges(cadfit.occt.read_step(path))
    curve = BRepAdaptor_Curve(edge).BSpline().Copy()
    if curve.IsPeriodic():  # how the kernel reads a closed curve: with the first pole not repeated at the end
        curve.SetNotPeriodic()
    poles = np.array([pole.Coord() for pole in curve.Poles()])[:, : spline.poles.shape[1]]
    off = np.abs(poles - spline.poles).max() / spline.size if poles.shape == spline.poles.shape else np.inf
    named = path.read_text(encoding="utf-8").count("B_SPLINE_CURVE_WITH_KNOTS")
    right = named == 1 and curve.Degree() == 3 and off < 1e-9
    return right, f"{named} B_SPLINE_CURVE_WITH_KNOTS of degree {curve.Degree()}, poles off by {off:.1g} of its size"


def mesh_says(path, spline):
    """Open a mesh file through trimesh, and compare its volume with area times length."""
    import trimesh

    mesh = trimesh.load_mesh(path)
    exact = np.pi * RADIUS**2 * spline.length()
    off = mesh.volume / exact - 1.0
    right = mesh.is_watertight and mesh.is_winding_consistent and abs(off) < 2.0 * TOLERANCE / RADIUS
    tight = "watertight" if mesh.is_watertight else "NOT watertight"
    return right, f"{len(mesh.faces)} faces, {tight}, volume {mesh.volume:.2f}, {off:+.1e} of area times length"


def main(folder):
    folder = Path(folder)
    folder.mkdir(parents=True, exist_ok=True)
    contour, around = airfoil(folder)
    within = light(folder, contour)
    trace, along = protein(folder)

    console = Console(highlight=False)
    table = Table("", "points", "poles", "largest deviation\nat points", "\nbetween", Column("files", no_wrap=True))
    figures = {}
    rows = [
        ("airfoil", "mm", contour, around),
        ("airfoil_light", "mm", contour, within),
        ("protein", "Å", trace, along),
    ]
    for name, unit, points, spline in rows:
        far = cadfit.deviation(spline, points)
        numbers = {"points": len(points), "poles": len(spline.poles), "at points": far.points, "between": far.between}
        files = "\n".join(sorted(path.name for path in folder.glob(f"{name}.*")))
        table.add_row(f"{name.replace('_', ', ')}, {unit}", *(f"{number:.3g}" for number in numbers.values()), files)
        figures[name] = numbers
    console.print(table)
    console.print("at points: no point is farther from the curve. between: nor is the curve from the polyline.")
    console.print(f"\nThe files are in {folder.resolve()}. Opened again:", soft_wrap=True)

    checks = {"airfoil.step": step_says(folder / "airfoil.step", around)}
    checks["airfoil_light.step"] = step_says(folder / "airfoil_light.step", within)
    checks["protein.step"] = step_says(folder / "protein.step", along)
    for name in ("protein.stl", "protein.3mf"):
        checks[name] = mesh_says(folder / name, along)
    for name, (right, said) in checks.items():
        console.print(f"{'ok   ' if right else 'WRONG'} {name}: {said}", soft_wrap=True)
    return figures | {"right": all(right for right, _ in checks.values()), "checks": checks}


if __name__ == "__main__":
    sys.exit(not main(*sys.argv[1:] or ["out/demo"])["right"])
