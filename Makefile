# `make run` and `make test` set up everything they need in .venv.
PYTHON ?= python3
VENV := .venv
BIN := $(VENV)/bin
DB := hcsearch.sqlite
TESTS := not slow and not extra
EXTRAS := .[bench,cluster,export,notebooks,parquet,postgresql,readers,serve]

# what mypy knows of files outlives the checkout, as compiled kernels do: it knows files by what they contain
export MYPY_CACHE_DIR ?= $(or $(XDG_CACHE_HOME),$(HOME)/.cache)/hcsearch/mypy

# commands and tests start many processes: each would compile all modules anew, and uv leaves that to the first
unexport PYTHONDONTWRITEBYTECODE

.PHONY: run test check bench db docs report gallery clean

run: $(VENV)/installed
	$(BIN)/hcsearch enumerate --grid hex --n 12 --db $(DB)
	$(BIN)/hcsearch report 'grid=hex n=12' --db $(DB) --output reports/hex-12.html

test: $(VENV)/tested
	$(BIN)/python -m pytest -m "$(TESTS)" -n auto --maxprocesses 8 --dist worksteal

check: $(VENV)/tested
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/mypy
	$(BIN)/lint-imports

bench: $(VENV)/benched
	$(BIN)/hcsearch bench enumeration

db: $(VENV)/installed
	$(BIN)/python -m hcsearch.store.generated schema > db/schema.sql
	$(BIN)/python -m hcsearch.store.generated datasette > db/datasette.json

docs: $(VENV)/installed
	$(BIN)/python -m hcsearch.api.reference > docs/reference/api.md
	$(BIN)/python -m hcsearch.store.generated columns > docs/reference/columns.md

report: $(VENV)/installed
	$(BIN)/hcsearch report --db $(DB)

# docs/gallery.md, and the pictures of it, of the README and of other pages
gallery: $(VENV)/installed
	$(BIN)/python -m hcsearch_bench.gallery docs

clean:
	rm -rf $(VENV) build *.egg-info

# uv installs in seconds what takes pip a minute; pip does it where uv cannot be had, or where only pip knows the index.
define install
$(BIN)/uv pip install --quiet --python $(BIN)/python --editable '$(1)' || $(BIN)/pip install --quiet --editable '$(1)'
endef

$(VENV)/installed: pyproject.toml
	$(PYTHON) -m venv $(VENV)
	-$(BIN)/pip install --quiet uv
	$(call install,.)
	touch $@

$(VENV)/tested: $(VENV)/installed
	$(call install,.[test])
	touch $@

$(VENV)/everything: $(VENV)/tested
	$(call install,$(EXTRAS))
	touch $@

$(VENV)/benched: $(VENV)/installed
	$(call install,.[bench])
	touch $@
