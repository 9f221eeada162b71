import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

import cadfit
from cadfit.fitting.along import allowed, largest_rows, off_chords, off_points, trace
from cadfit.fitting.deviation import straying_chords
from cadfit.fitting.matching import distances

from reference import EPS

T = np.linspace(0.0, 2.0 * np.pi, 90, endpoint=False)
ELLIPSE = np.column_stack([3.0 * np.cos(T), 2.0 * np.sin(T)])
SQUARE = np.array([[0, 0], [1, 0], [2, 0], [2, 1], [2, 2], [1, 2], [0, 2], [0, 1.0]])
NOISY = np.column_stack([t := np.linspace(0, 9, 200), np.sin(t), np.cos(2 * t)])
NOISY += np.random.default_rng(2).normal(scale=0.01, size=NOISY.shape)
FITS = {
    "closed": cadfit.fit(ELLIPSE, 0.01, closed=True),
    "cornered": cadfit.fit(SQUARE, 0.01, closed=True),
    "noisy, in space": cadfit.fit(NOISY, 0.08),
    "1D": cadfit.fit(NOISY[:, 1:2], 0.08),
    "5D": cadfit.fit(NOISY @ np.random.default_rng(3).normal(size=(3, 5)), 0.3),
}


@pytest.mark.parametrize("fit", FITS.values(), ids=FITS)
def test_distances_along_a_fit_are_those_certified(fit):
    off = np.linalg.norm(off_points(fit), axis=1)
    assert off.max() <= fit.deviation.points <= off.max() * 1.001 + 1e-12
    assert off[fit.deviation.worst] >= off.max() - 8 * EPS  # of points on a straight side, rounding tells which it is
    u, between, chords = off_chords(fit, 60_000)
    assert between.max() <= fit.deviation.between <= between.max() * 1.01 + 1e-12
    low, high = cadfit.join(fit.curves).domain
    assert u.min() >= low
    assert u.max() <= high
    assert np.all(np.diff(u) >= 0.0)
    assert np.all(between <= allowed(fit)[chords] * (1.0 + 1e-9))
    assert set(chords.tolist()) == set(range(len(allowed(fit))))


def test_what_is_allowed_is_what_the_fit_was_held_to():
    fit = FITS["noisy, in space"]
    whole = cadfit.join(fit.curves)
    at = fit.parameters, distances(whole, fit.points, fit.parameters)
    assert len(straying_chords(whole, fit.points, *at, allowed(fit) * (1.0 + 1e-9))) == 0
    _, between, chords = off_chords(fit, 60_000)
    farthest = (between / allowed(fit)[chords]).max()
    assert len(straying_chords(whole, fit.points, *at, 0.99 * farthest * allowed(fit))) > 0
    assert allowed(FITS["closed"]).min() > 0.01
    assert_array_equal(allowed(cadfit.fit(SQUARE, 0.01, closed=True, between="polyline")), np.full(8, 0.01))
    assert allowed(cadfit.fit_dominant(NOISY, fraction=0.5)) is None


@pytest.mark.parametrize("fit", FITS.values(), ids=FITS)
def test_thinning_keeps_the_largest(fit):
    every, few = off_chords(fit, 60_000)[1], off_chords(fit, 50)[1]
    assert len(few) <= 50
    assert few.max() >= 0.8 * every.max() - 1e-12


def test_largest_rows_are_those_of_each_run():
    values = np.random.default_rng(0).normal(size=1000)
    rows = largest_rows(values, 10)
    assert_array_equal(values[rows], values.reshape(10, 100).max(axis=1))


@pytest.mark.parametrize("fit", FITS.values(), ids=FITS)
def test_a_trace_is_on_the_curves_and_as_long(fit):
    along, joined = trace(fit.curves), cadfit.join(fit.curves)
    assert along.length == pytest.approx(sum(curve.length() for curve in fit.curves), rel=1e-7)
    assert np.all(np.diff(along.s) >= 0.0)
    assert np.all(np.diff(along.u) >= 0.0)
    assert_allclose(along.places, joined(along.u), atol=1e-12 * joined.size)
    assert_array_equal(along.at(np.array(joined.domain)), [0.0, along.length])
    for k, curve in enumerate(fit.curves):
        inside = (along.u > curve.domain[0]) & (along.u < curve.domain[1])
        first, second = (np.linalg.norm(curve.derivative(along.u[inside], n), axis=1) for n in (1, 2))
        rounding = 16 * EPS * (second / first**2)[:, None]  # where a curve in one dimension all but stands still
        wanted = curve.curvature(along.u[inside])
        assert np.all(np.abs(along.curvature[inside] - wanted) <= 1e-7 + 1e-6 * np.abs(wanted) + rounding), k


def test_the_sharpest_bend_is_among_the_samples():
    along = trace(FITS["closed"].curves)
    every = np.linalg.norm(FITS["closed"].spline.curvature(np.linspace(*FITS["closed"].spline.domain, 400_001)), axis=1)
    assert np.abs(along.bend).max() >= every.max() * (1.0 - 1e-9)
    assert np.abs(along.bend).max() <= every.max() * (1.0 + 1e-6)


def test_bends_have_a_sign_in_the_plane_and_both_sides_at_a_jump():
    wave = cadfit.cardinal_pieces([[0, 0], [1, 1], [2, 0], [3, 1]])  # C1: the curvature jumps at the points
    along = trace([cadfit.pieces_to_spline(wave)])
    assert along.bend.min() < 0.0 < along.bend.max()
    before, after = np.flatnonzero(np.diff(along.span)), np.flatnonzero(np.diff(along.span)) + 1
    assert_allclose(along.places[before], along.places[after], atol=1e-15)
    assert_allclose(np.abs(along.bend[before] - along.bend[after]), 1.0)
