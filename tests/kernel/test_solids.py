"""Swept solids against exact volumes and areas, and read back from STEP."""

from __future__ import annotations

import numpy as np
import pytest
import trimesh

pytest.importorskip("OCP", reason="needs OCP: install cadfit[build123d] or cadfit[cadquery]")

from OCP.BRep import BRep_Tool
from OCP.BRepCheck import BRepCheck_Analyzer
from OCP.BRepGProp import BRepGProp
from OCP.BRepMesh import BRepMesh_IncrementalMesh
from OCP.Geom import Geom_BSplineSurface
from OCP.GProp import GProp_GProps
from OCP.TopAbs import TopAbs_Orientation, TopAbs_ShapeEnum
from OCP.TopExp import TopExp
from OCP.TopLoc import TopLoc_Location

from cadfit import BSpline, Profile, fit, frames, join, local_spline, occt, pieces_to_spline, polyline, sweep, tube
from cadfit.bezier import Array
from cadfit.fitting.cardinal import cardinal_pieces
from cadfit.occt import KernelError, breps, kernel, read_step, solids, sweep_solid, tube_solid, volume, write_step

RADIUS = 1.0
SQUARE = [[-1, -1], [1, -1], [1, 1], [-1, 1]]


def helix(count: int) -> BSpline:
    t = np.linspace(0.0, 6.0 * np.pi, count)
    return local_spline(np.column_stack([10 * np.cos(t), 10 * np.sin(t), t]))


def trefoil() -> BSpline:
    t = np.linspace(0.0, 2.0 * np.pi, 60, endpoint=False)
    x, y, z = np.sin(t) + 2 * np.sin(2 * t), np.cos(t) - 2 * np.cos(2 * t), -np.sin(3 * t)
    return local_spline(10 * np.column_stack([x, y, z]), closed=True)


def vertical_s() -> BSpline:
    t = np.linspace(-1.0, 1.0, 40)
    return local_spline(np.column_stack([5 * np.sin(np.pi * t), 0 * t, 20 * t]))


def inflection() -> BSpline:
    """A straight start, then a bend one way and the other."""
    x = np.linspace(0.0, 40.0, 81)
    t = np.maximum(x - 10.0, 0.0) / 30.0
    return local_spline(np.column_stack([x, 10.0 * t**3 * np.sin(2 * np.pi * t), 0 * x]))


CORNER = polyline([[0, 0, 0], [20, 0, 0], [20, 15, 0]])
PATHS = {
    "helix, 60 points": helix(60),
    "helix, 600 points": helix(600),
    "trefoil": trefoil(),
    "vertical S": vertical_s(),
    "inflection": inflection(),
    "corner": CORNER,
    "four corners": polyline([[0, 0, 0], [20, 0, 0], [20, 15, 0], [20, 15, 9], [3, 3, 20]]),
    "closed, corners": polyline([[0, 0], [20, 0], [20, 15], [0, 15]], closed=True),
}


def precise(solid) -> float:
    """The volume by the kernel's slow rule: the quick one is up to 1e-5 off."""
    found = GProp_GProps()
    BRepGProp.VolumePropertiesGK_s(solid, found, 1e-6)
    return found.Mass()


def count(shape, kind: str) -> int:
    found = kernel.Shapes()
    TopExp.MapShapes_s(shape, getattr(TopAbs_ShapeEnum, f"TopAbs_{kind}"), found)
    return found.Extent()


def tessellated(solid, deflection: float) -> trimesh.Trimesh:
    """The kernel's triangles, joined where they have the very same corners."""
    BRepMesh_IncrementalMesh(solid, deflection, False, 0.5, False)
    vertices, faces = [], []
    for shape in occt.faces(solid):
        mesh = BRep_Tool.Triangulation_s(shape, TopLoc_Location())
        found = np.array([mesh.Triangle(k).Get() for k in range(1, mesh.NbTriangles() + 1)]) - 1 + len(vertices)
        faces.append(found[:, ::-1] if shape.Orientation() == TopAbs_Orientation.TopAbs_REVERSED else found)
        vertices += [mesh.Node(k).Coord() for k in range(1, mesh.NbNodes() + 1)]
    joined = trimesh.Trimesh(vertices, np.concatenate(faces), process=False)
    joined.merge_vertices(digits_vertex=10)
    joined.update_faces(joined.nondegenerate_faces())
    return joined


