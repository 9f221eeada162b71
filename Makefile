# make demo    set everything up, run the main job on real input
# make test    set everything up, run every test
# make check   the fast loop: format, lint, types, import directions, quick unit tests (core environment)
# make bench   the benchmark tables of the README
# make docs    the site of docs/, in out/site (its search needs a server: python -m http.server -d out/site)

PYTHON ?= python3
export UV_PYTHON_DOWNLOADS = never
# Compiled files are kept, whatever the environment says: to compile scipy anew is half the time of a short run.
export PYTHONDONTWRITEBYTECODE =

# Two hosts, two environments: build123d and CadQuery ship different builds of OCP into one folder. And two more with
# the oldest versions that are supported.
CORE := .venv
B123D := .venv-build123d
CQ := .venv-cadquery
OLDEST := $(B123D)-oldest $(CQ)-oldest
DOCS := .venv-docs

.PHONY: demo test check lint format bench docs clean

demo: $(B123D)/ready
	$(B123D)/bin/python examples/demo.py

test: lint docs $(B123D)/ready $(CQ)/ready $(OLDEST:%=%/ready)
	$(CORE)/bin/python -m pytest -n auto tests cadfit
	$(CORE)/bin/python -m pytest examples
	CADFIT_QUICK=1 $(B123D)/bin/python -m pytest -n auto -m "not slow" --ignore tests/kernel tests cadfit
	$(B123D)/bin/python -m pytest -n auto tests/kernel examples
	CADFIT_QUICK=1 $(CQ)/bin/python -m pytest -n auto -m "not slow" --ignore tests/kernel tests cadfit
	$(CQ)/bin/python -m pytest -n auto tests/kernel examples
	$(B123D)-oldest/bin/python -m pytest -n auto tests/kernel
	$(CQ)-oldest/bin/python -m pytest -n auto tests/kernel

check: lint
	CADFIT_QUICK=1 $(CORE)/bin/python -m pytest -n auto -m "not slow" tests cadfit

lint: $(CORE)/ready
	$(CORE)/bin/ruff format --check .
	$(CORE)/bin/ruff check .
	$(CORE)/bin/mypy
	$(CORE)/bin/lint-imports --verbose

format: $(CORE)/ready
	$(CORE)/bin/ruff check --fix .
	$(CORE)/bin/ruff format .

docs: $(DOCS)/ready
	PYTHONPATH=tools $(DOCS)/bin/python -m zensical build --clean --strict

bench: $(B123D)/ready $(CQ)/ready
	$(B123D)/bin/python benchmarks/run.py

# uv resolves and installs; where the machine has none, a copy of our own.
UV := $(shell command -v uv || echo .venv-uv/bin/uv)

.venv-uv/bin/uv:
	$(PYTHON) -m venv .venv-uv
	.venv-uv/bin/python -m pip install --quiet uv

$(CORE)/ready $(DOCS)/ready: EXTRAS := .
$(CORE)/ready: GROUPS := --group test --group lint
$(B123D)/ready $(B123D)-oldest/ready: EXTRAS := .[build123d,plot]
$(CQ)/ready $(CQ)-oldest/ready: EXTRAS := .[cadquery,plot]
$(B123D)/ready: GROUPS := --group test --group bench
$(CQ)/ready $(OLDEST:%=%/ready): GROUPS := --group test
$(B123D)-oldest/ready: PIN := build123d==0.12.0
$(CQ)-oldest/ready: PIN := cadquery==2.7.0
$(DOCS)/ready: GROUPS := --group docs

%/ready: pyproject.toml | $(UV)
	$(UV) venv --quiet --clear --python $(PYTHON) $*
	$(UV) pip install --quiet --python $*/bin/python --editable '$(EXTRAS)' $(PIN) $(GROUPS)
	touch $@

clean:
	rm -rf .venv* out
