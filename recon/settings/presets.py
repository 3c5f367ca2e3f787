"""Named sets of values: the thesis's own, and the two qualities of stereo."""

from typing import Any, Literal

from recon.settings.files import given_tree, merged, updated
from recon.settings.stages import S

Quality = Literal["best", "fast"]

PRESETS: dict[str, dict[str, dict[str, Any]]] = {
    "default": {},
    "thesis": {
        # Widths of 6, 12 and 18 pixels are six half supports: filters of 2, 4 and 6.
        "features": {"share": 0.025, "widths_px": (2.0, 4.0, 6.0)},
        "matching": {"min_disparity": -10, "max_disparity": 20, "max_row_offset_px": 1},
        "map": {"cell_size": 1.0, "min_count": 5, "max_sigma": None},
        "exploration": {
            "controller": "thesis",
            "clearance": 10.0,
            "object_turn_deg": 40.0,
            # The text says 90 degrees, the table 45: the table's is taken.
            "robot_turn_deg": 45.0,
        },
        "recognition": {"recogniser": "thesis", "hue_tolerance_deg": 7.0},
    },
}

QUALITIES: dict[Quality, dict[str, dict[str, Any]]] = {
    "best": {
        "features": {"share": 0.10, "widths_px": (1.5, 3.0, 6.0)},
        "matching": {"cross_check": "exact", "support_sampling": "half"},
        "dense": {"method": "semi-global"},
    },
    "fast": {
        "features": {"share": 0.05, "widths_px": (2.0,)},
        "matching": {"cross_check": "row", "support_sampling": "quarter"},
        "dense": {"method": "opencv"},
    },
}


def with_preset(settings: S, name: str) -> S:
    """`settings` with the values of a preset."""
    return updated(settings, PRESETS[name], f"preset {name}")


def with_quality(settings: S, quality: Quality) -> S:
    """`settings` with the stereo values of a quality."""
    return updated(settings, QUALITIES[quality], f"quality {quality}")


EXPLORER_BASE = merged(
    QUALITIES["fast"],
    {"matching": {"min_disparity": -10, "max_disparity": 20, "cross_check": "exact"}},
)
"""Default values of an explorer. With both cameras on the target, disparities lie around zero
(thesis, table of parameters). Pairs are matched fast, but each is checked against its whole row: a
phantom in front of the cameras would wall the agent in."""


def explorers(settings: S) -> S:
    """`settings` with the explorer's defaults for values not given."""
    return updated(type(settings)(), merged(EXPLORER_BASE, given_tree(settings)))
