"""Settings of the simulated cameras: field of view and focal length follow from each other."""

import math

import pytest

from recon.errors import InputError
from recon.settings.files import to_tree, updated
from recon.settings.settings import Settings
from recon.settings.world import SENSOR_WIDTH, EyesSettings


@pytest.mark.parametrize(
    ("given", "focal_length", "fov_deg"),
    [
        ({}, 0.1, 80.0),
        ({"fov_deg": 60.0}, SENSOR_WIDTH / 2 / math.tan(math.radians(30)), 60.0),
        ({"focal_length": 0.2}, 0.2, math.degrees(2 * math.atan(SENSOR_WIDTH / 0.4))),
        ({"fov_deg": 80.0, "focal_length": 0.1}, 0.1, 80.0),
    ],
)
def test_focal_length_and_field_of_view_follow_from_each_other(given, focal_length, fov_deg):
    for eyes in (EyesSettings(**given), updated(Settings(), {"eyes": given}).eyes):
        assert eyes.focal_length == pytest.approx(focal_length)
        assert eyes.fov_deg == pytest.approx(fov_deg)


def test_later_change_overrides_an_earlier_one():
    wide = updated(Settings(), {"eyes": {"fov_deg": 100.0}})
    assert updated(wide, {"eyes": {"fov_deg": 80.0}}).eyes == EyesSettings()
    assert updated(wide, {"eyes": {"focal_length": 0.1}}).eyes.fov_deg == pytest.approx(80)
    assert updated(wide, {"eyes": {"far": 50.0}}).eyes.fov_deg == 100
    assert updated(Settings(), to_tree(wide)) == wide


def test_contradicting_focal_length_and_field_of_view_are_rejected():
    with pytest.raises(InputError, match="do not belong together; give one of them"):
        EyesSettings(fov_deg=60.0, focal_length=0.2)
    with pytest.raises(InputError, match="do not belong together"):
        updated(Settings(), {"eyes": {"fov_deg": 60.0, "focal_length": 0.2}})


@pytest.mark.parametrize("value", [0, -1, 180, math.nan, "wide", None])
def test_invalid_field_of_view_is_rejected(value):
    with pytest.raises(InputError, match=r"eyes\.fov_deg is "):
        updated(Settings(), {"eyes": {"fov_deg": value}})
