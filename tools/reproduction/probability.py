"""Figure 17, Table 2 and Eq 22: the mixture model, and the cost of matching."""

import time
from collections.abc import Iterator

import numpy as np

from recon.mapping.sparse import match_sparse
from recon.settings import Settings, updated, with_preset
from recon.stereo.features import detect
from recon.stereo.matching import vonmises
from recon.stereo.matching.matching import match
from reproduction.drawing import sheet
from reproduction.entry import Entry, Result, number, table
from reproduction.pairs import recorded

SIDES = (256, 512, 1024)
TURN = np.linspace(-np.pi, np.pi, 361)


def entries() -> Iterator[Entry]:
    """List the entries of this part."""
    yield Entry(
        name="table 2", title="Parameters of the complexity, and Eq 22 by measurement",
        thesis="Filtering dominates: O(N^2 R S n^2); 2 s for features, 63 ms for matching.",
        difference="Separable filters in angular harmonics: the time per pixel depends neither on "
        "the size of the image nor, by much, on the width of the filter.",
        make=_complexity,
    )  # fmt: skip
    yield Entry(
        name="figure 17", title="Mixtures of von Mises densities, learned on Venus", make=_mixture,
        thesis="Five components a scale over the histogram of phase differences of right pairs.",
        difference="A uniform component takes up wrong pairs, and the angle is not doubled.",
    )  # fmt: skip


def _mixture() -> Result:
    pair = recorded("Venus")
    settings = updated(Settings(), {"matching": pair.search})
    left, right = (detect(image, settings.features) for image in (pair.left, pair.right))
    matches = match(left, right, settings.matching)
    model = vonmises.load_model(None)
    measured = vonmises.phase_differences(left, right, matches)
    shown = min(len(measured), len(model.widths_px))
    figure, axes = sheet(shown)
    for one, density, phases, width in zip(
        axes, model.densities(TURN), measured, left.widths_px, strict=False
    ):
        one.hist(phases, bins=90, range=(-np.pi, np.pi), density=True, color="#bbbbbb")
        # One line per bin of the similarity of magnitudes, the narrowest for the most similar.
        one.plot(TURN, np.atleast_2d(density).T, color="#0072b2", linewidth=0.8)
        one.set(title=f"filter {width:g} px wide", xlabel="phase difference, rad", ylabel="density")
    return Result(figures=(figure,))


def _complexity() -> Result:
    rng = np.random.default_rng(0)
    rows = []
    for preset in ("default", "thesis"):
        settings = updated(
            with_preset(Settings(), preset), {"matching": {"min_disparity": 0, "max_disparity": 20}}
        )
        for side in SIDES:
            image = rng.integers(0, 256, (side, side), dtype=np.uint8)
            seconds = [_seconds(image, settings) for _ in range(3)]
            both = np.median(np.array(seconds), axis=0)
            per_pixel = [number(1e6 * float(s) / side**2, 3) for s in both]
            rows.append((preset, f"{side} x {side}", *per_pixel))
    head = ("preset", "image", "features, us per pixel", "pair, us per pixel")
    own = [("S", "scales", "3", "3"), ("R", "orientations", "18", "4, by harmonics 0 to 5"),
           ("n", "filter window, px", "12, 24, 48", "separable, about 7 taps a scale"),
           ("D", "search range, px", "20", "as asked")]  # fmt: skip
    return Result(tables=(table(("symbol", "meaning", "thesis", "recon"), own), table(head, rows)))


def _seconds(image: np.ndarray, settings: Settings) -> tuple[float, float]:
    """Measure the time of the features of one image, and of a whole pair."""
    began = time.perf_counter()
    detect(image, settings.features)
    between = time.perf_counter()
    match_sparse(image, np.roll(image, -4, axis=1), settings)
    return between - began, time.perf_counter() - between
