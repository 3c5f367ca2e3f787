PYTHON ?= python3
VENV := .venv
BIN := $(VENV)/bin

.PHONY: setup demo test benchmark reproduce docs clean

setup:
	@$(MAKE) --no-print-directory --jobs=2 $(VENV)/ready $(VENV)/kernels

PIP := $(BIN)/python -m pip install --quiet --disable-pip-version-check --no-compile -c constraints.txt

# Two steps, as kernels are compiled while the extras are installed. The marks are made last, so
# that a set-up that was cut short starts again.
$(VENV)/installed: pyproject.toml constraints.txt
	$(PYTHON) -m venv $(VENV)
	$(PIP) -e .
	touch $@

$(VENV)/ready: $(VENV)/installed
	$(PIP) "recon-stereo[all,test]"
	$(BIN)/recon fetch motorcycle -o data/motorcycle --quiet
	touch $@

# numba's cache knows the file of a kernel, not those of the kernels it calls.
KERNELS := $(shell find recon -name '*.py' | xargs grep -l numba)

$(VENV)/kernels: $(VENV)/installed $(KERNELS)
	find recon -name '*.nb[ci]' -delete
	$(BIN)/recon doctor --compile --quiet
	touch $@

demo: setup
	$(BIN)/recon explore scenes/village.scene -o runs/village --overwrite

test: setup
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/mypy
	$(BIN)/python -m pytest -n logical --maxprocesses 4 --dist loadfile

benchmark: setup
	$(PIP) "recon-stereo[benchmark]"
	$(BIN)/python tools/benchmark.py

# The thesis beside recon: site/thesis/index.html.
reproduce: setup
	$(BIN)/python tools/reproduce.py

# The site: site/index.html. Examples run when it is made.
docs: setup
	$(PIP) "recon-stereo[docs]"
	$(BIN)/python -m sphinx -W --keep-going -q -b html docs site

clean:
	rm -rf $(VENV)
