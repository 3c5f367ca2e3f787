"""Recognition: share of correct labels, solids and CAD parts, and their cost."""

import json
import os
from collections.abc import Iterator
from pathlib import Path

import numpy as np

from benchmarks import Measurement, least_cpu_seconds
from recon.recognition.fitting.composite import Composite
from recon.recognition.fitting.shapes import fit
from recon.recognition.naming.catalogue import read_catalogues
from recon.recognition.naming.naming import name_object
from recon.recognition.recognition import recognise
from recon.recognition.reliability import calibration_error
from recon.recognition.synthetic import Orbit, observe, random_composite, voxelise
from recon.records import UNKNOWN, Box, Sphere, Voxels
from recon.settings import RecognitionSettings

DATA = Path(os.environ.get("RECON_DATA", Path(__file__).parents[3] / "shared" / "data"))
KINDS = ("apple tree", "pine tree", "cottage")
SHAPES = ("sphere", "ellipsoid", "cylinder", "cone")
COLOURS = np.array([[110.0, 70.0, 30.0], [40.0, 150.0, 40.0]])
NOISES_PX = (0.05, 0.1, 0.25)
NUM_REPEATS = 9


def measure(quick: bool) -> list[Measurement]:
    """Run all measurements of the topic; `quick` draws a tenth of the objects."""
    count = 6 if quick else 60
    return [*names(count), *partly_seen(count), *solids(count), *cad_parts(), *costs()]


def names(count: int) -> Iterator[Measurement]:
    """Measure the share of correct labels after nine views, and the error of body radii."""
    for sigma_px in NOISES_PX:
        for recogniser in ("robust", "thesis"):
            settings = RecognitionSettings(recogniser=recogniser)
            right = 0
            for seed in range(count):
                _, voxels = random_object(seed, sigma_px)
                found = recognise(voxels, settings).objects
                largest = max(found, key=lambda one: one.num_voxels, default=None)
                right += largest is not None and largest.label == KINDS[seed % 3]
            yield share(f"names_{recogniser}_{sigma_px}px", right / count)
    yield share("body_radius_error", body_radius_error(count), better="lower", tolerance=0.5)


def partly_seen(count: int) -> Iterator[Measurement]:
    """Measure labels of partly seen objects among unknown ones: recall and calibration."""
    kinds = read_catalogues(["village"])
    kept, chances, rights = [], [], []
    for seed in range(2 * count):
        truth, voxels = random_partly_seen_object(seed) if seed % 2 else random_unknown_object(seed)
        found = name_object(voxels, 0.0, kinds)
        chances.append(found.probability or 0.0)
        rights.append(found.label == truth)
        if truth != UNKNOWN:
            kept.append(found.label == truth and chances[-1] >= 0.5)
    yield share("partly_seen_kept", float(np.mean(kept)), tolerance=0.05)
    error = calibration_error(chances, rights)
    yield share("calibration_error", error, better="lower", tolerance=0.5)


