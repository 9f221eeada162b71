"""Sweeps against the exact surface by brute force, by volume, topology, and closed forms."""

import warnings

import numpy as np
import pytest
import trimesh
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial import cKDTree

from cadfit import BSpline, Profile, cardinal_spline, fit, frames, frenet, join, local_spline, polyline, sweep, tube
from cadfit.sweeping.caps import flat_cap
from cadfit.sweeping.laws import largest, law_of, smallest
from cadfit.sweeping.profile import polygons
from cadfit.sweeping.texture import textured

KNOTS = [0, 0, 0, 0, 1, 1, 1, 1]
BAR = np.array([[-0.3, -0.15], [0.3, -0.15], [0.3, 0.15], [-0.3, 0.15]])
BEND = BSpline([[0, 0, 0], [4, 0, 0], [5, 1, 0], [5, 5, 2]], KNOTS)


def ring(radius=1.0, points=24):
    t = 2 * np.pi * np.arange(points) / points
    return local_spline(radius * np.column_stack([np.cos(t), np.sin(t)]), closed=True)


def egg():
    t = 2 * np.pi * np.arange(20) / 20
    return local_spline(np.column_stack([0.4 * np.cos(t) + 0.1, 0.25 * np.sin(t) * (1 + 0.3 * np.cos(t))]), closed=True)


def trefoil(points=60):
    t = np.linspace(0.0, 2.0 * np.pi, points, endpoint=False)
    knot = np.column_stack([np.sin(t) + 2 * np.sin(2 * t), np.cos(t) - 2 * np.cos(2 * t), -np.sin(3 * t)])
    return cardinal_spline(knot, curvature=1.0, closed=True)


def check_solid(mesh, euler=2):
    assert mesh.is_watertight
    assert mesh.is_winding_consistent
    assert mesh.euler_number == euler
    assert mesh.volume > 0.0
    assert mesh.area_faces.min() > 0.0
    assert len(np.unique(mesh.faces)) == len(mesh.vertices)


# The exact surface: points of the outline in the frames of the path, scaled and turned.


def exact(path, outline, u, v, scale=None, twist=None, up=None):
    f = frames(path, u, up)
    x, y = outline(v).T
    size = 1.0 if scale is None else scale(u)
    angle = 0.0 if twist is None else twist(u)
    c, s = np.cos(angle), np.sin(angle)
    x, y = size * (c * x - s * y), size * (s * x + c * y)
    return f.origins + x[:, None] * f.normals + y[:, None] * f.binormals


def distances_to(triangles, points):
    """From each point to the nearest triangle: every triangle that could be it."""
    low, high = triangles.min(axis=1), triangles.max(axis=1)
    out = []
    for point in points:
        box = np.linalg.norm(np.maximum(np.maximum(low - point, point - high), 0.0), axis=1)
        best = np.linalg.norm(triangles[:, 0] - point, axis=1).min()
        near = triangles[box <= best]
        closest = trimesh.triangles.closest_point(near, np.broadcast_to(point, (len(near), 3)))
        out.append(np.linalg.norm(closest - point, axis=1).min())
    return np.array(out)


CASES = {
    "bar": (BEND, BAR, {}),
    "egg": (BEND, egg(), {}),
    "scaled": (BEND, BAR, {"scale": lambda u: 1.0 + 0.5 * np.sin(5 * u)}),
    "twisted": (BEND, BAR, {"twist": lambda u: 3.0 * u * u}),
    "up": (BEND, BAR, {"up": [0, 0, 1]}),
    "all": (BEND, egg(), {"scale": lambda u: 1.5 - u, "twist": lambda u: -2 * u, "up": [0.1, 0, 1]}),
    "closed": (trefoil(), BAR, {}),
}


