"""The promise of a fit, by brute force; what a CAD user expects of corners, seams, noise and lines; laws."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import cadfit
from cadfit.bezier import distance_to_segment

from corpus_data import OWN, curves, rotation, shapes, turn
from judge import violations


def barry_goldman(a, b, c, d, count):
    """The centripetal Catmull-Rom curve from b to c, by repeated interpolation."""
    knots = np.cumsum([0.0, *(np.sqrt(np.linalg.norm(q - p)) for p, q in ((a, b), (b, c), (c, d)))])
    t = np.linspace(knots[1], knots[2], count)[:, None]

    def between(p, q, i, j):
        return ((knots[j] - t) * p + (t - knots[i]) * q) / (knots[j] - knots[i])

    first, second, third = between(a, b, 0, 1), between(b, c, 1, 2), between(c, d, 2, 3)
    return between(between(first, second, 0, 2), between(second, third, 1, 3), 1, 2)


def bulge(points, closed, row, count=200):
    """How far the centripetal cardinal curve strays from chord `row`."""
    n = len(points)
    if not closed and row in (0, n - 2):
        return end_bulge(points, row)
    a, b, c, d = (points[k % n] for k in (row - 1, row, row + 1, row + 2))
    return distance_to_segment(barry_goldman(a, b, c, d, count), b, c).max()


def promise(fit, points, closed, corners=(), between="curve", per_chord=80):
    """The largest distance of points to their places, and of the curve between them beyond what is allowed."""
    n, tolerance = len(points), fit.tolerance
    curve = cadfit.join(fit.curves)
    u = fit.parameters
    assert np.array_equal(fit.points, points)
    far = np.linalg.norm(curve(u) - points, axis=1).max()
    low, high = curve.domain
    if closed:
        start = int(np.argmin(u))
        around = np.concatenate([u[start:], u[:start]])
        assert np.all(np.diff(around) >= 0)
    else:
        assert np.all(np.diff(u) >= 0)
        assert (u[0], u[-1]) == (low, high)
    beyond = -np.inf
    stretches = cadfit.fitting.approximate.stretches(n, np.asarray(corners, dtype=int), closed)
    for rows in stretches:
        whole = closed and len(corners) == 0
        part = points[rows]
        for k in range(len(rows) - (not whole)):
            i, j = rows[k], rows[(k + 1) % len(rows)]
            a, b = u[i], u[j]
            if b < a:
                b += high - low
            at = a + np.linspace(0, 1, per_chord) * (b - a)
            places = curve(np.where(at > high, at - (high - low), at))
            strays = distance_to_segment(places, points[i], points[j]).max()
            allowed = 0.0 if between == "polyline" else bulge(part, whole, k)
            beyond = max(beyond, strays - tolerance - 1.5 * allowed)
    return far, beyond


def end_bulge(part, k):
    """How far the curve of an end's chord strays from it: a cubic from the parabola's direction to the chord's."""
    if len(part) == 2:
        return 0.0
    p, q, r = part[-3:] if k else part[2::-1]  # the end is r
    h, g = np.sqrt(np.linalg.norm(q - p)), np.sqrt(np.linalg.norm(r - q))
    tangent = ((q - p) / h * g + (r - q) / g * h) / (h + g)
    handles = np.array([q, q + tangent * g / 3, r - (r - q) / 3, r])
    t = np.linspace(0, 1, 200)[:, None]
    places = sum(
        w * h for w, h in zip([(1 - t) ** 3, 3 * t * (1 - t) ** 2, 3 * t**2 * (1 - t), t**3], handles, strict=True)
    )
    return distance_to_segment(places, q, r).max()


