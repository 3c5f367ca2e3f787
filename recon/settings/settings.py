"""All settings of a run."""

from typing import Any

from recon.settings.keywords import by_keyword
from recon.settings.stage import table
from recon.settings.stages import Stages


@table
class Settings(Stages):
    """The settings of a run: one frozen table per stage."""

    @property
    def wants_surface(self) -> bool:
        """True if a run writes more than its sparse cloud."""
        asked = self.surface
        return self.dense.enabled or asked.wants_mesh or asked.depth_maps

    @classmethod
    def of(cls, settings: "Settings | None" = None, **values: Any) -> "Settings":
        """Settings by keyword: ``Settings.of(quality="fast", max_disparity=60)``.

        Parameters
        ----------
        settings : Settings, optional
            Values that those given by keyword replace.
        values
            `preset`, `quality`, a stage with its table (``map={"cell_size": 0.1}``),
            "stage.name", or the name of a setting that only one stage has.

        Raises
        ------
        InputError
            For an unknown or ambiguous name, and a value out of range.
        """
        return by_keyword(cls(), settings, **values)
