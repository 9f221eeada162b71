import os

from hypothesis import settings

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # numpy's and scipy's threads spin against each other

settings.register_profile("cadfit", deadline=None, max_examples=50, derandomize="CI" in os.environ)
settings.load_profile("cadfit")
