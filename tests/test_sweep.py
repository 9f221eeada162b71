"""Sweeps against the exact surface by brute force, by volume, topology, and closed forms."""

import numpy as np
import pytest

from cadfit import BSpline, Profile, local_spline, sweep

KNOTS = [0, 0, 0, 0, 1, 1, 1, 1]
SQUARE = [[-1, -1], [1, -1], [1, 1], [-1, 1]]


def circle(points=24, radius=1.0):
    t = 2 * np.pi * np.arange(points) / points
    return local_spline(radius * np.column_stack([np.cos(t), np.sin(t)]), closed=True)


def area(polygon):
    x, y = np.transpose(polygon)
    return 0.5 * (x @ np.roll(y, -1) - y @ np.roll(x, -1))


def test_a_straight_prism_with_a_hole():
    path = BSpline(np.outer([0, 1, 2, 5], [0, 0, 1]), KNOTS)
    mesh = sweep(path, Profile.of(SQUARE, 0.5 * np.array(SQUARE)))
    assert mesh.is_watertight
    assert mesh.is_winding_consistent
    assert mesh.euler_number == 0
    assert mesh.volume == pytest.approx(5.0 * 3.0, rel=1e-12)


def test_profile_moments_are_exact():
    profile = Profile.of(np.array(SQUARE) + [3, 1], [[3, 1], [3.5, 1], [3.5, 1.5], [3, 1.5]])
    assert profile.area == pytest.approx(3.75, rel=1e-14)
    assert profile.centroid == pytest.approx((np.array([3, 1]) * 4 - 0.25 * np.array([3.25, 1.25])) / 3.75, rel=1e-13)
    assert profile.reach == pytest.approx(np.hypot(4, 2))
    assert Profile.of(circle()).area == pytest.approx(np.pi, rel=1e-5)
    # Turned the right way, whichever way it came.
    assert Profile.of(SQUARE[::-1]).area == pytest.approx(4.0)
