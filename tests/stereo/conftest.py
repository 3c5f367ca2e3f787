"""Pairs and features shared by the tests of this folder."""

import sys
from pathlib import Path

import pytest

sys.path.insert(0, str(Path(__file__).parent))

from recon.settings import FeatureSettings
from recon.stereo.features import detect
from scenes import textured_pair


@pytest.fixture(scope="session")
def plane():
    """A slanted plane: left image, right image, true disparity."""
    return textured_pair()


@pytest.fixture(scope="session")
def plane_features(plane):
    settings = FeatureSettings()
    return detect(plane[0], settings), detect(plane[1], settings)
