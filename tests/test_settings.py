"""Settings: TOML round trip, presets, and rejected values."""

import tomllib

import pytest

from recon.errors import InputError
from recon.files.documents import read_toml
from recon.settings import (
    PRESETS,
    QUALITIES,
    Settings,
    merged,
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
        ("quality=fast", "quality is not a setting: it is the option --quality, and in a job"),
        ("seed=3", "seed is not a setting: it is the option --seed"),
        ("maps.cell_size=3", "maps is unknown; the nearest known name is map"),
        ("cell_size=3", "cell_size is unknown; the nearest known name is map.cell_size"),
        ("map=3", "map is 3, but a table is needed"),
        ("map.cell_size=-1", "map.cell_size is -1, but a number > 0 is needed"),
        ("map.cell_size=inf", "map.cell_size is inf, but a finite number is needed"),
        ("map.cell_size=true", "map.cell_size is 'True', but a number is needed"),
        ("map.max_sigma=true", "map.max_sigma is 'True', but a number is needed"),
        ("map.min_count=2.5", "map.min_count is 2.5, but a whole number is needed"),
        ("map.occupancy=count,views", "map.occupancy is 'count,views', but a list, such as"),
        ("map.occupancy=['x']", "map.occupancy.0 is 'x', but 'count', 'weight', .* is needed"),
        ("features.widths_px=[]", r"widths_px is \[\], but a list of at least 1 is needed"),
        ("sequence.roi=[1, 2]", "sequence.roi.2 is missing"),
        ("exploration.start_position=1", "exploration.start_position is 1, but a list, such as"),
        ("render.mipmaps=7", "render.mipmaps is 7, but true or false is needed"),
        ("map.partition_size=1", "partition_size is 1, but a multiple of 64 is needed"),
        ("render.blur_px=1e6", "blur_px is 1000000.0, but a number <= 100 is needed"),
        ("render.noise_grain_px=101", "noise_grain_px is 101, but a number <= 100 is needed"),
        ("motion.heading_noise_deg=1e9", "heading_noise_deg is .*, but a number <= 180 is needed"),
        ("matching.keep=many", "matching.keep is 'many', but a whole number is needed"),
        ("=3", "stage.name=value is needed"),
        ("map.cell_size", "stage.name=value is needed"),
        ("matching.max_disparity=-5", "max_disparity -5 is below min_disparity 0"),
    ],
)
def test_invalid_setting_is_named(override, message):
    with pytest.raises(InputError, match=message):
        updated(Settings(), parse_overrides([override]), "--set")


def test_keys_of_a_file_may_be_those_of_set(tmp_path):
    file = tmp_path / "settings.toml"
    file.write_text('"map.cell_size" = 0.5\n"map.min_count" = 3\n[matching]\nkeep = 7\n')
    settings = updated(Settings(), read_toml(file))
    assert (settings.map.cell_size, settings.map.min_count, settings.matching.keep) == (0.5, 3, 7)


def test_later_tables_take_precedence_value_by_value():
    tree = merged({"map.cell_size": 1.0, "map.min_count": 2}, {"map": {"cell_size": 3.0}})
    assert tree == {"map": {"cell_size": 3.0, "min_count": 2}}


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
