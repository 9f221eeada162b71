import importlib.util
import os
import subprocess
import sys

import numpy as np
import pytest
import trimesh

import cadfit
from cadfit.cli import main
from cadfit.files import read, write

HELIX = np.stack([10 * np.cos(t := np.linspace(0, 6, 40)), 10 * np.sin(t), 2 * t], axis=1)
HEAVY = ["OCP", "trimesh", "matplotlib", "build123d", "cadquery"]


@pytest.fixture
def here(tmp_path, monkeypatch):
    """A folder of its own with helix.csv, as the current one."""
    monkeypatch.chdir(tmp_path)
    write("helix.csv", HELIX)
    return tmp_path


@pytest.fixture
def run(here, capsys):
    """Run the command line; return the exit status, what it printed, and what it said to stderr."""

    def run(*arguments):
        status = main([str(argument) for argument in arguments])
        return (status, *capsys.readouterr())

    return run


def said(out):
    return {line[:21].strip(): line[21:].strip() for line in out.splitlines()}


def python(*arguments, **options):
    return subprocess.run([sys.executable, *arguments], capture_output=True, text=True, timeout=60, **options)


@pytest.mark.parametrize(
    "code", ["import cadfit; dir(cadfit)", "from cadfit.cli import main; assert main(['--help']) == 0"]
)
def test_starting_imports_nothing_heavy(code):
    names = HEAVY + (["numpy", "scipy", "rich"] if "main" in code else [])
    done = python("-c", f"{code}\nimport sys; print([name for name in {names} if name in sys.modules])")
    assert (done.stdout.splitlines()[-1], done.stderr) == ("[]", "")


@pytest.mark.slow
def test_the_command_is_installed_and_says_its_version():
    done = python("-m", "cadfit.cli", "--version")
    assert (done.returncode, done.stdout, done.stderr) == (0, f"{cadfit.__version__}\n", "")


def test_help_names_the_commands(run):
    for arguments in ([], ["--help"]):
        status, out, err = run(*arguments)
        assert status == 0
        assert all(f"\n  {name}" in out for name in ("fit", "tube", "info"))
        assert err == ""


@pytest.mark.parametrize(
    ("options", "curve"),
    [
        ([], cadfit.local_spline(HELIX)),
        (["--method", "local"], cadfit.local_spline(HELIX)),
        (["--method", "cardinal"], cadfit.cardinal_spline(HELIX)),
        (["--tension", "0.4"], cadfit.cardinal_spline(HELIX, 0.4)),
        (["--curvature", "1"], cadfit.cardinal_spline(HELIX, 0.5, 1.0)),
        (["--method", "cardinal", "--tension", "0"], cadfit.cardinal_spline(HELIX, 0.0)),
        (["--method", "interpolate"], cadfit.interpolate(HELIX)),
        (["--closed"], cadfit.local_spline(HELIX, closed=True)),
    ],
)
def test_fit_writes_the_curve_of_the_method(run, options, curve):
    status, out, err = run("fit", "helix.csv", "-o", "out.json", "--output", "poles.csv", *options)
    assert (status, err) == (0, "")
    found = read("out.json")
    assert found.closed == ("--closed" in options)
    assert found.curves[0].isclose(curve, 0.0)
    assert found.deviation.points < 1e-9
    assert np.array_equal(read("poles.csv"), curve.poles)
    assert out.splitlines()[0] == "helix.csv"
    assert out.splitlines()[-2:] == ["wrote out.json", "wrote poles.csv"]
    assert said(out)["points read"] == "40"
    assert said(out)["poles"] == str(len(curve.poles))
    assert float(said(out)["deviation between"]) == pytest.approx(found.deviation.between, rel=1e-2)


