# `make run` and `make test` set up everything they need in .venv.
PYTHON ?= python3
VENV := .venv
BIN := $(VENV)/bin
DB := hcsearch.sqlite
TESTS := not slow and not extra
EXTRAS := '.[bench,cluster,export,parquet,postgresql,serve]'

# what mypy knows of files outlives the checkout, as compiled kernels do: it knows files by what they contain
export MYPY_CACHE_DIR ?= $(or $(XDG_CACHE_HOME),$(HOME)/.cache)/hcsearch/mypy

# commands and tests start many processes: each would compile all modules anew, and uv leaves that to the first
unexport PYTHONDONTWRITEBYTECODE

.PHONY: run test check coverage bench db docs report gallery clean

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
	$(BIN)/python -m tests.package_size

# fails below the floor in pyproject.toml
coverage: $(VENV)/covered
	$(BIN)/python -m pytest -m "$(TESTS)" -n auto --maxprocesses 8 --dist loadfile --cov --cov-report=term

bench: $(VENV)/benched
	$(BIN)/hcsearch bench enumeration

db: $(VENV)/installed
	$(BIN)/python -m hcsearch.store.generated schema > db/schema.sql
	$(BIN)/python -m hcsearch.store.generated datasette > db/datasette.json

# Sphinx shows the warnings of a page when it reads it: after a failure it reads all pages again.
docs: $(VENV)/documented
	mkdir -p docs/_build
	for page in columns scene_values; do \
		$(BIN)/python -m hcsearch.store.generated $$page > docs/_build/$$page || exit 1; \
		cmp --quiet docs/_build/$$page docs/reference/$$page.md || mv docs/_build/$$page docs/reference/$$page.md; \
	done
	$(BIN)/python -m sphinx --fail-on-warning --keep-going --quiet -b html -c docs -d docs/_build/doctrees \
		. docs/_build/html || { rm -rf docs/_build/doctrees; exit 1; }
	@echo docs/_build/html/index.html

report: $(VENV)/installed
	$(BIN)/hcsearch report --db $(DB)

# docs/gallery.md, and the pictures of it, of the README and of other pages; screenshots only where Chromium is installed
gallery: $(VENV)/installed
	$(BIN)/python -m hcsearch_bench.gallery docs

clean:
	rm -rf $(VENV) build docs/_build docs/reference/generated *.egg-info

# uv installs in seconds what takes pip a minute; pip does it where uv cannot be had, or where only pip knows the index.
# The pip of a new environment may be older than 25.1, the first that knows dependency groups.
define install
$(BIN)/uv pip install --quiet --python $(BIN)/python $(1) || \
	{ $(BIN)/pip install --quiet --upgrade 'pip>=25.1' && $(BIN)/pip install --quiet $(1); }
endef

$(VENV)/installed: pyproject.toml
	$(PYTHON) -m venv $(VENV)
	-$(BIN)/pip install --quiet uv
	$(call install,--editable .)
	touch $@

$(VENV)/tested: $(VENV)/installed
	$(call install,--group test --group check)
	touch $@

$(VENV)/covered: $(VENV)/tested
	$(call install,--group coverage)
	touch $@

$(VENV)/everything: $(VENV)/tested
	$(call install,--editable $(EXTRAS) --group readers --group docs)
	touch $@

$(VENV)/documented: $(VENV)/installed
	$(call install,--group docs)
	touch $@

$(VENV)/benched: $(VENV)/installed
	$(call install,--editable '.[bench]')
	touch $@