@pytest.mark.slow
@pytest.mark.parametrize("name", CASES)
@pytest.mark.parametrize("share", [0.1, 0.02])
def test_within_tolerance_of_the_exact_surface_both_ways(name, share):
    path, profile, options = CASES[name]
    outline = Profile.of(profile).outline
    tolerance = share * Profile.of(profile).reach
    mesh = sweep(path, profile, tolerance, **options)
    check_solid(mesh, 0 if path.closed else 2)
    rng = np.random.default_rng(1)
    u, v = rng.uniform(*path.domain, 400), rng.uniform(*outline.domain, 400)
    surface = exact(path, outline, u, v, **options)
    assert distances_to(mesh.triangles, surface).max() <= tolerance
    # And the mesh to the surface, which is sampled so densely that its gaps hardly matter.
    corner_of_cap = np.abs(mesh.face_normals @ frames(path, path.domain).tangents.T).max(axis=1) > 0.999
    walls = mesh.triangles[~corner_of_cap] if not path.closed else mesh.triangles
    chosen = walls[rng.integers(len(walls), size=3000)]
    points = np.einsum("nk,nkd->nd", rng.dirichlet([0.5, 0.5, 0.5], size=len(chosen)), chosen)
    many = 1600 if path.closed else 700
    grid = [np.linspace(*curve.domain, count) for curve, count in ((path, many), (outline, 400))]
    u, v = (axis.ravel() for axis in np.meshgrid(*grid, indexing="ij"))
    dense = exact(path, outline, u, v, **options)
    step = np.linalg.norm(np.diff(dense.reshape(many, 400, 3), axis=0), axis=2).max()
    across = np.linalg.norm(np.diff(dense.reshape(many, 400, 3), axis=1), axis=2).max()
    gap = 0.5 * np.hypot(step, across)
    away = cKDTree(dense).query(points)[0]
    assert away.max() <= np.hypot(tolerance, gap)


def test_the_judge_of_distances_sees_a_ring_out_of_place():
    mesh = sweep(BEND, BAR, 0.03)
    outline = Profile.of(BAR).outline
    u, v = (np.random.default_rng(2).uniform(*c.domain, 300) for c in (BEND, outline))
    surface = exact(BEND, outline, u, v)
    assert distances_to(mesh.triangles, surface).max() <= 0.03
    vertices = mesh.vertices.copy()
    middle = len(vertices) // 8 * 4
    vertices[middle : middle + 4] += [0.0, 0.0, 0.1]
    broken = trimesh.Trimesh(vertices, mesh.faces, process=False)
    assert distances_to(broken.triangles, surface).max() > 0.03


def pappus(path, profile, scale=lambda u: np.ones_like(u), count=200_001):
    """The volume by plain sums along the path: area less the pull of the bends on the centroid."""
    u = np.linspace(*path.domain, count)
    speed = np.linalg.norm(path.derivative(u), axis=1)
    f = frames(path, u)
    x, y = profile.centroid
    arm = x * f.normals + y * f.binormals
    s = scale(u)
    held = profile.area * (s**2 - s**3 * np.einsum("nd,nd->n", path.curvature(u), arm))
    return np.trapezoid(held * speed, u)


@pytest.mark.parametrize("profile", [BAR, egg(), BAR + [0.1, 0.2]], ids=["bar", "egg", "beside the path"])
@pytest.mark.parametrize("closed", [False, True])
def test_volume(profile, closed):
    path = trefoil() if closed else BEND
    profile = Profile.of(profile)
    mesh = sweep(path, profile, 0.05 * profile.reach)
    assert mesh.volume == pytest.approx(pappus(path, profile), rel=1e-4 if closed else 2e-5)


def test_volume_with_what_varies():
    profile = Profile.of(BAR)
    size = lambda u: 1.0 + 0.5 * np.sin(5 * u)  # noqa: E731
    mesh = sweep(BEND, BAR, scale=size, twist=2.0)
    assert mesh.volume == pytest.approx(pappus(BEND, profile, size), rel=1e-4)


# Profiles.


def test_a_straight_prism_with_a_hole():
    path = BSpline(np.outer([0, 1, 2, 5], [0, 0, 1]), KNOTS)
    mesh = sweep(
        path,
        Profile.of(
            BAR,
            0.5 * BAR,
        ),
    )
    check_solid(mesh, 0)
    assert mesh.volume == pytest.approx(5.0 * 0.75 * 0.18, rel=1e-12)