def random_partly_seen_object(seed: int) -> tuple[str, Voxels]:
    """Make a random object as seen in a few views along an arc."""
    rng = np.random.default_rng([1, seed])
    orbit = Orbit(
        num_views=int(rng.integers(1, 6)),
        arc_rad=float(rng.uniform(0.5, 5.0)),
        sigma_px=float(rng.uniform(0.03, 0.2)),
    )
    kind = KINDS[seed // 2 % 3]
    return kind, standing(voxelise(observe(random_composite(kind, rng), COLOURS, orbit, rng)))


def random_unknown_object(seed: int) -> tuple[str, Voxels]:
    """Make a box or a ball of the size of a cottage."""
    rng = np.random.default_rng([2, seed])
    sizes = rng.uniform(3.0, 12.0, 3)
    box = Box(centre=np.array([0.0, sizes[1] / 2.0, 0.0]), axes=np.eye(3), sizes=sizes)
    ball = Sphere(centre=np.array([0.0, 0.4 * sizes[0], 0.0]), radius=sizes[0] / 2.0)
    parts = [box if seed % 4 else ball]
    return UNKNOWN, standing(voxelise(observe(parts, COLOURS[:1], Orbit(), rng)))


def standing(voxels: Voxels) -> Voxels:
    """Select the cells above the ground."""
    return voxels.select(voxels.centres[:, 1] >= 1.0)


def body_radius_error(count: int) -> float:
    """Median relative error of the radius of a body at 0.1 px."""
    errors = []
    for seed in range(count):
        composite, voxels = random_object(seed, 0.1)
        found = recognise(voxels, RecognitionSettings()).objects
        largest = max(found, key=lambda one: one.num_voxels)
        if largest.label == KINDS[seed % 3]:
            errors.append(abs(largest.parts[0].solid.radius / composite.radii[0][0] - 1.0))
    return float(np.median(errors))


def solids(count: int) -> Iterator[Measurement]:
    """Measure the share of single solids classified from cell means; ellipsoids may be spheres."""
    for sigma_px in NOISES_PX:
        for name, weighted in (("means", False), ("weighted_means", True)):
            correct = [
                is_recognised(shape, 100 * seed + number, sigma_px, weighted)
                for seed in range(count)
                for number, shape in enumerate(SHAPES)
            ]
            yield share(f"solids_{name}_{sigma_px}px", float(np.mean(correct)))


def is_recognised(shape: str, seed: int, sigma_px: float, weighted: bool) -> bool:
    """True if one random solid is recognised from its cells."""
    rng = np.random.default_rng(seed)
    voxels = voxelise(observe(random_part(shape, rng), COLOURS[:1], Orbit(sigma_px=sigma_px), rng))
    weights = np.clip(voxels.counts / np.median(voxels.counts), 0.1, 4.0)
    found = fit(voxels.means, weights if weighted else None)
    found_kind = found.kind.removeprefix("truncated ") if found else ""
    round_ones = {"sphere", "ellipsoid"}
    return found_kind == shape or {found_kind, shape} == round_ones


def cad_parts() -> Iterator[Measurement]:
    """Measure the share of CAD parts of the right type; nothing if the data is missing."""
    correct = []
    for folder in sorted((DATA / "pointclouds").glob("fit4cad_*")):
        cloud = np.load(folder / "cloud.npz")
        for truth in json.loads((folder / "primitives.json").read_text()):
            if truth["type"].lower() in (*SHAPES, "plane"):
                found = fit(cloud["xyz"][cloud["label"] == truth["id"]])
                name = found.kind.removeprefix("truncated ") if found else ""
                correct.append(name == truth["type"].lower())
    if correct:
        yield share("cad_types", float(np.mean(correct)))


def costs() -> Iterator[Measurement]:
    """Measure the time of a part and of an object, relative to a singular value decomposition."""
    matrix = np.random.default_rng(0).normal(size=(300, 300))
    peer = least_cpu_seconds(lambda: np.linalg.svd(matrix), NUM_REPEATS)
    _, voxels = random_object(0, 0.1)
    objects = voxels.select(voxels.centres[:, 1] > 1.0)
    kinds = read_catalogues(["village"])
    for name, work in (
        ("part", lambda: fit(objects.means)),
        ("object", lambda: name_object(objects, 0.0, kinds)),
    ):
        yield Measurement(
            name=f"recognition.{name}_ratio",
            value=least_cpu_seconds(work, NUM_REPEATS) / peer,
            unit="of the time of a 300 x 300 SVD",
            better="lower",
            tolerance=0.5,
        )


def random_object(seed: int, sigma_px: float) -> tuple[Composite, Voxels]:
    """Make a random object and its cells after nine views."""
    rng = np.random.default_rng(seed)
    composite = random_composite(KINDS[seed % 3], rng)
    return composite, voxelise(observe(composite, COLOURS, Orbit(sigma_px=sigma_px), rng))


def random_part(shape: str, rng: np.random.Generator) -> Composite:
    """Make one random solid, radius 1 to 8 and height 2 to 12."""
    radius, height, base = rng.uniform(1.0, 8.0), rng.uniform(2.0, 12.0), rng.uniform(0.0, 6.0)
    stretch = float(rng.choice([1.0, -1.0])) * rng.uniform(np.log(1.4), np.log(2.2))
    radii, top = {
        "sphere": ([], base + 2.0 * radius),
        "ellipsoid": ([radius], base + 2.0 * radius * np.exp(stretch)),
        "cylinder": ([radius], base + height),
        "cone": ([max(radius, 2.0), rng.uniform(0.0, 1.0)], base + height),
    }[shape]
    return Composite(
        shapes=("truncated cone" if shape == "cone" else shape,),
        axis=rng.uniform(-50.0, 50.0, 2),
        heights=np.array([base, top]),
        radii=(np.array(radii),),
    )


def share(name: str, value: float, better: str = "higher", tolerance: float = 0.02) -> Measurement:
    """Wrap a share (0 to 1) as a measurement."""
    return Measurement(
        name=f"recognition.{name}", value=value, unit="share", better=better, tolerance=tolerance
    )