@pytest.mark.parametrize(
    ("options", "how"),
    [
        ([], {}),
        (["--effort", "fast"], {"effort": "fast"}),
        (["--between", "polyline", "--effort", "fast"], {"between": "polyline", "effort": "fast"}),
        (["--corners", "none", "--method", "tolerance"], {"corners": None}),
        (["--corners", "50"], {"corners": np.radians(50)}),
        (["--corners", "2,4,"], {"corners": [2, 4]}),
        (["--closed"], {"closed": True}),
    ],
)
def test_fit_within_a_tolerance(run, options, how):
    outline = np.array([[0, 0], [1, 0.1], [2, 0], [2.1, 1], [2, 2], [1, 1.9], [1, 1.9], [0, 2], [-0.1, 1]])
    write("outline.csv", outline)
    status, out, err = run("fit", "outline.csv", "-t", "0.02", "-o", "out.json", "-o", "poles.csv", *options)
    assert (status, err) == (0, "")
    expected = cadfit.fit(outline, 0.02, **how)
    found = read("out.json")
    assert len(found.curves) == len(expected.curves)
    assert all(a.isclose(b, 0.0) for a, b in zip(found.curves, expected.curves, strict=True))
    assert found.closed == expected.closed
    assert found.deviation.points == expected.deviation.points <= 0.02
    facts = said(out)
    assert (facts["points read"], facts["repeats dropped"]) == ("9", "1")
    assert (facts["corners"], facts["poles"]) == (str(len(expected.corners)), str(expected.poles))
    assert facts["tolerance"].startswith("0.02, at the points")


def test_fit_sees_closed_contours_and_counts_repeats(run):
    square = [[0, 0], [1, 0], [1, 0], [1, 1], [0, 1], [0, 0]]
    write("square.txt", square)
    _, out, _ = run("fit", "square.txt", "-o", "out.json")
    assert (said(out)["repeats dropped"], said(out)["closed"]) == ("1", "yes")
    assert read("out.json").curves[0].closed
    run("fit", "square.txt", "-o", "out.json", "--open")
    assert not read("out.json").closed


def test_fit_in_many_dimensions(run):
    write("five.csv", np.random.default_rng(0).normal(size=(10, 5)))
    assert run("fit", "five.csv", "-o", "five.json", "-q") == (0, "", "")
    assert read("five.json").dimension == 5


@pytest.mark.parametrize("suffix", [".stl", ".3mf", ".ply", ".glb", ".obj"])
def test_tube_of_points(run, suffix):
    status, out, err = run("tube", "helix.csv", "--radius", "0.5", "-o", f"tube{suffix}")
    assert (status, err) == (0, "")
    mesh = trimesh.load_mesh(f"tube{suffix}")
    assert mesh.is_watertight
    length = cadfit.local_spline(HELIX).length()
    assert mesh.volume == pytest.approx(np.pi * 0.25 * length, rel=0.01)
    assert said(out)["watertight"] == "yes"
    assert out.splitlines()[-1] == f"wrote tube{suffix}"


def test_tube_of_a_curve_and_of_the_plane(run):
    run("fit", "helix.csv", "-o", "curve.json")
    assert run("tube", "curve.json", "--radius", 0.5, "--tolerance", 0.1, "-o", "a.stl", "-q") == (0, "", "")
    run("tube", "helix.csv", "--radius", 0.5, "--tolerance", 0.1, "-o", "b.stl")
    assert np.array_equal(read("a.stl").vertices, read("b.stl").vertices)
    write("ring.csv", np.append(HELIX[:, :2], HELIX[:1, :2], axis=0))
    assert run("tube", "ring.csv", "--radius", 0.5, "-o", "c.stl", "-q") == (0, "", "")
    assert np.allclose(read("c.stl").bounds[:, 2], [-0.5, 0.5], atol=5e-3)


def test_a_tube_that_meets_itself_is_warned_of_in_one_line(run):
    status, _, err = run("tube", "helix.csv", "--radius", "11", "-o", "fat.stl")
    assert status == 0
    assert err.startswith("cadfit: warning: ")
    assert err.count("\n") == 1


def test_info(run):
    for name in ("curve.json", "tube.stl"):
        run(*(["fit", "helix.csv"] if name == "curve.json" else ["tube", "helix.csv", "--radius", 1]), "-o", name)
    points, curve, mesh = (
        dict(line.split(None, 1) for line in run("info", name)[1].splitlines()[1:])
        for name in ("helix.csv", "curve.json", "tube.stl")
    )
    assert (points["kind"], points["points"], points["dimension"], points["closed"]) == ("points", "40", "3", "no")
    assert points["from"] == " ".join(f"{x:.7g}" for x in HELIX.min(axis=0))
    assert (curve["kind"], curve["poles"], curve["continuity"], curve["degree"]) == ("curve", "118", "C2", "3")
    assert float(curve["length"]) == pytest.approx(6 * np.hypot(10, 2), rel=1e-4)
    assert (mesh["kind"], mesh["watertight"]) == ("mesh", "yes")
    assert float(mesh["volume"]) == pytest.approx(np.pi * float(curve["length"]), rel=0.02)


