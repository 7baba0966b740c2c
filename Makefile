# SPDX-License-Identifier: MIT
# The commands a person types. Every one enters the environment by env/run, which makes what is missing.
SHELL := /bin/sh
RUN := env/run
DEMO ?= rail_joint
PYTEST ?= python3 -m pytest

.DEFAULT_GOAL := help
.PHONY: help demo test verify matrix bench docs notebooks shell lint format clean lint-here test-here test-units-here test-others-here \
  slow-here docs-here

help: ## this list
	@awk -F ':.*## ' '/^[a-z-]+:.*## / { printf "  make %-9s %s\n", $$1, $$2 }' Makefile

demo: ## the flagship run with its figures (another one: make demo DEMO=name; in space: ARGS=--3d)
	$(RUN) dolfinx-impact demo $(DEMO) $(ARGS)

test: lint ## the gates, then the whole test suite without the slow studies (a part: make test ARGS="-k name")
	$(RUN) make test-here

verify: ## generated kernels against the hand-written solver, then the slow studies; writes results/verify.json
	mkdir -p results
	$(RUN) dolfinx-impact verify --json results/verify.json
	$(RUN) make slow-here

matrix: ## every form of the catalogue: our kernels against FFCx's own C kernels (a long run)
	$(RUN) $(PYTEST) -m matrix $(ARGS)

bench: ## the benchmarks; writes results/bench.json
	mkdir -p results
	$(RUN) dolfinx-impact bench --large --json results/bench.json

docs: ## the documentation site, in build/site; works without a network
	$(RUN) make docs-here

notebooks: ## the demos as Jupyter notebooks, in build/notebooks (another folder: make notebooks FOLDER=name)
	$(RUN) python3 docs/notebooks.py $(or $(FOLDER),build/notebooks)

shell: ## an interactive shell inside the environment
	$(RUN) bash

lint: ## formatters in check mode and flake8
	$(RUN) --no-build make lint-here

sanitize: ## the C++ library and its tests with address and undefined-behaviour sanitizers (a long build)
	$(RUN) --no-build make sanitize-here

tidy: ## clang-tidy on the C++ library and the hand-written solver (a part: make tidy FILES="cpp/dolfinx_impact/gap/*.cpp")
	$(RUN) --no-build make tidy-here

format: ## rewrite the sources as the formatters want them
	$(RUN) --no-build sh -c 'find cpp demos -name "*.h" -o -name "*.cpp" | xargs -r clang-format-19 -i && black -q .'

clean: ## remove what builds and runs wrote in the checkout (the cached environment stays)
	rm -rf build results .pytest_cache .hypothesis
	find . -name __pycache__ -type d -prune -exec rm -rf {} +

# Inside the environment already. The gates are tested on broken files: tests/architecture/test_gates.py.
lint-here:
	@status=0; \
	find cpp demos -name '*.h' -o -name '*.cpp' | xargs -r clang-format-19 --dry-run -Werror || status=1; \
	black --check --quiet . || { black --check .; status=1; }; \
	python3 -m flake8 || status=1; \
	if python3 -c 'import mypy' 2>/dev/null; then python3 -m mypy --no-error-summary || status=1; \
	else echo "lint: mypy is not installed: types are not checked" >&2; fi; \
	[ $$status = 0 ] || echo "lint: stopped; 'make format' mends what formatters can" >&2; \
	exit $$status

# Two halves side by side, on two cores, cut so that both take about as long; then, one after the other, the tests that
# need the machine for themselves. What fails does not keep the others from running. Each part ends with its slowest
# tests.
test-here:
ifeq ($(strip $(ARGS)),)
	@status=0; $(MAKE) -k -j2 test-units-here test-others-here || status=1; \
	$(PYTEST) -m "alone and not slow" -q --durations=30 || status=1; exit $$status
else
	$(PYTEST) -m "not slow" $(ARGS)
endif

FIRST_HALF := tests/unit tests/demos tests/cpp tests/docs
test-units-here:
	$(PYTEST) -m "not alone and not slow" -q --durations=30 $(FIRST_HALF)

test-others-here:
	$(PYTEST) -m "not alone and not slow" -q --durations=30 $(FIRST_HALF:%=--ignore=%)

slow-here: # status 5: no slow test was found
	$(PYTEST) -m "slow and not matrix" $(ARGS) || [ $$? -eq 5 ]

# Warnings are errors. build/docs keeps what a second build need not do again.
docs-here:
	mkdir -p build/docs
	python3 -m sphinx -q -W --keep-going -b html -d build/docs/doctrees docs build/docs/html
	@ln -sfn docs/html build/site
	@echo "docs: build/site/index.html"

# A build folder of its own. What Open MPI and the other libraries keep until the process ends is not ours to free.
SANITIZE := build/sanitize
sanitize-here:
	cmake -S cpp -B $(SANITIZE) -G Ninja -DCMAKE_BUILD_TYPE=Release -DIMPACT_PYTHON=OFF -DIMPACT_SANITIZE=address,undefined \
	  -DCMAKE_INSTALL_PREFIX=$(CURDIR)/$(SANITIZE)/install
	cmake --build $(SANITIZE) --target dolfinx_impact -- -j2
	cmake --install $(SANITIZE) >/dev/null
	cmake -S tests/cpp -B $(SANITIZE)/tests -G Ninja -DCMAKE_BUILD_TYPE=Debug \
	  -DCMAKE_PREFIX_PATH=$(CURDIR)/$(SANITIZE)/install/dolfinx_impact \
	  -DCMAKE_CXX_FLAGS="-fsanitize=address,undefined -fno-omit-frame-pointer"
	cmake --build $(SANITIZE)/tests -- -j2
	@for program in unit_tests tangent_check; do \
	  ASAN_OPTIONS=detect_leaks=0 UBSAN_OPTIONS=halt_on_error=1:print_stacktrace=1 $(SANITIZE)/tests/$$program || exit 1; done
	@echo "sanitize: nothing found"

FILES ?= $(shell find cpp/dolfinx_impact cpp/reference -name '*.cpp' | sort)
tidy-here:
	@command -v clang-tidy-19 >/dev/null || { echo "tidy: clang-tidy-19 is not installed" >&2; exit 1; }
	cmake -S cpp -B build/tidy -G Ninja -DCMAKE_BUILD_TYPE=Release -DIMPACT_PYTHON=ON \
	  -DCMAKE_DISABLE_PRECOMPILE_HEADERS=ON >/dev/null # each file includes what it uses
	printf '%s\n' $(FILES) | xargs -P2 -n1 clang-tidy-19 -p build/tidy --quiet
	@echo "tidy: nothing found"