def test_profile_moments_are_exact():
    square = np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]])
    profile = Profile.of(square + [3, 1], [[3, 1], [3.5, 1], [3.5, 1.5], [3, 1.5]])
    assert profile.area == pytest.approx(3.75, rel=1e-14)
    assert profile.centroid == pytest.approx((np.array([3, 1]) * 4 - 0.25 * np.array([3.25, 1.25])) / 3.75, rel=1e-13)
    assert profile.reach == pytest.approx(np.hypot(4, 2))
    assert Profile.of(ring()).area == pytest.approx(np.pi, rel=1e-5)
    assert Profile.of(square[::-1]).area == pytest.approx(4.0)  # turned the right way, whichever way it came
    assert Profile.of(fit(ring()(np.linspace(0, ring().domain[1], 200)), 1e-4)).area == pytest.approx(np.pi, rel=1e-3)


@pytest.mark.parametrize("outline", [ring(), egg()], ids=["ring", "egg"])
@pytest.mark.parametrize("tolerance", [3e-2, 1e-3])
def test_polygons_keep_area_and_tolerance(outline, tolerance):
    profile = Profile.of(outline)
    (polygon,) = polygons(profile, tolerance)
    x, y = polygon.T
    assert 0.5 * (x @ np.roll(y, -1) - y @ np.roll(x, -1)) == pytest.approx(profile.area, rel=1e-12)
    edges = np.concatenate([polygon + t * (np.roll(polygon, -1, axis=0) - polygon) for t in np.linspace(0, 1, 9)])
    assert profile.outline.nearest(edges)[1].max() <= tolerance


def test_corners_of_a_profile_stay():
    half = join([BSpline([[1, 0], [1, 1], [-1, 1], [-1, 0]], KNOTS), polyline([[-1, 0], [1, 0]])])
    (polygon,) = polygons(Profile.of(half), 0.01)
    for corner in ([1, 0], [-1, 0]):
        assert np.abs(polygon - corner).sum(axis=1).min() < 1e-15


def test_bad_profiles():
    for bad, said in [
        ([[0, 0], [1, 0]], "n >= 3"),
        ([[0, 0], [1, 0], [2, 0]], "no area"),
        ([[0, 0], [1, 1], [1, 0], [0, 1.5]], "passes through itself"),
        ([[0, 0], [1, 0], [np.nan, 1]], "corner 2 .* not finite"),
        (BSpline([[0, 0], [1, 0], [1, 1], [0, 1]], KNOTS), "not closed: its ends are 1 apart"),
        (BSpline(np.zeros((4, 3)), KNOTS), "2 dimensions, not 3"),
        (Profile.of(0.5 * BAR, BAR), "cannot be filled"),
    ]:
        with pytest.raises(ValueError, match=said):
            sweep(BEND, bad)


@pytest.mark.parametrize("shift", [[0.0, 0.0], [0.3, 0.0], [0.5, 0.0]], ids=["larger", "crossing", "outside"])
@pytest.mark.parametrize("way", ["closed", "without caps"])
def test_holes_that_are_not_inside_are_refused_where_no_cap_shows_it(shift, way):
    hole = (1.2 if shift == [0.0, 0.0] else 0.3) * BAR + shift
    path, caps = (ring(5.0), "flat") if way == "closed" else (BEND, "none")
    with pytest.raises(ValueError, match="holes must lie inside its outline"):
        sweep(path, Profile.of(BAR, hole), caps=caps)


def test_caps_fill_the_profile_without_slivers():
    # Corners in line, a hole, not convex.
    outline = np.array([[0, 0], [1, 0], [2, 0], [3, 0], [4, 0], [4, 2], [4, 4], [3, 4], [2, 1], [1, 4], [0, 4], [0, 2]])
    hole = np.array([[0.5, 0.5], [0.5, 0.8], [0.8, 0.8], [0.8, 0.5]])
    triangles = flat_cap([outline.astype(float), hole])
    corners = np.concatenate([outline, hole])[triangles]
    a, b = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    areas = 0.5 * (a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0])
    assert areas.min() > 1e-3
    assert areas.sum() == pytest.approx(4 * 4 - 0.5 * 2 * 3 - 0.09)


