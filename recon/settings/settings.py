"""All settings of a run: one frozen dataclass a stage."""

from dataclasses import field
from typing import Any

from recon.settings.exploration import ExplorationSettings
from recon.settings.mapping import MapSettings
from recon.settings.motion import MotionSettings
from recon.settings.recognition import RecognitionSettings
from recon.settings.sequences import SequenceSettings
from recon.settings.stage import table
from recon.settings.stereo import (
    DenseSettings,
    FeatureSettings,
    MatchingSettings,
    TriangulationSettings,
)
from recon.settings.surface import SurfaceSettings
from recon.settings.world import EyesSettings, RenderSettings, WorldSettings


@table
class Settings:
    """One table a stage; a stage is handed its own table and nothing else."""

    sequence: SequenceSettings = field(default_factory=SequenceSettings)
    world: WorldSettings = field(default_factory=WorldSettings)
    eyes: EyesSettings = field(default_factory=EyesSettings)
    render: RenderSettings = field(default_factory=RenderSettings)
    features: FeatureSettings = field(default_factory=FeatureSettings)
    matching: MatchingSettings = field(default_factory=MatchingSettings)
    dense: DenseSettings = field(default_factory=DenseSettings)
    triangulation: TriangulationSettings = field(default_factory=TriangulationSettings)
    surface: SurfaceSettings = field(default_factory=SurfaceSettings)
    map: MapSettings = field(default_factory=MapSettings)
    exploration: ExplorationSettings = field(default_factory=ExplorationSettings)
    motion: MotionSettings = field(default_factory=MotionSettings)
    recognition: RecognitionSettings = field(default_factory=RecognitionSettings)

    @classmethod
    def of(cls, **values: Any) -> "Settings":
        """Settings by keyword: ``Settings.of(quality="fast", max_disparity=60)``.

        Parameters
        ----------
        values
            `preset`, `quality`, a stage with its table (``map={"cell_size": 0.1}``), or the name
            of a setting that only one stage has.
        """
        from recon.settings.keywords import by_keyword

        return by_keyword(**values)