def held(fit, shape, between="curve"):
    """Assert all that a fit promises."""
    far, beyond = promise(fit, shape.points, shape.closed, fit.corners, between)
    rounding = 32 * np.finfo(float).eps * shape.reach  # of evaluating the curve here
    assert far - rounding <= fit.deviation.points <= fit.tolerance
    assert fit.deviation.points <= 1.01 * far + rounding
    assert beyond <= rounding
    for curve in fit.curves:
        assert np.all(curve.multiplicities[1:-1] == 1)
        assert len(curve.knots) == len(curve.poles) + 4
    for before, after in zip(fit.curves[:-1], fit.curves[1:], strict=True):
        assert np.array_equal(before.poles[-1], after.poles[0])
        assert before.domain[1] == after.domain[0]
    if shape.closed:
        assert np.array_equal(fit.curves[0].poles[0], fit.curves[-1].poles[-1])
    else:
        assert np.array_equal(fit.curves[0].poles[0], shape.points[0])
        assert np.array_equal(fit.curves[-1].poles[-1], shape.points[-1])
    joints = [curve.poles[0] for curve in fit.curves]
    for corner in fit.corners:
        assert any(np.array_equal(shape.points[corner], joint) for joint in joints)


def seam_jumps(spline):
    """The jumps of the first and second derivative at the seam, in parts of their sizes along the curve."""
    a, b = spline.domain
    return [
        np.linalg.norm(spline.derivative(np.array([a]), k) - spline.derivative(np.array([b]), k))
        / np.linalg.norm(spline.derivative(np.linspace(a, b, 500), k), axis=1).max()
        for k in (1, 2)
    ]


@pytest.mark.parametrize("shape", shapes(per_family=1, max_points=600))
@pytest.mark.parametrize("relative", [1e-2, 1e-4])
def test_the_promise_by_brute_force(shape, relative):
    fit = cadfit.fit(shape.points, relative * shape.size, closed=shape.closed, effort="fast")
    held(fit, shape)


@pytest.mark.parametrize("shape", curves(per_family=1, max_points=200))
def test_the_promise_between_vertices(shape):
    fit = cadfit.fit(shape.points, 3e-3 * shape.size, closed=shape.closed, effort="fast", between="polyline")
    held(fit, shape, "polyline")
    assert fit.deviation.between <= fit.tolerance


# What a CAD user expects.


@pytest.mark.parametrize("effort", ["fast", "best"])
def test_a_circle_has_few_poles_and_no_seam(effort):
    for n in (60, 200, 1000):
        fit = cadfit.fit(turn(n, 10.0), 0.01, closed=True, effort=effort)
        assert len(fit.spline.poles) <= (10 if effort == "best" else 12)
        assert max(seam_jumps(fit.spline)) < 1e-12
        held(fit, type(OWN["leaf"])(turn(n, 10.0), True))


@pytest.mark.slow
@pytest.mark.parametrize("start", [1, 77, 150])
@pytest.mark.parametrize("name", ["knot", "flower"])
def test_a_closed_curve_is_c2_at_the_seam_wherever_it_is(name, start):
    t = 2 * np.pi * np.arange(200) / 200
    flower = (10 + np.cos(5 * t)) * np.stack([np.cos(t), np.sin(t)])
    points = {"knot": trefoil(200), "flower": flower.T}[name]
    poles = len(cadfit.fit(points, 0.01, closed=True).spline.poles)
    rolled = cadfit.fit(np.roll(points, -start, axis=0), 0.01, closed=True)
    assert max(seam_jumps(rolled.spline)) < 1e-11
    assert abs(len(rolled.spline.poles) - poles) <= 0.05 * poles


@pytest.mark.parametrize("seed", range(4))
def test_a_seam_is_not_where_spans_are_short(seed):
    rng = np.random.default_rng(seed)
    outline = rng.uniform(5, 15, (20, 1)) * turn(20, 1.0)
    for tolerance in (1e-3, 1e-5, 1e-7):  # the closer ones round the joints of the points' own chain
        fit = cadfit.fit(outline, tolerance, closed=True, corners=None, effort="fast")
        assert max(seam_jumps(fit.spline)) < 1e-12


