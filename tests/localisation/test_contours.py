"""Solids become as large, and stand where, their outlines in images show."""

import numpy as np
import pytest

from recon.localisation.contours import _changes, changed, fitted
from recon.localisation.portrait import Portrait
from recon.localisation.revolved import revolved
from recon.records import Cone, Cylinder, Sphere, TruncatedCone
from tests.localisation.trees import taken, tree

PAIRS = [taken(degrees) for degrees in range(0, 360, 60)]
THING = np.zeros(2, np.intp)
UP = np.array([0.0, 1.0, 0.0])
OFF = np.array([0.08, 0.0, -0.06])


@pytest.fixture(scope="module")
def paint():
    return Portrait.of((tree(),), PAIRS, 1.0).plain


def true_solids():
    return [part.solid for part in tree().parts]


def wrong_solids():
    """Trunk and crown that are thin and stand beside the true ones."""
    trunk, crown = true_solids()
    return [
        Cylinder(point=trunk.point + OFF, axis=UP, radius=trunk.radius - 0.1, height=trunk.height),
        Sphere(centre=crown.centre + OFF, radius=crown.radius - 0.08),
    ]


def radii(solids):
    return np.sqrt(solids.radius_sq[:, 0])


def test_solids_that_are_off_are_fitted_to_their_outlines(paint):
    right, wrong = (revolved(solids, 0.3) for solids in (true_solids(), wrong_solids()))
    found = fitted(wrong, THING, paint, PAIRS, 1.0)
    assert np.abs(wrong.origin - right.origin).max() > 0.07
    assert np.abs(found.origin - right.origin)[:, [0, 2]].max() < 0.02
    assert np.abs(radii(found) - radii(right)).max() < 0.03
    assert (found.shape == wrong.shape).all()


def test_solids_that_no_pair_shows_stay_as_they_are(paint):
    wrong = revolved(wrong_solids(), 0.3)
    found = fitted(wrong, THING, paint, [], 1.0)
    assert (found.origin == wrong.origin).all()
    assert (found.radius_sq == wrong.radius_sq).all()


@pytest.mark.parametrize(
    "solid",
    [
        Sphere(centre=UP, radius=2.0),
        Cylinder(point=UP, axis=UP, radius=2.0, height=3.0),
        TruncatedCone(point=UP, axis=UP, radius_bottom=3.0, radius_top=1.0, height=3.0),
        Cone(apex=2.0 * UP, axis=-UP, half_angle_rad=0.7, height=3.0),
    ],
)
def test_no_change_is_no_change(solid):
    one = revolved([solid], 0.3)
    changes = _changes(one, np.zeros(1, np.intp), 1.0)
    same = changed(one, changes, np.zeros(len(changes.shift)))
    for before, after in zip(one._replace(reach=0), same._replace(reach=0), strict=True):
        assert np.allclose(before, after, atol=1e-9)
