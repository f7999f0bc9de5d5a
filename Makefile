# Two commands do everything on a fresh Debian 12 or 13: `make run` and `make test`.
export OMP_NUM_THREADS := 1
unexport PYTHONDONTWRITEBYTECODE # the processes that tests start read the bytecode of the first one
SHELL := /bin/bash
PYTHON := .venv/bin/python
WORKERS ?= 2
SEED ?= 1

.PHONY: help setup run test test-all test-random test-debian13 lint format schema docs bench clean distclean

help: ## what can be made
	@grep -E '^[a-z0-9-]+:.*##' $(MAKEFILE_LIST) | sed -E 's/:[^#]*## /\t/' | expand -t 12

setup: ## install what is missing (quick when nothing is)
	@tools/setup.sh

run: setup ## the main job: the lab roll chirped through its resonance
	.venv/bin/wroll run configs/lab_sweep.yaml --out runs/lab_sweep --resume

test: setup ## the test suite
	$(PYTHON) -m pytest -q -n $(WORKERS) --dist worksteal -m "not slow"

test-all: setup ## the test suite with the slow tests
	$(PYTHON) -m pytest -q -n $(WORKERS) --dist worksteal

test-random: setup ## the test suite in a random order; the same one for the same SEED
	$(PYTHON) -m pytest -q -n $(WORKERS) --dist worksteal -m "not slow" -p randomly --randomly-seed=$(SEED)

test-debian13: ## the test suite on Debian 13 (dolfinx 0.9) in a chroot; says so where none can be made
	@tools/debian13.sh

lint: setup ## ruff and mypy
	.venv/bin/ruff check .
	.venv/bin/ruff format --check .
	.venv/bin/mypy

format: setup ## let ruff put the code in order
	.venv/bin/ruff check --fix .
	.venv/bin/ruff format .

schema: setup ## write the JSON schema of the case file and the reference pages again
	.venv/bin/wroll schema --out docs/wroll-case.schema.json
	.venv/bin/wroll schema --grid --out docs/wroll-grid.schema.json
	$(PYTHON) -m tools.reference docs/reference

docs: setup ## the pages as one site, without warnings: build/docs/index.html
	$(PYTHON) -m sphinx -E -a -q -W --keep-going -b html -d build/doctrees docs build/docs

bench: setup ## time full, condensed, reduced and harmonic on the lab chirp (about 10 minutes): docs/tables/benchmark.md
	$(PYTHON) benchmarks/run.py

clean: ## remove results and caches
	rm -rf runs build dist *.egg-info .pytest_cache .mypy_cache .ruff_cache .hypothesis
	find . -path ./.venv -prune -o -name __pycache__ -type d -print0 | xargs -0r rm -rf

distclean: clean ## remove .venv as well
	rm -rf .venv
