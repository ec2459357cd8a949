# `make` lists what there is. Everything happens in .venv; nothing else on the machine is touched.

BIN := .venv/bin
DEMO_EXTRAS := sim

# One BLAS thread a process: the matrices are small, and tests and folds run side by side.
export OMP_NUM_THREADS := 1
export OPENBLAS_NUM_THREADS := 1
export MKL_NUM_THREADS := 1

UV := $(shell command -v uv)
# Searched for only by the recipe that makes .venv. Pip is told twice to be quiet: once leaves warnings.
PYTHON ?= $(shell for p in python3.11 python3.12 python3.13 python3; do \
	"$$p" -c 'import sys; sys.exit(sys.version_info < (3, 11))' 2>/dev/null && echo "$$p" && break; done)
INSTALL = $(if $(UV),$(UV) pip install --quiet --python $(BIN)/python,$(BIN)/python -m pip install -qq)

.DEFAULT_GOAL := help
.DELETE_ON_ERROR:
.PHONY: help setup demo test check format-check lint types imports bench figures honesty fuzz docs clean

help: ## list these targets
	@awk -F ':.*## ' '/^[a-z-]+:.*## / {printf "make %-13s %s\n", $$1, $$2}' $(firstword $(MAKEFILE_LIST))

setup: .venv/.installed ## make .venv and install all that development needs
	@echo "Ready: $(BIN)/bodyschema. Next: make demo, make test."

demo: .venv/.installed-demo ## calibrate a simulated robot that does not know its arm
	$(BIN)/python examples/demo.py

test: .venv/.installed ## run all tests
	$(BIN)/pytest -n auto

check: format-check lint types imports ## check form, types and the order of imports

format-check: .venv/.installed
	$(BIN)/ruff format --check .

lint: .venv/.installed
	$(BIN)/ruff check .

types: .venv/.installed
	$(BIN)/mypy

imports: .venv/.installed
	$(BIN)/lint-imports

bench: .venv/.installed ## measure accuracy on recordings, speed, and whether answers can be trusted
	$(BIN)/python benchmarks/recordings.py
	$(BIN)/python benchmarks/speed.py
	$(BIN)/python benchmarks/trust.py

figures: .venv/.installed ## compare the key figures of every part with their frozen values
	$(BIN)/python benchmarks/figures.py

honesty: .venv/.installed ## how often a wrong answer gets a green light, and a good one none; half an hour
	$(BIN)/python benchmarks/honesty.py --runs 1400

fuzz: .venv/.installed ## read thousands of damaged and hostile files; ten minutes
	$(BIN)/python benchmarks/fuzz.py --mutants 6000

docs: .venv/.installed-docs ## build the documentation into docs/_build
	$(BIN)/sphinx-build -W --keep-going --quiet docs docs/_build
	@echo "Open docs/_build/index.html."

clean: ## remove what the other targets made, except .venv
	rm -rf build demo dist docs/_build .hypothesis .import_linter_cache .mypy_cache .pytest_cache .ruff_cache
	find . -name .venv -prune -o -name __pycache__ -type d -prune -exec rm -rf {} +

# Without ensurepip `venv` would leave half an environment behind, so it is looked for first.
$(BIN)/python:
ifeq ($(UV),)
	@test -n "$(PYTHON)" || { echo "Python 3.11 or newer is needed; none was found." >&2; exit 1; }
	@$(PYTHON) -c 'import ensurepip' 2>/dev/null || { \
		echo "$(PYTHON) has no ensurepip, so it cannot make .venv." >&2; \
		echo "Install it (Debian, Ubuntu: apt install python3-venv) or install uv." >&2; exit 1; }
	$(PYTHON) -m venv .venv
else
	$(UV) venv --quiet --seed --python '>=3.11' .venv
endif

# A stamp is written last, so that an install that was cut off runs again.
.venv/.installed: pyproject.toml | $(BIN)/python
	@echo "Installing bodyschema for development into .venv ..."
	@$(INSTALL) -e '.[dev]'
	@touch .venv/.installed-demo $@

# The demo's packages are a part of development's: after `make setup` there is nothing to do.
.venv/.installed-demo: pyproject.toml | $(BIN)/python
	@echo "Installing bodyschema for the demo into .venv ..."
	@$(INSTALL) -e '.[$(DEMO_EXTRAS)]'
	@touch $@

.venv/.installed-docs: pyproject.toml | $(BIN)/python
	@echo "Installing bodyschema for the documentation into .venv ..."
	@$(INSTALL) -e '.[docs]'
	@touch $@
