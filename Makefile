# Two commands are enough: `make tables` and `make test`. Each sets up .venv first if it is not there or no longer up to date.

# uv makes .venv from uv.lock. Where it is not installed, pip installs it into .uv. PYTHON=python3.12 chooses another Python.
UV ?= $(or $(shell command -v uv),.uv/bin/uv)
SYNC = $(UV) sync --quiet --frozen --inexact --all-packages $(if $(PYTHON),--python $(PYTHON))
CORES ?= 2
SNAKEMAKE = .venv/bin/snakemake --cores $(CORES) --quiet rules reason host
# Three steps of one environment: packages of the benchmark, of `make lint` and `make test`, and of training and export.
READY = .venv/ready
DEV = .venv/ready-dev
NETWORKS = .venv/ready-networks
# PyTorch's build: auto takes the one without CUDA if the machine lacks an NVIDIA driver.
TORCH_BACKEND ?= auto

export PATH := $(CURDIR)/.venv/bin:$(PATH)
export PYTHONNOUSERSITE = 1
# With PYTHONDONTWRITEBYTECODE every job would compile all that it imports.
unexport PYTHONPATH PYTHONHOME PYTHONDONTWRITEBYTECODE
.DELETE_ON_ERROR:
.PHONY: help tables all restore quick models show release leaderboard test golden test-networks soak bench lint lock site \
	setup setup-dev setup-networks clean

help:
	@echo "make tables   run the benchmark from floor plans to results/tables, on $(CORES) cores (CORES=n for more)"
	@echo "make all      the same for every split, to results/all"
	@echo "make restore  put the released results into results/, so that a changed threshold starts no simulator"
	@echo "make quick    every stage on two scenes and a home in a minute and a half, in results-quick"
	@echo "make show     write a page about an episode: make show EPISODE=FloorPlan201/moved/0001"
	@echo "make models   train the networks of the default, in hours, in results/models"
	@echo "make release  write results/ into data/ovman-embedded-v6 and, as Parquet, into dataset/"
	@echo "make leaderboard  replay the entries of leaderboard/ and write its tables"
	@echo "make test     run the tests; make test-networks: those that need PyTorch; make soak: the long ones as well"
	@echo "make golden   compare results with the released ones: pure stages; SIZE=tiny or SIZE=scene: a small world, everything"
	@echo "make bench    measure the engine and the workflow on this machine"
	@echo "make lint     check format, lint, types and import contracts"
	@echo "make site     build the documentation into site/ and check its links"
	@echo "make lock     write uv.lock from the newest releases that pyproject.toml allows"
	@echo "make setup    .venv with the packages of the benchmark; make setup-dev: also those of the tests"
	@echo "make setup-networks  .venv with PyTorch as well; TORCH_BACKEND=cpu or cu128 chooses its build"
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
	@.venv/bin/ovman leaderboard --workers $(CORES) $(addprefix --draw ,$(wildcard data/draws/*))

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
	@for file in packages/ovman-engine/bench/*.py packages/ovman-engine/bench/unity/[pr]*.py bench/*.py; do echo "== $$file"; PYTHONPATH=.:packages/ovman-engine/bench .venv/bin/python $$file || exit 1; done

lint: $(DEV)
	@.venv/bin/ruff check
	@.venv/bin/ruff format --check
	@.venv/bin/snakefmt --check Snakefile workflow packages/ovman-released
	@.venv/bin/mypy
	@.venv/bin/lint-imports --no-cache

lock: | $(UV)
	@$(UV) lock --upgrade

# LinkChecker would follow links out of the site only with --check-extern.
site: $(READY)
	@$(SYNC) --group docs
	@.venv/bin/python docs/stage.py
	@.venv/bin/zensical build --clean --strict
	@.venv/bin/linkchecker --no-status --no-warnings site/index.html

setup: $(READY)

setup-dev: $(DEV)

setup-networks: $(NETWORKS)

# The kernels are compiled again when they change, the rest is installed again when the lock changes.
$(READY): uv.lock pyproject.toml $(wildcard packages/*/pyproject.toml packages/ovman-engine/setup.py packages/ovman-engine/kernels/*) | $(UV)
	@echo "Setting up .venv (once; a minute, 1.2 GB)"
	@$(SYNC) --no-group dev
	@touch $@

$(DEV): $(READY)
	@echo "Adding the packages of the tests to .venv (once; a minute, 0.5 GB)"
	@$(SYNC)
	@touch $@

# Locked but for the build of PyTorch, which brings the CUDA libraries that it needs.
$(NETWORKS): $(DEV)
	@echo "Adding PyTorch and the packages of the extra networks to .venv (once; some minutes, 1.6 GB, with CUDA 6 GB)"
	@$(UV) export --quiet --frozen --all-packages --extra networks --no-emit-workspace --no-hashes \
		| grep -Ev '^(cuda-|nvidia-|triton)' > $@.txt
	@$(UV) pip install --quiet --torch-backend $(TORCH_BACKEND) --requirement $@.txt
	@rm $@.txt; touch $@

.uv/bin/uv:
	@$(or $(PYTHON),python3) -m venv .uv
	@.uv/bin/python -m pip install --quiet --quiet --disable-pip-version-check --no-input 'uv>=0.9'

clean:
	rm -rf .venv .uv .hypothesis .import_linter_cache .mypy_cache .pytest_cache .ruff_cache mutants *.egg-info
	find ovman packages tests workflow bench -name __pycache__ -type d -prune -exec rm -rf {} +
