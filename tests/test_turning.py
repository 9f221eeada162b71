"""Fits of polylines follow the chords and round the corners: no loops, no wiggles; by the benchmarks' sampled judge."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from turning import LOOP, SHORT, angles, looked_at, runs, turning

import cadfit
from cadfit.fitting.checking import Stretch
from cadfit.fitting.rounded import rounded_polyline
from cadfit.fitting.spans import Curve, Spans
from cadfit.fitting.turning import span_turns, worst_run

from corpus_data import Shape, curves, point_rows, turn
from judge import violations

X = np.linspace(0.0, 2.0 * np.pi, 60)
WAVE = Shape(np.column_stack([X, 3.0 * np.sin(X)]), False)
OVAL = Shape(turn(59) * [12.0, 6.0], True)
KNOTTED = Shape(np.column_stack([np.sin(2.0 * X), np.sin(3.0 * X), np.cos(5.0 * X)])[:-1], True)


def follows(shape, tolerance, **options):
    """Fit the polyline, assert what it promises and that it does not loop, and return the fit and how it turns."""
    fit = cadfit.fit(shape.points, tolerance, closed=shape.closed, between="polyline", effort="fast", **options)
    assert violations(fit, shape.points, shape.closed, "polyline") == []
    found = turning(fit)
    assert found.loops == 0
    return fit, found


# The judge.


def test_the_judge_counts_the_turns_of_a_circle_and_of_a_loop_in_it():
    points = turn(40, 10.0)
    fit = cadfit.fit(points, 0.1, closed=True, between="polyline")
    round_ = turning(fit)
    assert round_.curve == pytest.approx(2.0 * np.pi, rel=1e-3)
    assert round_.loops == 0
    assert round_.polyline == pytest.approx(2.0 * np.pi, rel=1e-12)
    assert round_.length == pytest.approx(1.0, rel=0.01)
    loop = np.array([[0, 0], [4, 0], [7, 0], [8, 4], [5, 4], [6, 0], [9, 0], [13, 0]], float)
    looped = cadfit.BSpline(loop, [0, 0, 0, 0, 1, 2, 3, 4, 5, 5, 5, 5])
    for count in (2, 14):
        line = np.column_stack([np.linspace(0.0, 13.0, count), np.zeros(count)])
        at = np.linspace(0.0, 5.0, count)
        found = turning(replace(fit, curves=(looped,), points=line, parameters=at, closed=False))
        assert found.loops == 1
        assert found.excess == pytest.approx(2.0 * np.pi, rel=1e-2)
        assert found.length > 1.2


@given(st.integers(0, 2**32 - 1))
def test_the_worst_run_is_the_largest_of_all_runs(seed):
    rng = np.random.default_rng(seed)
    n = int(rng.integers(2, 9))
    vertices = np.sort(rng.uniform(0, 10, n))
    turns, along = rng.uniform(0, 2, n), np.sort(rng.uniform(0, 10, 14))
    curve, reach = np.cumsum(rng.uniform(0, 2, 14)), float(rng.choice([0.0, 0.5, 3.0]))
    slow = short = 0.0
    for i in range(14):
        for j in range(i, 14):
            first = min(np.sum(vertices < along[i]) - 1, np.sum(vertices < along[i] - reach))
            last = max(np.sum(vertices < along[j]) + 1, np.sum(vertices <= along[j] + reach))
            beyond = curve[j] - curve[i] - turns[max(first, 0) : max(last, 0)].sum()
            slow, short = max(slow, beyond), max(short, beyond if j - i <= SHORT else 0.0)
    largest, loops = runs(curve, along, vertices, turns, reach)
    assert (loops > 0) == (short > LOOP)
    assert largest == pytest.approx(slow, abs=1e-9)


# What fits use.


@settings(max_examples=60)
@given(st.integers(0, 2**32 - 1), st.sampled_from([1, 2, 3, 9]), st.sampled_from([2, 3]), st.booleans())
def test_what_spans_turn_is_bounded_from_above(seed, m, d, closed):
    rng = np.random.default_rng(seed)
    m = max(m, 4) if closed else m
    knots = np.concatenate([[0.0], np.cumsum(10.0 ** rng.uniform(-1, 1, m))])
    curve = Curve(Spans(knots, closed), rng.normal(size=(d, m if closed else m + 3)))
    bound = span_turns(curve)
    for k in range(m):
        x = np.linspace(0.0, 1.0, 2000)[:, None]
        _, b, c, e = curve.powers[:, :, k]
        along = b + x * (2.0 * c + x * 3.0 * e)
        assert angles(along[:-1], along[1:]).sum() <= bound[k] + 1e-6


@settings(max_examples=60, deadline=None)
@given(point_rows(dimensions=(2, 3), least=4, most=20, rough=False), st.booleans(), st.floats(1e-6, 1e-1))
def test_a_rounded_polyline_turns_no_more_than_it_and_keeps_the_tolerance(points, closed, tolerance):
    rows = np.arange(len(points))
    alone = np.zeros(len(points), dtype=bool)
    stretch = Stretch(points, tolerance, closed, True, np.ones(len(points)), alone, (None, None))
    trial = rounded_polyline(stretch.goal(rows), 0.99)
    _, turned, _, _, _ = looked_at([trial.curve.spans.spline(trial.curve.poles)])
    chords = np.diff(points, axis=0, append=points[:1])
    turns = angles(np.roll(chords, 1, axis=0), chords)
    assert turned.sum() <= (turns.sum() if closed else turns[1:-1].sum()) + 1e-6
    assert trial.worst <= 0.99 + 1e-6


def test_a_loop_is_found_where_it_is():
    t = np.linspace(0.0, 10.0, 11)
    line = np.stack([t, 0.0 * t])
    knots = np.linspace(0.0, 10.0, 21)
    spans = Spans(knots, False)
    averages = np.convolve(spans.extended, np.ones(3) / 3.0, "valid")[1:-1]
    poles = np.stack([averages, 0.0 * averages])
    assert worst_run(Curve(spans, poles), line, t, 0.01)[0] <= 0.0
    looped = poles.copy()
    looped[:, 9:13] += np.array([[1.5, 1.0, -1.0, -1.5], [0.0, 1.0, 1.0, 0.0]])
    excess, first, stop = worst_run(Curve(spans, looped), line, t, 0.01)
    assert excess > np.pi
    assert 5 <= first < stop <= 13


# What a user gets.


@pytest.mark.parametrize("shape", [WAVE, OVAL, KNOTTED], ids=["wave", "oval", "knotted"])
@pytest.mark.parametrize(
    "share", [3e-3, 1e-3, *(pytest.param(share, marks=pytest.mark.slow) for share in (3e-4, 1e-4, 1e-5))]
)
def test_below_the_sagitta_the_corners_are_rounded(shape, share):
    fit, found = follows(shape, share * shape.size, corners=None)
    assert found.curve <= 1.15 * found.polyline + 0.1
    assert 0.98 < found.length <= 1.001
    assert found.bend < 3.5
    assert found.slowest > 0.1
    assert fit.poles <= 3 * len(shape.points) + 4


@pytest.mark.slow
def test_the_poles_rise_gently_from_a_smooth_curve_to_rounded_corners():
    poles = [follows(WAVE, tolerance)[0].poles for tolerance in (0.01, 0.005, 0.0025, 0.0015, 0.001, 0.0003, 0.0001)]
    assert poles == sorted(poles)
    assert max(b / a for a, b in zip(poles[:-1], poles[1:], strict=True)) < 3.0
    assert poles[-1] <= 3 * 58 + 4


@pytest.mark.parametrize("tolerance", [1e-2, 1e-3, 1e-4])
def test_given_directions_at_the_ends_are_kept_without_loops(tolerance):
    directions = np.array([[1.0, 0.0], [0.0, 1.0]])
    fit, _ = follows(WAVE, tolerance, end_tangents=directions)
    low, high = fit.spline.domain
    for u, direction in zip((low, high), directions, strict=True):
        velocity = fit.spline.derivative(np.array([u]), 1)[0]
        assert velocity @ direction == pytest.approx(np.linalg.norm(velocity), rel=1e-9)


@pytest.mark.slow
@pytest.mark.parametrize("shape", curves(per_family=1, max_points=150))
@pytest.mark.parametrize("share", [1e-3, 1e-4, 1e-5])
def test_real_polylines_are_followed_without_loops(shape, share):
    _, found = follows(shape, share * shape.size)
    assert found.curve <= 1.25 * found.polyline + 0.5
