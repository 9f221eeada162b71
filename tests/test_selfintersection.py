"""Sweeps that would pass through themselves: said where, and repaired, counted by an independent test."""

import warnings

import numpy as np
import pytest
import trimesh

from cadfit import BSpline, Profile, cardinal_spline, local_spline, polyline, sweep, tube
from cadfit.sweeping import touching
from cadfit.sweeping.selfintersection import SelfIntersectionError, SelfIntersectionWarning

from selfcrossing import crossing_faces

KNOTS = [0, 0, 0, 0, 1, 1, 1, 1]
BAR = np.array([[-0.3, -0.15], [0.3, -0.15], [0.3, 0.15], [-0.3, 0.15]])
TIGHT = BSpline([[-4, 4, 0], [0.5, -4, 0], [-0.5, -4, 0], [4, 4, 0]], KNOTS)
CUSP = BSpline([[0, 0, 0], [3, 3, 0], [0, 3, 0], [3, 0, 0]], KNOTS)
SHORT = polyline([[0, 0, 0], [5, 0, 0], [5, 0.4, 0], [0, 2.5, 0]])
BACK = polyline([[0, 0, 0], [5, 0, 0], [0, 0.5, 0]])


def loop():
    """A turn and a half of a spring with a pitch of 1."""
    t = np.linspace(0.0, 3.0 * np.pi, 40)
    return local_spline(np.column_stack([3 * np.cos(t), 3 * np.sin(t), t / (2 * np.pi)]))


def said_of(path, radius, **options):
    with pytest.raises(SelfIntersectionError) as error:
        tube(path, radius, on_self_intersection="raise", **options)
    return error.value.crossings


def test_the_independent_test_counts():
    one, two = trimesh.creation.box(), trimesh.creation.box()
    two.apply_translation([0.5, 0.4, 0.3])
    apart = trimesh.creation.box()
    apart.apply_translation([1.0, 0.0, 0.0])  # touches
    assert crossing_faces(one) == 0
    assert crossing_faces(trimesh.util.concatenate([one, apart])) == 0
    assert crossing_faces(trimesh.util.concatenate([one, two])) > 10
    assert crossing_faces(tube(TIGHT, 0.5)) == 0


@pytest.mark.parametrize(
    ("path", "radius", "kind", "parameter", "largest"),
    [
        (TIGHT, 1.5, "bend", 0.5, 0.574),
        (CUSP, 0.1, "cusp", 0.5, 0.0),
        (BACK, 0.3, "cusp", 5.0, 0.0),
        (SHORT, 0.5, "corner", 5.0, 0.24),
        pytest.param(loop(), 0.6, "near", None, 0.5, marks=pytest.mark.slow),
    ],
    ids=["tight", "cusp", "back", "short", "loop"],
)
def test_what_is_reported(path, radius, kind, parameter, largest):
    worst = said_of(path, radius)[0]
    assert worst.kind == kind
    assert worst.reach == radius
    assert np.abs(path(worst.parameter) - worst.position).max() < 1e-12
    if parameter is not None:
        assert worst.parameter == pytest.approx(parameter, abs=1e-3)
    assert worst.largest == pytest.approx(largest, rel=0.02)
    with pytest.warns(SelfIntersectionWarning, match="passes through itself at the parameter"):
        mesh = tube(path, radius)
    assert mesh.is_watertight
    assert crossing_faces(mesh) > 0
    if worst.largest:
        # A little less than the largest is right, and a little more is not.
        assert crossing_faces(tube(path, 0.98 * worst.largest, on_self_intersection="raise")) == 0
        with pytest.raises(SelfIntersectionError):
            tube(path, 1.05 * worst.largest, on_self_intersection="raise")


CASES = {"tight": (TIGHT, 1.5), "cusp": (CUSP, 0.1), "back": (BACK, 0.3), "short": (SHORT, 0.5), "loop": (loop(), 0.6)}


def inside_somewhere(path, radius, mesh, count=6_000):
    """The share of points well inside the mesh's box that are within the tube's discs, by distance to the path."""
    rng = np.random.default_rng(3)
    points = rng.uniform(*mesh.bounds, size=(count, 3))
    u, away = path.nearest(points)
    inner = (u > path.domain[0]) & (u < path.domain[1]) & (away < radius)
    return inner.mean() * np.prod(np.ptp(mesh.bounds, axis=0))