def spoil(name, content):
    with open(name, "wb") as file:
        file.write(content)


MISTAKES = {
    "no such file": (["fit", "none.csv", "-o", "a.json"], "none.csv: No such file or directory"),
    "a folder": (["info", "."], ".: Is a directory"),
    "text": (["fit", "bad.csv", "-o", "a.json"], "bad.csv: line 2: 'two' is not a number in '3,two'"),
    "empty": (["info", "empty.csv"], "empty.csv: no rows of numbers in it"),
    "garbage": (["tube", "garbage.csv", "--radius", "1", "-o", "a.stl"], "garbage.csv: not a text file"),
    "one point": (["fit", "one.csv", "-o", "a.json"], "one.csv: a curve needs at least 2 distinct points"),
    "two to close": (["fit", "two.csv", "-o", "a.json", "--closed"], "two.csv: a closed curve needs at least 3"),
    "wrong output": (["fit", "helix.csv", "-o", "a.stl"], "a.stl: .stl does not hold curves; these do: .csv"),
    "wrong output first": (["fit", "none.csv", "-o", "a.stl"], "a.stl: .stl does not hold curves"),
    "wrong second output": (["fit", "helix.csv", "-o", "a.json", "-o", "a.foo"], "a.foo: unknown suffix '.foo'"),
    "no folder": (["fit", "helix.csv", "-o", "none/a.json"], "none/a.json: no such folder: none"),
    "no second folder": (
        ["fit", "helix.csv", "-o", "a.json", "-o", "none/a.json"],
        "none/a.json: no such folder: none",
    ),
    "no folder for a tube": (
        ["tube", "helix.csv", "--radius", "1", "-o", "a.stl", "-o", "none/a.stl"],
        "none/a.stl: no such folder: none",
    ),
    "no folder for a page": (
        ["fit", "helix.csv", "-o", "a.json", "--report", "none/a.html"],
        "none/a.html: no such folder: none",
    ),
    "no folder for G-code": (["toolpath", "none.nc", "-t", "1", "-o", "none/a.nc"], "none/a.nc: no such folder: none"),
    "a file for a folder": (["fit", "helix.csv", "-o", "one.csv/a.json"], "one.csv/a.json: no such folder: one.csv"),
    "a folder for a page": (
        ["fit", "helix.csv", "-o", "a.json", "--report", "folder.html"],
        "folder.html: a folder, where a file is to be written",
    ),
    "onto itself": (["fit", "helix.csv", "-o", "./helix.csv"], "helix.csv: the output would replace the input"),
    "no output": (["fit", "helix.csv"], "helix.csv: where to? --output says it, or --report"),
    "no input": (["fit"], "Missing argument 'IN...'"),
    "method": (["fit", "helix.csv", "-o", "a.json", "--method", "best"], "Invalid value for '--method'"),
    "tension of local": (
        ["fit", "helix.csv", "-o", "a.json", "--method", "local", "--tension", "1"],
        "helix.csv: --tension cannot go with --method local",
    ),
    "effort of cardinal": (
        ["fit", "helix.csv", "-o", "a.json", "-t", "1", "--effort", "fast", "--tension", "1", "--method", "cardinal"],
        "helix.csv: --tolerance and --effort cannot go with --method cardinal",
    ),
    "no corners": (
        ["fit", "helix.csv", "-o", "a.json", "-t", "1", "--corners", ""],
        "helix.csv: --corners must be auto, none, an angle in degrees, or rows with commas (3,17 or 5,), not ''",
    ),
    "endless curvature": (
        ["fit", "helix.csv", "-o", "a.json", "--curvature", "inf"],
        "helix.csv: the curvature must be a finite number, not inf",
    ),
    "huge tension": (
        ["fit", "helix.csv", "-o", "a.json", "--tension", "1e300"],
        "helix.csv: coordinates must be below 1e+60, and one is",
    ),
    "huge curvature": (
        ["fit", "helix.csv", "-o", "a.json", "--curvature", "1e300", "--fraction", "0.5"],
        "helix.csv: coordinates must be below 1e+60, and one is",
    ),
    **{
        f"huge points, {'local' if not options else options[0]}": (
            ["fit", "huge.csv", "-o", "a.json", *options],
            "huge.csv: coordinates must be below 1e+60, and one is 1e+308: scale them",
        )
        for options in ([], ["-t", "1"], ["--fraction", "0.5"], ["--curvature", "1"], ["--method", "interpolate"])
    },
    "no tolerance": (
        ["fit", "helix.csv", "-o", "a.json", "--corners", "none"],
        "helix.csv: how far may the curve be from the points? --tolerance says it",
    ),
    "too small a tolerance": (
        ["fit", "helix.csv", "-o", "a.json", "-t", "1e-30"],
        "helix.csv: the tolerance must be at least",
    ),
    "corners": (
        ["fit", "helix.csv", "-o", "a.json", "-t", "1", "--corners", "some"],
        "helix.csv: --corners must be auto, none, an angle in degrees, or rows with commas (3,17 or 5,), not 'some'",
    ),
    "a corner's angle": (
        ["fit", "helix.csv", "-o", "a.json", "-t", "1", "--corners", "200"],
        "helix.csv: --corners: an angle must be above 0 and at most 180 degrees, not 200",
    ),
    "corners out of range": (
        ["fit", "helix.csv", "-o", "a.json", "-t", "1", "--corners", "3,99"],
        "helix.csv: corners must be rows of the points, 0 to 39",
    ),
    "between": (["fit", "helix.csv", "-o", "a.json", "-t", "1", "--between", "x"], "Invalid value for '--between'"),
    "tube within a tolerance": (
        ["tube", "helix.csv", "--radius", "1", "-o", "a.stl", "--method", "tolerance"],
        "helix.csv: --method tolerance is for cadfit fit: write its curve to a .json, and sweep that",
    ),
    "number": (["fit", "helix.csv", "-o", "a.json", "--tension", "x"], "Invalid value for '--tension'"),
    "not a number": (["fit", "helix.csv", "-o", "a.json", "--tension", "nan"], "helix.csv: "),
    "radius": (["tube", "helix.csv", "--radius", "-1", "-o", "a.stl"], "helix.csv: the radius must be"),
    "no radius": (["tube", "helix.csv", "-o", "a.stl"], "Missing option '--radius'"),
    "tolerance": (
        ["tube", "helix.csv", "--radius", "1", "--tolerance", "-1", "-o", "a.stl"],
        "helix.csv: the tolerance must be",
    ),
    **{
        f"tube, {' '.join(options)}": (
            ["tube", "helix.csv", "--radius", "1", *options, "-o", "a.stl"],
            f"helix.csv: the {options[-2].strip('-')} {said}",
        )
        for options, said in (
            (["--tolerance", "1e308"], "must be between 1e-60 and 1e+60, not 1e+308"),
            (["--tolerance", "1e-320"], "must be between 1e-60 and 1e+60, not 9.99989e-321"),
            (["--tolerance", "1e-30"], "1e-30 is below what numbers of this size hold"),
            (["--thickness", "0.1", "--tolerance", "1e-30"], "1e-30 is below what numbers of this size hold"),
            (["--caps", "round", "--tolerance", "1e-30"], "1e-30 is below what numbers of this size hold"),
            (["--radius", "1e308"], "must be between 1e-60 and 1e+60, not 1e+308"),
        )
    },
    "sweep, a tiny tolerance": (
        ["sweep", "helix.csv", "--profile", "round.json", "--tolerance", "1e-30", "-o", "a.stl"],
        "helix.csv: the tolerance 1e-30 is below what numbers of this size hold",
    ),
    "sweep, a tiny scale": (
        ["sweep", "helix.csv", "--profile", "round.json", "--scale", "1e-320", "-o", "a.stl"],
        "helix.csv: the profile must not vanish: its scale or radius comes down to 9.99989e-321",
    ),
    "tube in 5D": (["tube", "five.csv", "--radius", "1", "-o", "a.stl"], "five.csv: "),
    "fit of a curve": (["fit", "curve.json", "-o", "a.csv"], "curve.json: points are needed, and it holds curves"),
    "fit of a mesh": (["fit", "mesh.stl", "-o", "a.csv"], "mesh.stl: points are needed, and it holds a mesh"),
    "closed tube of a curve": (
        ["tube", "curve.json", "--closed", "--radius", "1", "-o", "a.stl"],
        "curve.json: holds curves: --fit, --method, --tension, --curvature and --closed are for points",
    ),
    "command": (["fitt"], "No such command 'fitt'"),
}


