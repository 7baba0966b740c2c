# SPDX-License-Identifier: MIT
# The commands a person types. Every one enters the environment by env/run, which makes what is missing.
SHELL := /bin/sh
RUN := env/run
DEMO ?= rail_joint
PYTEST ?= python3 -m pytest

# RELEASE=0.11: another DOLFINx than Debian's 0.9, from where env/build_dolfinx.sh has installed it. Inside the
# environment, where IMPACT_ROUTE is set, it was chosen already.
ifneq ($(filter-out 0.9,$(RELEASE)),)
ifndef IMPACT_ROUTE
cache := $(or $(IMPACT_CACHE),$(or $(XDG_CACHE_HOME),$(HOME)/.cache)/dolfinx_impact)
export IMPACT_DOLFINX := $(if $(filter /%,$(cache)),,$(CURDIR)/)$(cache)/dolfinx-$(RELEASE)
ifneq ($(shell test -d "$(IMPACT_DOLFINX)" || echo missing),)
$(error DOLFINx $(RELEASE) is not there: build it by 'env/run --no-build env/build_dolfinx.sh $(RELEASE) \
  "$(IMPACT_DOLFINX)" SOURCES', where SOURCES has basix, ffcx, ufl and dolfinx)
endif
endif
endif

.DEFAULT_GOAL := help
# What is measured: the commit, and whether sources differ from it.
COMMIT = $(shell git rev-parse --short=8 HEAD)$(shell git diff --quiet HEAD -- . ':!docs' || echo ' (changed)')
.PHONY: help demo test verify matrix bench coverage docs notebooks sdist public-names shell lint format stub \
  clean lint-here formats-here types-here tree-here test-here tests-1 tests-2 tests-chosen slow-here docs-here

help: ## this list
	@awk -F ':.*## ' '/^[a-z-]+:.*## / { printf "  make %-12s %s\n", $$1, $$2 }' Makefile

demo: ARGS ?= $(if $(filter rail_joint,$(DEMO)),--ranks 2)
demo: ## the flagship run on two ranks, with its figures and a report (another one: make demo DEMO=name)
	$(RUN) dolfinx-impact demo $(DEMO) $(ARGS)

test: ## the gates, then the whole test suite without the slow studies (a part: make test ARGS="-k name")
	$(RUN) --no-build make formats-here
	$(RUN) make test-here

verify: ## generated kernels against the hand-written solver, then the slow studies; writes results/verify.json
	mkdir -p results
	$(RUN) dolfinx-impact verify --json results/verify.json
	$(RUN) make slow-here

matrix: ## every form of the catalogue: our kernels against FFCx's own C kernels (a long run)
	$(RUN) $(PYTEST) -m matrix $(ARGS)

bench: ## the benchmarks (ARGS=--large: larger models, too): results/bench.json, ratios appended to docs/bench_history.csv
	mkdir -p results
	$(RUN) dolfinx-impact bench $(ARGS) --json results/bench.json --history docs/bench_history.csv --commit "$(COMMIT)"

docs: ## the documentation site, in build/site; works without a network
	$(RUN) make docs-here

notebooks: ## the demos as Jupyter notebooks, run, in build/notebooks (ARGS="hertz", ARGS=--no-run, FOLDER=name)
	$(RUN) python3 docs/notebooks.py $(or $(FOLDER),build/notebooks) $(ARGS)

sdist: ## the source distribution, in build/sdist, built and run outside the checkout
	$(RUN) --no-build env/try_sdist.sh

public-names: ## the list of public names and signatures anew, after a change on purpose (docs/compatibility.md)
	$(RUN) python3 tests/architecture/public_names.py

shell: ## an interactive shell inside the environment
	$(RUN) bash

lint: ## formatters in check mode, flake8, mypy, the rules of the tree
	$(RUN) --no-build make -k lint-here tree-here

sanitize: ## the C++ library and its tests with address and undefined-behaviour sanitizers (a long build)
	$(RUN) --no-build make sanitize-here

coverage: ## which lines of Python and C++ the tests run, and which none does; writes results/coverage (a long run)
	IMPACT_BUILD=$(COVERAGE) SKBUILD_CMAKE_ARGS=-DIMPACT_COVERAGE=ON $(RUN) make coverage-here

