# Two commands are enough: `make tables` and `make test`. Each sets up .venv first if it is not there or no longer up to date.

PYTHON ?= $(shell for name in python3.11 python3.12 python3.13 python3; do \
	$$name -c 'import sys; sys.exit(sys.version_info < (3, 11))' 2>/dev/null && { echo $$name; break; }; done)
CORES ?= 2
# Of the data set, once it has a page: make release PUBLISHED='--url URL --date DAY'
PUBLISHED ?=
# The release's large archive: make restore FROM=ovman-embedded-v2-perceived.tar.xz
FROM ?=
SNAKEMAKE = .venv/bin/snakemake --cores $(CORES)
WATCH = .venv/bin/python -m ovman.workflow.watch
# Twice quiet: pip warns of every index of the machine's own that lacks a package.
PIP = .venv/bin/python -m pip --quiet --quiet --disable-pip-version-check --no-input
READY = .venv/ready

export PATH := $(CURDIR)/.venv/bin:$(PATH)
export PYTHONNOUSERSITE = 1
# Where nothing compiled may be kept, each of the workflow's many short jobs compiles all that it imports.
unexport PYTHONPATH PYTHONHOME PYTHONDONTWRITEBYTECODE
.DELETE_ON_ERROR:
.PHONY: help tables restore static quick models show release leaderboard test soak mutants bench lint lock setup clean

help:
	@echo "make tables  the benchmark from floor plans to results/tables, on $(CORES) cores (CORES=n for more)"
	@echo "make restore the release's measurements into results/, so that a changed threshold starts no simulator; FROM=ARCHIVE"
	@echo "make static  the tables of the static gate alone, in results/static_tables: before anything drives"
	@echo "make quick   the same on three scenes in a few minutes, in results-quick"
	@echo "make show    a page about an episode of results/: make show EPISODE=FloorPlan201/moved/0001"
	@echo "make models  the networks of the default, trained anew in some hours, in results/models"
	@echo "make release results/ into data/ovman-embedded-v2, with card, checksums and picture, and into dataset/ as Parquet"
	@echo "make leaderboard  the entries of leaderboard/ driven again, and its tables"
	@echo "make test    the tests, in $(CORES) processes;  make soak: the long ones"
	@echo "make mutants the mutation tests of make soak alone: code is changed line by line, and a test has to notice"
	@echo "make bench   what the engine and the workflow cost on this machine"
	@echo "make lint    format, lint, types, import contracts and the workflow's conventions"
	@echo "make lock    requirements.lock from the newest releases that pyproject.toml allows"
	@echo "make setup   .venv alone;  make clean: remove .venv and caches, keep results"

# Episodes first: where they come out as they were, to the byte, Snakemake runs nothing of what follows them.
# V=1 shows all that Snakemake says.
tables: $(READY)
	@$(WATCH) logs/tables.log ::: $(SNAKEMAKE) -- judged ::: $(SNAKEMAKE) -- results/tables \
		:::: results/tables/static.md results/tables/embodied.md

restore: $(READY)
	@.venv/bin/ovman restore $(if $(FROM),--from $(FROM))

static: $(READY)
	@$(WATCH) logs/static.log ::: $(SNAKEMAKE) -- results/static_tables :::: results/static_tables/static.md

quick: $(READY)
	@$(WATCH) logs/quick.log ::: $(SNAKEMAKE) --directory results-quick --configfile overlays/quick.yaml -- results/tables \
		:::: results-quick/results/tables/static.md results-quick/results/tables/embodied.md

models: $(READY)
	@$(SNAKEMAKE) -- results/models

show: $(READY)
	@[ -n "$(EPISODE)" ] || { echo "Name an episode: make show EPISODE=FloorPlan201/moved/0001" >&2; exit 2; }
	@.venv/bin/ovman show "$(EPISODE)"

