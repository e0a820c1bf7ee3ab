# make paper | demo | test | frozen | nightly | floors | dist | docs | benchmark | kernels | wasm |
# lock | clean.
# Set-up happens by itself, in .venv.

# The first Python that is new enough; PYTHON=... on the command line chooses another.
CANDIDATES = python3 python3.14 python3.13 python3.12 python3.11
NEW_ENOUGH = -c 'import sys; sys.exit(sys.version_info < (3, 11))'
PYTHON = $(shell for p in $(CANDIDATES); do \
	$$p $(NEW_ENOUGH) 2>/dev/null && command -v $$p && break; done)

BIN = .venv/bin
# Debian's venv has no pip of its own unless python3-venv is installed: then the system's pip fills it.
PIP = $$($(BIN)/python -c 'import pip' 2>/dev/null && echo $(BIN)/python || echo $(PYTHON)) \
	-m pip --python $(BIN)/python --disable-pip-version-check --quiet

STUDIES = examples/n3_above.toml examples/n3_below.toml examples/half_harmonic.toml

.PHONY: paper demo test frozen nightly docs benchmark kernels wasm large-kernels doctests collected
.PHONY: other-tests types style floors dist lock clean numbers numbers-of-motions numbers-of-grids
.DELETE_ON_ERROR:

paper: .venv/run.stamp
	$(BIN)/percuss paper --out demo/paper --force

demo: .venv/run.stamp
	@mkdir -p demo
	@set -e; for study in $(STUDIES); do \
		echo "percuss run $$study"; \
		$(BIN)/percuss run $$study --out demo/$$(basename $$study .toml) --force; \
	done
	$(BIN)/python examples/graze_and_chatter.py --out demo/graze_and_chatter.png

# The tests begin a hundred processes: without its bytecode each would compile the package anew.
unexport PYTHONDONTWRITEBYTECODE

# Some tests at a time, as tests/conftest.py says; a worker that has done its share takes from
# another's.
TESTS = $(BIN)/python -m pytest -n logical --dist worksteal

# The examples of docstrings compile the kernels of one displacement on one core, on the other three
# files of tests compile those of structures, the largest, before an example asks for them: each is
# compiled once, beside others that share its parts, and all tests find it. The file that compares
# structures with oscillators comes last: by then the doctests have compiled the kernels that both
# need. Types and style are checked beside the other tests, while these wait.
LARGE_KERNELS = tests/structures/test_ensembles.py tests/fitting/test_structure_shooting.py \
	tests/sensitivity/test_structures.py
test: .venv/dev.stamp
	$(MAKE) --jobs 2 large-kernels doctests collected
	$(MAKE) --jobs 3 other-tests types style

other-tests: .venv/dev.stamp
	$(TESTS) tests $(LARGE_KERNELS:%=--ignore=%)

# Keeps all tests compiled for the workers: what is wrong with one these tell.
collected: .venv/dev.stamp
	-@$(BIN)/python -m pytest --collect-only -q tests >/dev/null

large-kernels: .venv/dev.stamp
	$(BIN)/python -m pytest -q $(LARGE_KERNELS)

# What a change of the house must not change; after a change that is meant, `make frozen KEEP=--write`.
frozen: .venv/dev.stamp
	$(BIN)/python -m tests.frozen $(KEEP)

# The second and third runs: the quick part as on machines of other kinds.
SOME = tests/orbits tests/motion tests/kernels tests/model tests/paper
PLAIN = OPENBLAS_CORETYPE=Prescott NUMBA_CPU_NAME=generic \
	NPY_DISABLE_CPU_FEATURES="X86_V3 X86_V4 AVX512_ICL" \
	GLIBC_TUNABLES=glibc.cpu.hwcaps=-AVX2,-FMA,-FMA4,-AVX2_Usable,-FMA_Usable
nightly: .venv/dev.stamp
	$(MAKE) --jobs 2 TYPED= doctests types style
	$(TESTS) -m "nightly or not nightly" tests
	OPENBLAS_CORETYPE=SkylakeX $(TESTS) $(SOME)
	$(PLAIN) $(TESTS) $(SOME)

# By day the types of the package, at night those of the tests too.
TYPED = src tools
types: .venv/dev.stamp
	$(BIN)/mypy $(TYPED)

style: .venv/dev.stamp
	$(BIN)/ruff check
	$(BIN)/ruff format --check
	$(BIN)/lint-imports

doctests: .venv/dev.stamp
	MPLBACKEND=agg $(BIN)/python -m pytest src

# What hangs on numbers, for a second run as on a machine of another kind: the digests of results,
# motions by closed forms, orbits and verdicts on the paper. The rest runs so at night. One half compiles the kernels of a motion, the other begins with those of grids.
MOTIONS = closed_forms edges growth half_harmonic
ORBITS = edges grazing reference_orbits special_points symmetry
VERDICTS = harmonics oscillator_statements smooth_law
numbers: .venv/dev.stamp
	$(MAKE) --jobs 2 numbers-of-motions numbers-of-grids

numbers-of-motions:
	$(BIN)/python -m pytest -q $(MOTIONS:%=tests/motion/test_%.py)

