"""`cadfit fit --report`: the page says what was done, and by which command."""

import hashlib
import json
import shlex
from pathlib import Path

import numpy as np
import pytest
from test_report import Words

import cadfit
from cadfit.cli import main

WAVE = np.column_stack([x := np.linspace(0, 9, 80), np.sin(x)])


@pytest.fixture
def run(tmp_path, monkeypatch, capsys):
    """Run the command line in a folder with wave.csv; return the status, and what it printed and said."""
    monkeypatch.chdir(tmp_path)
    cadfit.write("wave.csv", WAVE)

    def run(*arguments):
        return (main(list(arguments)), *capsys.readouterr())

    return run


def page(name):
    return Words(Path(name).read_text(encoding="utf-8"))


def test_the_page_is_of_the_fit_and_names_the_command(run):
    arguments = ["fit", "wave.csv", "-t", "0.01", "--report", "a b.html", "-o", "a.json", "--unit", "m"]
    status, out, err = run(*arguments)
    assert (status, err) == (0, "")
    assert out.splitlines()[-2:] == ["wrote a.json", "wrote a b.html"]
    found = page("a b.html")
    data = json.loads(found.scripts[0])
    fit = cadfit.fit(WAVE, 0.01)
    assert np.array_equal(data["entries"][0]["exact_poles"][0], fit.spline.poles)
    assert data["unit"] == "m"
    assert shlex.join(["cadfit", *arguments]) in found.words
    assert "cadfit.fit(points, 0.01)" in found.words
    assert hashlib.sha256(Path("wave.csv").read_bytes()).hexdigest() in "".join(found.words)
    assert "wave.csv" in found.words


@pytest.mark.parametrize("options", [[], ["--method", "cardinal"], ["--fraction", "0.5"]])
def test_curves_through_points_have_a_page_too(run, options):
    assert run("fit", "wave.csv", "--report", "a.html", *options)[0] == 0
    figures = json.loads(page("a.html").scripts[0])["entries"][0]["figures"]
    assert figures["tolerance"] is None
    assert figures["points"] == 80


def test_a_file_named_as_a_tag(run):
    name = "<script>alert(1)<>.csv"
    cadfit.write(name, WAVE)
    assert run("fit", name, "-t", "0.01", "--report", "a.html")[0] == 0
    found = page("a.html")
    assert len(found.scripts) == 2
    assert name in found.words


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["wave.csv", "-t", "1"], "wave.csv: where to? --output says it, or --report"),
        (["wave.csv", "-t", "1", "--report", "a.pdf"], "a.pdf: a report is a .html"),
        (["wave.csv", "-t", "1", "--report", "none/a.html"], "none/a.html: no such folder"),
        (["wave.csv", "wave.csv", "-t", "1", "-o", "out/", "--report", "a.html"], "a.html: --report is for one file"),
    ],
)
def test_mistakes_are_said_before_the_work(run, arguments, message):
    status, out, err = run("fit", *arguments)
    assert (status, out) == (2, "")
    assert err.startswith(f"cadfit: {message}")
    assert not list(Path().glob("*.html"))