release: tables
	@$(SNAKEMAKE) -- results/figures/relations.png results/figures/difficulty.png results/results.md
	@mkdir -p docs/figures; cp results/results.md docs/; cp results/figures/*.png results/figures/*.pdf docs/figures/
	@mkdir -p dist
	@.venv/bin/python -m ovman.report.release results data/ovman-embedded-v2 dist/ovman-embedded-v2-perceived.tar.xz
	@.venv/bin/ovman dataset --out dataset --visits results/visits $(PUBLISHED)

leaderboard: $(READY)
	@.venv/bin/ovman leaderboard --workers $(CORES)

test: $(READY)
	@.venv/bin/python -m pytest -q --numprocesses $(CORES) --dist loadfile --no-loadscope-reorder

soak: $(READY)
	@.venv/bin/python -m pytest -q -m soak
	@$(MAKE) --no-print-directory mutants

mutants: $(READY)
	@.venv/bin/python tests/mutation/survivors.py --processes $(CORES)

bench: $(READY)
	@for file in packages/ovman-engine/bench/*.py bench/*.py; do echo "== $$file"; PYTHONPATH=packages/ovman-engine/bench .venv/bin/python $$file || exit 1; done

lint: $(READY)
	@.venv/bin/ruff check
	@.venv/bin/ruff format --check
	@.venv/bin/snakefmt --check Snakefile workflow packages/ovman-released
	@.venv/bin/mypy
	@.venv/bin/lint-imports --no-cache
	@.venv/bin/python -m ovman.workflow.lint

# opencv-python-headless is opencv-python less the windows, which need system libraries that a fresh machine may lack.
lock:
	@directory=$$(mktemp -d); trap 'rm -rf "$$directory"' EXIT; set -e; \
	"$(PYTHON)" -m venv "$$directory"; \
	"$$directory/bin/python" -m pip --quiet --disable-pip-version-check install --editable ./packages/ovman-engine --editable ".[dev]"; \
	{ \
		echo "# Exact versions of everything for $$("$(PYTHON)" --version | cut -d. -f1,2) on Linux x86-64; made by \`make lock\`:"; \
		echo "# pip install .[dev] with the engine of this repository in a fresh environment, then pip list, with opencv-python replaced by its build without windows."; \
		"$$directory/bin/python" -m pip list --format=freeze --exclude pip --exclude ovman --exclude ovman-engine --exclude ovman-released \
			| sed 's/^opencv-python==/opencv-python-headless==/' | LC_ALL=C sort -f; \
	} > "$$directory/lock"; \
	cp "$$directory/lock" requirements.lock

setup: $(READY)

$(READY): requirements.lock pyproject.toml
	@"$(PYTHON)" -c 'import sys; sys.exit(sys.version_info < (3, 11))' 2>/dev/null || { \
		echo "OVMAN needs Python 3.11 or newer, which $(or $(PYTHON),python3) is not. Name one: make $(MAKECMDGOALS) PYTHON=python3.11" >&2; \
		exit 1; }
	@[ -e $@ ] || rm -rf .venv; rm -f $@
	@echo "Setting up .venv with $$("$(PYTHON)" --version) (once; two to five minutes, 7 GB, most of it PyTorch with its CUDA libraries)"
	@echo "1 of 3  an empty environment"
	@"$(PYTHON)" -m venv .venv
	@$(PIP) install --no-deps "$$(grep '^setuptools==' requirements.lock)"
	@echo "2 of 3  $$(grep -c '^[^#]' requirements.lock) packages of requirements.lock"
	@$(PIP) install --no-deps --no-build-isolation --requirement requirements.lock
	@echo "3 of 3  the packages of this repository"
	@$(PIP) install --no-deps --no-build-isolation --editable packages/ovman-client --editable packages/ovman-engine --editable . --editable packages/ovman-released
	@touch $@

clean:
	rm -rf .venv .hypothesis .import_linter_cache .mypy_cache .pytest_cache .ruff_cache mutants *.egg-info
	find ovman packages tests workflow bench -name __pycache__ -type d -prune -exec rm -rf {} +