numbers-of-grids:
	$(BIN)/python -m pytest -q tests/ensembles/test_reference_cases.py \
		$(ORBITS:%=tests/orbits/test_%.py) $(VERDICTS:%=tests/paper/test_%.py)

# Needs uv. The tests with the oldest versions that pyproject.toml takes, in an environment of its
# own; FLOOR_PYTHON=3.12 takes another interpreter.
FLOOR_PYTHON = $(PYTHON)
# Old packages use what newer ones, on which they depend, call deprecated.
OLD = -W ignore::DeprecationWarning -W ignore::PendingDeprecationWarning
FLOORS = tests/model tests/motion tests/io tests/ensembles tests/orbits tests/optimization \
	tests/plotting tests/studies
floors:
	uv venv --quiet --clear --python $(FLOOR_PYTHON) .venv-floors
	uv pip install --quiet --python .venv-floors --resolution lowest-direct \
		--group floors --editable ".[certified,design,netcdf,stores]"
	.venv-floors/bin/python -m pytest -q -n logical --dist worksteal $(OLD) $(FLOORS)

# The wheel and the source distribution, and what is in them. Where what is made of the kernels is not
# of those of today, it is made first.
dist: kernels
	$(BIN)/python -m percuss.web.wasm.sources || $(BIN)/python -m percuss.web.wasm.build
	$(BIN)/python -m hatchling build
	$(BIN)/python -m pytest -q tests/test_distribution.py

docs: .venv/docs.stamp
	$(BIN)/python -m sphinx -b html -W --keep-going -q docs docs/_build
	@echo "open docs/_build/index.html"

benchmark: .venv/benchmark.stamp
	$(BIN)/python benchmarks/run.py

# What the package keeps of the kernels' compilation, after a change of kernels.
kernels: .venv/dev.stamp
	MPLBACKEND=agg $(BIN)/python tools/precompile.py

# The kernels of the page, after a change of kernels. Needs wasm-ld (Debian: lld), or LINKER=...
wasm: .venv/run.stamp
	$(BIN)/python -m percuss.web.wasm.build

# Once a stamp is there nothing is downloaded, until the lock or pyproject.toml changes. Of eleven
# thousand files most are never imported: those that are get their bytecode then.
.venv/%.stamp: requirements/%.txt pyproject.toml | .venv/made.stamp
	@echo "installing $< into .venv"
	@$(PIP) install --no-compile --require-hashes -r $<
	@$(PIP) install --no-compile --no-deps --no-build-isolation --editable .
	@touch $@

# An environment that works is adopted, and one that was left half-made here is made again, as its
# mark tells. Any other is somebody else's, and stays.
.venv/made.stamp:
	@test -n "$(PYTHON)" && "$(PYTHON)" $(NEW_ENOUGH) 2>/dev/null || { \
		echo "percuss needs Python 3.11 or newer: none of $(or $(PYTHON),$(CANDIDATES)) is;" \
			"name one with make PYTHON=/path/to/python3" >&2; exit 1; }
	@$(BIN)/python $(NEW_ENOUGH) 2>/dev/null && $(BIN)/python -m pip --version >/dev/null 2>&1 || { \
		test ! -e .venv || test -e .venv/half-made || { \
			echo ".venv is there, is not of this Makefile's making and cannot be used: its Python" \
				"is older than 3.11 or has no pip; move it away" >&2; exit 1; }; \
		$(AFRESH); "$(PYTHON)" -m venv .venv >/dev/null 2>&1 || { \
		$(AFRESH); "$(PYTHON)" -m pip --version >/dev/null 2>&1 || { \
			echo "percuss needs pip: $(PYTHON) has none (on Debian: apt install python3-pip)" >&2; \
			exit 1; }; \
		"$(PYTHON)" -m venv --without-pip .venv; }; }
	@rm -f .venv/half-made
	@touch $@
AFRESH = rm -rf .venv; mkdir .venv && touch .venv/half-made

# Needs uv. Keeps the versions that stand in the locks; make lock UPGRADE=--upgrade renews them.
LOCK = UV_CUSTOM_COMPILE_COMMAND="make lock" uv pip compile pyproject.toml --quiet --universal \
	--python-version 3.11 --generate-hashes --no-annotate --no-emit-index-url \
	--no-emit-find-links $(UPGRADE)
lock:
	$(LOCK) --group build --group dev --extra all -o requirements/dev.txt
	$(LOCK) --group build --group docs --extra all -c requirements/dev.txt -o requirements/docs.txt
	$(LOCK) --group build --extra netcdf --extra paper --extra stores --extra web -c requirements/dev.txt -o requirements/run.txt
	$(LOCK) --group build --extra benchmark --extra certified --extra netcdf --extra stores --extra web -c requirements/dev.txt -o requirements/benchmark.txt

# What the demos have written; what else is in their folder stays.
DEMOS = demo/paper demo/graze_and_chatter.png $(patsubst examples/%.toml,demo/%,$(STUDIES))
clean:
	rm -rf $(DEMOS) dist docs/_build docs/gallery .mypy_cache .pytest_cache .ruff_cache .hypothesis .import_linter_cache
	rmdir demo 2>/dev/null || true
	find src tests examples benchmarks -name __pycache__ -type d -prune -exec rm -rf {} +