@pytest.mark.slow
@pytest.mark.parametrize("name", CASES)
def test_repaired_tubes_do_not_cross(name):
    pytest.importorskip("manifold3d")
    path, radius = CASES[name]
    mesh = tube(path, radius, 0.05 * radius, on_self_intersection="repair")
    assert mesh.is_watertight
    assert mesh.is_winding_consistent
    assert mesh.volume > 0.0
    assert len(mesh.split(only_watertight=False)) == 1
    assert crossing_faces(mesh) == 0
    # Its volume is that of the points within the radius of the path, but for the ends: by throwing points.
    assert mesh.volume == pytest.approx(inside_somewhere(path, radius, mesh), rel=0.1)


@pytest.mark.slow
@pytest.mark.parametrize("profile", [BAR, Profile.of(2 * BAR, BAR)], ids=["bar", "frame"])
@pytest.mark.parametrize("name", ["tight", "short", "loop"])
def test_repaired_profiles_do_not_cross(name, profile):
    pytest.importorskip("manifold3d")
    path, _ = CASES[name]
    scale = {"tight": 4.0, "short": 1.5, "loop": 3.5}[name]
    with pytest.raises(SelfIntersectionError):
        sweep(path, profile, scale=scale, on_self_intersection="raise")
    mesh = sweep(path, profile, scale=scale, on_self_intersection="repair")
    assert mesh.is_watertight
    assert mesh.volume > 0.0
    assert crossing_faces(mesh) == 0


def test_repair_leaves_what_is_right_alone():
    pytest.importorskip("manifold3d")
    for options in ({}, {"caps": "round"}, {"thickness": 0.1}):
        plain, repaired = (tube(TIGHT, 0.5, on_self_intersection=way, **options) for way in ("warn", "repair"))
        assert np.array_equal(plain.vertices, repaired.vertices)
        assert np.array_equal(plain.faces, repaired.faces)


def test_repair_keeps_round_caps_and_refuses_open_ends():
    pytest.importorskip("manifold3d")
    mesh = tube(TIGHT, 1.5, caps="round", on_self_intersection="repair")
    assert crossing_faces(mesh) == 0
    assert mesh.is_watertight
    assert mesh.volume > tube(TIGHT, 1.5, on_self_intersection="repair").volume + 0.9 * 4 / 3 * np.pi * 1.5**3
    with pytest.raises(ValueError, match="without caps encloses nothing"):
        tube(TIGHT, 1.5, caps="none", on_self_intersection="repair")


def test_repair_of_what_bends_too_tightly_looks_for_nothing_else(monkeypatch):
    pytest.importorskip("manifold3d")
    for room in ("judging", "tube"):
        monkeypatch.setattr(f"cadfit.sweeping.{room}.touching", lambda *_: pytest.fail("looked for"))
    assert tube(TIGHT, 1.5, on_self_intersection="repair").is_watertight


def test_an_unknown_answer():
    with pytest.raises(ValueError, match="on_self_intersection must be one of raise, warn, repair, not 'ignore'"):
        tube(TIGHT, 0.5, on_self_intersection="ignore")


def test_flat_ribbons_may_lie_side_by_side():
    """Wide but thin: the reaches overlap, the profiles do not."""
    t = np.linspace(0.0, 4.0 * np.pi, 60)
    spiral = local_spline(np.column_stack([(4 + t / 10) * np.cos(t), (4 + t / 10) * np.sin(t), 0 * t]))
    ribbon = [[-0.1, -2], [0.1, -2], [0.1, 2], [-0.1, 2]]
    mesh = sweep(spiral, ribbon, on_self_intersection="raise")
    assert crossing_faces(mesh) == 0
    with pytest.raises(SelfIntersectionError):
        sweep(spiral, 4 * np.array(ribbon), on_self_intersection="raise")


def said_and_seen(call):
    """Whether a sweep is said to pass through itself, and whether faces of its mesh do."""
    with warnings.catch_warnings(record=True) as said:
        warnings.simplefilter("always")
        mesh = call()
    return bool(said), crossing_faces(mesh) > 0


