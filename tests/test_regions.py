"""Plane regions, held to polylines and to what is known of a shape."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import cadfit
from cadfit.bezier import evaluate
from cadfit.joining import join, periodic
from cadfit.regions import inside, meeting, polygon, signed_area


def _places(loop, n):
    return np.stack([evaluate(loop, t) for t in np.arange(n) / n], axis=1).reshape(-1, 2)


def _polyline_crosses(loop, n=60):
    """Whether any two edges of the loop's polyline cross, all pairs looked at."""
    start = _places(loop, n)
    leg = np.roll(start, -1, axis=0) - start
    gap = start[None] - start[:, None]
    cross = leg[:, None, 0] * gap[:, :, 1] - leg[:, None, 1] * gap[:, :, 0]
    across = cross * np.roll(cross, -1, axis=1) < 0
    return bool(np.any(across & across.T))


def _ring(seed):
    rng = np.random.default_rng(seed)
    n = int(rng.integers(4, 10))
    turn = np.arange(n) * 2 * np.pi / n
    ring = np.column_stack([np.cos(turn), np.sin(turn)]) * (1 + rng.uniform(-0.9, 0.9, (n, 1)))
    return periodic(ring + 0.25 * rng.normal(size=(n, 2)), np.arange(n + 1.0))


@given(st.integers(0, 10_000))
def test_crossings_are_those_of_the_polyline(seed):
    ring = _ring(seed)
    loop = ring.pieces()
    found = meeting([loop])
    assert (found is not None) == _polyline_crosses(loop)
    if found is not None:
        assert ring.nearest(found[2])[1] < 1e-9


@given(st.integers(0, 10_000), st.integers(0, 10_000))
def test_area_and_inside_are_those_of_the_polyline(seed, other):
    loop, small = _ring(seed).pieces(), 0.05 * _ring(other).pieces()
    x, y = _places(loop, 500).T
    assert signed_area(loop) == pytest.approx(0.5 * float(x @ np.roll(y, -1) - y @ np.roll(x, -1)), abs=1e-3)
    assert signed_area(loop[::-1, ::-1]) == pytest.approx(-signed_area(loop))
    if meeting([loop]) is None and meeting([small]) is None and meeting([loop, small]) is None:
        ray = _places(loop, 500) - small[0, 0]
        turned = np.diff(np.unwrap(np.arctan2(*np.append(ray, ray[:1], axis=0).T[::-1])), axis=0).sum()
        assert inside(small, loop) == (abs(turned) > 3)


def test_loops_that_meet_are_named():
    square = polygon([(0, 0), (4, 0), (4, 4), (0, 4)])
    assert meeting([square, 0.5 * square + 1.0]) is None
    assert meeting([square, square + 10.0, 0.5 * square + 3.0])[:2] == (0, 2)
    first, second, at = meeting([square, polygon([(4, 2), (6, 1), (6, 3)])])  # a vertex on a side
    assert (first, second) == (0, 1)
    assert at == pytest.approx([4, 2])
    assert meeting([square, square])[:2] in [(0, 0), (0, 1)], "one along the other"
    assert meeting([polygon([(0, 0), (2, 0), (2, 1), (1, 0), (0, 1)])])[2] == pytest.approx([1, 0])


@pytest.mark.parametrize("gap", [1e-3, 1e-6, 1e-9])
def test_what_nearly_meets_does_not(gap):
    slit = polygon([(0, 0), (9, 0), (9, 2), (5, gap), (1, 2)])
    assert meeting([slit]) is None
    assert meeting([polygon([(0, 0), (9, 0), (9, 2), (5, -gap), (1, 2)])]) is not None


def test_a_cusp_is_no_crossing():
    there = cadfit.BSpline([[0, 0], [1, 0], [2, 0], [3, 1]], [0] * 4 + [1] * 4)
    back = cadfit.BSpline([[3, 1], [2.5, 2], [1, 0], [0, 0]], [0] * 4 + [1] * 4)  # leaves along itself
    assert meeting([join([there, back]).pieces()]) is None


def test_one_piece_can_cross_itself():
    curl = np.array([[[0.0, 0.0], [3.0, 2.0], [-2.0, 2.0], [1.0, 0.0]]])
    closed = np.concatenate([curl, polygon([(1, 0), (0.5, -1), (0, 0)])[:2]])
    assert meeting([closed]) is not None
    assert _polyline_crosses(closed)


def test_many_pieces():
    turn = np.linspace(0, 2 * np.pi, 5000, endpoint=False)
    radius = 1 + 0.2 * np.cos(40 * turn)
    ring = cadfit.local_spline(radius[:, None] * np.column_stack([np.cos(turn), np.sin(turn)]), closed=True)
    assert meeting([ring.pieces()]) is None
    assert signed_area(ring.pieces()) == pytest.approx(np.pi * 1.02, rel=1e-6)