def on_walls(solid, count: int = 40) -> Array:
    """Places on the solid's curved faces."""
    places = []
    for shape in occt.faces(solid):
        surface = BRep_Tool.Surface_s(shape)
        if isinstance(surface, Geom_BSplineSurface):
            u0, u1, v0, v1 = surface.Bounds()
            grid = ((u, v) for u in np.linspace(u0, u1, 9) for v in np.linspace(v0, v1, count))
            places += [surface.Value(u, v).Coord() for u, v in grid]
    return np.array(places)


@pytest.mark.parametrize("name", PATHS)
def test_tube_has_the_exact_volume_in_memory_and_from_step(name, tmp_path):
    path = PATHS[name]
    made = tube_solid(path, RADIUS)
    write_step(tmp_path / "tube.step", made)
    [read] = read_step(tmp_path / "tube.step")
    for solid in (made, read):
        assert solid.ShapeType() == TopAbs_ShapeEnum.TopAbs_SOLID
        assert BRepCheck_Analyzer(solid).IsValid()
        assert volume(solid) == pytest.approx(np.pi * RADIUS**2 * path.length(), rel=1e-5)
    assert count(read, "FACE") == count(made, "FACE")


@pytest.mark.parametrize("name", ["helix, 60 points", "trefoil", "vertical S", "inflection"])
@pytest.mark.parametrize("tolerance", [0.3, 1e-2, 1e-4])
def test_walls_are_within_the_tolerance(name, tolerance):
    path = PATHS[name]
    off = np.abs(path.nearest(on_walls(tube_solid(path, RADIUS, tolerance)))[1] - RADIUS)
    assert off.max() <= tolerance
    assert off.max() >= 1e-3 * tolerance  # no more accurate, and heavier, than asked for


@pytest.mark.parametrize("name", PATHS)
def test_the_kernels_triangles_are_watertight(name):
    path = PATHS[name]
    mesh = tessellated(tube_solid(path, RADIUS), 0.05)
    assert mesh.is_watertight
    assert mesh.is_winding_consistent
    assert mesh.volume == pytest.approx(np.pi * RADIUS**2 * path.length(), rel=5e-2)


def test_mitre_is_exact():
    assert volume(sweep_solid(CORNER, SQUARE)) == pytest.approx(4 * 35.0, rel=1e-12)
    assert volume(tube_solid(CORNER, RADIUS)) == pytest.approx(np.pi * 35.0, rel=1e-6)
    off = volume(sweep_solid(CORNER, np.add(SQUARE, [3.0, 0.0])))  # inside the bend, so shorter
    assert off == pytest.approx(4 * (17.0 + 12.0), rel=1e-12)


def test_straight_walls_are_planes(tmp_path):
    made = sweep_solid(polyline([[0, 0, 0], [20, 0, 0], [20, 15, 0], [20, 15, 9]]), SQUARE)
    write_step(tmp_path / "bar.step", made)
    for solid in (made, *read_step(tmp_path / "bar.step")):
        assert len(on_walls(solid)) == 0
        assert count(solid, "FACE") == 14
        assert BRepCheck_Analyzer(solid).IsValid()
        assert volume(solid) == pytest.approx(4 * 44.0, rel=1e-12)
    assert "B_SPLINE" not in (tmp_path / "bar.step").read_text()
    half_moon = join([polyline([[-1, 0], [1, 0]]), local_spline([[1, 0], [0.5, 0.9], [-0.5, 0.9], [-1, 0]])])
    mixed = sweep_solid([CORNER, local_spline([[20, 15, 0], [20, 18, 0], [19, 21, 1], [17, 24, 3]])], half_moon)
    assert tessellated(mixed, 0.01).is_watertight


def test_curved_parts_meet_in_a_mitre():
    t = np.linspace(0.0, 1.0, 20)
    first = local_spline(np.column_stack([20 * t, 3 * np.sin(6 * t), 0 * t]))
    second = local_spline(first.poles[-1] + np.column_stack([2 * t**2, 20 * t, 4 * t**2]))
    made = tube_solid([first, second], RADIUS)
    assert count(made, "FACE") == 6
    assert precise(made) == pytest.approx(np.pi * (first.length() + second.length()), rel=1e-5)
    assert tessellated(made, 0.01).is_watertight