def airfoil(n):
    """A symmetric contour with a blunt trailing edge: the middle of that is halfway round from the leading edge."""
    x = 0.5 * (1 - np.cos(np.linspace(0, np.pi, n)))
    y = 0.6 * (0.2969 * np.sqrt(x) - 0.126 * x - 0.3516 * x**2 + 0.2843 * x**3 - 0.1015 * x**4)
    return np.concatenate([np.column_stack([x, y])[::-1], np.column_stack([x, -y])[1:]])


@pytest.mark.parametrize("n", [38, 90, 110, 126])
def test_a_symmetric_shape_takes_as_many_poles_however_it_is_turned(n):
    turns = [np.eye(2), *(rotation(2, seed) for seed in range(3))]
    counts = [cadfit.fit(airfoil(n) @ turn, 1e-3, closed=True, effort="fast").poles for turn in turns]
    assert max(counts) - min(counts) <= 1


def test_long_edges_between_short_chords_take_few_poles():
    angle = np.linspace(0, np.pi / 2, 16)
    quarter = np.column_stack([2 * np.cos(angle) + 20, 2 * np.sin(angle) + 20])
    outline = np.concatenate([quarter @ np.linalg.matrix_power([[0, 1], [-1, 0]], k) for k in range(4)])
    for effort, most in (("fast", 20), ("best", 12)):  # 25 with three samples on an edge, which left room to swing
        fit = cadfit.fit(outline, 0.044, closed=True, effort=effort)
        assert fit.poles <= most
        held(fit, type(OWN["leaf"])(outline, True))


@pytest.mark.parametrize(("radius", "half", "tolerance"), [(5, 15, 1e-3), (2, 22, 1e-3), (3, 15, 0.01)])
def test_best_takes_no_more_poles_than_fast_on_a_rounded_square(radius, half, tolerance):
    """A shape of which four alike knots have to go at once: one by one none could, from where many trials had led."""
    angle = np.linspace(0, np.pi / 2, 16)
    quarter = np.column_stack([radius * np.cos(angle), radius * np.sin(angle)]) + half - radius
    outline = np.concatenate([quarter @ np.linalg.matrix_power([[0, 1], [-1, 0]], k) for k in range(4)])
    best, fast = (cadfit.fit(outline, tolerance, closed=True, effort=effort).poles for effort in ("best", "fast"))
    assert best <= fast


def trefoil(n):
    t = 2 * np.pi * np.arange(n) / n
    return 10 * np.column_stack([np.sin(t) + 2 * np.sin(2 * t), np.cos(t) - 2 * np.cos(2 * t), -np.sin(3 * t)])


def test_a_trefoil_of_2000_points_takes_25_poles():
    fit = cadfit.fit(trefoil(2000), 1e-2, closed=True)
    assert len(fit.spline.poles) <= 25
    assert fit.deviation.points <= 1e-2


def test_a_noisy_circle_is_smoothed_within_the_tolerance_and_followed_where_that_is_less():
    rng = np.random.default_rng(7)
    points = turn(501, 50.0) + rng.normal(scale=0.05, size=(501, 2))
    smooth = cadfit.fit(points, 0.25, closed=True)
    assert len(smooth.spline.poles) <= 12
    assert abs(smooth.spline.length() / (100 * np.pi) - 1) < 0.003
    held(smooth, type(OWN["leaf"])(points, True))
    traced = cadfit.fit(points, 0.01, closed=True, effort="fast")
    held(traced, type(OWN["leaf"])(points, True))


@pytest.mark.slow
@pytest.mark.parametrize("seed", [1, 2])
def test_noise_at_twice_its_scale_takes_as_many_poles_whichever_way_it_is_turned(seed):
    """Strays are found while knots are added, and points side by side slide to one foot point: neither may run away."""
    points = turn(2000, 50.0) + np.random.default_rng(seed).normal(scale=0.05, size=(2000, 2))
    counts = []
    for angle in (0.0, 1.1):
        rotation = np.array([[np.cos(angle), np.sin(angle)], [-np.sin(angle), np.cos(angle)]])
        fit = cadfit.fit(points @ rotation, 0.1, closed=True, effort="fast")
        held(fit, type(OWN["leaf"])(points @ rotation, True))
        counts.append(len(fit.spline.poles))
    assert counts[0] == counts[1] <= 400