def test_a_bar_bent_the_easy_way():
    """Its corners are as far from the path as those of a circle, but none that far in the plane of the bend."""
    tall = np.array([[-0.3, -2], [0.3, -2], [0.3, 2], [-0.3, 2]])
    assert said_and_seen(lambda: sweep(TIGHT, tall)) == (False, False)
    assert said_and_seen(lambda: sweep(TIGHT, tall[:, ::-1])) == (True, True)


@pytest.mark.parametrize("caps", ["flat", "round"])
@pytest.mark.parametrize("gap", [0.8, 0.99, 1.01, 1.5, 1.9, 2.01])
def test_an_end_that_comes_near_a_wall(caps, gap):
    """A flat end meets a wall of radius 1 at a distance of 1, a round one at 2."""
    path = polyline([[0, -6, 0], [0, 6, 0], [6, 6, 0], [6, 0, 0], [gap, 0, 0]])
    meets = gap < (1.0 if caps == "flat" else 2.0)
    assert said_and_seen(lambda: tube(path, 1.0, caps=caps)) == (meets, meets)


@pytest.mark.parametrize("x", [1.5, 2.0, 2.5, 3.0, 3.5, 4.0])
def test_the_tip_of_a_mitre_that_comes_near_a_wall(x):
    """It reaches farther from the path than the profile does."""
    path = polyline([[0, -8, 0], [0, 8, 0], [10, 8, 0], [10, 3, 0], [x, 0, 0], [10, -3, 0]])
    said, seen = said_and_seen(lambda: tube(path, 1.0))
    assert said == seen == (x <= 3.0)


def flanges(turn, apart=3.0, neck=0.3):
    """A path that turns a little between two discs, each `apart` from the bend, and the tube's radius along it."""
    t = np.linspace(0.0, turn, 30)
    bend = 2 * np.column_stack([np.sin(t), 1 - np.cos(t), 0 * t])
    ahead = np.array([np.cos(turn), np.sin(turn), 0.0])
    legs = np.linspace(0.1, 2 * apart, 60)[:, None]
    path = local_spline(np.concatenate([-legs[::-1] * [1, 0, 0], bend, bend[-1] + legs * ahead]))
    places = path.nearest(np.array([[-apart, 0, 0], bend[-1] + apart * ahead]))[0]

    def radius(u):
        return neck + 8.0 * np.exp(-np.square((u[:, None] - places) / (0.02 * path.domain[1]))).sum(axis=1)

    return path, radius


@pytest.mark.slow
@pytest.mark.parametrize("turn", [20, 40, 60, 80])
def test_discs_on_both_sides_of_a_gentle_bend(turn):
    """Where each is the path is straight, and the neck between them has room in the bend."""
    path, radius = flanges(np.radians(turn))
    said, seen = said_and_seen(lambda: tube(path, radius, 0.1))
    assert said == seen == (turn >= 60)


@pytest.mark.parametrize("radius", [0.5, 0.8, 1.2, 3.0, 5.0])
@pytest.mark.parametrize("turn", [30, 60, 85, 120])
def test_cones_that_share_a_mitre(turn, radius):
    t = np.radians(turn)
    path = polyline([[-1, 0, 0], [0, 0, 0], [np.cos(t), np.sin(t), 0]])
    said, seen = said_and_seen(lambda: tube(path, [[0, radius], [1, 0.1], [2, radius]]))
    assert said == seen
    if seen:
        worst = said_of(path, [[0, radius], [1, 0.1], [2, radius]])[0]
        assert 0.0 < worst.largest < worst.reach


@pytest.mark.slow
def test_a_ribbon_that_turns_beside_a_bend_and_back():
    path, _ = flanges(np.radians(60))
    ribbon = [[-6, -0.1], [6, -0.1], [6, 0.1], [-6, 0.1]]
    low, high = path.domain
    middle, width = 0.5 * (low + high), high - low

    def twist(u):  # upright in the bend, flat before it and after it
        return 0.5 * np.pi * np.exp(-(((u - middle) / (0.15 * width)) ** 8))

    assert said_and_seen(lambda: sweep(path, ribbon, 0.1, twist=twist)) == (True, True)


ANGLE = np.array([[0, 0], [0.5, 0], [0.5, 0.1], [0.1, 0.1], [0.1, 0.5], [0, 0.5]])
ASIDE = np.array([[0.2, 0.2], [0.6, 0.2], [0.6, 0.4], [0.2, 0.4]])


