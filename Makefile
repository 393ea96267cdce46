# `make run` and `make test` set up everything they need in .venv.
PYTHON ?= python3
VENV := .venv
BIN := $(VENV)/bin
DB := hcsearch.sqlite

.PHONY: run test check bench db report clean

run: $(VENV)/installed
	$(BIN)/hcsearch enumerate --grid hex --n 12 --db $(DB)
	$(BIN)/hcsearch report 'grid=hex n=12' --db $(DB) --output reports/hex-12.html

test: $(VENV)/tested
	$(BIN)/python -m pytest -m "not slow" -n 2 --dist worksteal

check: $(VENV)/tested
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/mypy
	$(BIN)/lint-imports

bench: $(VENV)/benched
	$(BIN)/hcsearch bench enumeration

db: $(VENV)/installed
	$(BIN)/python -m hcsearch.store.schema_dump > db/schema.sql

report: $(VENV)/installed
	$(BIN)/hcsearch report --db $(DB)

clean:
	rm -rf $(VENV) build *.egg-info

$(VENV)/installed: pyproject.toml
	$(PYTHON) -m venv $(VENV)
	$(BIN)/pip install --quiet --editable .
	touch $@

$(VENV)/tested: $(VENV)/installed
	$(BIN)/pip install --quiet --editable '.[test]'
	touch $@

$(VENV)/benched: $(VENV)/installed
	$(BIN)/pip install --quiet --editable '.[bench]'
	touch $@