def test_a_straight_run_takes_four_poles():
    x = np.linspace(0, 3, 50) ** 2
    for points in (np.column_stack([x, 2 * x, 1 - x]), np.column_stack([x, x])[[0, -1]], x[:, None]):
        fit = cadfit.fit(points, 1e-6)
        assert len(fit.spline.poles) == 4
        assert fit.spline.length() == pytest.approx(np.linalg.norm(points[-1] - points[0]))


@pytest.mark.parametrize(("seed", "decades"), [(2, 2), (1, 3), (0, 5)])
@pytest.mark.parametrize("effort", ["fast", "best"])
def test_a_straight_run_takes_four_poles_however_unevenly_it_is_given(seed, decades, effort):
    along = np.cumsum(10 ** np.random.default_rng(seed).uniform(-decades, 0, 80))
    points = along[:, None] * np.array([3.0, 4.0, 1.0]) / along[-1]
    for tolerance in (1e-3, 1e-5, 1e-6):  # up to 86 poles, from samples taken for places where they are not
        assert cadfit.fit(points, tolerance * np.sqrt(26.0), effort=effort).poles == 4


@pytest.mark.parametrize("effort", ["fast", "best"])
def test_a_straight_run_takes_four_poles_in_noise_larger_than_the_spacing(effort):
    for seed, noise in ((0, 0.3), (1, 0.2), (2, 0.4)):
        rng = np.random.default_rng(seed)
        along = np.cumsum(10 ** rng.uniform(-5, 0, 60))
        points = along[:, None] * np.array([0.6, 0.8]) / along[-1] + noise * 1e-5 * rng.uniform(-0.7, 0.7, (60, 2))
        fit = cadfit.fit(points, 1e-5, effort=effort)
        assert fit.poles == 4
        held(fit, type(OWN["leaf"])(points, False))


@pytest.mark.slow
@pytest.mark.parametrize("effort", ["fast", "best"])
def test_points_far_nearer_each_other_than_the_tolerance_are_measured_at_their_own_places(effort):
    t = np.linspace(0, 1, 1500)  # 1.6 times as far as they are, where each moved by less than the way to the next
    points = np.column_stack([10 * t, np.sin(9 * t)])
    fit = cadfit.fit(points, 0.1, effort=effort)
    far = cadfit.deviation(fit, points)
    assert fit.deviation.points <= 1.01 * far.points
    assert fit.deviation.between <= 1.01 * far.between
    held(fit, type(OWN["leaf"])(points, False))


def test_a_square_of_four_vertices_is_four_straight_edges():
    fit = cadfit.fit(turn(4), 1e-6, closed=True, between="polyline")
    assert [len(curve.poles) for curve in fit.curves] == [4] * 4
    assert fit.corners.tolist() == [0, 1, 2, 3]
    assert fit.deviation.between < 1e-14
    with pytest.raises(ValueError, match=r"4 curves, split at 4 corners: use \.curves"):
        fit.spline  # noqa: B018
    held(fit, type(OWN["leaf"])(turn(4), True), "polyline")


