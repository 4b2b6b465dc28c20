# `make demo` and `make test` need only python3 (3.11 or later) with its venv module, and pip.
PYTHON ?= python3
BIN := $(CURDIR)/.venv/bin
READY := .venv/.ready

# what a kernel does is tested here
KERNEL_TESTS := $(addprefix tests/,remeshing surface mesh insertion gradation tetrahedra)
# rooms of numpy alone, and one of kernels
FAST_TESTS := $(addprefix tests/,assembly campaign commands cracks deck io mechanics sizing voxels) \
    tests/gradation/test_gradation_kernels.py
# plain Python is quick enough for these
UNCOMPILED_TESTS := $(addprefix tests/gradation/test_,\
    gradation_kernels.py guards.py preprocess.py refusals.py refused_moves.py)

# where this is set, as in many containers, each process would compile all that it imports: jobs of 2 s took 6
unexport PYTHONDONTWRITEBYTECODE

.PHONY: setup docs demo paper test test-fast test-slow test-slurm test-bounds test-branches lint speed bench wheel

setup: $(READY)

# Debian splits pip off the venv module, so the environment is made without pip and filled from outside.
# Compiling every module of every package took half of that minute; those in use are compiled by use.
$(READY): pyproject.toml constraints.txt
	$(PYTHON) -m venv --without-pip .venv
	$(PYTHON) -m pip --python .venv/bin/python install -q --no-compile -c constraints.txt -e '.[test]'
	@echo "Installed with TetGen (package tetgen, AGPL-3.0) and fTetWild (package pytetwild, MPL-2.0) as meshers:"
	@echo "see the section Licence of README.md before you pass them on or serve them."
	touch $@

demo: setup
	$(BIN)/craftmesh demo

# the paper's three models (docs/paper.md) into results/: two hours of CPU, 7 GB for the largest job
paper: setup
	for model in 1 2 3; do \
	    $(BIN)/snakemake --cores all --configfile examples/paper_$$model/config.yaml || exit; \
	done
	$(BIN)/snakemake intensities all --cores all \
	    --configfile examples/paper_3/config.yaml examples/paper_3/uniform.yaml

# the kernels first, a half on each core: campaigns would wait for each other's. The campaigns of a file are made
# once for all its tests; a test that hangs fails after a quarter of an hour.
test: setup
	$(BIN)/craftmesh compile volume & $(BIN)/craftmesh compile; status=$$?; wait; exit $$status
	$(BIN)/python -m pytest -m "not slow" -n 2 --dist loadfile --no-loadscope-reorder --timeout 900

# under a minute with compiled kernels
test-fast: setup
	$(BIN)/python -m pytest -m "not slow" -n 2 $(FAST_TESTS)

# indices out of bounds are errors; a cache of its own, for numba does not tell such kernels from others
test-bounds: setup
	NUMBA_BOUNDSCHECK=1 NUMBA_CACHE_DIR=$(CURDIR)/.numba-bounds \
	    $(BIN)/python -m pytest -m "not slow" -n 2 $(KERNEL_TESTS)

# the lines of the gradation's kernels that no test of theirs reaches, found without compiling
test-branches: setup
	$(PYTHON) -m pip --python .venv/bin/python install -q -c constraints.txt -e '.[branches]'
	NUMBA_DISABLE_JIT=1 $(BIN)/coverage run --branch --include='craftmesh/gradation/kernels/*' \
	    -m pytest -m "not slow" $(UNCOMPILED_TESTS)
	$(BIN)/coverage report --show-missing

test-slow: setup
	$(BIN)/python -m pytest -m slow

# as root, with Debian's slurm-wlm, which is installed where it is missing: a Slurm of one node on loopback, ten
# minutes; where that cannot be it says why
test-slurm: setup
	CRAFTMESH_TEST_SLURM=1 $(BIN)/python -m pytest -rs tests/workflow/test_slurm.py

# the site in site/; a link that leads nowhere or a docstring that cannot be read stops it
docs: setup
	$(BIN)/python -m mkdocs build --strict --quiet

lint: setup
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/mypy
	$(BIN)/snakefmt --check Snakefile workflow
	$(BIN)/snakemake --lint
	$(BIN)/python -m pytest tests/test_architecture.py
	$(BIN)/python .ci/size.py

# gradate and tetrahedralize beside TetGen, against the last row of docs/speed.csv that is of this machine
speed: setup
	$(BIN)/python benchmarks/speed.py --check

# dist/: sdist, wheel, and the wheel that has the kernels' machine code, for the Python of .venv
wheel: setup
	.ci/release
	.ci/wheel dist/craftmesh-*-none-any.whl $(BIN)/python dist

bench: setup
	$(BIN)/python benchmarks/speed.py
	$(BIN)/python benchmarks/gradation.py
	$(BIN)/python benchmarks/volume.py
	$(BIN)/python benchmarks/deck.py
	$(BIN)/python benchmarks/noise.py
	$(BIN)/python benchmarks/solve.py
