# make setup     everything that `rover` needs, in .venv (nothing outside this folder)
# make demo      a whole mission on the simulated rig; DATA=<dir> lays its ground with real pictures
# make test      every test there is; make lint, make firmware, make bench beside it
# make train     the detector's networks anew, from a seed; without DATA=<dir> only the one for ground
# make evaluate  docs/results/detection.md anew: every table about the detector (DATA=<dir> for those of real pictures)
SHELL := /bin/bash
.DELETE_ON_ERROR:

PYTHON ?= python3
VENV := .venv
BIN := $(VENV)/bin
SEED ?= 1
OUT ?= runs/demo
DATA ?=
CARGO ?= cargo

PYPROJECTS := protocol/python/pyproject.toml companion/pyproject.toml hil_tests/pyproject.toml
RUST_SOURCES := $(shell find protocol/rust firmware/core firmware/sitl companion/native hil_tests/plant \
	-name '*.rs' -o -name Cargo.toml) Cargo.toml $(wildcard Cargo.lock)

.PHONY: setup setup-dev demo test test-rust test-python lint firmware bench mutate train evaluate clean

setup: $(BIN)/rover target/.native

$(BIN)/python:
	$(PYTHON) -c 'import sys; sys.exit(sys.version_info < (3, 10) and "Python 3.10 or newer is needed")'
	$(PYTHON) -m venv $(VENV)

$(BIN)/rover: $(BIN)/python $(PYPROJECTS)
	$(BIN)/python -m pip install --quiet --disable-pip-version-check "maturin>=1.7,<2"
	$(BIN)/python -m pip install --quiet --disable-pip-version-check -e protocol/python -e companion -e hil_tests
	touch $@

target/.native: $(BIN)/rover $(RUST_SOURCES)
	@command -v $(CARGO) >/dev/null || { echo "Rust is needed (cargo was not found): see README.md"; exit 1; }
	$(CARGO) build --release --quiet -p rover-sitl
	cd companion/native && VIRTUAL_ENV=$(CURDIR)/$(VENV) ../../$(BIN)/maturin develop --release --quiet
	cd hil_tests/plant && VIRTUAL_ENV=$(CURDIR)/$(VENV) ../../$(BIN)/maturin develop --release --quiet
	touch $@

demo: setup
	$(BIN)/rover run demo --rig sitl --seed $(SEED) --out $(OUT) $(if $(DATA),--data $(DATA))

$(VENV)/.dev: $(BIN)/rover requirements-dev.txt
	$(BIN)/python -m pip install --quiet --disable-pip-version-check -r requirements-dev.txt
	touch $@

setup-dev: setup $(VENV)/.dev

test: setup-dev firmware test-rust test-python

test-rust: setup
	$(CARGO) test --release --quiet -p rover-protocol -p rover-core -p rover-long-arithmetic -p rover-mcp2515 -p rover-sitl -p rover-native -p rover-plant
	firmware/no_panic.sh

test-python: setup-dev
	$(BIN)/python -m pytest

lint: setup-dev
	$(BIN)/ruff check .
	$(CARGO) fmt --all --check
	$(CARGO) clippy --release --quiet --workspace --all-targets -- -D warnings
	firmware/lint.sh

firmware: $(BIN)/python
	PYTHON=$(CURDIR)/$(BIN)/python firmware/build.sh

bench: setup-dev
	$(BIN)/python -m tools.bench missions

train: setup-dev
	OMP_NUM_THREADS=1 $(BIN)/python -m tools.train ground --seed $(SEED)
	$(if $(DATA),OMP_NUM_THREADS=1 $(BIN)/python -m tools.train pictures --seed $(SEED) --data $(DATA))

evaluate: setup-dev
	OMP_NUM_THREADS=1 $(BIN)/python -m tools.evaluate --seed $(SEED) $(if $(DATA),--data $(DATA))

mutate: setup-dev
	$(BIN)/python -m rover_hil.scenario.mutate

clean:
	rm -rf $(VENV) target firmware/pico/target firmware/no_panic/target firmware/build build runs
