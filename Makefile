# Verbs: install demo test check bench train clean. `make` alone explains them.
# Each works alone on a machine with Python 3.11 or newer, venv, pip and make.

PYTHON   ?= python3
VENV     ?= .venv
# Passed to pip, e.g. PIP_ARGS="--index-url URL" for a mirror or a CPU-only torch.
PIP_ARGS ?=
# Passed to the verb's own command, e.g. make test ARGS="-k plan".
ARGS     ?=

BIN := $(VENV)/bin
PIP := $(BIN)/python -m pip install -q --disable-pip-version-check $(PIP_ARGS) -c constraints.txt

.DEFAULT_GOAL := help
.PHONY: help install demo test check bench train clean

help:
	@echo "make install   create $(VENV) and install mobius into it"
	@echo "make demo      watch the robot crawl through a house of our own: report, video, log"
	@echo "make test      all tests"
	@echo "make check     format, lint, types, import rules"
	@echo "make bench     timings of the planner, the kinematics and the loop"
	@echo "make train     train a crawl policy from nothing (about 20 minutes on 2 cores)"
	@echo "make clean     remove $(VENV), caches and build output; runs and trained policies stay"

install: $(VENV)/.installed-core

demo: $(VENV)/.installed-core
	$(BIN)/mobius demo $(ARGS)

bench: $(VENV)/.installed-core
	$(BIN)/mobius bench $(ARGS)

train: $(VENV)/.installed-train
	$(BIN)/mobius train crawl --preset fast $(ARGS)

test: $(VENV)/.installed-dev
	$(BIN)/python -m pytest $(ARGS)

check: $(VENV)/.installed-dev
	$(BIN)/ruff format --check .
	$(BIN)/ruff check .
	$(BIN)/mypy
	$(BIN)/lint-imports --no-logo

clean:
	rm -rf $(VENV) build dist .pytest_cache .ruff_cache .mypy_cache .import_linter_cache
	rm -rf src/*.egg-info
	find src tests -name __pycache__ -type d -prune -exec rm -rf {} +

# --- the environment: made once; a stamp per set of packages ----------------------------

$(BIN)/python:
	@command -v $(PYTHON) >/dev/null || { \
	  echo "no '$(PYTHON)' here; mobius needs Python 3.11 or newer. Type:" \
	    "make PYTHON=/path/to/python3" >&2; \
	  exit 1; }
	@$(PYTHON) -c 'import sys; sys.exit(sys.version_info < (3, 11))' || { \
	  echo "mobius needs Python 3.11 or newer, '$(PYTHON)' is $$($(PYTHON) --version 2>&1)." \
	    "Type: make PYTHON=python3.11" >&2; \
	  exit 1; }
	@$(PYTHON) -c 'import ensurepip, venv' 2>/dev/null || { \
	  echo "'$(PYTHON)' lacks the venv module. On Debian or Ubuntu type:" \
	    "apt install python3-venv" >&2; \
	  exit 1; }
	$(PYTHON) -m venv $(VENV)

$(VENV)/.installed-core: pyproject.toml constraints.txt | $(BIN)/python
	@echo "installing mobius into $(VENV) (a minute or two) ..."
	$(PIP) -e .
	@touch $@

$(VENV)/.installed-train: pyproject.toml constraints.txt | $(BIN)/python
	@echo "installing mobius with what training needs into $(VENV) (a few minutes) ..."
	$(PIP) -e '.[train]'
	@touch $(VENV)/.installed-core $@

$(VENV)/.installed-dev: pyproject.toml constraints.txt | $(BIN)/python
	@echo "installing mobius with what training and tests need into $(VENV) (a few minutes) ..."
	$(PIP) -e '.[train,dev]'
	@touch $(VENV)/.installed-core $(VENV)/.installed-train $@