# Laws.


def test_laws():
    u = np.linspace(0.0, 6.0, 5001)
    wave = law_of(lambda u: 1 + 0.5 * np.sin(5 * u), (0.0, 6.0), "radius", 1e-5)
    assert np.abs(wave(u)[:, 0] - 1 - 0.5 * np.sin(5 * u)).max() < 3e-5
    at, values = np.array([0.0, 1.0, 2.0, 4.0, 6.0]), np.array([1.0, 2.0, 2.0, 5.0, 1.0])
    for law in (law_of(values, (0.0, 6.0), "radius", 1e-5, at), law_of(np.c_[at, values], (0.0, 6.0), "radius", 1e-5)):
        assert np.abs(law(at)[:, 0] - values).max() < 1e-14
        assert law(u).min() >= 1.0  # no overshoot
        assert law(u).max() <= 5.0
    held = law_of([[1.0, 2.0], [2.0, 3.0]], (0.0, 6.0), "radius", 1e-5)
    assert held([0.0, 1.0, 1.5, 2.0, 6.0])[:, 0] == pytest.approx([2, 2, 2.5, 3, 3])


def test_a_law_comes_down_to_its_values_not_to_its_poles():
    narrow = BSpline([[1.0], [-0.3], [-0.3], [1.0]], KNOTS)  # 0.025 at its least
    line = polyline([[0, 0, 0], [0, 0, 1]])
    mesh = tube(line, narrow, 1e-3)
    check_solid(mesh)
    u = np.linspace(0.0, 1.0, 20_001)
    assert mesh.volume == pytest.approx(np.trapezoid(np.pi * narrow(u)[:, 0] ** 2, u), rel=2e-3)
    check_solid(tube(line, narrow, 1e-3, thickness=0.02), 0)
    with pytest.raises(ValueError, match=r"the thickness 0\.03 is not below the radius, 0\.025 at its least"):
        tube(line, narrow, thickness=0.03)
    with pytest.raises(ValueError, match=r"radius must be finite and above zero, not -0\.5"):
        tube(line, [[0.0, -1.0], [1.0, -0.5]])


@pytest.mark.parametrize("seed", range(20))
def test_the_bounds_of_a_law_are_its_extremes(seed):
    rng = np.random.default_rng(seed)
    inner = np.sort(rng.uniform(0.1, 0.9, seed % 5))
    law = BSpline(rng.normal(size=(4 + len(inner), 1)), np.concatenate([np.zeros(4), inner, np.ones(4)]))
    values = law(np.linspace(0.0, 1.0, 20_001))
    assert (smallest(law), largest(law)) == pytest.approx((values.min(), values.max()), abs=1e-6)


def test_bad_laws():
    for bad, said in [
        (lambda u: np.sign(u - 0.3), "jumps at the parameter 0.29999"),
        (lambda u: u[:-1], r"gives \(\d+,\)"),
        ([1.0, 2.0, 3.0], "at which parameters are these 3 values"),
        ([[-1.0, 2.0], [1.0, 3.0]], "given from -1 to 1, the path runs from 0 to 1"),
        ([[0.0, np.nan]], r"must be finite, not nan at \[0, 1\]"),
        (BSpline([[1.0]] * 4, [0, 0, 0, 0, 2, 2, 2, 2]), "runs over"),
        (BSpline([[1.0, 1.0]] * 4, KNOTS), "1 coordinate, not 2"),
        (lambda u: u, "must not vanish"),
        (-1.0, "must not vanish"),
    ]:
        with pytest.raises(ValueError, match=said):
            sweep(BEND, BAR, scale=bad)
    with pytest.raises(TypeError, match="must be a number, not 'big'"):
        sweep(BEND, BAR, scale="big")
    with pytest.raises(ValueError, match="does not end as it starts"):
        sweep(trefoil(), BAR, twist=1.0)


