PYTHON ?= python3
VENV := .venv
BIN := $(VENV)/bin

.PHONY: setup demo test benchmark clean

setup: $(VENV)/ready

# The mark is made last, so that a set-up that was cut short starts again.
$(VENV)/ready: pyproject.toml constraints.txt
	$(PYTHON) -m venv $(VENV)
	$(BIN)/python -m pip install --quiet --disable-pip-version-check -c constraints.txt -e ".[all,test]"
	$(BIN)/python tools/fetch_motorcycle.py
	touch $@

demo: setup
	$(BIN)/recon doctor --quiet
	$(BIN)/recon explore scenes/village.scene -o runs/village --overwrite

test: setup
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/mypy
	$(BIN)/python -m pytest

benchmark: setup
	$(BIN)/python -m pip install --quiet --disable-pip-version-check -c constraints.txt -e ".[benchmark]"
	$(BIN)/python tools/benchmark.py

clean:
	rm -rf $(VENV)
