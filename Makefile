PYTHON ?= python3
VENV ?= .venv
DEMO_VENV ?= .venv-demo
DIST ?= dist
WEB := examples/web

# Holds for the build environments that pip makes on its way, too.
export PIP_CONSTRAINT := $(CURDIR)/constraints.txt

.DEFAULT_GOAL := help
.PHONY: help demo test lint format types wheel web test-web clean

help: ## what can be made
	@grep -E '^[a-z-]+:.*##' $(MAKEFILE_LIST) | sed 's/:.*## /\t/' | expand -t 10

demo: $(DEMO_VENV)/installed ## install the runtime alone, find the ground in the example picture
	$(DEMO_VENV)/bin/fp-infer examples/room.jpg -o out --overwrite
	@echo "Open $(CURDIR)/out/room.jpg.overlay.png"

test: $(VENV)/installed ## run all tests
	$(VENV)/bin/python -m pytest

lint: $(VENV)/installed ## check style and formatting
	$(VENV)/bin/ruff check .
	$(VENV)/bin/ruff format --check .

format: $(VENV)/installed ## format the code
	$(VENV)/bin/ruff check --fix .
	$(VENV)/bin/ruff format .

types: $(VENV)/installed ## check types
	$(VENV)/bin/mypy

wheel: $(VENV)/installed ## build the wheel into DIST
	$(VENV)/bin/python -m build --wheel --outdir $(DIST)

web: $(WEB)/node_modules/installed ## build the web page and serve it
	npm --prefix $(WEB) run build
	npm --prefix $(WEB) run preview

# PATIENCE=4 on a machine that is busy with other things: it multiplies the time limits.
test-web: $(VENV)/installed $(WEB)/node_modules/installed ## test the web page in Chromium
	$(VENV)/bin/python $(WEB)/tests/make_fixtures.py
	$(VENV)/bin/fp-export vectors edge -o $(WEB)/tests/fixtures/vectors >/dev/null
	npm --prefix $(WEB) run build
	npm --prefix $(WEB) test
	PYTHON=$(abspath $(VENV)/bin/python) npm --prefix $(WEB) run test:browser

clean: ## remove environments and builds
	rm -rf $(VENV) $(DEMO_VENV) build $(DIST) out $(WEB)/node_modules $(WEB)/dist $(WEB)/tests/fixtures

$(DEMO_VENV)/installed: pyproject.toml constraints.txt $(shell find runtime -name "*.py" -o -name "*.onnx")
	$(PYTHON) -m venv $(DEMO_VENV)
	$(DEMO_VENV)/bin/pip install -q .
	@touch $@

# torch comes first and by its pin: a plain range would pull gigabytes of CUDA packages.
$(VENV)/installed: pyproject.toml constraints.txt
	$(PYTHON) -m venv $(VENV)
	$(VENV)/bin/pip install -q torch==2.13.0
	$(VENV)/bin/pip install -q -e '.[dev]'
	@touch $@

$(WEB)/node_modules/installed: $(WEB)/package.json $(WEB)/package-lock.json
	npm --prefix $(WEB) ci
	@touch $@
