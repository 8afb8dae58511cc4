PYTHON ?= python3
VENV ?= .venv
DEMO_VENV ?= .venv-demo
DIST ?= dist

# Holds for the build environments that pip makes on its way, too.
export PIP_CONSTRAINT := $(CURDIR)/constraints.txt

.DEFAULT_GOAL := help
.PHONY: help demo test lint format types wheel clean

help: ## what can be made
	@grep -E '^[a-z]+:.*##' $(MAKEFILE_LIST) | sed 's/:.*## /\t/' | expand -t 10

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

clean: ## remove environments and builds
	rm -rf $(VENV) $(DEMO_VENV) build $(DIST) out

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
