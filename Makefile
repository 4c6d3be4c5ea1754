# Two commands are enough: `make tables` and `make test`. Each sets up .venv first if it is not there or no longer up to date.

PYTHON ?= $(shell for name in python3.11 python3.12 python3.13 python3; do \
	$$name -c 'import sys; sys.exit(sys.version_info < (3, 11))' 2>/dev/null && { echo $$name; break; }; done)
CORES ?= 2
SNAKEMAKE = .venv/bin/snakemake --cores $(CORES) --quiet rules reason host
# Twice quiet: pip warns of every index of the machine's own that lacks a package.
PIP = .venv/bin/python -m pip --quiet --quiet --disable-pip-version-check --no-input
# Three steps of one environment: packages of the benchmark, of `make lint` and `make test`, and of training and export.
READY = .venv/ready
DEV = .venv/ready-dev
NETWORKS = .venv/ready-networks
# Index with PyTorch's build without CUDA, used if the machine lacks an NVIDIA driver. Empty: PyPI, whose build has CUDA.
TORCH_INDEX ?= $(if $(wildcard /proc/driver/nvidia/version),,https://download.pytorch.org/whl/cpu)

export PATH := $(CURDIR)/.venv/bin:$(PATH)
export PYTHONNOUSERSITE = 1
# With PYTHONDONTWRITEBYTECODE every job would compile all that it imports.
unexport PYTHONPATH PYTHONHOME PYTHONDONTWRITEBYTECODE
.DELETE_ON_ERROR:
.PHONY: help tables all restore quick models show release leaderboard test golden test-networks soak bench lint lock \
	setup setup-dev setup-networks clean

help:
	@echo "make tables   run the benchmark from floor plans to results/tables, on $(CORES) cores (CORES=n for more)"
	@echo "make all      the same for every split, to results/all"
	@echo "make restore  put the released results into results/, so that a changed threshold starts no simulator"
	@echo "make quick    everything on three scenes in a few minutes, in results-quick"
	@echo "make show     write a page about an episode: make show EPISODE=FloorPlan201/moved/0001"
	@echo "make models   train the networks of the default, in hours, in results/models"
	@echo "make release  write results/ into data/ovman-embedded-v3 and, as Parquet, into dataset/"
	@echo "make leaderboard  replay the entries of leaderboard/ and write its tables"
	@echo "make test     run the tests; make test-networks: those that need PyTorch; make soak: the long ones as well"
	@echo "make golden   compare results with the released ones: pure stages; SIZE=tiny or SIZE=scene: a small world, everything"
	@echo "make bench    measure the engine and the workflow on this machine"
	@echo "make lint     check format, lint, types and import contracts"
	@echo "make lock     write requirements*.lock from the newest releases that pyproject.toml allows"
	@echo "make setup    .venv with the packages of the benchmark; make setup-dev: also those of the tests"
	@echo "make setup-networks  .venv with PyTorch as well; TORCH_INDEX= for the build with CUDA"
	@echo "make clean    remove .venv and caches, keep results"

tables: $(READY)
	@$(SNAKEMAKE) -- results/tables
	@cat results/tables/static.md results/tables/embodied.md results/tables/overview.md

# Every split.
all: $(READY)
	@$(SNAKEMAKE) -- results/all
	@cat results/all/everyday.md results/all/overview.md

# The released results, and Snakemake's record that this checkout made them.
restore: $(READY)
	@.venv/bin/python -m ovman.report.release restore
	@$(SNAKEMAKE) --quiet all --touch --forceall -- results/all

quick: $(READY)
	@$(SNAKEMAKE) --directory results-quick --configfile overlays/quick.yaml -- results/all
	@cat results-quick/results/tables/static.md results-quick/results/tables/embodied.md results-quick/results/all/overview.md

models: $(NETWORKS)
	@$(SNAKEMAKE) -- results/models

show: $(READY)
	@[ -n "$(EPISODE)" ] || { echo "Name an episode: make show EPISODE=FloorPlan201/moved/0001" >&2; exit 2; }
	@.venv/bin/ovman show "$(EPISODE)"

release: all $(DEV)
	@$(SNAKEMAKE) -- results/episodes/dev.jsonl results/episodes/dev_everyday.jsonl \
		results/figures/relations.png results/figures/difficulty.png results/results.md
	@mkdir -p docs/figures; cp results/results.md results/verdicts.md results/beyond.md docs/; cp results/figures/*.png results/figures/*.pdf docs/figures/
	@.venv/bin/python -m ovman.report.release release
	@.venv/bin/ovman dataset --out dataset --visits results/visits

leaderboard: $(READY)
	@.venv/bin/ovman leaderboard --workers $(CORES)

# One thread per process, as in a job of the workflow.
test: $(DEV)
	@OMP_NUM_THREADS=1 .venv/bin/python -m pytest -q --numprocesses $(CORES) --dist loadfile --no-loadscope-reorder

# Shows that a change of the code changes no number. Compares contents of results, not paths.
SIZE ?= pure
golden: $(DEV)
	@OMP_NUM_THREADS=1 .venv/bin/python -m tests.golden.compare $(SIZE)

test-networks: $(NETWORKS)
	@.venv/bin/python -m pytest -q -m "networks and not soak"

soak: $(NETWORKS)
	@.venv/bin/python -m pytest -q -m "networks or soak"

bench: $(NETWORKS)
	@for file in packages/ovman-engine/bench/*.py packages/ovman-engine/bench/unity/[pr]*.py bench/*.py; do echo "== $$file"; PYTHONPATH=packages/ovman-engine/bench .venv/bin/python $$file || exit 1; done

lint: $(DEV)
	@.venv/bin/ruff check
	@.venv/bin/ruff format --check
	@.venv/bin/snakefmt --check Snakefile workflow packages/ovman-released
	@.venv/bin/mypy
	@.venv/bin/lint-imports --no-cache

# The first environment resolves everything at once. Each further one takes the versions of the one before, for fewer packages.
# opencv-python-headless is opencv-python less the windows, which need system libraries that a fresh machine may lack.
OWN = --editable ./packages/ovman-client --editable ./packages/ovman-engine
FOUND = list --format=freeze --exclude pip --exclude ovman --exclude ovman-client --exclude ovman-engine --exclude ovman-released
lock:
	@directory=$$(mktemp -d); trap 'rm -rf "$$directory"' EXIT; set -e; touch "$$directory/found" "$$directory/nothing"; \
	for kind in networks dev core; do \
		"$(PYTHON)" -m venv "$$directory/venv-$$kind"; \
		pip="$$directory/venv-$$kind/bin/python -m pip --quiet --disable-pip-version-check"; \
		case $$kind in networks) of=".[dev,networks,soak]";; dev) of=".[dev]";; core) of=".";; esac; \
		$$pip install --constraint "$$directory/found" --upgrade setuptools pybind11; \
		$$pip install --constraint "$$directory/found" $(OWN) --editable "$$of"; \
		$$pip $(FOUND) | LC_ALL=C sort -f > "$$directory/$$kind"; \
		cp "$$directory/$$kind" "$$directory/found"; \
	done; \
	locked() { \
		echo "# Exact versions for $$("$(PYTHON)" --version | cut -d. -f1,2) on Linux x86-64 of $$3; made by \`make lock\`, opencv-python replaced by its build without windows."; \
		LC_ALL=C grep --invert-match --line-regexp --fixed-strings --file "$$directory/$$2" "$$directory/$$1" \
			| sed 's/^opencv-python==/opencv-python-headless==/'; \
	}; \
	locked core nothing "what the benchmark imports" > "$$directory/requirements.lock"; \
	locked dev core "what the extra dev adds to requirements.lock" > "$$directory/requirements-dev.lock"; \
	locked networks dev "what the extras networks and soak add to requirements-dev.lock" > "$$directory/requirements-networks.lock"; \
	cp "$$directory"/requirements*.lock .

setup: $(READY)

setup-dev: $(DEV)

setup-networks: $(NETWORKS)

# The kernels are compiled again when they change, the rest is installed again when its list changes.
$(READY): .venv/installed $(wildcard packages/ovman-engine/kernels/* packages/ovman-engine/setup.py)
	@cd packages/ovman-engine && ../../.venv/bin/python setup.py --quiet build_ext --inplace
	@touch $@

.venv/installed: requirements.lock pyproject.toml packages/ovman-engine/pyproject.toml
	@"$(PYTHON)" -c 'import sys; sys.exit(sys.version_info < (3, 11))' 2>/dev/null || { \
		echo "OVMAN needs Python 3.11 or newer, which $(or $(PYTHON),python3) is not. Name one: make $(MAKECMDGOALS) PYTHON=python3.11" >&2; \
		exit 1; }
	@[ -e $@ ] || rm -rf .venv; rm -f $@
	@echo "Setting up .venv with $$("$(PYTHON)" --version) (once; a minute, 1.2 GB)"
	@echo "1 of 3  an empty environment"
	@"$(PYTHON)" -m venv .venv
	@$(PIP) install --no-deps $$(grep -E '^(setuptools|pybind11)==' requirements.lock)
	@command -v c++ > /dev/null || $(PIP) install ziglang
	@echo "2 of 3  $$(grep -c '^[^#]' requirements.lock) packages of requirements.lock"
	@$(PIP) install --no-deps --no-build-isolation --requirement requirements.lock
	@echo "3 of 3  the packages of this repository"
	@$(PIP) install --no-deps --no-build-isolation --editable packages/ovman-client --editable packages/ovman-engine --editable . --editable packages/ovman-released
	@touch $@

# Into the same environment.
$(DEV): requirements-dev.lock $(READY)
	@rm -f $@
	@echo "Adding to .venv the $$(grep -c '^[^#]' requirements-dev.lock) packages of requirements-dev.lock (once; a minute, 0.5 GB)"
	@$(PIP) install --no-deps --no-build-isolation --requirement requirements-dev.lock
	@touch $@

# TORCH_INDEX is asked for PyTorch alone. The third call adds the CUDA libraries that the build from PyPI requires; the build for
# processors requires none.
TORCH = ^torch(vision)?==
CUDA = ^(cuda-|nvidia-(cu|n)|triton==)
$(NETWORKS): requirements-networks.lock $(DEV)
	@rm -f $@
	@echo "Adding to .venv the packages of requirements-networks.lock (once; some minutes, 1.6 GB, with CUDA 6 GB)"
	@$(PIP) install --no-deps $(if $(TORCH_INDEX),--extra-index-url $(TORCH_INDEX)) $$(grep -E '$(TORCH)' requirements-networks.lock)
	@grep -Ev '$(TORCH)|$(CUDA)' requirements-networks.lock > $@.lock
	@$(PIP) install --no-deps --no-build-isolation --requirement $@.lock
	@$(PIP) install --constraint requirements-networks.lock torch
	@rm $@.lock; touch $@

clean:
	rm -rf .venv .hypothesis .import_linter_cache .mypy_cache .pytest_cache .ruff_cache mutants *.egg-info
	find ovman packages tests workflow bench -name __pycache__ -type d -prune -exec rm -rf {} +