def test_corners_are_kept_exactly_as_found_or_as_given():
    angle = np.linspace(0, np.pi, 40)
    arch = np.concatenate([np.column_stack([np.cos(angle), np.sin(angle)]), [[-0.5, 0], [0, 0], [0.5, 0]]])
    shape = type(OWN["leaf"])(arch, True)
    for corners in ("auto", 0.6, [0, 39], np.array([39, 0])):
        fit = cadfit.fit(arch, 1e-3, closed=True, corners=corners)
        assert fit.corners.tolist() == [0, 39]
        assert len(fit.curves) == 2
        assert len(fit.curves[1].poles) == 4
        held(fit, shape)
    smooth = cadfit.fit(arch, 1e-3, closed=True, corners=None)
    assert len(smooth.curves) == 1
    held(smooth, shape)
    one = cadfit.fit(arch, 1e-3, closed=True, corners=[39])
    assert len(one.curves) == 1
    assert np.array_equal(one.spline.poles[0], arch[39])


def test_repeats_are_dropped_and_counted_and_corners_given_in_the_callers_rows():
    points = np.repeat(turn(4), 2, axis=0)
    fit = cadfit.fit(points, 1e-6, closed=True, corners=[1, 2, 4, 7], between="polyline")
    assert fit.cleaned.tolist() == [1, 3, 5, 7]
    assert fit.corners.tolist() == [0, 1, 2, 3]


@pytest.mark.parametrize("between", ["curve", "polyline"])
@pytest.mark.parametrize("tolerance", [1e-1, 1e-3, 1e-5])
@pytest.mark.parametrize("start", [0, 20, 24])
def test_a_slot_whose_arcs_and_lines_meet_but_for_rounding_is_fitted(between, tolerance, start):
    half = np.linspace(-np.pi / 2, np.pi / 2, 24)
    arc = 3.0 * np.column_stack([np.cos(half), np.sin(half)])  # from 1.8e-16, -3 to 1.8e-16, 3
    slot = np.roll(np.vstack([arc, [[0, 3]], [-20, 0] - arc, [[0, -3]]]), -start, axis=0)
    fit = cadfit.fit(slot, tolerance, closed=True, between=between, effort="fast")
    assert violations(fit, slot, True, between) == []
    assert fit.poles <= 3 * len(slot) + 3


@pytest.mark.parametrize("start", [0, 1, 59, 118])
def test_two_ends_that_are_one_but_for_rounding_make_one_corner(start):
    x = 0.5 * (1.0 + np.cos(np.linspace(0.0, np.pi, 60)))
    y = 0.6 * (0.2969 * np.sqrt(x) + x * (-0.126 + x * (-0.3516 + x * (0.2843 - 0.1036 * x))))
    y[0] = 1.2e-17
    foil = np.roll(np.vstack([np.column_stack([x, y]), np.column_stack([x, -y])[-2::-1]]), -start, axis=0)
    fit = cadfit.fit(foil, 1e-3, closed=True, effort="fast")
    assert len(fit.corners) == len(fit.curves) == 1
    assert violations(fit, foil, True) == []


def test_points_that_are_one_but_for_rounding_at_the_ends_and_the_seam_are_passed_in_order():
    around = turn(60, 10.0)
    nudged = np.vstack([around[:1] + [0, 1e-15], around, around[:1] - [0, 2e-15]])
    for points, closed in ((nudged, True), (np.roll(nudged, 20, axis=0), True), (nudged[:40], False)):
        fit = cadfit.fit(points, 1e-3, closed=closed, effort="fast")
        assert violations(fit, points, closed) == []
    arch = np.vstack([around[:30], around[29:30] + [0, 1e-15]])
    fit = cadfit.fit(arch, 1e-3, effort="fast")
    assert violations(fit, arch, False) == []


def test_a_contour_smaller_than_rounding_is_refused_by_name():
    with pytest.raises(ValueError, match="float64 tells apart"):
        cadfit.fit([(1, 0), (1, 1e-30), (1 + 2e-16, 0)], 1e-12, closed=True)
    assert cadfit.fit([(1, 0), (1, 1e-30), (1, 2e-30)], 1e-12).deviation.points < 1e-12


@pytest.mark.parametrize("size", [1e-170, 1e-80, 1e80, 1e300])
def test_sizes_whose_squares_float64_does_not_hold_are_refused(size):
    with pytest.raises(ValueError, match=r"(size must be above 1e-60|must be below 1e\+60).*: scale them"):
        cadfit.fit(size * turn(20), 1e-3 * size, closed=True)


