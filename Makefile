PYTHON ?= python3
VENV := .venv
BIN := $(VENV)/bin

.PHONY: setup demo test benchmark reproduce docs clean

setup: $(VENV)/ready

# The mark is made last, so that a set-up that was cut short starts again.
$(VENV)/ready: pyproject.toml constraints.txt
	$(PYTHON) -m venv $(VENV)
	$(BIN)/python -m pip install --quiet --disable-pip-version-check -c constraints.txt -e ".[all,test]"
	$(BIN)/recon fetch motorcycle -o data/motorcycle --quiet
	touch $@

# numba's cache knows the file of a kernel, not those of the kernels it calls.
KERNELS := $(shell find recon -name '*.py' | xargs grep -l numba)

$(VENV)/kernels: $(VENV)/ready $(KERNELS)
	find recon -name '*.nb[ci]' -delete
	touch $@

demo: setup $(VENV)/kernels
	$(BIN)/recon doctor --quiet
	$(BIN)/recon explore scenes/village.scene -o runs/village --overwrite

test: setup $(VENV)/kernels
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/mypy
	$(BIN)/python -m pytest -n logical --maxprocesses 4 --dist loadfile

benchmark: setup $(VENV)/kernels
	$(BIN)/python -m pip install --quiet --disable-pip-version-check -c constraints.txt -e ".[benchmark]"
	$(BIN)/python tools/benchmark.py

# The thesis beside recon: site/thesis/index.html.
reproduce: setup $(VENV)/kernels
	$(BIN)/python tools/reproduce.py

# The site: site/index.html. Examples run when it is made.
docs: setup $(VENV)/kernels
	$(BIN)/python -m pip install --quiet --disable-pip-version-check -c constraints.txt -e ".[docs]"
	$(BIN)/python -m sphinx -W --keep-going -q -b html docs site

clean:
	rm -rf $(VENV)