@pytest.mark.parametrize(
    ("profile", "twist", "ends", "meets"),
    [
        (BAR, 8.0, [[-1.1, 0, 0], [0.45, 1.9, 0]], True),
        pytest.param(2 * BAR, 2.0, [[-1.3, 0, 0], [0.26, 1.97, 0]], True, marks=pytest.mark.slow),
        pytest.param(4 * BAR, 8.0, [[-0.5, 0, 0], [0.47, 0.27, 0]], True, marks=pytest.mark.slow),
        pytest.param(4 * ASIDE, -3.0, [[-2.2, 0, 0], [0.84, 1.54, 0]], True, marks=pytest.mark.slow),
        (BAR, 1.0, [[-2.2, 0, 0], [0.84, 1.54, 0]], False),
        (ANGLE, 0.3, [[-0.8715, 0, 0], [-1.239, 2.2224, 0]], False),  # with no room to grow for its volume
    ],
)
def test_a_twist_that_folds_the_walls_of_a_mitre(profile, twist, ends, meets):
    """Within one wall, where a fibre that runs aslant leaves the slope of the mitre on its wrong side."""
    path = polyline([ends[0], [0, 0, 0], ends[1]])
    assert said_and_seen(lambda: sweep(path, profile, 0.05, twist=twist)) == (meets, meets)


def test_a_fold_at_a_mitre_is_passed_by_where_there_is_room():
    """Rings too near to the slope for a fibre aslant are left out, and the walls are whole."""
    path = polyline([[-2, 0, 0], [0, 0, 0], [0.695, 0.8837, 0], [0.695, 0.8837, 2]])
    assert said_and_seen(lambda: sweep(path, 0.5 * ASIDE, 0.005, twist=2.0)) == (False, False)


@pytest.mark.slow
@pytest.mark.parametrize("case", ["bend", "corner"])
def test_repaired_discs_do_not_cross(case):
    pytest.importorskip("manifold3d")
    path, radius = flanges(np.radians(80))
    if case == "corner":
        path, radius = polyline([[-1, 0, 0], [0, 0, 0], [0.5, 0.75**0.5, 0]]), [[0, 5.0], [1, 0.1], [2, 5.0]]
    mesh = tube(path, radius, 0.1, on_self_intersection="repair")
    assert mesh.is_watertight
    assert crossing_faces(mesh) == 0
    with pytest.warns(SelfIntersectionWarning):
        crossed = tube(path, radius, 0.1)
    assert 0.8 * crossed.volume < mesh.volume < crossed.volume  # what was counted twice


@pytest.mark.slow
@pytest.mark.parametrize("share", [-3e-3, -1e-3, 3e-4, 1e-3, 3e-3])
@pytest.mark.parametrize("tolerance", [1e-2, 1e-3])
def test_touching_by_a_thousandth(share, tolerance):
    """What is said is what the mesh does, however near to touching; and that, up to the tolerance, is right."""
    radius = (1.0 + share) * 0.49933  # half of the distance of the turns
    said, seen = said_and_seen(lambda: tube(loop(), radius, tolerance * radius))
    assert said == seen
    if abs(share) > 2.0 * tolerance:
        assert said == (share > 0.0)


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(8))
def test_random_paths(seed):
    """Nothing said: nothing crosses. Something said: something does, or is within a tenth of it."""
    path = cardinal_spline(np.random.default_rng(seed).normal(size=(9, 3)), curvature=1.0, closed=seed % 2 == 0)
    radius = 0.1
    try:
        mesh = tube(path, radius, on_self_intersection="raise")
    except SelfIntersectionError as error:
        worst = error.crossings[0]
        with pytest.warns(SelfIntersectionWarning):
            assert crossing_faces(tube(path, 1.1 * radius)) > 0
        assert worst.largest <= radius
    else:
        assert crossing_faces(mesh) == 0


def test_a_path_that_crowds_is_still_said_to_touch_itself(monkeypatch):
    path = local_spline(np.random.default_rng(3).normal(size=(120, 3)))
    places = path(np.linspace(*path.domain, 3_000))
    everything = len(touching._pairs(places, 1.0))
    monkeypatch.setattr(touching, "_MOST_PAIRS", 20_000)
    assert everything > 200_000
    assert 3_000 < len(touching._pairs(places, 1.0)) < 40_000
    assert said_of(path, 0.02)[-1].kind == "near"
