"""Settings: TOML round trip, presets, and rejected values."""

import tomllib

import pytest

from recon.errors import InputError
from recon.files.documents import read_toml
from recon.settings import (
    PRESETS,
    QUALITIES,
    Settings,
    parse_overrides,
    to_toml,
    tolerated,
    updated,
    with_preset,
    with_quality,
)
from recon.settings.files import to_tree


@pytest.mark.parametrize("preset", PRESETS)
def test_saved_settings_round_trip(tmp_path, preset):
    settings = with_preset(Settings(), preset)
    file = tmp_path / "settings.toml"
    file.write_text(to_toml(settings))
    assert updated(Settings(), read_toml(file)) == settings


@pytest.mark.parametrize("quality", QUALITIES)
def test_qualities_name_known_values(quality):
    assert tomllib.loads(to_toml(with_quality(Settings(), quality)))


def test_thesis_preset_matches_the_table_of_the_thesis():
    settings = with_preset(Settings(), "thesis")
    assert (settings.eyes.width, settings.eyes.baseline, settings.eyes.fov_deg) == (256, 0.3, 80.0)
    assert (settings.matching.min_disparity, settings.matching.max_disparity) == (-10, 20)
    assert (settings.matching.max_row_offset_px, settings.map.min_count) == (1, 5)
    assert settings.exploration.object_turn_deg == 40
    assert settings.exploration.robot_turn_deg == 45
    assert settings.recognition.hue_tolerance_deg == 7


def test_overrides_are_parsed_as_toml_or_as_a_word():
    tree = parse_overrides(["map.cell_size=0.5", "matching.keep=none", "render.renderer=filament"])
    settings = updated(Settings(), tree)
    assert settings.map.cell_size == 0.5
    assert settings.matching.keep is None
    assert settings.render.renderer == "filament"


@pytest.mark.parametrize(
    ("override", "message"),
    [
        ("matching.max_dispraity=3", "matching.max_dispraity is unknown.*matching.max_disparity"),
        ("maps.cell_size=3", "maps is unknown; the nearest known name is map"),
        ("map.cell_size=-1", "map.cell_size is -1: .*greater than 0"),
        ("map.cell_size=inf", "map.cell_size is inf"),
        ("matching.keep=many", "matching.keep is 'many'"),
        ("map.cell_size", "stage.name=value is needed"),
        ("matching.max_disparity=-5", "max_disparity -5 is below min_disparity 0"),
    ],
)
def test_invalid_setting_is_named(override, message):
    with pytest.raises(InputError, match=message):
        updated(Settings(), parse_overrides([override]), "--set")


def test_invalid_toml_file_is_named(tmp_path):
    file = tmp_path / "broken.toml"
    file.write_text("map = {")
    with pytest.raises(InputError, match=r"broken\.toml.*TOML file is needed"):
        read_toml(file)


def test_settings_of_an_older_version_are_read_as_far_as_known():
    tree = to_tree(updated(Settings(), {"eyes": {"near": 200.0, "far": 300.0}}))
    tree["eyes"]["gone"] = 1
    tree["old"] = {"stage": True}
    tree["map"]["cell_size"] = -1.0
    settings, ignored = tolerated(tree)
    assert set(ignored) == {"eyes.gone", "old.stage", "map.cell_size"}
    assert (settings.eyes.near, settings.eyes.far) == (200.0, 300.0)
    assert settings.map == Settings().map
    assert tolerated(to_tree(Settings())) == (Settings(), ())
