PYTHON ?= python3
VENV ?= .venv
DEMO_VENV ?= .venv-demo
DOCS_VENV ?= .venv-docs
DIST ?= dist
SITE ?= site
JS := runtime/js
WEB := examples/web
# In processes of their own: not all inference and training libraries get on with each other in one.
TESTS := tests/runtime tests/export tests/models tests/bench
OTHER_TESTS := tests/test_cpp.py tests/test_examples.py tests/test_house.py tests/fuzz

# PyPI's torch for Linux is a CUDA build of several GB. Of the same version, pip prefers the CPU build
# that this page lists; where the page cannot be reached, it warns and takes what it finds elsewhere.
TORCH := torch==2.13.0 --find-links https://download.pytorch.org/whl/cpu/torch/ --retries 1 --timeout 10

# Holds for the build environments that pip makes on its way, too.
export PIP_CONSTRAINT := $(CURDIR)/constraints.txt

.DEFAULT_GOAL := help
.PHONY: help demo test fuzz lint format types docs wheel js web test-web test-arm port-table model-facts clean

help: ## what can be made
	@grep -E '^[a-z-]+:.*##' $(MAKEFILE_LIST) | sed 's/:.*## /\t/' | expand -t 10

demo: $(DEMO_VENV)/installed ## install the runtime alone, make the first picture of README.md
	@$(DEMO_VENV)/bin/fp-infer examples/office.jpg --hfov 57.2 --bev -o out --format overlay,json --overwrite --quiet >/dev/null
	@$(DEMO_VENV)/bin/python examples/read_result.py out/office.jpg.json
	@echo "Open $(CURDIR)/out/office.jpg.overlay.png"

test: $(VENV)/installed ## run all tests
	@echo "Running about 2,500 tests: some ten minutes on two cores."
	@set -e; for part in $(TESTS) "$(OTHER_TESTS)"; do OMP_NUM_THREADS=1 $(VENV)/bin/python -m pytest -n auto $$part; done

MINUTES ?= 10
SEED ?= 0
fuzz: $(VENV)/installed ## spoil files of every kind for MINUTES, from SEED
	$(VENV)/bin/python tests/fuzz/run.py --minutes $(MINUTES) --seed $(SEED)

lint: $(VENV)/installed ## check style and formatting
	$(VENV)/bin/ruff check .
	$(VENV)/bin/ruff format --check .

format: $(VENV)/installed ## format the code
	$(VENV)/bin/ruff check --fix .
	$(VENV)/bin/ruff format .

types: $(VENV)/installed ## check types
	$(VENV)/bin/mypy

docs: $(DOCS_VENV)/installed ## build the documentation into SITE
	NO_MKDOCS_2_WARNING=1 $(DOCS_VENV)/bin/mkdocs build --strict --clean --site-dir $(abspath $(SITE))
	@echo "Open $(abspath $(SITE))/index.html"

wheel: $(VENV)/installed ## build the wheel into DIST
	$(VENV)/bin/python -m build --wheel --outdir $(DIST)

js: $(JS)/node_modules/installed ## build the package for JavaScript, which `npm pack` packs
	npm --prefix $(JS) run build

web: js $(WEB)/node_modules/installed ## build the web page and serve it
	npm --prefix $(WEB) run build
	npm --prefix $(WEB) run preview

# PATIENCE=4 on a machine that is busy with other things: it multiplies the time limits.
test-web: $(VENV)/installed js $(WEB)/node_modules/installed ## test the package for JavaScript, and the web page in Chromium
	$(VENV)/bin/python $(JS)/tests/make_fixtures.py
	npm --prefix $(JS) run types
	npm --prefix $(JS) test
	npm --prefix $(WEB) run build
	PYTHON=$(abspath $(VENV)/bin/python) npm --prefix $(WEB) test

# PHOTOS=folder calibrates a file for arm64, too; ARM_CPU=cortex-a53, say, has no dot product.
test-arm: $(VENV)/installed ## run the model's files on 64-bit Arm, emulated (Debian, Ubuntu)
	PYTHON=$(abspath $(VENV)/bin/python) tests/arm/fetch.sh build/arm
	$(VENV)/bin/python tests/arm/check.py build/arm $(if $(PHOTOS),--photos $(PHOTOS)) $(if $(ARM_CPU),--cpu $(ARM_CPU))

port-table: $(VENV)/installed js $(WEB)/node_modules/installed ## run the test vectors in every port, print how far each is from them
	$(VENV)/bin/python $(JS)/tests/make_fixtures.py
	npm --prefix $(WEB) run build
	ONNXRUNTIME_NODE_INSTALL=skip npm --prefix examples/node ci
	PYTHON=$(abspath $(VENV)/bin/python) tests/arm/fetch.sh build/arm
	$(VENV)/bin/python tests/ports/run.py build/ports build/arm

model-facts: $(VENV)/installed ## bring what pages and ports state of the bundled model up to date
	$(VENV)/bin/python tests/support/model_facts.py

clean: ## remove environments and builds
	rm -rf $(VENV) $(DEMO_VENV) $(DOCS_VENV) build $(DIST) $(SITE) out $(WEB)/node_modules $(WEB)/dist $(JS)/node_modules $(JS)/dist $(JS)/model $(JS)/tests/fixtures

$(DEMO_VENV)/installed: pyproject.toml constraints.txt $(shell find runtime -name "*.py" -o -name "*.onnx")
	@echo "Installing footprints-edge with numpy, onnxruntime, Pillow and typer into $(DEMO_VENV): some 225 MB."
	$(PYTHON) -m venv $(DEMO_VENV)
	$(DEMO_VENV)/bin/pip install -q .
	@touch $@

# torch comes first, so that the extras find it there.
$(VENV)/installed: pyproject.toml constraints.txt
	@echo "Installing torch for CPUs, then all extras and the tools, into $(VENV): some 2.2 GB, a few minutes."
	$(PYTHON) -m venv $(VENV)
	$(VENV)/bin/pip install $(TORCH)
	$(VENV)/bin/pip install -e '.[dev]'
	@touch $@

$(DOCS_VENV)/installed: pyproject.toml constraints.txt
	@echo "Installing the runtime, MkDocs and its theme into $(DOCS_VENV): some 370 MB."
	$(PYTHON) -m venv $(DOCS_VENV)
	$(DOCS_VENV)/bin/pip install -q -e '.[docs]'
	@touch $@

# onnxruntime-node brings its library along, and need not fetch another.
$(JS)/node_modules/installed: $(JS)/package.json $(JS)/package-lock.json
	ONNXRUNTIME_NODE_INSTALL=skip npm --prefix $(JS) ci
	@touch $@

$(WEB)/node_modules/installed: $(WEB)/package.json $(WEB)/package-lock.json
	npm --prefix $(WEB) ci
	@touch $@
