"""Figures 4 to 7: the filters and the features they find."""

from collections.abc import Iterator

import numpy as np

from recon.settings import Settings, updated, with_preset
from recon.stereo.features import detect
from reproduction.drawing import features_over, sheet, show
from reproduction.entry import Entry, Result, number, table
from reproduction.pairs import blocks

STAND_IN = (
    "The pairs of CMU could not be had: a rendered pair of painted blocks stands in for them."
)
SIX_HALF_SUPPORTS = 6.0
"""A width of the thesis is six half supports: its 6 px are filters of 2 px here, wavelength 4.4."""


def entries() -> Iterator[Entry]:
    """List the entries of this part."""
    yield Entry(
        name="figure 4", title="Features by population coding", make=_population,
        thesis="980 feature points in the right image of Blocks 1.",
        difference=STAND_IN,
    )  # fmt: skip
    yield Entry(
        name="figure 5", title="The template filter", make=_template,
        thesis="Fourth derivative of a Gaussian, and an approximation of its Hilbert transform.",
        difference="None: the polynomials are those of Eq 11.",
    )  # fmt: skip
    yield Entry(
        name="figure 6", title="Features by steerable filters", make=_steerable,
        thesis="Feature points of Blocks 1, coloured by their orientation.",
        difference=STAND_IN,
    )  # fmt: skip
    yield Entry(
        name="figure 7", title="Features at different numbers of scales", make=_scales,
        thesis="One scale of 6 px, one of 18 px, three from 6 to 18, five from 6 to 22.",
        difference=f"{STAND_IN} A coarse scale alone loses what lies close together, as there.",
    )  # fmt: skip


def _settings(**features: object) -> Settings:
    return updated(with_preset(Settings(), "thesis"), {"features": features})


def _population() -> Result:
    return _both("population")


def _steerable() -> Result:
    return _both("steerable")


def _both(method: str) -> Result:
    pair = blocks("Blocks 1")
    found = [detect(image, _settings(method=method).features) for image in (pair.left, pair.right)]
    figure, axes = sheet(4)
    show(axes[0], pair.left, "left")
    show(axes[1], pair.right, "right")
    features_over(axes[2], found[0], f"left: {len(found[0])} points")
    features_over(axes[3], found[1], f"right: {len(found[1])} points")
    return Result(figures=(figure,))


def _template() -> Result:
    x, y = np.meshgrid(np.linspace(-3, 3, 121), np.linspace(-3, 3, 121))
    envelope = np.exp(-(x**2 + y**2))
    even = (0.934 - 3.738 * x**2 + 1.246 * x**4) * envelope
    odd = (2.858 * x - 2.982 * x**3 + 0.3975 * x**5) * envelope
    figure, axes = sheet(2)
    for one, values, title in (
        (axes[0], even, "real part, g"),
        (axes[1], odd, "imaginary part, q"),
    ):
        image = one.imshow(values, cmap="coolwarm", extent=(-3, 3, -3, 3), vmin=-1.2, vmax=1.2)
        one.set_title(title, fontsize=9)
        figure.colorbar(image, ax=one, shrink=0.8)
    return Result(figures=(figure,))


def _scales() -> Result:
    pair = blocks("Blocks 1")
    sets = {"one scale, 6 px": (6,), "one scale, 18 px": (18,), "three scales": (6, 12, 18),
            "five scales": (6, 10, 14, 18, 22)}  # fmt: skip
    figure, axes = sheet(4)
    rows = []
    for one, (title, widths) in zip(axes, sets.items(), strict=True):
        widths_px = tuple(2.0 * width / SIX_HALF_SUPPORTS for width in widths)
        found = detect(pair.left, _settings(widths_px=widths_px).features)
        features_over(one, found, f"{title}: {len(found)} points")
        rows.append((title, len(found), number(float(np.median(found.modulus)), 2)))
    return Result(figures=(figure,), tables=(table(("scales", "points", "median modulus"), rows),))