@pytest.mark.parametrize("case", MISTAKES)
def test_a_mistake_is_one_line_and_status_2(run, here, case):
    spoil("bad.csv", b"1,2\n3,two\n")
    spoil("empty.csv", b"")
    spoil("huge.csv", b"1e308,1e308\n-1e308,-1e308\n1e308,-1e308\n3,4\n")
    spoil("garbage.csv", bytes(range(256)))
    write("one.csv", [[1, 2], [1, 2]])
    write("two.csv", [[1, 2], [3, 4]])
    write("five.csv", np.random.default_rng(0).normal(size=(10, 5)))
    write("curve.json", cadfit.cardinal_spline(HELIX))
    write("round.json", cadfit.local_spline(HELIX[:31:2, :2], closed=True))
    write("mesh.stl", trimesh.creation.box())
    os.mkdir("folder.html")
    before = sorted(os.listdir())
    arguments, expected = MISTAKES[case]
    status, out, err = run(*arguments)
    assert status == 2
    assert out == ""
    assert err.startswith(f"cadfit: {expected}")
    assert err.count("\n") == 1
    assert sorted(os.listdir()) == before


@pytest.mark.skipif(importlib.util.find_spec("OCP") is not None, reason="OCP is here")
def test_without_a_kernel_the_extra_is_named_before_anything_is_written(run):
    status, _, err = run("fit", "helix.csv", "-o", "a.json", "-o", "a.step")
    assert status == 2
    assert "cadfit[build123d]" in err
    assert err.count("\n") == 1
    assert not os.path.exists("a.json")


