"""Probabilities of labels are calibrated, on simulated objects and clumps of recorded maps."""

import dataclasses
from pathlib import Path

import numpy as np
import pytest

from recon.recognition.fitting.composite import solids
from recon.recognition.fitting.composite_fits import fit_composites
from recon.recognition.fitting.surface_points import surface
from recon.recognition.naming import flat_rival, hypotheses, probability, upright
from recon.recognition.naming.case import a_case
from recon.recognition.naming.catalogue import read_catalogues
from recon.recognition.naming.hypothesis import Hypothesis, as_kind, rated
from recon.recognition.naming.limits import log_within
from recon.recognition.naming.naming import name_object
from recon.recognition.naming.probability import Evidence, Logistic
from recon.recognition.reliability import calibration_error
from recon.recognition.synthetic import Orbit, observe, random_composite, voxelise
from recon.records import Box, Cylinder, PointCloud, Sphere, Voxels

KINDS = read_catalogues(["village"])[:3]
NAMES = ("apple tree", "pine tree", "cottage")
COLOURS = np.full((2, 3), 120.0)
UP = np.array([0.0, 1.0, 0.0])
CLUMPS = Path(__file__).with_name("data") / "recorded_clumps.npz"
SURE = Evidence(
    criterion=-4.0,
    lead=2.0,
    seen=np.array([0.8, 0.8]),
    widths=np.array([4.0, 9.0]),
    num_cells=200,
    num_cells_above=90,
    num_cells_lowest=90,
)


def recorded_clumps():
    """Clumps of maps of recordings, in cells, with the ground at 0; none is of a known kind."""
    with np.load(CLUMPS) as archive:
        pieces = np.split(archive["cells"] / 64.0, archive["ends"][:-1])
        counts = np.split(archive["counts"].astype(np.int64), archive["ends"][:-1])
    for means, number in zip(pieces, counts, strict=True):
        index = np.floor(means).astype(np.int64)
        colours = np.full(means.shape, 120, np.uint8)
        yield Voxels(
            index=index,
            centres=index + 0.5,
            means=means,
            counts=number,
            colours=colours,
            cell_size=1.0,
        )


def partly_seen(seed):
    """Make an object of a kind as seen in a few views from one side."""
    rng = np.random.default_rng([31, seed])
    orbit = Orbit(
        num_views=int(rng.integers(2, 6)),
        arc_rad=float(rng.uniform(1.0, 5.0)),
        start_rad=float(rng.uniform(0.0, 6.0)),
        sigma_px=float(rng.uniform(0.03, 0.15)),
    )
    kind = NAMES[seed % 3]
    voxels = voxelise(observe(random_composite(kind, rng), COLOURS, orbit, rng))
    return kind, voxels.select(voxels.centres[:, 1] >= 1.0)


def foreign(seed):
    """Make a box, a ball or a pillar, which are of no known kind."""
    rng = np.random.default_rng([32, seed])
    width, height = rng.uniform(4.0, 9.0), rng.uniform(5.0, 12.0)
    sizes = np.array([width, height, width])
    solid = (
        Box(centre=np.array([0.0, height / 2.0, 0.0]), axes=np.eye(3), sizes=sizes),
        Sphere(centre=np.array([0.0, 0.8 * width, 0.0]), radius=width),
        Cylinder(point=np.zeros(3), axis=UP, radius=width / 2.0, height=height),
    )[seed % 3]
    voxels = voxelise(observe([solid], COLOURS[:1], Orbit(), rng))
    return "unknown", voxels.select(voxels.centres[:, 1] >= 1.0)


def test_recorded_clumps_get_no_village_labels():
    found = [name_object(clump, 0.0, KINDS) for clump in list(recorded_clumps())[::4]]
    named = [one for one in found if one.label != "unknown" and one.probability >= 0.5]
    assert len(found) > 15
    assert len(named) <= 1


def test_partly_seen_objects_are_named_with_calibrated_probabilities():
    chances, rights, kept = [], [], []
    for truth, voxels in [*map(partly_seen, range(18)), *map(foreign, range(9))]:
        found = name_object(voxels, 0.0, KINDS)
        chances.append(found.probability)
        rights.append(found.label == truth)
        if truth != "unknown":
            kept.append(found.label == truth and found.probability >= 0.5)
    assert np.mean(kept) >= 0.75
    assert calibration_error(chances, rights) < 0.15


@pytest.mark.parametrize(
    "missing",
    [
        {"criterion": 0.5},
        {"criterion": -0.2},
        {"lead": -0.5},
        {"seen": np.array([0.01, 0.9])},
        {"widths": np.array([0.2, 30.0])},
        {"num_cells": 8},
        {"num_cells_above": 3},
    ],
    ids=lambda missing: next(iter(missing)),
)
def test_missing_evidence_is_not_compensated_by_other_evidence(missing):
    better = dataclasses.replace(
        SURE, criterion=-9.0, lead=9.0, seen=np.ones(2), widths=np.full(2, 99.0), num_cells=9999
    )
    assert SURE.probability > 0.9
    assert dataclasses.replace(better, **missing).probability < 0.2


def test_object_is_unknown_without_a_catalogue():
    _, voxels = partly_seen(0)
    found = name_object(voxels, 0.0, ())
    assert (found.label, found.probability) == ("unknown", None)
    assert found.failures == ["no catalogue was asked"]


