"""Every benchmark finds what it imports: those of the project's names may have moved."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

pytest.importorskip("OCP", reason="needs OCP: install cadfit[build123d] or cadfit[cadquery]")

FOLDER = Path(__file__).parents[2] / "benchmarks"
IMPORTING = """
import importlib, pathlib
for path in sorted(pathlib.Path().glob("*.py")):
    try:
        importlib.import_module(path.stem)
    except ModuleNotFoundError as missing:  # a host or a peer that this environment has not
        assert not missing.name.startswith("cadfit"), missing
        print(path.stem, "needs", missing.name)
"""


@pytest.mark.slow
def test_what_benchmarks_import_is_there():
    done = subprocess.run([sys.executable, "-c", IMPORTING], cwd=FOLDER, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    assert len(done.stdout.splitlines()) < len(list(FOLDER.glob("*.py"))) / 2
