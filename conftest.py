"""The rooms of the kernel and of a host are collected only where these are installed; laws are tried on steady cases.

With CADFIT_RANDOM=1 in the environment hypothesis tries others each time.
"""

import os
from importlib.util import find_spec

from hypothesis import settings

settings.register_profile("steady", derandomize=True)
settings.load_profile("default" if os.environ.get("CADFIT_RANDOM") else "steady")

collect_ignore_glob = [] if find_spec("OCP") else ["cadfit/occt/*", "cadfit/files/kernel.py"]
collect_ignore_glob += [] if find_spec("cadquery") else ["cadfit/cadquery/*", "examples/cadquery/*"]
collect_ignore_glob += [] if find_spec("build123d") else ["cadfit/build123d/*", "examples/build123d_cases.py"]