tidy: ## clang-tidy on the C++ library and the hand-written solver (a part: make tidy FILES="cpp/dolfinx_impact/gap/*.cpp")
	$(RUN) --no-build make tidy-here

format: ## rewrite the sources as the formatters want them
	$(RUN) --no-build sh -c 'find cpp demos -name "*.h" -o -name "*.cpp" | xargs -r clang-format-19 -i && black -q .'

stub: ## the typed stub of the compiled module, python/dolfinx_impact/_cpp, from its bindings
	$(RUN) python3 cpp/bindings/stub.py python/dolfinx_impact/_cpp

clean: ## remove what builds and runs wrote in the checkout (the cached environment stays)
	rm -rf build results .pytest_cache .hypothesis
	find . -name __pycache__ -type d -prune -exec rm -rf {} +

# Inside the environment already. The gates are tested on broken files: tests/architecture/test_gates.py. `tree-here` are
# the rules of the tree, which `make test` has among its tests.
lint-here:
	@$(MAKE) --no-print-directory -k -j2 formats-here types-here

formats-here:
	@status=0; \
	find cpp demos -name '*.h' -o -name '*.cpp' | xargs -r clang-format-19 --dry-run -Werror || status=1; \
	black --check --quiet . || { black --check .; status=1; }; \
	python3 -m flake8 || status=1; \
	[ $$status = 0 ] || echo "lint: stopped; 'make format' mends what formatters can" >&2; \
	exit $$status

tree-here:
	@$(PYTEST) -q tests/architecture/test_tree.py

# The first check of a checkout takes a minute; it begins with what one of another checkout left in the environment's
# cache. There mypy must compare the contents of each file: time and size alone may agree by chance. Other releases of
# DOLFINx and UFL declare other types than 0.9.
types-here:
	@if [ -n "$$IMPACT_DOLFINX" ]; then echo "lint: types are checked with DOLFINx 0.9 alone" >&2; exit; fi; \
	if ! python3 -c 'import mypy' 2>/dev/null; then echo "lint: mypy is not installed: types are not checked" >&2; exit; fi; \
	kept=$${IMPACT_CACHE:+$$IMPACT_CACHE/types} first=; \
	if [ -n "$$kept" ] && [ ! -d build/mypy ]; then \
	  first=yes; mkdir -p build; \
	  if [ -d "$$kept" ] && cp -a "$$kept" build/mypy.new; then \
	    find build/mypy.new -name '*.meta.json' -exec sed -i 's/"mtime":[0-9]*/"mtime":0/' {} + && mv build/mypy.new build/mypy; \
	  fi; \
	fi; \
	python3 -m mypy --no-error-summary || { echo "lint: types do not agree" >&2; exit 1; }; \
	if [ -n "$$first" ] && cp -a build/mypy "$$kept.$$$$"; then rm -rf "$$kept"; mv -T "$$kept.$$$$" "$$kept" || true; fi

# Types, which take a minute the first time, and two processes that share the tests between them: tests/sharing.py. What
# fails does not keep the others from running; the last line says what it was. Each process ends with its slowest tests.
test-here:
ifeq ($(strip $(ARGS)),)
	@SHARE=$$(mktemp -d) && export SHARE && trap 'rm -rf "$$SHARE"' EXIT && trap 'exit 130' INT TERM; \
	$(MAKE) --no-print-directory -k -j3 part-types-here part-tests-1 part-tests-2 && exit; \
	echo "test: failed: $$(sort "$$SHARE/failed" | paste -sd' ')" >&2; exit 1
else
	@$(MAKE) --no-print-directory -k types-here tests-chosen
endif

part-%:
	@$(MAKE) --no-print-directory $* || { echo $* >>"$$SHARE/failed"; exit 1; }

tests-1 tests-2:
	@$(PYTEST) -m "not slow" -q --durations=30 --share="$$SHARE"

tests-chosen:
	$(PYTEST) -m "not slow" $(ARGS)

slow-here: # status 5: no slow test was found
	$(PYTEST) -m "slow and not matrix" $(ARGS) || [ $$? -eq 5 ]