@pytest.mark.parametrize("effort", ["fast", "best"])
def test_no_tolerance_takes_more_poles_than_the_points_own_chain(effort):
    angle = np.sort(np.random.default_rng(5).uniform(0, 2 * np.pi, 20))
    outline = (1 + 0.3 * np.random.default_rng(6).normal(size=(20, 1))) * np.column_stack(
        [np.cos(angle), np.sin(angle)]
    )
    for tolerance in (1e-5, 1e-6, 1e-8):
        fit = cadfit.fit(outline, tolerance, closed=True, corners=None, effort=effort)
        assert fit.poles <= 2 * len(outline) + 3 + 1  # one for a seam away from short spans
        assert fit.deviation.points <= tolerance


def test_ends_have_the_tangents_asked_for():
    points = turn(60, 10.0)[:20]
    tangents = np.array([[0.1, 1.0], [-3.0, 0.2]])
    fit = cadfit.fit(points, 0.01, end_tangents=tangents)
    ends = fit.spline.derivative(np.array(fit.spline.domain))
    for found, asked in zip(ends, tangents, strict=True):
        assert found / np.linalg.norm(found) == pytest.approx(asked / np.linalg.norm(asked), abs=1e-10)
    held(fit, type(OWN["leaf"])(points, False))


@pytest.mark.slow
def test_two_points_have_the_tangents_asked_for():
    rng = np.random.default_rng(0)
    for _ in range(100):  # without samples between the points the equations were empty, and poles became infinite
        points, tangents = rng.normal(size=(2, 3)), rng.normal(size=(2, 3))
        curve = cadfit.fit(points, 1e-4, effort="fast", end_tangents=tangents).spline
        for leg, tangent in zip(
            (curve.poles[1] - curve.poles[0], curve.poles[-1] - curve.poles[-2]), tangents, strict=True
        ):
            assert leg @ tangent == pytest.approx(np.linalg.norm(leg) * np.linalg.norm(tangent))


def test_weights_draw_the_curve_nearer_and_the_tolerance_holds_for_all():
    rng = np.random.default_rng(1)
    points = turn(200, 10.0) + rng.uniform(-0.02, 0.02, (200, 2))
    heavy = np.where(np.arange(200) < 40, 100.0, 1.0)
    gaps = []
    for weights in (None, heavy):
        fit = cadfit.fit(points, 0.05, closed=True, weights=weights, effort="fast")
        held(fit, type(OWN["leaf"])(points, True))
        gaps.append(np.linalg.norm(fit.spline(fit.parameters) - points, axis=1)[:40].mean())
    assert gaps[1] < gaps[0]


