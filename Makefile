# Two commands matter: `make demo` walks, `make test` tests. Both set up what they need.

PYTHON ?= python3
BIN := .venv/bin
UV := $(shell command -v uv 2>/dev/null)

ifeq ($(UV),)
  NEW_VENV = $(PYTHON) -m venv .venv
  INSTALL = $(BIN)/python -m pip install --quiet --disable-pip-version-check
else
  NEW_VENV = uv venv --quiet --allow-existing --python $(PYTHON) .venv
  INSTALL = uv pip install --quiet --python $(BIN)/python
endif

# The live page is tested in a browser.
define BROWSER
command -v chromium >/dev/null || command -v chromium-browser >/dev/null || \
  if [ "$$(id -u)" = 0 ] && command -v apt-get >/dev/null; \
  then apt-get update && apt-get install --yes --no-install-recommends chromium; \
  else echo "the live page is tested in a browser; run: sudo apt-get install chromium"; fi
endef

.PHONY: demo test check bench docs clean

demo: .venv/demo.done  ## walk, get pushed, recover, and leave a picture in walk.png
	$(BIN)/surefoot walk --velocity 0.5 0 --push 176,0@1.1+0.2 --plot walk.png

test: .venv/test.done  ## every test, the examples, and the commands of the README
	$(BIN)/python -m pytest -n auto --dist loadfile

check: .venv/check.done  ## style and types
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/pyright --pythonpath $(BIN)/python

bench: .venv/bench.done  ## speed, as figures and ratios of one run
	$(BIN)/python benchmarks/speed.py

docs: .venv/test.done  ## the documentation, in docs/_build/html
	$(BIN)/python -m sphinx -W --keep-going -b html docs docs/_build/html

clean:
	rm -rf .venv build dist docs/_build .pytest_cache .ruff_cache .hypothesis

.venv/bin/python:
	$(NEW_VENV)

.venv/demo.done: pyproject.toml | .venv/bin/python
	$(INSTALL) -e ".[plot]"
	touch $@

.venv/test.done: pyproject.toml | .venv/bin/python
	$(INSTALL) -e ".[test]"
	@$(BROWSER)
	touch $@

.venv/check.done: pyproject.toml | .venv/bin/python
	$(INSTALL) -e ".[test,bench,check]"
	touch $@

.venv/bench.done: pyproject.toml | .venv/bin/python
	$(INSTALL) -e ".[bench]"
	touch $@
