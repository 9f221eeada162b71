"""The pages: every block runs, every picture is made by an example, every link leads somewhere, every name is in."""

import ast
import doctest
import importlib.util
import re
import shlex
import sys
from pathlib import Path

import pytest

import cadfit
from cadfit.cli import main

ROOT = Path(__file__).parents[1]
DOCS = ROOT / "docs"
PAGES = sorted(DOCS.glob("*.md"))
ALL = [ROOT / "README.md", *PAGES]
BLOCK = re.compile(r"^```(\w*)\n(.*?)^```", re.MULTILINE | re.DOTALL)
NEEDS = {  # the module that a block needs, by what is in it
    "build123d": r"build123d",
    "ocp_vscode": r"ocp_vscode",
    "cadquery": r"cadquery",
    "OCP": r"\.(step|stp|brep)\b|\bocct\b",
    "ezdxf": r"ezdxf|\.dxf\b",
    "svgelements": r"\.svg\b",
    "dask": r"\bdask\b",
}
ELSEWHERE = ("pip ", "python ", "make ", "pytest ")  # what installs or measures is not run here


def named(paths):
    return [pytest.param(path, id=path.stem) for path in paths]


def missing(code):
    return [name for name, sign in NEEDS.items() if re.search(sign, code) and not importlib.util.find_spec(name)]


def bound_and_used(code):
    nodes = list(ast.walk(ast.parse(code)))
    names = [node for node in nodes if isinstance(node, ast.Name)]
    bound = {node.id for node in names if isinstance(node.ctx, ast.Store)}
    bound |= {node.name for node in nodes if isinstance(node, (ast.FunctionDef, ast.ClassDef))}
    bound |= {(node.asname or node.name).split(".")[0] for node in nodes if isinstance(node, ast.alias)}
    return bound, {node.id for node in names} - bound


def run_python(code, names, skipped):
    """Run a block, unless something it needs is not installed, or was to come from a block that was left out."""
    bound, used = bound_and_used(code)
    if missing(code) or used & skipped:
        skipped |= bound
        return
    skipped -= bound
    exec(compile(code, "<block>", "exec"), names)


def run_doctest(code, names, skipped):
    examples = doctest.DocTestParser().get_examples(code)
    bound, used = bound_and_used("\n".join(example.source for example in examples))
    if missing(code) or used & skipped:
        skipped |= bound
        return
    skipped -= bound
    test = doctest.DocTest(examples, names, "<block>", None, 0, code)
    flags = doctest.NORMALIZE_WHITESPACE | doctest.ELLIPSIS
    out = []
    runner = doctest.DocTestRunner(optionflags=flags)
    runner.run(test, out=out.append, clear_globs=False)
    names.update(test.globs)
    assert runner.failures == 0, "".join(out)


def run_shell(code, skipped):
    for line in code.splitlines():
        words = shlex.split(line, comments=True)
        if not words or line.startswith(ELSEWHERE) or missing(line):
            continue
        assert words[0] == "cadfit", line
        assert main(words[1:]) == 0, line


@pytest.mark.slow
@pytest.mark.parametrize("page", named(PAGES))
def test_every_block_runs(page, tmp_path, monkeypatch):
    matplotlib = pytest.importorskip("matplotlib")
    matplotlib.use("agg")
    (tmp_path / "examples").symlink_to(ROOT / "examples")
    monkeypatch.chdir(tmp_path)
    names, skipped = {"__name__": "page"}, set()
    monkeypatch.setitem(sys.modules, "page", type(sys)("page"))
    for language, code in BLOCK.findall(page.read_text(encoding="utf-8")):
        if language == "python":
            run_python(code, names, skipped)
        elif language == "pycon":
            run_doctest(code, names, skipped)
        elif language == "sh":
            run_shell(code, skipped)
        else:
            assert language in ("text", "toml", "json", "gcode"), f"a block of {language!r}"


def test_a_block_that_is_wrong_is_seen(tmp_path):
    with pytest.raises(AssertionError, match="Expected"):
        run_doctest(">>> 1 + 1\n3\n", {}, set())
    with pytest.raises(AssertionError, match="cadfit info none"):
        run_shell(f"cadfit info none{tmp_path.name}.csv\n", set())
    assert bound_and_used("from a import b\nimport c.d as e, f.g\nh = b(i)") == ({"b", "e", "f", "h"}, {"i"})
    names, skipped = {}, {"host"}
    run_python("part = host.make()\n", names, skipped)
    run_python("print(part)\n", names, skipped)
    assert (names, skipped) == ({}, {"host", "part"})


def without_code(page):
    return re.sub(r"`[^`\n]+`", "", BLOCK.sub("", page.read_text(encoding="utf-8")))


def links(page):
    return re.findall(r"\]\(([^)\s]+)\)", without_code(page))


def anchors(page):
    """The anchors of a page's headings, as Markdown's table of contents makes them."""
    found = []
    text = BLOCK.sub("", page.read_text(encoding="utf-8"))
    for title in re.findall(r"^#+ +(.+)$", text, re.MULTILINE):
        words = re.sub(r"[^\w\s-]", "", re.sub(r"[`*]|\]\([^)]*\)", "", title)).strip().lower()
        found.append(re.sub(r"[-\s]+", "-", words))
    return found


@pytest.mark.parametrize("page", named(ALL))
def test_every_link_leads_somewhere(page):
    for link in links(page):
        if "://" in link:
            continue
        path, _, anchor = link.partition("#")
        target = page.parent / path if path else page
        assert target.exists(), link
        assert page.parent == ROOT or DOCS in target.resolve().parents, f"{link} leads out of the site"
        if anchor and target.name != "api.md":
            assert anchor in anchors(target), link
        if anchor and target.name == "api.md":
            assert f"::: {anchor}" in target.read_text(encoding="utf-8"), link


def test_every_picture_is_used_and_made_by_an_example_or_a_benchmark():
    makers = [*ROOT.glob("examples/**/*.py"), *ROOT.glob("benchmarks/*.py")]
    code = "\n".join(path.read_text(encoding="utf-8") for path in makers if not path.name.startswith("test_"))
    used = {link for page in ALL for link in links(page) if link.endswith((".png", ".svg"))}
    used = {Path(link).name for link in used}
    kept = {path.name for path in (DOCS / "pictures").iterdir()}
    assert used == kept
    stems = {Path(name).stem for name in used}
    assert [stem for stem in stems if stem not in code and f"{stem.rstrip('0123456789')}{{" not in code] == []


def test_every_page_is_in_the_navigation_and_every_name_in_the_api():
    tomllib = pytest.importorskip("tomllib")

    def leaves(entries):
        for entry in entries:
            for value in entry.values():
                yield from [value] if isinstance(value, str) else leaves(value)

    config = tomllib.loads((ROOT / "zensical.toml").read_text(encoding="utf-8"))
    assert sorted(leaves(config["project"]["nav"])) == [page.name for page in PAGES]
    told = re.findall(r"^::: cadfit\.(\w+)$", (DOCS / "api.md").read_text(encoding="utf-8"), re.MULTILINE)
    assert sorted(name for name in told if name in cadfit.__all__) == cadfit.__all__


@pytest.mark.skipif(not (ROOT / "out" / "site").is_dir(), reason="the site is not built: make docs")
def test_the_site_fetches_nothing_from_elsewhere():
    pages = list((ROOT / "out" / "site").rglob("*.html"))
    assert pages
    for page in pages:
        fetched = re.findall(r"<(?:script|link|img|iframe)[^>]*(?:src|href)=\"?(?:https?:)?//[^>]*", page.read_text())
        assert fetched == [], page