def many(n, closed, noise, seed=3):
    """Points of which only some are fitted at first, given the noise's standard deviation."""
    t = 2 * np.pi * np.arange(n) / n
    points = np.column_stack([10 * np.cos(t) + np.sin(3 * t), 6 * np.sin(t), np.cos(2 * t)])
    points += np.random.default_rng(seed).normal(scale=noise, size=points.shape)
    return type(OWN["leaf"])(points if closed else points[: n // 2], closed)


@pytest.mark.slow
@pytest.mark.parametrize("closed", [False, True])
@pytest.mark.parametrize("noise", [0.0, 1.5e-3])
def test_many_points_take_no_more_poles_than_some(closed, noise):
    some, all_ = (
        cadfit.fit(shape.points, 0.01, closed=closed, effort="fast", corners=None)
        for shape in (many(2000, closed, noise), many(20000, closed, noise))
    )
    assert len(all_.spline.poles) <= 1.3 * len(some.spline.poles) + 1
    assert violations(all_, many(20000, closed, noise).points, closed) == []


@pytest.mark.slow
@pytest.mark.parametrize("rows", [[1234], [3000, 3001], [2, 7001, 7997]])
def test_points_out_of_line_are_held_among_many(rows):
    shape = many(16000, False, 1e-4)
    shape.points[rows] += [0.0, 0.0, 0.08]
    fit = cadfit.fit(shape.points, 0.01, effort="fast", corners=None)
    assert violations(fit, shape.points, False) == []
    assert len(fit.spline.poles) <= 300


@pytest.mark.slow
def test_noise_at_the_tolerance_is_followed_among_many_points():
    shape = many(5200, False, 4e-3)
    fit = cadfit.fit(shape.points, 0.01, effort="fast", corners=None)
    assert violations(fit, shape.points, False) == []


@pytest.mark.slow
def test_noise_at_two_and_a_half_times_its_scale_is_followed_among_many_points():
    points = turn(20000, 50.0) + np.random.default_rng(1).normal(scale=0.05, size=(20000, 2))
    fit = cadfit.fit(points, 0.125, closed=True, effort="fast")
    assert len(fit.spline.poles) <= 2500
    assert violations(fit, points, True) == []


# Laws.


@pytest.mark.slow
@settings(max_examples=12, deadline=None)
@given(st.integers(0, 2**32 - 1), st.booleans(), st.sampled_from([2, 3]), st.sampled_from(["fast", "best"]))
def test_reversed_moved_turned_and_scaled_points_have_the_same_fit(seed, closed, d, effort):
    rng = np.random.default_rng(seed)
    t = 2 * np.pi * np.arange(90) / 90
    waves = np.stack([np.cos(k * t) for k in (1, 2, 3)] + [np.sin(k * t) for k in (1, 2, 3)], axis=1)
    points = (waves @ rng.normal(size=(6, d)))[: 90 if closed else 70]
    size = np.linalg.norm(np.ptp(points, axis=0))
    tolerance = 2e-3 * size

    def found(points, scale=1.0):
        fit = cadfit.fit(points, scale * tolerance, closed=closed, effort=effort, corners=None)
        return fit.poles, fit.deviation.points / scale

    poles, far = found(points)
    rounding = 1e-4  # of the tolerance, where the points are 1e6 sizes away
    for other, near in [
        (found(points[::-1]), None),
        (found(points @ rotation(d, seed).T), 0.01),
        (found(points * 1e-6, 1e-6), 0.01),
        (found(points * 1e6, 1e6), 0.01),
        (found(points + 1e6 * size), 0.01),
    ]:
        assert abs(other[0] - poles) <= 1
        if near is not None and other[0] == poles:
            assert other[1] == pytest.approx(far, rel=near, abs=rounding * tolerance)


# Bad arguments.


@pytest.mark.parametrize("scale", [1.0, 1e200])
@pytest.mark.parametrize("which", [0, 1])
def test_a_direction_may_be_given_at_one_end_alone(which, scale):
    x = np.linspace(0.0, 6.0, 60)
    points = np.column_stack([x, np.sin(x)])
    given, directions = [None, None], np.array([[1.0, 1.4], [1.0, 0.7]])
    given[which] = scale * directions[which]
    fit = cadfit.fit(points, 0.01, end_tangents=given)
    ends = [fit.spline.derivative(u) for u in fit.spline.domain]
    turned = [
        abs(np.linalg.det(vectors) / np.prod(np.linalg.norm(vectors, axis=1)))
        for vectors in (np.array([end, direction]) for end, direction in zip(ends, directions, strict=True))
    ]
    assert turned[which] < 1e-9
    assert turned[1 - which] > 1e-3
    held(fit, type(OWN["leaf"])(points, False))


@pytest.mark.parametrize(("values", "tolerance"), [([0.9, 2.6, 1.0, 0.0], 1e-3), ([-1.7, -2.2, -1.3, -2.0], 1e-2)])
def test_nothing_is_divided_by_errors_that_are_all_zero(values, tolerance):
    """On a line a pass may meet all points exactly, to the last bit."""
    points = np.array(values)[:, None]
    held(cadfit.fit(points, tolerance, between="polyline", corners=None), type(OWN["leaf"])(points, False), "polyline")


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"tolerance": 0.0}, "the tolerance must be at least .* not 0.0"),
        ({"tolerance": -1.0}, "the tolerance must be at least"),
        ({"tolerance": 1e-18}, "the tolerance must be at least .* for points of this size, not 1e-18"),
        ({"tolerance": np.nan}, "the tolerance must be at least"),
        ({"tolerance": np.inf}, "the tolerance must be below 1e\\+60, not inf"),
        ({"between": "chord"}, "between must be one of"),
        ({"effort": "most"}, "effort must be one of"),
        ({"corners": "all"}, 'corners must be "auto", None, an angle'),
        ({"corners": True}, 'corners must be "auto", None, an angle'),
        ({"corners": 40.0}, "angle must be in radians, above 0 and at most pi, not 40"),
        ({"corners": [0.5, 2]}, "whole numbers"),
        ({"corners": [3, 99]}, "rows of the points, 0 to"),
        ({"corners": [-1]}, "rows of the points, 0 to"),
        ({"weights": np.ones(3)}, "weights must be 40 positive numbers"),
        ({"weights": np.zeros(40)}, "weights must be 40 positive numbers"),
        ({"end_tangents": np.ones((2, 2))}, "a closed curve has no ends"),
        ({"end_tangents": np.ones((2, 3)), "closed": False}, r"two finite directions, shape \(2, 2\)"),
        ({"end_tangents": np.zeros((2, 2)), "closed": False}, "none of them zero"),
        ({"end_tangents": [[1, 0], [1, np.nan]], "closed": False}, "two finite directions"),
        ({"end_tangents": [[1, 0]], "closed": False}, "two finite directions"),
        ({"end_tangents": [[1, 0], "up"], "closed": False}, "two finite directions"),
        ({"end_tangents": 5.0, "closed": False}, "two finite directions"),
        ({"points": [[0, 0], [1, np.inf], [2, 2]]}, "row 1"),
        ({"points": [[1, 1], [1, 1]], "closed": False}, "at least 2 distinct points"),
    ],
)
def test_bad_arguments(change, message):
    arguments = {"points": turn(40), "tolerance": 0.01, "closed": True} | change
    with pytest.raises(ValueError, match=message):
        cadfit.fit(arguments.pop("points"), arguments.pop("tolerance"), **arguments)


