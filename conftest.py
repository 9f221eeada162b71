"""How tests run: the kernel's and the hosts' rooms are collected only where these are installed; laws on steady cases.

With CADFIT_RANDOM=1 in the environment hypothesis tries others each time; with CADFIT_QUICK=1, as `make check` sets it,
it tries fewer, and half as many real curves are taken.
"""

import os
from importlib.util import find_spec

from hypothesis import settings

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # numpy's and scipy's threads spin against each other

cases = {"max_examples": 15 if os.environ.get("CADFIT_QUICK") else 50, "derandomize": "CADFIT_RANDOM" not in os.environ}
settings.register_profile("cadfit", deadline=None, **cases)
settings.load_profile("cadfit")

collect_ignore_glob = [] if find_spec("OCP") else ["cadfit/occt/*", "cadfit/files/kernel.py"]
collect_ignore_glob += [] if find_spec("cadquery") else ["cadfit/cadquery/*", "examples/cadquery/*"]
collect_ignore_glob += [] if find_spec("build123d") else ["cadfit/build123d/*", "examples/build123d_cases.py"]
