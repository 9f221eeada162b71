"""Swept solids against exact volumes and areas, and read back from STEP."""

from __future__ import annotations

import numpy as np
import pytest

pytest.importorskip("OCP", reason="needs OCP: install cadfit[build123d] or cadfit[cadquery]")

from OCP.BRepCheck import BRepCheck_Analyzer
from OCP.BRepGProp import BRepGProp
from OCP.GProp import GProp_GProps
from OCP.TopAbs import TopAbs_ShapeEnum
from OCP.TopExp import TopExp

from cadfit import BSpline, Profile, local_spline, polyline
from cadfit.occt import KernelError, kernel, read_step, sweep_solid, tube_solid, volume, write_step

RADIUS = 1.0


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


def test_mitre_is_exact():
    square = [[-1, -1], [1, -1], [1, 1], [-1, 1]]
    assert volume(sweep_solid(CORNER, square)) == pytest.approx(4 * 35.0, rel=1e-12)
    assert volume(tube_solid(CORNER, RADIUS)) == pytest.approx(np.pi * 35.0, rel=1e-6)


def test_hollow_and_holes():
    path = helix(60)
    assert volume(tube_solid(path, 1.0, thickness=0.25)) == pytest.approx(np.pi * 0.4375 * path.length(), rel=1e-5)
    frame = Profile.of([[-2, -1], [2, -1], [2, 1], [-2, 1]], [[-1, -0.5], [1, -0.5], [1, 0.5], [-1, 0.5]])
    assert precise(sweep_solid(path, frame, 1e-5)) == pytest.approx(6.0 * path.length(), rel=2e-6)
    ring = tube_solid(trefoil(), 1.0, thickness=0.25)
    assert count(ring, "SHELL") == 2
    assert volume(ring) == pytest.approx(np.pi * 0.4375 * trefoil().length(), rel=1e-4)


def test_impossible_tubes_say_why():
    arc = local_spline([[np.cos(t), np.sin(t), 0.0] for t in np.linspace(0.0, 3.0, 20)])
    with pytest.raises(KernelError, match=r"bends more tightly than the profile reaches .*a radius below 0\.9"):
        tube_solid(arc, 1.1)
    with pytest.raises(KernelError, match=r"the mitres of the corners meet: the path runs 1\.5 between them"):
        tube_solid(polyline([[0, 0, 0], [9, 0, 0], [9, 1.5, 0], [0, 1.5, 0]]), 1.0)
    with pytest.raises(KernelError, match="turns straight back"):
        tube_solid(polyline([[0, 0, 0], [9, 0, 0], [3, 0, 0]]), 1.0)
