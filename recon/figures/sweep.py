"""A metric of many runs over a swept setting, with a line per combination of other settings."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from recon.figures.canvas import FAINT, INK, Sheet, Size
from recon.figures.scales import ORDER

SIZE: Size = (900, 620)
Runs = Mapping[str, Sequence[tuple[Any, float]]]
"""Value of the setting and metric of each run, by the values of the other settings."""


def sweep(runs: Runs, setting: str, metric: str) -> Any:
    """The mean metric per value of a setting as a line, and every run as a dot.

    Parameters
    ----------
    runs : mapping
    setting : str
        Name below the axis; words are placed at equal distances.
    metric : str
        Name beside the axis.

    Returns
    -------
    matplotlib Figure
    """
    from matplotlib import colormaps

    sheet = Sheet.of(SIZE)
    axes = sheet.axes(f"{metric} over {setting}", setting, metric)
    values = list(dict.fromkeys(value for found in runs.values() for value, _ in found))
    is_numbers = all(isinstance(v, int | float) and not isinstance(v, bool) for v in values)
    place = {str(v): float(v) if is_numbers else n for n, v in enumerate(values)}
    shades = colormaps[ORDER](np.linspace(0.0, 0.8, len(runs)))
    for (name, found), shade in zip(runs.items(), shades, strict=True):
        at = np.array([place[str(value)] for value, _ in found])
        numbers = np.array([number for _, number in found])
        middles = np.unique(at)
        means = [numbers[at == x].mean() for x in middles]
        axes.plot(at, numbers, "o", color=shade, ms=4, alpha=0.5)
        axes.plot(middles, means, "-", color=shade, lw=1.8, label=name)
    axes.set_xticks(list(place.values()), [str(value) for value in values])
    axes.grid(color=FAINT, lw=0.4)
    if any(runs):
        axes.legend(fontsize=0.9 * sheet.font_size, labelcolor=INK, frameon=False)
    return sheet.figure