def test_hollow_and_holes():
    path = helix(60)
    assert volume(tube_solid(path, 1.0, thickness=0.25)) == pytest.approx(np.pi * 0.4375 * path.length(), rel=2e-5)
    frame = Profile.of([[-2, -1], [2, -1], [2, 1], [-2, 1]], [[-1, -0.5], [1, -0.5], [1, 0.5], [-1, 0.5]])
    assert precise(sweep_solid(path, frame, 1e-5)) == pytest.approx(6.0 * path.length(), rel=2e-6)
    ring = tube_solid(trefoil(), 1.0, thickness=0.25)
    assert count(ring, "SHELL") == 2
    assert volume(ring) == pytest.approx(np.pi * 0.4375 * trefoil().length(), rel=1e-4)
    assert tessellated(ring, 0.05).body_count == 2


def test_round_ends(tmp_path):
    straight = polyline([[0, 0, 0], [5, 0, 0]])
    ball = tube_solid(straight, 1.0, caps="round")
    write_step(tmp_path / "round.step", ball)
    for solid in (ball, *read_step(tmp_path / "round.step")):
        assert BRepCheck_Analyzer(solid).IsValid()
        assert precise(solid) == pytest.approx(np.pi * (5.0 + 4.0 / 3.0), rel=1e-9)
        assert tessellated(solid, 0.01).is_watertight
    off = np.abs(straight.nearest(on_walls(ball))[1] - 1.0)
    assert off.max() < 1e-12
    bar = sweep_solid(straight, SQUARE, caps="round")
    assert precise(bar) == pytest.approx(4 * (5.0 + 2 * np.sqrt(2) * 2 / 3), rel=1e-9)
    with pytest.raises(ValueError, match=r"round"):
        tube_solid(straight, 1.0, thickness=0.2, caps="round")


def test_varying_radius_and_twist():
    straight = polyline([[0, 0, 0], [10, 0, 0]])
    cone = tube_solid(straight, lambda u: 2.0 - 0.1 * u)
    assert precise(cone) == pytest.approx(np.pi * 10 * (4 + 2 + 1) / 3, rel=1e-9)
    wavy = tube_solid(straight, lambda u: 1.0 + 0.2 * np.sin(u), 1e-5)
    u = np.linspace(0.0, 10.0, 100_001)
    assert precise(wavy) == pytest.approx(np.trapezoid(np.pi * (1.0 + 0.2 * np.sin(u)) ** 2, u), rel=1e-5)
    places = on_walls(wavy)
    off = np.hypot(places[:, 1], places[:, 2]) - 1.0 - 0.2 * np.sin(places[:, 0])
    assert np.abs(off).max() <= 1e-5
    twisted = sweep_solid(helix(60), SQUARE, 1e-4, twist=12.0)
    assert precise(twisted) == pytest.approx(4 * helix(60).length(), rel=1e-4)


def test_upright_profiles_stand_as_their_frames():
    path, tolerance = helix(60), 1e-4
    made = sweep_solid(path, SQUARE, tolerance, up=[0, 0, 1])
    assert precise(made) == pytest.approx(4 * path.length(), rel=1e-4)
    places = on_walls(made)
    u = path.nearest(places)[0]
    inside = (u > path.domain[0] + 0.1) & (u < path.domain[1] - 0.1)
    f = frames(path, u[inside], up=[0, 0, 1])
    arms = places[inside] - f.origins
    x, y = np.abs((arms * f.normals).sum(axis=1)), np.abs((arms * f.binormals).sum(axis=1))
    assert np.abs(np.maximum(x, y) - 1.0).max() <= tolerance


def test_radii_in_rows():
    path = polyline([[0, 0, 0], [10, 0, 0]])
    made = tube_solid(path, [[0.0, 2.0], [10.0, 1.0]], caps="round")
    assert precise(made) == pytest.approx(np.pi * (10 * 7 / 3 + (8 + 1) * 2 / 3), rel=1e-6)


