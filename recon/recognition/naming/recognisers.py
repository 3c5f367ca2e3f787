"""Recognisers by name: functions that name the cells of one object."""

from typing import Protocol

from recon.plugins import Registry
from recon.recognition.naming.kinds import Kind
from recon.recognition.naming.naming import Naming, name_object
from recon.recognition.naming.thesis import name_by_quadrics
from recon.records import Voxels
from recon.settings import RecognitionSettings


class Recogniser(Protocol):
    """Names the cells of one object on the ground (y up)."""

    def __call__(
        self,
        cells: Voxels,
        ground: float,
        kinds: tuple[Kind, ...],
        settings: RecognitionSettings,
        /,
    ) -> Naming:
        """Name the object."""
        ...


def robust(
    cells: Voxels, ground: float, kinds: tuple[Kind, ...], settings: RecognitionSettings
) -> Naming:
    """Composite fits of solids, with a probability."""
    return name_object(cells, ground, kinds, settings.unit == "m")


def thesis(
    cells: Voxels, ground: float, kinds: tuple[Kind, ...], settings: RecognitionSettings
) -> Naming:
    """The thesis's hue parts and quadrics."""
    return name_by_quadrics(cells, ground, kinds, settings.hue_tolerance_deg)


RECOGNISERS: Registry[Recogniser] = Registry(
    "recon.recognisers",
    "recogniser",
    {
        "robust": "recon.recognition.naming.recognisers:robust",
        "thesis": "recon.recognition.naming.recognisers:thesis",
    },
)
