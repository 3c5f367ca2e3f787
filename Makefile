PYTHON ?= python3
VENV := .venv
BIN := $(VENV)/bin

# Modules are compiled once, not by every process that is started.
unexport PYTHONDONTWRITEBYTECODE

.PHONY: setup demo test benchmark reproduce docs clean

setup: $(VENV)/ready $(VENV)/kernels

# uv unpacks side by side what pip does one after the other, in a sixth of its time; pip is asked
# where uv gets nothing, as behind a proxy that only pip knows of.
install = $(BIN)/uv pip install --quiet --python $(BIN)/python -c constraints.txt $(1) || \
	$(BIN)/python -m pip install --quiet --disable-pip-version-check -c constraints.txt $(1)

EVERYTHING := -e ".[all,test]"

# The mark is made last, so that a set-up that was cut short starts again.
$(VENV)/ready: pyproject.toml constraints.txt
	$(PYTHON) -m venv $(VENV)
	$(BIN)/python -m pip install --quiet --disable-pip-version-check -c constraints.txt uv
	$(call install,$(EVERYTHING))
	$(BIN)/recon fetch motorcycle -o data/motorcycle --quiet
	touch $@

# numba's cache knows the file of a kernel, not those of the kernels it calls.
KERNELS := $(shell find recon -name '*.py' | xargs grep -l numba)

$(VENV)/kernels: $(VENV)/ready $(KERNELS)
	find recon -name '*.nb[ci]' -delete
	$(BIN)/recon doctor --compile --quiet
	touch $@

demo: setup
	$(BIN)/recon explore scenes/village.scene -o runs/village --overwrite

test: setup
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/mypy
	$(BIN)/python -m pytest -n logical --maxprocesses 4 --dist loadfile --no-loadscope-reorder

benchmark: setup
	$(call install,-e ".[benchmark]")
	$(BIN)/python tools/benchmark.py

# The thesis beside recon: site/thesis/index.html.
reproduce: setup
	$(BIN)/python tools/reproduce.py

# The site: site/index.html.
docs: setup
	$(call install,-e ".[docs]")
	$(BIN)/python -m sphinx -W --keep-going -q -b html docs site

clean:
	rm -rf $(VENV)
