"""Colour scales that are readable with any colour vision, and their limits."""

import functools
from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.floating]

COUNT = "cividis"
SIGMA = "cividis"
ERROR = "plasma"
ORDER = "plasma"
# Their lightness is monotonic, so that it alone distinguishes values; a test checks this.

STRAY_PERCENT = 0.5
"""Percentage of values at either end that may exceed a scale: wrong matches are rare but far
out."""
DECADE = 10.0
FEW, MANY = (1.0, 2.0, 5.0), (1.0, 1.5, 2.0, 2.5, 3.0, 4.0, 5.0, 6.0, 8.0)
"""Digits on a logarithmic scale of more than a decade, and of less."""
DARKEST_SHARE = {"viridis": 0.22, "plasma": 0.35}
"""Share of a scale left out because it would vanish in a dimmed image."""


def disparity() -> Any:
    """The scale of disparities, all of it visible on a dimmed image."""
    return _bright("viridis")


def error() -> Any:
    """The scale of errors of single points, all of it visible on a dimmed image."""
    return _bright(ERROR)


@functools.cache
def _bright(name: str) -> Any:
    from matplotlib import colormaps
    from matplotlib.colors import ListedColormap

    return ListedColormap(colormaps[name](np.linspace(DARKEST_SHARE[name], 1.0, 256)))


def ends(values: Array) -> tuple[float, float]:
    """Limits of a scale, without outliers; (0, 1) if no value is finite."""
    known = np.asarray(values)[np.isfinite(values)]
    if not len(known):
        return 0.0, 1.0
    low, high = np.percentile(known, (STRAY_PERCENT, 100.0 - STRAY_PERCENT))
    return (float(low), float(high)) if high > low else (float(low), float(low) + 1.0)


def coloured(values: Array, cmap: Any, *, is_log: bool = False) -> Any:
    """The scale of values as matplotlib's mappable, for `to_rgba` and colour bars."""
    from matplotlib.cm import ScalarMappable
    from matplotlib.colors import LogNorm, Normalize

    low, high = ends(values)
    norm = LogNorm(max(low, 1e-300), max(high, 1e-299)) if is_log else Normalize(low, high)
    scale = ScalarMappable(norm=norm, cmap=cmap)
    scale.set_array(np.asarray(values))
    return scale


def rgb(scale: Any, values: Array) -> NDArray[np.uint8]:
    """Colours (K, 3) of values (K,)."""
    colours: NDArray[np.uint8] = scale.to_rgba(np.asarray(values), bytes=True)[..., :3]
    return colours


def beyond(values: Array, low: float, high: float) -> str:
    """Ends of a colour bar that need an arrow, as values lie beyond them."""
    known = np.asarray(values)[np.isfinite(values)]
    under, over = bool((known < low).any()), bool((known > high).any())
    if under and over:
        return "both"
    return "min" if under else "max" if over else "neither"


def round_length(most: float) -> float:
    """The longest of 1, 2 and 5 times powers of ten that is not longer than `most`."""
    power = float(10.0 ** np.floor(np.log10(most)))
    # The logarithm of a number just below a power of ten is rounded up.
    return power * max((digit for digit in (1.0, 2.0, 5.0) if digit * power <= most), default=0.5)


def plain_numbers(bar: Any) -> None:
    """Number a logarithmic colour bar 1, 2, 5, 10, ..."""
    number_plainly(bar.ax.yaxis, bar.mappable.get_clim())


def number_plainly(axis: Any, ends: tuple[float, float]) -> None:
    """Number a logarithmic axis 1, 2, 5, 10, ...; more densely if it is short."""
    from matplotlib.ticker import FuncFormatter, LogLocator, NullLocator

    low, high = ends
    axis.set_major_locator(LogLocator(subs=FEW if high / low > DECADE else MANY))
    axis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
    axis.set_minor_locator(NullLocator())