@pytest.mark.slow
def test_a_mistake_in_a_process_of_its_own(here):
    done = python("-m", "cadfit.cli", "fit", "none.csv", "-o", "a.json")
    assert (done.returncode, done.stdout) == (2, "")
    assert done.stderr == "cadfit: none.csv: No such file or directory\n"


@pytest.mark.slow
def test_names_the_terminal_has_no_letters_for(here):
    write("höhe.csv", HELIX)
    done = python("-m", "cadfit.cli", "info", "höhe.csv", env=os.environ | {"PYTHONIOENCODING": "ascii"})
    assert done.returncode == 0
    assert done.stdout.startswith("h\\xf6he.csv\n")


def test_a_corner_at_a_guessed_seam_is_pointed_out(run):
    write("edge.csv", np.array([[1, 0], [0.5, 0.1], [0, 0], [0.5, -0.1], [1, 0.0]]))
    status, _, err = run("fit", "edge.csv", "-o", "edge.json")
    assert status == 0
    assert "turn by 157 degrees; --open keeps that corner sharp" in err
    for choice in ("--open", "--closed"):
        assert run("fit", "edge.csv", choice, "-o", "edge.json")[2] == ""


def test_fit_through_dominant_points(run):
    for options, expected in (
        (["--fraction", "0.5"], cadfit.fit_dominant(HELIX, fraction=0.5)),
        (["--square-error", "20"], cadfit.fit_dominant(HELIX, square_error=20.0)),
        (["--fraction", "0.5", "--curvature", "0"], cadfit.fit_dominant(HELIX, fraction=0.5, curvature=0.0)),
    ):
        status, out, err = run("fit", "helix.csv", "--method", "dominant", *options, "-o", "out.json")
        assert (status, err) == (0, "")
        assert np.array_equal(read("out.json").curves[0].poles, expected.spline.poles)
        assert said(out)["dominant"] == str((len(expected.spline.poles) + 2) // 3)
        assert said(out)["deviation at points"] == f"{expected.deviation.points:.3g}"


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (["--method", "dominant"], "needs one of --fraction and --square-error"),
        (["--method", "dominant", "--fraction", "0.5", "--square-error", "1"], "needs one of"),
        (["--method", "dominant", "--fraction", "0.5", "--tension", "1"], "--tension cannot go with --method dominant"),
        (["--fraction", "0.5", "-t", "1"], "--fraction cannot go with --method tolerance"),
        (["--method", "dominant", "--fraction", "2"], "at most 1"),
    ],
)
def test_mistakes_with_dominant_points(run, options, message):
    status, out, err = run("fit", "helix.csv", *options, "-o", "out.json")
    assert (status, out) == (2, "")
    assert err.startswith("cadfit: helix.csv: ")
    assert message in err


def test_tube_takes_no_dominant_points(run):
    assert run("tube", "helix.csv", "--radius", "1", "--method", "dominant", "-o", "tube.stl")[0] == 2


WAVES = {name: np.column_stack([t := np.linspace(0, 5, 60), np.sin(k * t)]) for k, name in enumerate("abc", 1)}


