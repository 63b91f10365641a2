# Needs Python 3.11 or newer, make and a network; everything else goes into .venv.
PYTHON ?= python3
BIN := .venv/bin
# Small matrices: more threads a product only get in each other's way.
export OPENBLAS_NUM_THREADS := 1

.PHONY: help demo play test test-all lint format bench experiments pictures docs clean

help:            ## these lines
	@grep -E '^[a-z-]+:.*##' $(MAKEFILE_LIST) | sed 's/:.*##/\t/'

.venv/installed: pyproject.toml
	@$(PYTHON) -c 'import sys; sys.exit(sys.version_info < (3, 11) and "Python 3.11 or newer is needed, as in make PYTHON=python3.11")'
	$(PYTHON) -m venv .venv
	$(BIN)/python -m pip install --quiet --disable-pip-version-check --editable '.[dev]'
	touch $@

demo: .venv/installed            ## the main job: drive, judge, compensate; results/index.html shows it
	@$(BIN)/python experiments/radius_compensation.py
	@$(BIN)/python experiments/mismatched_radii.py

node_modules/.package-lock.json: package-lock.json
	@command -v npm > /dev/null || { echo "make play needs npm, which comes with Node.js" >&2; exit 2; }
	npm ci --no-fund --no-audit
	touch $@

play: .venv/installed node_modules/.package-lock.json            ## drive by hand, in the browser (needs npm); ROBOT=ct_bot takes another robot
	@$(BIN)/diffdrive play $(ROBOT)

test: .venv/installed            ## the tests, the experiments' bounds among them, but for a few slow ones
	$(BIN)/python -m pytest --numprocesses 2 --dist worksteal -m "not slow"

test-all: .venv/installed            ## all tests
	$(BIN)/python -m pytest --numprocesses 2 --dist worksteal

lint: .venv/installed            ## style and types
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/mypy

format: .venv/installed            ## put the style right
	$(BIN)/ruff check --fix .
	$(BIN)/ruff format .

bench: .venv/installed            ## speed, as ratios taken in one run
	@$(BIN)/python benchmarks/bench.py

experiments: .venv/installed            ## every experiment, its bounds checked
	@for script in experiments/*.py; do $(BIN)/python $$script || exit 1; done

pictures: experiments            ## the pictures of the READMEs, made anew; DATA=folder adds the real robot's
	@if [ -n "$(DATA)" ]; then for name in umbmark calibration error_attribution; do \
		$(BIN)/python experiments/$$name.py --data "$(DATA)" || exit 1; done; fi
	@mkdir -p experiments/pictures && cp results/*/*.png experiments/pictures/
	@$(BIN)/python examples/ghost.py

docs: .venv/installed            ## the pages as a website in docs/_build/html, warnings as errors
	@$(BIN)/python -m sphinx --fail-on-warning --keep-going --quiet --jobs 2 -c docs . docs/_build/html
	@echo "written: docs/_build/html/index.html"

clean:            ## what make built
	rm -rf .venv results docs/_build docs/reference node_modules
