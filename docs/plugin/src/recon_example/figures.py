"""A kind of figure: the number of cells at each height above the ground."""

from typing import Any

import numpy as np

from recon.figures.canvas import Sheet
from recon.figures.kinds import Arrays, Kind, Subject


def data(subject: Subject) -> Arrays:
    """The height of every occupied cell."""
    return {"height": subject.mapped.voxels.centres[:, 1]}


def draw(subject: Subject, sheet: Sheet) -> Any:
    """A histogram of heights."""
    axes = sheet.axes("Cells by height", xlabel=f"height [{subject.unit}]", ylabel="cells")
    height = data(subject)["height"]
    axes.hist(height, bins=np.linspace(height.min(initial=0.0), height.max(initial=1.0), 40))
    return sheet.figure


HEIGHTS = Kind(draw=draw, data=data, size=(900, 600))
