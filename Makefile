# `make demo` and `make test` need only python3 (3.11 or later) with its venv module, and pip.
PYTHON ?= python3
BIN := $(CURDIR)/.venv/bin
READY := .venv/.ready

.PHONY: setup demo test test-slow lint bench

setup: $(READY)

# Debian splits pip off the venv module, so the environment is made without pip and filled from outside.
$(READY): pyproject.toml constraints.txt
	$(PYTHON) -m venv --without-pip .venv
	$(PYTHON) -m pip --python .venv/bin/python install -q -c constraints.txt -e '.[test]'
	@echo "Installed with TetGen (package tetgen, AGPL-3.0) and fTetWild (package pytetwild, MPL-2.0) as meshers:"
	@echo "see the section Licence of README.md before you pass them on or serve them."
	touch $@

demo: setup
	$(BIN)/snakemake --cores all

test: setup
	$(BIN)/python -m pytest -m "not slow" -n 2 --dist loadgroup

test-slow: setup
	$(BIN)/python -m pytest -m slow

lint: setup
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/mypy
	$(BIN)/python -m pytest tests/test_architecture.py

bench: setup
	$(BIN)/python benchmarks/gradation.py
	$(BIN)/python benchmarks/volume.py
	$(BIN)/python benchmarks/deck.py