def test_the_least_tolerance_named_can_be_held_where_the_points_are_far_away():
    points = turn(30) + 1e8
    with pytest.raises(ValueError, match="at least") as error:
        cadfit.fit(points, 1e-9, closed=True)
    least = float(str(error.value).split("at least ")[1].split()[0])
    fit = cadfit.fit(points, least, closed=True, effort="fast")
    assert fit.deviation.points <= 1.01 * least


def test_progress_runs_to_one():
    seen = []
    cadfit.fit(turn(4), 1e-3, closed=True, between="polyline", progress=seen.append)
    assert seen == [0.25, 0.5, 0.75, 1.0]
    for effort in ("fast", "best"):
        seen.clear()
        cadfit.fit(turn(60), 1e-3, closed=True, effort=effort, progress=seen.append)
        assert len(seen) >= 3
        assert seen == sorted(seen)
        assert seen[-1] == 1.0


def test_spans_that_a_check_took_back_are_taken_away_again():
    """A tolerance below the noise: what the check of few spans mends may have every span again."""
    angle = np.linspace(0, 2 * np.pi, 501)[:-1]
    for seed in (0, 1):
        radius = 50 + np.random.default_rng(seed).normal(scale=0.05, size=500)
        scan = radius[:, None] * np.column_stack([np.cos(angle), np.sin(angle)])
        assert cadfit.fit(scan, 0.01, closed=True, effort="fast").poles < 450
