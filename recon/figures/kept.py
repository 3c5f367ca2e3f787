"""The kinds of figures not drawn from the map, but from arrays kept by the run."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from recon.figures import confusion, disparity, matching, mixture, overview
from recon.figures.canvas import Sheet
from recon.figures.kinds import Arrays, Kind, Subject
from recon.figures.mapped import MAP3D, draw_labels
from recon.figures.photo import plain
from recon.records import Matches

LABEL_HEIGHT = 1.5
"""Height of the floor plan in the overview, relative to an image."""


def kept_pair(left: NDArray[np.uint8], matches: Matches) -> dict[str, NDArray[Any]]:
    """Arrays that `disparity` is drawn from."""
    return {
        "left": left, "points_px": matches.points_px, "disparity_px": matches.disparity_px
    }  # fmt: skip


def kept_matches(name: str, matches: Matches) -> dict[str, NDArray[Any]]:
    """Arrays of one named set of matches."""
    return {
        f"{name}/points_px": matches.points_px, f"{name}/disparity_px": matches.disparity_px
    }  # fmt: skip


def _sets(arrays: Arrays) -> dict[str, matching.Drawn]:
    """Sets of matches by name, as stored by `kept_matches`."""
    names = [key.removesuffix("/points_px") for key in arrays if key.endswith("/points_px")]
    return {
        name: matching.Drawn(
            points_px=arrays[f"{name}/points_px"], disparity_px=arrays[f"{name}/disparity_px"]
        )
        for name in names
    }


def _data(subject: Subject) -> Arrays:
    return subject.arrays


def _disparity(subject: Subject, sheet: Sheet) -> Any:
    kept = subject.arrays
    return disparity.disparity(kept["left"], kept["points_px"], kept["disparity_px"], sheet=sheet)


def _dense(subject: Subject, sheet: Sheet) -> Any:
    return disparity.dense(subject.arrays["left"], subject.arrays["disparity_px"], sheet=sheet)


def _errors(subject: Subject, sheet: Sheet) -> Any:
    kept = subject.arrays
    found = matching.Drawn(points_px=kept["points_px"], disparity_px=kept["disparity_px"])
    return matching.error_map(kept["left"], found, kept["truth_px"], sheet=sheet)


def _scales(subject: Subject, sheet: Sheet) -> Any:
    return matching.side_by_side(subject.arrays["left"], _sets(subject.arrays), sheet=sheet)


def _tuning(subject: Subject, sheet: Sheet) -> Any:
    kept = subject.arrays
    found = _sets(kept)
    return matching.tuning(
        found["matched"], found["tuned"], kept["truth_px"], int(kept["row"]), sheet=sheet
    )


def _mixture(subject: Subject, sheet: Sheet) -> Any:
    kept = subject.arrays
    titles = [str(title) for title in kept["titles"]]
    measured = [kept[f"measured_{number}"] for number in range(len(titles))]
    return mixture.mixture(
        kept["phases_rad"], list(kept["densities"]), measured, titles, sheet=sheet
    )


def _confusion(subject: Subject, sheet: Sheet) -> Any:
    kept = subject.arrays
    return confusion.confusion_matrix(kept["true"].tolist(), kept["found"].tolist(), sheet=sheet)


def _reliability(subject: Subject, sheet: Sheet) -> Any:
    kept = subject.arrays
    return confusion.reliability(kept["probability"], kept["is_right"], sheet=sheet)


def _overview(subject: Subject, sheet: Sheet) -> Any:
    kept = subject.arrays
    others = [
        lambda panel: plain(panel, kept["left"], "Left image"),
        lambda panel: _disparity(subject, panel),
        lambda panel: draw_labels(subject, panel, with_legend=False),
    ]
    return overview.overview(
        lambda panel: MAP3D.draw(subject, panel), others, heights=(1.0, 1.0, LABEL_HEIGHT),
        sheet=sheet,
    )  # fmt: skip


def _overview_data(subject: Subject) -> Arrays:
    return {**subject.arrays, "kind": np.array("overview")}


OVERVIEW = Kind(
    draw=_overview, data=_overview_data, size=overview.SIZE, is_kept=True, has_view=True
)
DISPARITY = Kind(draw=_disparity, data=_data, size=disparity.SIZE, is_kept=True)
DENSE = Kind(draw=_dense, data=_data, size=disparity.SIZE, is_kept=True)
ERRORS = Kind(draw=_errors, data=_data, size=matching.WIDE, is_kept=True)
SCALES = Kind(draw=_scales, data=_data, size=matching.WIDE, is_kept=True)
TUNING = Kind(draw=_tuning, data=_data, size=matching.TUNING_SIZE, is_kept=True)
MIXTURE = Kind(draw=_mixture, data=_data, size=mixture.SIZE, is_kept=True)
CONFUSION = Kind(draw=_confusion, data=_data, size=confusion.SIZE, is_kept=True)
RELIABILITY = Kind(draw=_reliability, data=_data, size=confusion.SIZE, is_kept=True)