@pytest.fixture
def waves(here):
    for name, points in WAVES.items():
        write(f"{name}.csv", points)


def test_fit_of_several_files_into_a_folder(run, waves):
    spoil("bad.csv", b"1,2\n3,two\n")
    files = ["a.csv", "bad.csv", "b.csv", "none.csv", "c.csv"]
    options = ["-t", "0.01", "--effort", "fast", "--jobs", "1", "--format", "json", "--format", ".CSV"]
    status, out, err = run("fit", *files, "-o", "new/out/", *options, "--summary", "sum.csv")
    assert status == 1
    assert sorted(os.listdir("new/out")) == ["a.csv", "a.json", "b.csv", "b.json", "c.csv", "c.json"]
    for name, points in WAVES.items():
        [curve] = read(f"new/out/{name}.json").curves
        assert curve.isclose(cadfit.fit(points, 0.01, effort="fast").spline, 0.0)
        assert np.array_equal(read(f"new/out/{name}.csv"), curve.poles)
    assert [line.split()[:2] for line in out.splitlines()[1:]] == [["a.csv", "60"], ["b.csv", "60"], ["c.csv", "60"]]
    assert err.splitlines() == [
        "cadfit: 2 of 5 failed:",
        "cadfit: bad.csv: line 2: 'two' is not a number in '3,two'",
        "cadfit: none.csv: No such file or directory",
    ]
    table = [line.split(",", 1)[0] for line in (here_text("sum.csv")).splitlines()]
    assert table == ["name", *files]


def here_text(name):
    with open(name, encoding="utf-8") as file:
        return file.read()


def test_one_file_into_a_folder_and_stages_on_request(run, waves):
    assert run("fit", "a.csv", "-o", "out/", "--format", "json", "-q") == (0, "", "")
    assert os.listdir("out") == ["a.json"]
    status, out, err = run("fit", "b.csv", "-o", "out", "--format", "json", "-t", "0.01", "-v")
    assert status == 0
    assert out.splitlines()[-1] == f"wrote {os.path.join('out', 'b.json')}"
    stages = {line[13:]: float(line[:9]) for line in err.splitlines()}
    assert {"reading", "finding corners", "taking spans away", "bounding the deviation", "writing"} < set(stages)
    assert sum(stages.values()) == pytest.approx(2 * stages["all"], abs=0.01)
    _, _, err = run("fit", "a.csv", "c.csv", "-o", "out", "--format", "json", "-t", "0.01", "-v", "--jobs", "1", "-q")
    assert {"reading", "taking spans away", "writing"} < {line[13:] for line in err.splitlines()}


def test_every_command_tells_its_stages(run):
    write("square.csv", [[-1, -1], [1, -1], [1, 1], [-1, 1]])
    with open("part.nc", "w", encoding="utf-8") as file:
        file.write("G21 G90 G1 F100\n" + "".join(f"G1 X{x:.4f} Y{y:.4f}\n" for x, y, _ in HELIX.tolist()))
    for arguments, expected in (
        (["info", "helix.csv"], {"reading", "measuring"}),
        (["toolpath", "part.nc", "-t", 0.1, "-o", "a.nc"], {"fitting runs"}),
        (["tube", "helix.csv", "--radius", 0.5, "-o", "a.stl"], {"reading", "sweeping", "writing"}),
        (["sweep", "helix.csv", "--profile", "square.csv", "-o", "a.stl"], {"reading", "sweeping", "writing"}),
    ):
        status, _, err = run(*arguments, "-v")
        assert status == 0
        stages = {line[13:]: float(line[:9]) for line in err.splitlines()}
        assert expected < set(stages)
        assert sum(stages.values()) == pytest.approx(2 * stages["all"], abs=0.01)


def test_warnings_of_several_files_name_theirs(run, waves):
    write("edge.csv", np.array([[1, 0], [0.5, 0.1], [0, 0], [0.5, -0.1], [1, 0.0]]))
    status, _, err = run("fit", "a.csv", "edge.csv", "-o", "out", "--format", "json", "--jobs", "1", "-q")
    assert status == 0
    assert err.startswith("cadfit: warning: edge.csv: the last row repeats the first")
    assert err.count("\n") == 1


