# Everything starts from Python 3.11 or newer; `make PYTHON=/path/to/python3.12 …` picks another one.
PYTHON ?= $(shell for p in python3 python3.14 python3.13 python3.12 python3.11; do \
	$$p -c 'import sys; sys.exit(sys.version_info < (3, 11))' 2>/dev/null && { echo $$p; break; }; done)
VENV := .venv
BIN := $(VENV)/bin
PACKAGES := thermoroll_cli tests scripts

.DEFAULT_GOAL := help
.PHONY: help install run test test-all format check docs figures stress bench table

help:
	@echo "make run      install, solve the article's case and draw its pictures"
	@echo "make test     install, and run the tests that guard a change, on all cores"
	@echo "make test-all the same with the slow tests (minutes)"
	@echo "make install  install into $(VENV)"
	@echo "make format   format the code"
	@echo "make check    ruff, mypy, and a run in which every warning is an error"
	@echo "make docs     build the site of the documents in build/site, with a gallery of cases/"
	@echo "make stress   solve thousands of random cases, and check what must hold of each (minutes)"
	@echo "make figures  draw the figures of docs/ again and fill in its measured tables (minutes)"
	@echo "make table    build the default table of creep forces again; may be stopped and started again (half an hour of CPU time)"
	@echo "make bench    measure cost and errors, fill in the tables of docs/ (minutes); CONTACT=PATH measures CONTACT in turn, too"

install: $(VENV)/.installed

run: install
	$(BIN)/thermoroll run cases/article_4_1.toml -o results
	@echo
	@echo "Pictures: $(CURDIR)/results/article_4_1_*.png, numbers: results/article_4_1.h5"

PYTEST := OPENBLAS_NUM_THREADS=1 $(BIN)/python -m pytest --numprocesses auto --maxprocesses 8 --dist loadfile --no-loadscope-reorder

test: $(VENV)/.installed-test
	$(PYTEST)

test-all: $(VENV)/.installed-test
	$(PYTEST) -m "slow or not slow"

format: $(VENV)/.installed-test
	$(BIN)/ruff format $(PACKAGES)
	$(BIN)/ruff check --fix $(PACKAGES)

check: $(VENV)/.installed-test
	$(BIN)/ruff check $(PACKAGES)
	$(BIN)/mypy thermoroll_cli
	$(BIN)/python -W error -m thermoroll_cli run cases/article_4_1.toml -o build/check -q

docs: $(VENV)/.installed-docs
	OPENBLAS_NUM_THREADS=1 NO_MKDOCS_2_WARNING=1 $(BIN)/python -m mkdocs build
	@echo "The site: $(CURDIR)/build/site/index.html"

stress: $(VENV)/.installed-test
	OPENBLAS_NUM_THREADS=1 $(BIN)/python -m scripts.stress --write

figures: install
	OPENBLAS_NUM_THREADS=1 $(BIN)/python -m scripts.figures.figures

table: install
	OPENBLAS_NUM_THREADS=1 $(BIN)/thermoroll table build -o thermoroll_cli/studies/creep_table/default_table.h5 --resume --jobs $$($(BIN)/python -c 'import os; print(os.cpu_count())')

# Peers for the frictionless part, in an environment of their own. Without them, and without CONTACT, recorded rows stay.
PEERS := build/peers

bench: install
	@test -x $(PEERS)/bin/tamaas || { $(PYTHON) -m venv $(PEERS) && \
		$(PEERS)/bin/python -m pip install --quiet --disable-pip-version-check tamaas ContactMechanics; } || \
		echo "tamaas and ContactMechanics cannot be installed here: measured without them" >&2
	OPENBLAS_NUM_THREADS=1 $(BIN)/python -m scripts.benchmark.bench $(if $(CONTACT),--contact '$(CONTACT)') \
		$$(test -x $(PEERS)/bin/tamaas && echo --peers $(PEERS)/bin/python)
	$(if $(CONTACT),OPENBLAS_NUM_THREADS=1 $(BIN)/python -m scripts.peers "$$(dirname "$$(dirname '$(CONTACT)')")" \
		--contact '$(CONTACT)' --write)

$(VENV)/bin/python:
	@test -n "$(PYTHON)" || { echo "thermoroll needs Python 3.11 or newer, and found none." \
		"Install one, or name it: make PYTHON=/path/to/python3.11 $(MAKECMDGOALS)" >&2; exit 1; }
	@$(PYTHON) -m venv $(VENV) || { echo "$(PYTHON) cannot make a virtual environment." \
		"On Debian and Ubuntu: apt install python3-venv" >&2; rm -rf $(VENV); exit 1; }

# The stamps make an installation happen once, and again when pyproject.toml changes.
$(VENV)/.installed: pyproject.toml | $(VENV)/bin/python
	$(BIN)/python -m pip install --quiet --disable-pip-version-check --editable .
	@touch $@

$(VENV)/.installed-test: pyproject.toml | $(VENV)/bin/python
	$(BIN)/python -m pip install --quiet --disable-pip-version-check --editable '.[test]'
	@touch $@ $(VENV)/.installed

$(VENV)/.installed-docs: pyproject.toml | $(VENV)/bin/python
	$(BIN)/python -m pip install --quiet --disable-pip-version-check --editable '.[docs]'
	@touch $@ $(VENV)/.installed