def test_calibration_error_of_simulated_outcomes():
    rng = np.random.default_rng(0)
    chances = rng.uniform(size=20_000)
    assert calibration_error(chances, rng.uniform(size=20_000) < chances) < 0.02
    assert calibration_error(chances, rng.uniform(size=20_000) < chances**4) > 0.2
    assert np.isnan(calibration_error([], []))


def test_box_on_a_box_is_not_a_cottage(monkeypatch):
    rng = np.random.default_rng(0)
    sizes = np.array([[8.6, 4.0, 7.2], [4.3, 2.1, 4.4]])
    heights = np.cumsum(sizes[:, 1]) - sizes[:, 1] / 2.0
    parts = [
        Box(centre=np.array([0.0, height, 0.0]), axes=np.eye(3), sizes=own)
        for height, own in zip(heights, sizes, strict=True)
    ]
    orbit = Orbit(num_views=7, arc_rad=4.5, sigma_px=0.07)
    voxels = voxelise(observe(parts, COLOURS, orbit, rng))
    voxels = voxels.select(voxels.centres[:, 1] >= 1.0)
    assert name_object(voxels, 0.0, KINDS).label == "unknown"
    monkeypatch.setattr(hypotheses, "FORMED", Logistic(middle=-99.0, steepness=1.0))
    assert name_object(voxels, 0.0, KINDS).label == "cottage"


@pytest.mark.parametrize(("radius", "height"), [(3.0, 10.0), (4.0, 12.0), (5.0, 16.0)])
def test_front_of_a_post_with_a_ball_is_not_a_cottage(radius, height, monkeypatch):
    rng = np.random.default_rng(0)
    post = Cylinder(point=np.zeros(3), axis=UP, radius=radius, height=height)
    ball = Sphere(centre=height * UP, radius=1.12 * radius)
    whole = surface([post, ball], 40_000, rng)
    front = whole.points[whole.normals[:, 2] > 0.2]
    points = front + rng.normal(0.0, 0.25, front.shape)
    voxels = voxelise(PointCloud(points=points, colours=np.full(points.shape, 120, np.uint8)))
    voxels = voxels.select(voxels.centres[:, 1] >= 1.0)
    assert name_object(voxels, 0.0, KINDS).label == "unknown"
    # Its outline bulges as well.
    monkeypatch.setattr(probability, "STRAIGHT", Logistic(middle=-99.0, steepness=1.0))
    assert name_object(voxels, 0.0, KINDS).label == "unknown"
    monkeypatch.setattr(upright, "OTHER_SHAPES", Logistic(middle=-99.0, steepness=1.0))
    assert name_object(voxels, 0.0, KINDS).label == "cottage"


@pytest.mark.parametrize("seed", range(3))
def test_a_few_cells_off_the_rim_of_a_post_are_no_roof(seed):
    post = Cylinder(point=np.zeros(3), axis=UP, radius=4.5, height=6.6)
    voxels = voxelise(observe([post], COLOURS, Orbit(), np.random.default_rng(seed)))
    voxels = voxels.select(voxels.means[:, 1] > 1.0)
    means = voxels.means.copy()
    means[np.flatnonzero(means[:, 1] > 5.5)[::9][:6]] *= [0.8, 1.08, 0.8]
    assert name_object(dataclasses.replace(voxels, means=means), 0.0, KINDS).label == "unknown"


@pytest.mark.parametrize("seed", [5, 11, 20])
def test_cottage_in_noise_wider_than_a_cell_is_not_its_level_slices(seed, monkeypatch):
    rng = np.random.default_rng(seed)
    cottage = random_composite("cottage", rng)
    voxels = voxelise(observe(cottage, COLOURS, Orbit(sigma_px=0.25), rng))
    voxels = voxels.select(voxels.centres[:, 1] >= 1.0)
    assert name_object(voxels, 0.0, KINDS).label == "cottage"
    monkeypatch.setattr(flat_rival, "MOST_INSIDE", 1.0)
    assert name_object(voxels, 0.0, KINDS).label == "unknown"


@pytest.fixture
def post():
    """A post, and the fit of a cottage to it."""
    solid = Cylinder(point=np.zeros(3), axis=UP, radius=4.5, height=6.6)
    voxels = voxelise(observe([solid], COLOURS, Orbit(), np.random.default_rng(0)))
    case = a_case(voxels.select(voxels.means[:, 1] > 1.0), 0.0, is_metric=False)
    shapes = ("cylinder", "truncated cone")
    fit, *_ = fit_composites(shapes, case.cells.means, 0.0, case.cells.cell_size, case.weights)
    return case, fit


def test_lead_of_a_part_does_not_hide_that_the_rest_is_worse_explained(post, monkeypatch):
    case, fit = post
    monkeypatch.setattr(upright, "lead_of_parts", lambda *_: 0.4)
    rival = case.lone_criterion(case.alone[0])
    for loss in (0.0, 0.3):
        evidence = upright._evidence(case, fit, rival + loss, np.ones(2))
        assert evidence.lead == pytest.approx(0.4 - loss)


def test_only_ratios_beyond_their_bounds_lower_the_probability(post):
    case, fit = post
    found = Hypothesis(
        kind=None, evidence=0.0, criterion=0.0, composite=fit.state, solids=solids(fit.state)
    )
    chances = [log_within(ratio, (0.3, 2.5), 0.05) for ratio in (1.0, 0.3, 0.22)]
    kinds = (as_kind(case, found, KINDS[2], chance) for chance in chances)
    inside, bound, beyond = (rated(one, SURE).whole for one in kinds)
    assert inside == bound
    assert beyond < 0.1 * bound