def test_writing_that_fails_stops_no_other_file(run, waves):
    os.makedirs("out/b.json")
    status, _, err = run("fit", "a.csv", "b.csv", "c.csv", "-o", "out", "--format", "json", "--jobs", "1")
    assert status == 1
    assert sorted(os.listdir("out")) == ["a.json", "b.json", "c.json"]
    assert err.splitlines()[1] == f"cadfit: b.csv: {os.path.join('out', 'b.json')}: Is a directory"


SEVERAL = {
    "nowhere": (["-o", ""], "an output has no name: give a file, or a folder such as out/"),
    "output twice": (["-o", "out/", "-o", "out/"], "out/: given twice as an output"),
    "to a file": (["-o", "a.json"], "a.json: several files need a folder to go to, such as out/"),
    "twice": (["a.csv", "-o", "out"], "a.csv: given twice"),
    "one name": (["old/a.csv", "-o", "out", "--format", "json"], "{old/a.csv} and a.csv would both be written to"),
    "one name in capitals": (["A.csv", "-o", "out", "--format", "json"], "A.csv and a.csv would both be written to"),
    "over an input": (["-o", ".", "--format", "csv"], "a.csv: the output would replace an input"),
    "to both": (["-o", "out/", "-o", "a.json"], "a.json: a file, where out is a folder"),
    "format": (["-o", "out", "--format", "stl"], "{out/a.stl}: .stl does not hold curves"),
    "options": (["-o", "out", "--tension", "1", "-t", "1"], "--tension cannot go with --method tolerance"),
    "corners": (["-o", "out", "--corners", "x", "-t", "1"], "--corners must be auto"),
    "jobs": (["-o", "out", "--jobs", "0"], "Invalid value for '-j'"),
    "summary": (["-o", "out", "--format", "json", "--summary", "a.txt"], "a.txt: the summary is a .csv"),
    "summary over input": (["-o", "out", "--format", "json", "--summary", "b.csv"], "b.csv: the summary would replace"),
    "summary nowhere": (["-o", "o", "--format", "json", "--summary", "x/s.csv"], "x: no such folder for the summary"),
}


@pytest.mark.parametrize("case", SEVERAL)
def test_mistakes_with_several_files(run, waves, case):
    os.mkdir("old")
    before = sorted(os.listdir())
    arguments, expected = SEVERAL[case]
    status, out, err = run("fit", "a.csv", "b.csv", *arguments)
    assert (status, out, err.count("\n")) == (2, "", 1)
    assert err.startswith("cadfit: " + expected.replace("{", "").replace("}", "").replace("/a.stl", f"{os.sep}a.stl"))
    assert [name for name in sorted(os.listdir()) if name != "o"] == before


@pytest.mark.parametrize("option", [["--jobs", "2"], ["--summary", "s.csv"]])
def test_options_for_several_files_alone(run, option):
    assert run("fit", "helix.csv", "-o", "a.json", *option)[::2] == (
        2,
        "cadfit: helix.csv: --jobs and --summary are for several files\n",
    )


SQUARE = [[-1, -1], [1, -1], [1, 1], [-1, 1]]


@pytest.fixture
def vessel(here):
    """A path with a radius in its last column, and a square with a hole to sweep."""
    (here / "vessel.csv").write_text(
        "x,y,z,r\n" + "".join(f"{x!r},{y!r},{z!r},{1 + 0.1 * k / 39!r}\n" for k, (x, y, z) in enumerate(HELIX.tolist()))
    )
    write("square.csv", SQUARE)
    write("hole.csv", 0.5 * np.array(SQUARE))


@pytest.mark.usefixtures("vessel")
def test_a_radius_in_a_column(run):
    by_name = run("tube", "vessel.csv", "--radius", "r", "-o", "a.stl")
    by_number = run("tube", "vessel.csv", "--radius", "#4", "-o", "b.stl")
    assert by_name[0] == by_number[0] == 0
    assert (read("a.stl").vertices == read("b.stl").vertices).all()
    radii = 1 + 0.1 * np.linspace(0, 1, 1001)
    length = float(said(by_name[1])["length"])
    assert read("a.stl").volume == pytest.approx(np.pi * np.mean(radii**2) * length, rel=1e-3)
    for column, why in (
        ("q", "its columns are x, y, z, r; #4 is the fourth"),
        ("#5", "has 4 columns, and no column #5"),
    ):
        status, _, err = run("tube", "vessel.csv", "--radius", column, "-o", "a.stl")
        assert (status, err.count("\n")) == (2, 1)
        assert why in err
    run("fit", "helix.csv", "-o", "curve.json")
    assert "holds curves, which have no column 'r'" in run("tube", "curve.json", "--radius", "r", "-o", "a.stl")[2]