# Warnings are errors. build/docs keeps what a second build need not do again.
docs-here:
	mkdir -p build/docs
	python3 -m sphinx -q -W --keep-going -b html -d build/docs/doctrees docs build/docs/html
	@ln -sfn docs/html build/site
	@echo "docs: build/site/index.html"

# A build folder of its own. What Open MPI and the other libraries keep until the process ends is not ours to free.
SANITIZE := build/sanitize$(RELEASE:%=-%)
sanitize-here:
	cmake -S cpp -B $(SANITIZE) -G Ninja -DCMAKE_BUILD_TYPE=Release -DIMPACT_PYTHON=OFF -DIMPACT_SANITIZE=address,undefined \
	  -DCMAKE_INSTALL_PREFIX=$(CURDIR)/$(SANITIZE)/install
	cmake --build $(SANITIZE) --target dolfinx_impact -- -j2
	cmake --install $(SANITIZE) >/dev/null
	cmake -S tests/cpp -B $(SANITIZE)/tests -G Ninja -DCMAKE_BUILD_TYPE=Debug \
	  -DCMAKE_PREFIX_PATH=$(CURDIR)/$(SANITIZE)/install/dolfinx_impact \
	  -DCMAKE_CXX_FLAGS="-fsanitize=address,undefined -fno-omit-frame-pointer"
	cmake --build $(SANITIZE)/tests -- -j2
	@for program in unit_tests tangent_check $$(grep -qw avx2 /proc/cpuinfo && echo functions_avx2) \
	    $$(grep -qw avx512dq /proc/cpuinfo && echo functions_avx512); do \
	  ASAN_OPTIONS=detect_leaks=0 UBSAN_OPTIONS=halt_on_error=1:print_stacktrace=1 $(SANITIZE)/tests/$$program || exit 1; done
	@echo "sanitize: nothing found"

# An install of its own, whose Python counts lines in every process that the tests start, and whose C++ library does. What
# fails does not keep the others from being counted.
COVERAGE := build/coverage$(RELEASE:%=-%)
COVERED := COVERAGE_PROCESS_START=$(CURDIR)/pyproject.toml COVERAGE_FILE=$(CURDIR)/$(COVERAGE)/data/python
coverage-here:
	rm -rf $(COVERAGE)/data results/coverage && mkdir -p $(COVERAGE)/data results/coverage
	find $(COVERAGE)/release -name '*.gcda' -delete
	python3 tests/count_processes.py
	@status=0; $(COVERED) COVERAGE_CORE=sysmon $(MAKE) --no-print-directory test-here || status=1; \
	$(COVERED) python3 -m coverage combine --quiet --rcfile=pyproject.toml && \
	$(COVERED) python3 -m coverage json --quiet -o results/coverage/python.json && \
	$(COVERED) python3 -m coverage html --quiet -d results/coverage/python && \
	gcovr --root . --filter cpp/ --gcov-ignore-parse-errors=all --merge-mode-functions=separate -j2 \
	  --json results/coverage/cpp.json $(COVERAGE)/release && \
	gcovr --root . --add-tracefile results/coverage/cpp.json --html-nested results/coverage/cpp.html && \
	python3 tests/never_run.py results/coverage/python.json results/coverage/cpp.json results/coverage && exit $$status

TIDY := build/tidy$(RELEASE:%=-%)
FILES ?= $(shell find cpp/dolfinx_impact cpp/reference -name '*.cpp' | sort)
tidy-here:
	@command -v clang-tidy-19 >/dev/null || { echo "tidy: clang-tidy-19 is not installed" >&2; exit 1; }
	cmake -S cpp -B $(TIDY) -G Ninja -DCMAKE_BUILD_TYPE=Release -DIMPACT_PYTHON=ON \
	  -DCMAKE_DISABLE_PRECOMPILE_HEADERS=ON >/dev/null # each file includes what it uses
	headers="$$(python3 -c 'import sysconfig; print(sysconfig.get_path("include"))') $$(python3 -m nanobind --include_dir)"; \
	for folder in $$headers; do extra="$$extra --extra-arg=-isystem$$folder"; done; \
	printf '%s\n' $(FILES) | xargs -P2 -n1 clang-tidy-19 -p $(TIDY) --quiet $$extra
	@echo "tidy: nothing found"
