"""What `import cadfit` brings in, and that every public name is there and says what it is."""

import importlib
import importlib.metadata
import inspect
import subprocess
import sys

import pytest

import cadfit

HEAVY = ["OCP", "trimesh", "matplotlib", "build123d", "cadquery", "networkx", "lxml", "typer", "rich"]
CORE = [name for name in cadfit.__all__ if name not in {"Curves", "read", "write", "tube"}]


def loaded_after(statements):
    """The top-level modules a fresh interpreter holds after the statements."""
    code = f"{statements}\nimport sys\nprint(*sorted({{name.split('.')[0] for name in sys.modules}}))"
    return set(subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout.split())


def test_the_package_alone_brings_in_nothing():
    assert loaded_after("import cadfit").isdisjoint([*HEAVY, "numpy", "scipy"])


@pytest.mark.slow
def test_fitting_brings_in_numpy_and_scipy_alone():
    fit = f"import cadfit\nfor name in {CORE}: getattr(cadfit, name)\n"
    fit += "cadfit.deviation(cadfit.cardinal_spline([(0, 0), (1, 1)]), [(0, 0), (1, 1)])"
    assert loaded_after(fit).isdisjoint(HEAVY)


@pytest.mark.parametrize("name", cadfit.__all__)
def test_every_public_name_resolves_and_is_documented(name):
    value = getattr(cadfit, name)
    assert callable(value)
    assert inspect.getdoc(value)
    assert value.__name__ == name
    assert getattr(cadfit, name) is value
    assert name in dir(cadfit)


@pytest.mark.parametrize("name", cadfit.__all__)
def test_methods_of_public_classes_are_documented(name):
    members = vars(value) if inspect.isclass(value := getattr(cadfit, name)) else {}
    fields = getattr(value, "__dataclass_fields__", {})
    own = [member for member in members if not member.startswith("_") and member not in fields]
    assert [member for member in own if not inspect.getdoc(getattr(value, member))] == []


def test_public_names_are_in_order():
    assert cadfit.__all__ == sorted({*cadfit.__all__})


def test_unknown_names_are_attribute_errors():
    with pytest.raises(AttributeError, match="module 'cadfit' has no attribute 'spline'"):
        cadfit.spline  # noqa: B018
    with pytest.raises(ImportError):
        importlib.import_module("cadfit.spline")
    assert not hasattr(cadfit, "__wrapped__")


def test_the_version_is_the_distributions():
    assert importlib.metadata.version("cadfit") == cadfit.__version__