@pytest.mark.slow
@pytest.mark.usefixtures("vessel")
def test_pipes_caps_up_and_repair(run):
    volumes = {}
    for name, options in {
        "plain": [],
        "pipe": ["--thickness", 0.2],
        "round": ["--caps", "round"],
        "up": ["--up", "0,0,1"],
        "fit": ["--fit", 0.01],
    }.items():
        assert run("tube", "helix.csv", "--radius", 0.5, *options, "-o", "a.3mf", "-q") == (0, "", "")
        mesh = read("a.3mf")
        assert mesh.is_watertight
        volumes[name] = mesh.volume
    assert volumes["pipe"] == pytest.approx(volumes["plain"] * (1 - 0.36), rel=1e-3)
    assert volumes["round"] == pytest.approx(volumes["plain"] + 4 / 3 * np.pi * 0.125, rel=1e-2)
    assert volumes["up"] == pytest.approx(volumes["plain"], rel=1e-3)
    assert volumes["fit"] == pytest.approx(volumes["plain"], rel=1e-2)
    assert run("tube", "helix.csv", "--radius", 0.5, "--caps", "none", "-o", "a.stl", "-q")[0] == 0
    assert not read("a.stl").is_watertight
    assert run("tube", "helix.csv", "--radius", 11, "--on-self-intersection", "raise", "-o", "a.stl")[0] == 2
    pytest.importorskip("manifold3d")
    assert run("tube", "helix.csv", "--radius", 11, "--on-self-intersection", "repair", "-o", "a.stl", "-q") == (
        0,
        "",
        "",
    )
    assert read("a.stl").is_watertight


@pytest.mark.usefixtures("vessel")
@pytest.mark.parametrize("suffix", [".stl", ".3mf", ".ply", ".glb", ".obj"])
def test_sweeping_a_profile(run, suffix):
    with_hole = ["--profile", "square.csv", "--profile", "hole.csv"]
    status, out, err = run("sweep", "helix.csv", *with_hole, "--twist", 90, "-o", f"a{suffix}")
    assert (status, err) == (0, "")
    mesh = read(f"a{suffix}")
    assert mesh.is_watertight
    assert mesh.euler_number == 0
    assert len(mesh.split(only_watertight=False)) == 1
    assert mesh.volume == pytest.approx(3 * float(said(out)["length"]), rel=1e-3)
    assert said(out)["profile"] == "square.csv, hole.csv"


@pytest.mark.usefixtures("vessel")
def test_what_a_sweep_refuses(run):
    write("flat.csv", [[0, 0], [1, 0], [2, 0]])
    for arguments, why in [
        (["--profile", "flat.csv"], "flat.csv: the outline of the profile encloses no area"),
        (["--profile", "helix.csv"], "helix.csv: a profile's polygon must have the shape (n >= 3, 2), not (40, 3)"),
        (["--profile", "square.csv", "--up", "0,1"], "helix.csv: --up must be three numbers with commas"),
        (["--profile", "square.csv", "--scale", 0], "helix.csv: the profile must not vanish"),
        (["--profile", "hole.csv", "--profile", "square.csv"], "helix.csv: the profile cannot be filled"),
        ([], "Missing option '--profile'"),
    ]:
        status, _, err = run("sweep", "helix.csv", *arguments, "-o", "a.stl")
        assert (status, err.count("\n")) == (2, 1)
        assert err.startswith(f"cadfit: {why}")


@pytest.mark.usefixtures("vessel")
def test_a_3mf_is_in_millimetres(run):
    run("tube", "helix.csv", "--radius", 0.5, "-o", "a.3mf", "-q")
    run("tube", "helix.csv", "--radius", 0.5, "--unit", "inch", "-o", "b.3mf", "-q")
    assert read("b.3mf").extents == pytest.approx(25.4 * read("a.3mf").extents)
    assert read("b.3mf", "inch").extents == pytest.approx(read("a.3mf").extents)


@pytest.mark.usefixtures("vessel")
def test_texture_coordinates_are_written(run):
    for suffix in (".obj", ".glb"):
        run("sweep", "helix.csv", "--profile", "square.csv", "--texture", "-o", f"a{suffix}", "-q")
        assert trimesh.load_mesh(f"a{suffix}", process=False).visual.uv is not None
