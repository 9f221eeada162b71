"""Corners: found where one smooth curve ends and the next begins, and nowhere else."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from cadfit import clean, find_corners

from corpus_data import curves, rotation, turn, with_corners


def polygon(vertices, per_side):
    """Points along the sides of a closed polygon, each vertex one of them."""
    after = np.roll(vertices, -1, axis=0)
    return np.concatenate(
        [p + np.arange(per_side)[:, None] / per_side * (q - p) for p, q in zip(vertices, after, strict=True)]
    )


def arch(n=40):
    """A half circle of radius 10 on its diameter, closed: two corners."""
    angle = np.linspace(0, np.pi, n)
    half = 10 * np.column_stack([np.cos(angle), np.sin(angle)])
    return np.concatenate([half, np.column_stack([np.linspace(-10, 10, n)[1:-1], np.zeros(n - 2)])])


def test_an_arch_has_two_corners_on_its_diameter():
    assert find_corners(arch(), 0.01, closed=True).tolist() == [0, 39]


@pytest.mark.parametrize("sides", [3, 4, 5, 8])
@pytest.mark.parametrize("per_side", [1, 2, 7, 40])
def test_every_vertex_of_a_polygon_over_the_angle(sides, per_side):
    points = polygon(turn(sides, 10.0), per_side)
    found = find_corners(points, 1e-3, closed=True, angle=2 * np.pi / sides - 0.01)
    assert found.tolist() == list(range(0, sides * per_side, per_side))
    assert len(find_corners(points, 1e-3, closed=True, angle=2 * np.pi / sides + 0.01)) == 0


@pytest.mark.parametrize("n", [12, 15, 20, 50, 1000])
def test_a_circle_has_none(n):
    assert len(find_corners(turn(n, 10.0), 1e-3, closed=True)) == 0


@pytest.mark.parametrize("noise", [0.2, 0.5, 1.0])
def test_noise_within_the_tolerance_makes_none_and_hides_none(noise):
    rng = np.random.default_rng(3)
    away = rng.normal(size=(400, 2))
    away *= noise * 0.01 * rng.uniform(size=(400, 1)) / np.linalg.norm(away, axis=1)[:, None]
    assert len(find_corners(turn(400, 10.0) + away, 0.01, closed=True)) == 0
    found = find_corners(polygon(turn(4, 10.0), 100) + away, 0.01, closed=True)
    assert found.tolist() == [0, 100, 200, 300]


def test_ends_of_an_open_path_and_points_on_a_line_are_none():
    assert find_corners([[0, 0], [3, 0], [3, 3]], 0.01).tolist() == [1]
    assert len(find_corners([[0, 0], [3, 0]], 0.01)) == 0
    assert len(find_corners([[0.0], [1], [2], [1], [0]], 0.01)) == 0
    assert find_corners([[0.0], [1], [2], [1], [0]], 0.01, angle=1.0).tolist() == [2]


@given(st.integers(0, 2**32 - 1), st.booleans(), st.sampled_from([2, 3]), st.floats(-6, 6))
def test_laws(seed, closed, d, power):
    """Reversed, moved, turned, scaled and, closed, started elsewhere, a path has the same corners."""
    rng, tolerance = np.random.default_rng(seed), 0.03
    vertices = rng.integers(-4, 5, (6, d)).astype(float)
    vertices += rng.normal(size=vertices.shape) * 0.2
    points = polygon(vertices, 9)
    points += 1e-3 * rng.normal(size=points.shape)
    n = len(points)
    found = find_corners(points, tolerance, closed)
    assert find_corners(points[::-1], tolerance, closed).tolist() == (n - 1 - found)[::-1].tolist()
    scale = 10.0**power
    moved = scale * (points @ rotation(d, seed).T + 100.0)
    assert find_corners(moved, scale * tolerance, closed).tolist() == found.tolist()
    if closed:
        k = int(rng.integers(1, n))
        assert find_corners(np.roll(points, -k, axis=0), tolerance, True).tolist() == sorted((found - k) % n)


def test_bad_arguments():
    with pytest.raises(ValueError, match="must be positive, not 0 "):
        find_corners(turn(9), 0)
    with pytest.raises(ValueError, match=r"must be positive, not .* and -1"):
        find_corners(turn(9), 0.1, angle=-1)
    with pytest.raises(ValueError, match="row 1"):
        find_corners([[0, 0], [np.nan, 0], [1, 1]], 0.1)


@pytest.mark.parametrize("tolerance", [1e-3, 1e-4])
def test_true_corners_of_real_outlines_are_found(tolerance):
    known = found = 0
    for curve, true in with_corners("font_outline", "airfoil"):
        cleaned = clean(curve.points, closed=curve.closed)
        rows = np.searchsorted(cleaned.kept, true)
        corners = find_corners(cleaned.points, tolerance * curve.size, cleaned.closed)
        known += len(rows)
        found += len(np.intersect1d(rows, corners))
    assert known > 100
    assert found >= 0.97 * known


@pytest.mark.parametrize("tolerance", [1e-3, 1e-4])
@pytest.mark.parametrize(
    "shape", curves(per_family=1000, families=("tract", "backbone", "turbine_section", "cad_edge"))
)
def test_smooth_real_curves_have_none(shape, tolerance):
    corners = find_corners(shape.points, tolerance * shape.size, shape.closed)
    assert len(corners) <= 0.01 * len(shape.points)


def test_a_cusp_between_two_points_is_found_the_same_wherever_rounding_puts_it():
    """Two turns are equal but for rounding there: both points are corners, however the points are scaled and turned."""
    t = np.linspace(0.0, 8.0 * np.pi, 400)
    cycloid = np.column_stack([t - np.sin(t), 1.0 - np.cos(t)])
    expected = find_corners(cycloid, 2.5e-3)
    assert {199, 200} <= set(expected.tolist())
    for k in range(20):
        turned = 10.0 ** (k - 10) * cycloid @ rotation(2, k).T
        assert find_corners(turned, 2.5e-3 * 10.0 ** (k - 10)).tolist() == expected.tolist()
    assert (399 - find_corners(cycloid[::-1], 2.5e-3))[::-1].tolist() == expected.tolist()
