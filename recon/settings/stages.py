"""The tables of settings of all stages."""

from dataclasses import field
from typing import TypeVar

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
class Stages:
    """One table per stage; a stage is handed its own table and nothing else."""

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


S = TypeVar("S", bound=Stages)
