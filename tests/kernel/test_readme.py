"""The README's Python runs as it stands and ends with a STEP file that holds what it says."""

import re
from pathlib import Path

import numpy as np
import pytest
import trimesh

pytest.importorskip("OCP", reason="needs OCP: the README's lines end with a STEP file")
ROOT = Path(__file__).parents[2]


def test_the_readmes_lines_run(tmp_path, monkeypatch):
    code, *_ = re.findall(r"```python\n(.*?)```", (ROOT / "README.md").read_text(encoding="utf-8"), re.DOTALL)
    assert 8 <= len([line for line in code.splitlines() if line.strip()]) <= 12
    (tmp_path / "examples").symlink_to(ROOT / "examples")
    monkeypatch.chdir(tmp_path)
    names = {}
    exec(code, names)
    [back] = names["cadfit"].read("airfoil.step").curves
    fit = names["fit"]
    assert np.array_equal(back.poles[:, :2], fit.spline.poles)
    assert np.array_equal(back.knots, fit.spline.knots)
    assert fit.corners.tolist() == [0]
    assert f"# {len(fit.spline.poles)} poles" in code
    assert fit.deviation.points <= 1e-4
    mesh = trimesh.load("tube.stl")
    assert mesh.is_watertight
    assert mesh.volume == pytest.approx(np.pi * 0.75**2 * names["wire"].length(), rel=1e-3)


def test_every_file_the_readme_points_to_is_there():
    links = re.findall(r"\]\(([^)#:]+)\)", (ROOT / "README.md").read_text(encoding="utf-8"))
    assert len(links) > 8
    assert [link for link in links if not (ROOT / link).exists()] == []
