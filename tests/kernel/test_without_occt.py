"""Without a kernel: the message says how to get one."""

import importlib
import sys

import pytest


def test_missing_kernel_names_the_extras(monkeypatch):
    for name in [name for name in sys.modules if name.startswith("cadfit.occt")]:
        monkeypatch.delitem(sys.modules, name)
    for name in ("OCP", "OCP.BRep"):
        monkeypatch.setitem(sys.modules, name, None)
    with pytest.raises(ImportError, match=r"cadfit\[build123d\]' or 'cadfit\[cadquery\]"):
        importlib.import_module("cadfit.occt")