def test_radii_at_the_points_of_a_fit():
    t = np.linspace(0.0, 3.0, 40)
    points = np.column_stack([5 * np.cos(t), 5 * np.sin(t), t])
    made = fit(points, 1e-3)
    radii = 0.3 + 0.1 * np.sin(3 * t)
    mesh = tube(made, radii)
    check_solid(mesh)
    exact = np.trapezoid(np.pi * np.interp(np.linspace(0, 3, 9999), t, radii) ** 2, dx=np.sqrt(26) * 3 / 9998)
    assert mesh.volume == pytest.approx(exact, rel=2e-3)
    with pytest.raises(ValueError, match="39 values of the radius for 40 points"):
        tube(made, radii[:-1])


def test_a_cone_is_exact():
    line = BSpline(np.outer([0, 1, 2, 3], [1, 2, 2]), KNOTS)
    mesh = tube(line, BSpline(np.array([[1], [2], [3], [4.0]]), KNOTS), 0.01)
    assert mesh.volume == pytest.approx(np.pi * 9 / 3 * (1 + 4 + 16), rel=1e-9)
    assert len(np.unique(np.round(mesh.vertices @ [1, 2, 2], 9))) == 2  # two rings are all it needs
    # The same surface along an uneven parameter: no longer straight in it.
    uneven = BSpline(np.outer([0, 0.1, 0.2, 3], [1, 2, 2]), KNOTS)
    bent = tube(uneven, BSpline(np.array([[1], [2], [3], [4.0]]), KNOTS), 0.01)
    assert len(bent.vertices) > 5 * len(mesh.vertices)


# Pipes, caps, texture.


def test_pipe():
    mesh = tube(BEND, 0.4, thickness=0.1)
    check_solid(mesh, 0)
    assert mesh.volume == pytest.approx(np.pi * (0.4**2 - 0.3**2) * BEND.length(), rel=1e-6)
    for bad in (0.0, 0.4, 1.0):
        with pytest.raises(ValueError, match="thickness"):
            tube(BEND, 0.4, thickness=bad)


def test_round_caps():
    mesh = tube(BEND, 0.4, 1e-3, caps="round")
    check_solid(mesh)
    assert mesh.volume == pytest.approx(np.pi * 0.16 * BEND.length() + 4 / 3 * np.pi * 0.4**3, rel=1e-3)
    ends = BEND(BEND.domain)
    apart = np.linalg.norm(mesh.vertices[:, None] - ends, axis=2).min(axis=1)
    assert apart.min() > 0.4 - 1e-3
    with pytest.raises(ValueError, match="without holes"):
        sweep(BEND, Profile.of(BAR, 0.5 * BAR), caps="round")


def test_no_caps_leaves_the_ends_open():
    mesh = tube(BEND, 0.4, caps="none")
    assert not mesh.is_watertight
    assert mesh.is_winding_consistent
    open_edges = trimesh.grouping.group_rows(mesh.edges_sorted, require_count=1)
    rims = mesh.vertices[np.unique(mesh.edges_sorted[open_edges])] - BEND(BEND.domain)[:, None]
    at_start, at_end = np.abs(np.einsum("end,ed->en", rims, frames(BEND, BEND.domain).tangents)) < 1e-9
    assert (at_start | at_end).all()
    with pytest.raises(ValueError, match="caps must be one of flat, round, none, not 'square'"):
        tube(BEND, 0.4, caps="square")


