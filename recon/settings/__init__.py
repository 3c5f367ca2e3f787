"""Settings: one frozen dataclass per stage, read from and saved as TOML, unknown names refused."""

from recon.settings.exploration import ExplorationSettings
from recon.settings.files import (
    given_tree,
    merged,
    parse_overrides,
    to_toml,
    updated,
)
from recon.settings.mapping import MapSettings
from recon.settings.older import tolerated
from recon.settings.presets import (
    EXPLORER_BASE,
    PRESETS,
    QUALITIES,
    Quality,
    explorers,
    with_preset,
    with_quality,
)
from recon.settings.recognition import RecognitionSettings
from recon.settings.sequences import SequenceSettings
from recon.settings.settings import Settings
from recon.settings.stereo import (
    DenseSettings,
    FeatureSettings,
    MatchingSettings,
    TriangulationSettings,
)
from recon.settings.surface import SurfaceSettings
from recon.settings.world import EyesSettings, RenderSettings, WorldSettings

__all__ = [
    "EXPLORER_BASE",
    "PRESETS",
    "QUALITIES",
    "DenseSettings",
    "ExplorationSettings",
    "EyesSettings",
    "FeatureSettings",
    "MapSettings",
    "MatchingSettings",
    "Quality",
    "RecognitionSettings",
    "RenderSettings",
    "SequenceSettings",
    "Settings",
    "SurfaceSettings",
    "TriangulationSettings",
    "WorldSettings",
    "explorers",
    "given_tree",
    "merged",
    "parse_overrides",
    "to_toml",
    "tolerated",
    "updated",
    "with_preset",
    "with_quality",
]
