"""Composites: the fits of parts on one axis."""

import numpy as np
import pytest

from recon.recognition.fitting.composite import Composite
from recon.recognition.fitting.composite_fits import fit_composites
from recon.recognition.synthetic import Orbit, observe, voxelise

COTTAGE = Composite(
    shapes=("cylinder", "truncated cone"),
    axis=np.zeros(2),
    heights=np.array([0.0, 8.75, 12.2]),
    radii=(np.array([6.9]), np.array([7.1, 1.0])),
)
"""Its roof is so flat that an orbit sees only a few of its cells."""


@pytest.mark.parametrize("seed", [4, 7])
def test_roof_of_few_cells_is_among_the_fits(seed):
    cloud = observe(
        COTTAGE, np.full((2, 3), 120.0), Orbit(sigma_px=0.1), np.random.default_rng(seed)
    )
    cells = voxelise(cloud)
    cells = cells.select(cells.centres[:, 1] >= 1.0)
    assert (cells.means[:, 1] > 9.0).sum() < 20
    fits = fit_composites(COTTAGE.shapes, cells.means, 0.0, 1.0, np.ones(len(cells)))
    deviances = [fit.deviance for fit in fits]
    assert deviances == sorted(deviances)
    eave = [abs(fit.state.heights[1] - 8.75) for fit in fits]
    top = [abs(fit.state.heights[2] - 12.2) for fit in fits]
    assert min(np.hypot(eave, np.divide(top, 2.0))) < 0.5
