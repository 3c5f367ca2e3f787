"""Generators of points on solids."""

import importlib.util
from pathlib import Path

import pytest


@pytest.fixture(scope="session")
def surfaces():
    """The module of surface generators beside these tests."""
    path = Path(__file__).with_name("surfaces.py")
    spec = importlib.util.spec_from_file_location("surfaces", path)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module