def test_radii_at_the_points_of_a_closed_fit():
    """As the mesh takes them: joined across the seam, though no point is at the path's end."""
    t = np.linspace(0.0, 2.0 * np.pi, 60, endpoint=False)
    path = fit(np.column_stack([9 * np.cos(t), 6 * np.sin(t), np.sin(2 * t)]), 1e-3, closed=True)
    radii = 1.0 + 0.3 * np.sin(2 * t)
    assert volume(tube_solid(path, radii)) == pytest.approx(tube(path, radii).volume, rel=1e-3)
    made = sweep_solid(path, SQUARE, scale=0.5 * radii)
    assert volume(made) == pytest.approx(sweep(path, SQUARE, scale=0.5 * radii).volume, rel=1e-3)


def test_paths_that_are_not_c2():
    circle = helix(60)
    c1 = pieces_to_spline(cardinal_pieces(circle(np.linspace(*circle.domain, 40))))
    made = tube_solid(c1, RADIUS)
    assert count(made, "FACE") == 2 * 39 + 2  # curvature jumps at every point, so a wall ends there
    assert precise(made) == pytest.approx(np.pi * c1.length(), rel=1e-4)
    from_rest = BSpline([[0, 0, 0], [0, 0, 0], [5, 0, 0], [9, 0, 0]], [0, 0, 0, 0, 1, 1, 1, 1])
    assert precise(tube_solid(from_rest, RADIUS)) == pytest.approx(np.pi * 9.0, rel=1e-9)


@pytest.mark.parametrize(("size", "offset"), [(1e-3, 0.0), (1.0, 1e5), (1e4, 0.0)])
def test_sizes_and_places(size, offset):
    path = helix(60).transformed(size * np.eye(3), offset)
    assert volume(tube_solid(path, size)) == pytest.approx(np.pi * size**2 * path.length(), rel=1e-4)


def test_the_check_sees_what_is_wrong(monkeypatch):
    """A wall, a face or an edge out of place never leaves unnoticed."""
    honest = breps.wall

    def bent(loop, rails, *rest):
        poles = rails[0].poles.copy()
        poles[len(poles) // 2, 3:] *= 0.9
        return honest(loop, [BSpline(poles, rails[0].knots), *rails[1:]], *rest)

    def open_(loop, rails, *rest):
        faces, first, last = honest(loop, rails, *rest)
        return faces[:-1], first, last

    def rippled(loop, rails, *rest):  # sections moved to and fro, each in its plane: the volume stays
        poles = rails[0].poles.copy()
        poles[4:-4, :3] += 0.1 * (-1.0) ** np.arange(len(poles) - 8)[:, None] * poles[4:-4, 3:6]
        return honest(loop, [BSpline(poles, rails[0].knots), *rails[1:]], *rest)

    for broken, said in ((bent, "volume|invalid"), (open_, "volume|invalid"), (rippled, "its area is")):
        with monkeypatch.context() as patch:
            patch.setattr(breps, "wall", broken)
            with pytest.raises(KernelError, match=said):
                tube_solid(PATHS["vertical S"], RADIUS)
    rail = solids.rail

    def narrow(stretch, law, reach, tolerance):
        return rail(stretch, BSpline(0.99 * law.poles, law.knots), reach, tolerance)

    monkeypatch.setattr(solids, "rail", narrow)
    with pytest.raises(KernelError, match="the walls hold"):
        tube_solid(PATHS["vertical S"], RADIUS)


def test_impossible_tubes_say_why():
    arc = local_spline([[np.cos(t), np.sin(t), 0.0] for t in np.linspace(0.0, 3.0, 20)])
    with pytest.raises(KernelError, match=r"bends there with a radius of .* a radius below (0\.99|1\.0)\d* would do"):
        tube_solid(arc, 1.1)
    with pytest.raises(KernelError, match="too short for its mitres"):
        tube_solid(polyline([[0, 0, 0], [9, 0, 0], [9, 1.5, 0], [0, 1.5, 0]]), 1.0)
    with pytest.raises(KernelError, match="turns there on the spot"):
        tube_solid(polyline([[0, 0, 0], [9, 0, 0], [3, 0, 0]]), 1.0)
    t = np.linspace(0.0, 12.0, 80)
    coil = local_spline(np.column_stack([10 * np.cos(t), 10 * np.sin(t), 0.25 * t]))  # 1.57 a turn
    with pytest.raises(KernelError, match=r"is too near for a radius of 1; a radius below 0\.7\d* would do"):
        tube_solid(coil, 1.0)
    assert volume(tube_solid(coil, 0.75)) == pytest.approx(np.pi * 0.75**2 * coil.length(), rel=1e-5)