@pytest.mark.parametrize("caps", ["flat", "round", "none"])
def test_texture_coordinates_are_lengths(caps):
    line = BSpline(np.outer([0, 1, 2, 3], [1, 2, 2]), KNOTS)
    mesh = tube(line, 0.5, caps=caps, texture=True)
    uv = mesh.face_attributes["uv"]
    assert uv.shape == (len(mesh.faces), 3, 2)
    a, b = uv[:, 1] - uv[:, 0], uv[:, 2] - uv[:, 0]
    flat_areas = 0.5 * np.abs(a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0])
    walls = np.abs(mesh.face_normals @ np.array([1, 2, 2]) / 3) < 1e-6
    assert walls.sum() > 20
    assert flat_areas[walls] == pytest.approx(mesh.area_faces[walls], rel=1e-9)
    if caps == "flat":
        assert flat_areas == pytest.approx(mesh.area_faces, rel=1e-9)
    drawn = textured(mesh)
    assert drawn.visual.uv.shape == (len(drawn.vertices), 2)
    assert np.abs(drawn.triangles - mesh.triangles).max() == 0.0
    with pytest.raises(ValueError, match="no texture coordinates"):
        textured(tube(line, 0.5))


# Corners.


def test_a_mitred_l_is_exact():
    path = polyline([[0, 0, 0], [10, 0, 0], [10, 7, 0]])
    for profile, area in ((BAR, 0.18), (egg(), Profile.of(egg()).area)):
        mesh = sweep(path, profile)
        check_solid(mesh)
        x = Profile.of(profile).centroid[0]  # to the left: inside the turn
        assert mesh.volume == pytest.approx(area * (17.0 - 2.0 * x), rel=1e-6)
    bar = sweep(path, BAR)
    assert len(bar.vertices) == 12
    mitre = bar.vertices[4:8]
    assert np.abs(mitre[:, 0] - 10 + mitre[:, 1]).max() < 1e-12  # in the plane x - 10 = -y
    assert np.abs(bar.bounds - [[0, -0.3, -0.15], [10.3, 7, 0.15]]).max() < 1e-12


def test_mitred_frames_and_zigzags():
    square = polyline([[0, 0, 0], [10, 0, 0], [10, 10, 0], [0, 10, 0]], closed=True)
    check_solid(mesh := sweep(square, BAR), 0)
    assert len(mesh.vertices) == 16
    assert mesh.volume == pytest.approx(40 * 0.18, rel=1e-12)
    pipe = tube(square, 0.5, thickness=0.1)
    assert pipe.is_watertight
    assert pipe.volume == pytest.approx(np.pi * 0.09 * 40, rel=1e-9)
    zigzag = [[0, 0, 0], [10, 0, 0], [10, 10, 0], [10, 10, 10], [0, 12, 15]]
    for closed in (False, True):
        path = polyline(zigzag, closed=closed)
        mesh = sweep(path, BAR)
        check_solid(mesh, 0 if closed else 2)
        assert mesh.volume == pytest.approx(0.18 * path.length(), rel=1e-6)


def test_corners_of_curved_legs_and_several_curves():
    arc = BSpline([[0, 0, 0], [3, 0, 0], [6, 2, 0], [6, 6, 0]], KNOTS)
    line = polyline([[6, 6, 0], [12, 6, 0]])
    for path in ([arc, line], join([arc, line])):
        mesh = tube(path, 0.4)
        check_solid(mesh)
        assert mesh.volume == pytest.approx(np.pi * 0.16 * (arc.length() + 6), rel=2e-3)
    with pytest.raises(ValueError, match=r"starts .* away"):
        tube([arc, arc], 0.4)


def test_up_and_corners():
    flat = polyline([[0, 0, 0], [10, 0, 0], [10, 7, 0]])
    assert sweep(flat, BAR, up=[0, 0, 1]).volume == pytest.approx(sweep(flat, BAR).volume)
    climbing = polyline([[0, 0, 0], [10, 0, 0], [10, 5, 5]])
    with pytest.raises(ValueError, match=r"would roll by .* degrees at the corner"):
        sweep(climbing, BAR, up=[0, 0, 1])


