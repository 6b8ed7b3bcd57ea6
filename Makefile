PROJECT ?= items.yaml
WORKERS ?= 2
SECONDS ?= 60
PY := .venv/bin/python
CODE := pcaccess tests tools $(wildcard bench examples)
BENCHES := $(filter-out bench/_%,$(wildcard bench/*.py))

.DEFAULT_GOAL := help

.NOTPARALLEL:
.PHONY: help run test check unit fuzz mutants bench format clean

help: ## list these targets
	@grep -E '^[a-z]+:.*##' Makefile | sed -E 's/^([a-z]+):.*## /  make \1\t/' | expand -t 16

run: ## serve items.yaml (PROJECT=other.yaml names another)
	@tools/setup.sh run
	@exec $(PY) -m pcaccess run $(PROJECT)

test: check unit ## every check, then every test

check: ## style, types, layers, module length, problem pages
	@tools/setup.sh test
	$(PY) -m ruff check $(CODE)
	$(PY) -m ruff format --check -q $(CODE)
	$(PY) -m mypy
	$(PY) -m mypy tools
	.venv/bin/lint-imports --no-logo
	$(PY) tools/check_modules.py
	$(PY) tools/problem_pages.py

unit: ## the tests alone (WORKERS=0 runs them in one process)
	@tools/setup.sh test
	$(PY) -m pytest -n $(WORKERS)

fuzz: ## mutated programs against the STL reader for a minute (SECONDS=3600 for longer)
	@tools/setup.sh test
	$(PY) tools/fuzz_reader.py --seconds $(SECONDS)

mutants: ## seeded faults in what executes programs: does a test catch each? (ONLY=name for one)
	@tools/setup.sh test
	$(PY) tools/mutants.py $(addprefix --only ,$(ONLY))

bench: ## every benchmark of bench/, with its targets
	@tools/setup.sh test
	@status=0; for bench in $(BENCHES); do \
	    echo "== $$bench"; $(PY) $$bench || status=1; \
	done; exit $$status

format: ## let ruff mend what it can
	@tools/setup.sh test
	$(PY) -m ruff check --fix $(CODE)
	$(PY) -m ruff format $(CODE)

clean: ## forget the environment and everything built
	rm -rf .venv build dist *.egg-info .mypy_cache .ruff_cache .pytest_cache .hypothesis .import_linter_cache
