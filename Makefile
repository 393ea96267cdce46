# `make run` and `make test` set up everything they need in .venv.
PYTHON ?= python3
VENV := .venv
BIN := $(VENV)/bin
DB := hcsearch.sqlite
TESTS := not slow and not extra
EXTRAS := .[bench,cluster,docs,export,parquet,postgresql,readers,serve]

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

# Sphinx shows the warnings of a page when it reads it: after a failure it reads all pages again.
docs: $(VENV)/documented
	mkdir -p docs/_build
	$(BIN)/python -m hcsearch.store.generated columns > docs/_build/columns
	cmp --quiet docs/_build/columns docs/reference/columns.md || mv docs/_build/columns docs/reference/columns.md
	$(BIN)/python -m sphinx --fail-on-warning --keep-going --quiet -b html -c docs -d docs/_build/doctrees \
		. docs/_build/html || { rm -rf docs/_build/doctrees; exit 1; }
	@echo docs/_build/html/index.html

report: $(VENV)/installed
	$(BIN)/hcsearch report --db $(DB)

# the pictures of the README and of docs/reference/grids.md
MOVING = triangle:0123434501:1 rectangle:01222300:1 rhombus:231213121210:3 kite:23203030:3 right45:12121212:0 \
	right30:20201210:3 obtuse:121212121212:0
gallery: $(VENV)/installed
	$(BIN)/hcsearch export hex:012223444500:4 --scene hinged --motion springs --format animation --output reports/gallery/deployment.svg
	for folding in $(MOVING); do $(BIN)/hcsearch export $$folding --motion springs --format animation \
		--output reports/gallery/moving-$${folding%%:*}.svg || exit 1; done
	$(BIN)/python -m hcsearch_bench.gallery reports/gallery

clean:
	rm -rf $(VENV) build docs/_build docs/reference/generated *.egg-info

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

$(VENV)/documented: $(VENV)/installed
	$(call install,.[docs])
	touch $@

$(VENV)/benched: $(VENV)/installed
	$(call install,.[bench])
	touch $@