def test_up_frames():
    u = np.linspace(0, 1, 50)
    f = frames(BEND, u, up=[0, 0, 2])
    assert np.abs(f.normals[:, 2]).max() < 1e-15
    assert f.binormals[:, 2].min() > 0.0
    assert np.abs(np.cross(f.tangents, f.normals) - f.binormals).max() < 1e-15
    tall = BSpline(np.outer([0, 1, 2, 3], [0, 0, 1]), KNOTS)
    with pytest.raises(ValueError, match="runs along `up` at the parameter 0"):
        frames(tall, u, up=[0, 0, 1])
    for bad in ([0, 0, 0], [1, 2], [np.nan, 0, 1]):
        with pytest.raises(ValueError, match="three finite numbers"):
            frames(BEND, u, up=bad)


def test_frenet_frames():
    t = np.linspace(0.0, 12.0, 400)
    helix = local_spline(np.column_stack([3 * np.cos(t), 3 * np.sin(t), t]))
    f = frenet(helix, np.linspace(*helix.domain, 50)[1:-1])
    inward = -f.origins * [1, 1, 0]
    assert np.abs(f.normals - inward / np.linalg.norm(inward, axis=1)[:, None]).max() < 1e-3
    with pytest.raises(ValueError, match=r"does not bend at the parameter 0\.5"):
        frenet(BSpline(np.outer([0, 1, 2, 3], [0, 0, 1]), KNOTS), [0.5])


@settings(deadline=None, max_examples=30)
@given(seed=st.integers(0, 10_000), steps=st.sampled_from([1, 2, 4, 8]))
def test_the_error_estimate_of_frames(seed, steps):
    """At least a third of the true error, and not over 1000 times it where that is above rounding."""
    path = cardinal_spline(np.random.default_rng(seed).normal(size=(12, 3)), curvature=1.0)

    def end(count):
        knots = path.distinct_knots
        f = frames(
            path, np.concatenate([np.linspace(a, b, count + 1) for a, b in zip(knots[:-1], knots[1:], strict=True)])
        )
        return f.normals[-1], f.binormals[-1], f.error

    normal, _, error = end(steps)
    best, across, _ = end(16 * steps)
    true = abs(np.arctan2(normal @ across, normal @ best))
    assert error > true / 3 - 1e-12


# Laws of sweeps on random paths and polylines.


@pytest.mark.slow
@settings(deadline=None, max_examples=8)
@given(seed=st.integers(0, 10_000), closed=st.booleans())
def test_random_polylines_have_area_times_length(seed, closed):
    rng = np.random.default_rng(seed)
    path = polyline(rng.uniform(0, 25, size=(6, 3)), closed=closed)
    with warnings.catch_warnings(record=True) as said:
        warnings.simplefilter("always")
        mesh = sweep(path, BAR)
    assert mesh.is_watertight
    assert mesh.is_winding_consistent
    if not said:
        assert mesh.volume == pytest.approx(0.18 * path.length(), rel=1e-6)


def test_turns_of_a_coil_that_touch_are_reported():
    t = np.linspace(0.0, 12.0, 80)
    coil = local_spline(np.column_stack([10 * np.cos(t), 10 * np.sin(t), 0.25 * t]))  # 1.57 from turn to turn
    with pytest.warns(UserWarning, match=r"is too near for a radius of 1; a radius below 0\.7\d* would do"):
        tube(coil, 1.0)
    tube(coil, 0.75)


def test_a_profile_of_points_is_told_to_use_of():
    with pytest.raises(TypeError, match=r"hole 0 must be a cadfit.BSpline, not list; Profile\.of takes polygons"):
        Profile(Profile.of([[0, 0], [4, 0], [0, 4]]).outline, ([[1, 1], [2, 1], [1, 2]],))


def test_a_twist_that_is_no_number_is_named():
    with pytest.raises(TypeError, match="the twist must be a number, not 'x'"):
        sweep(BEND, BAR, twist="x")
    with pytest.raises(ValueError, match=r"the twist must be finite, not nan$"):
        sweep(BEND, BAR, twist=np.nan)


def test_no_values_of_a_scale_are_named():
    with pytest.raises(ValueError, match="no values of the scale are given"):
        sweep(BEND, BAR, scale=np.empty((0, 2)))
