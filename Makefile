# endocal's front door: `make help` lists what there is. Each target sets up what it needs by itself.

PYTHON ?= python3
VENV ?= .venv
BIN := $(VENV)/bin
INSTALLED := $(VENV)/.installed

.DEFAULT_GOAL := help
.PHONY: help install demo test lint format bench bench-calibration bench-methods bench-zoom tables sample-data docs package clean

help: ## Show this list
	@awk -F ':.*## ' '/^[a-z-]+:.*## / { printf "  make %-18s %s\n", $$1, $$2 }' $(MAKEFILE_LIST)

install: $(INSTALLED) ## Make .venv with endocal (editable) and all that developing it needs

$(INSTALLED): pyproject.toml
	@$(PYTHON) -c 'import sys; sys.exit(sys.version_info < (3, 11))' || \
	    { echo "endocal needs Python 3.11 or newer: make PYTHON=python3.11 $(MAKECMDGOALS)" >&2; exit 1; }
	$(PYTHON) -m venv $(VENV)
	$(BIN)/python -m pip install --quiet --disable-pip-version-check --editable '.[dev,report,cluster]'
	@touch $@

demo: $(INSTALLED) ## Calibrate, tabulate and correct the samples; leaves clip, pictures and pages in demo/
	$(BIN)/python sample_data/demo.py demo

test: $(INSTALLED) ## Run the tests
	$(BIN)/python -m pytest --numprocesses auto --maxprocesses 4 --dist loadfile

lint: $(INSTALLED) ## Check style and types
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/mypy

format: $(INSTALLED) ## Bring the code into shape
	$(BIN)/ruff check --fix .
	$(BIN)/ruff format .

bench: $(INSTALLED) ## Time endocal beside its peers, in the same run
	$(BIN)/endocal bench remap
	$(BIN)/endocal bench calibrate
	$(BIN)/endocal bench boundary

bench-calibration: $(INSTALLED) ## Print how accurate calibration is, on random boards and real pictures
	@mkdir -p build
	$(BIN)/python bench/calibration.py --json build/calibration.json

bench-methods: $(INSTALLED) ## Print how near bare HEwG and HEPLP come on random boards
	$(BIN)/python bench/methods.py

tables: $(INSTALLED) ## Write docs/results.md, the article's tables and figures made anew (some minutes)
	$(BIN)/python -m bench.tables

bench-zoom: $(INSTALLED) ## Print how well the zoom is found, tabulated and followed
	@mkdir -p build
	$(BIN)/python bench/zoom.py --json build/zoom.json

sample-data: $(INSTALLED) ## Make sample_data/ anew (the same bytes each time)
	$(BIN)/python sample_data/make.py

docs: $(INSTALLED) ## Write docs/cli.md anew from the commands' help
	$(BIN)/python docs/generate_cli.py

package: $(INSTALLED) ## Build wheel and sdist in dist/, install the wheel alone and try it
	rm -rf dist build
	$(BIN)/python -m build --outdir dist .
	$(BIN)/python bench/try_wheel.py dist/*.whl

clean: ## Remove everything that make has made, .venv included
	rm -rf $(VENV) build dist demo *.egg-info .pytest_cache .mypy_cache .ruff_cache .hypothesis
	find . -name __pycache__ -type d -prune -exec rm -rf {} +
