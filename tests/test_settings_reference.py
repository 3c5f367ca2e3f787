"""The reference lists every setting with its description."""

from dataclasses import asdict

from recon.settings import Settings
from recon.settings.reference import reference


def test_every_setting_is_listed_once_with_its_default():
    listed = {one.name: one.default for one in reference()}
    tree = asdict(Settings())
    assert listed == {f"{s}.{n}": v for s, values in tree.items() for n, v in values.items()}


def test_types_meanings_and_thesis_values_are_listed():
    found = {one.name: one for one in reference()}
    assert found["matching.cross_check"].type == "exact | row"
    assert found["eyes.width"].type == "int >= 1 and <= 4096"
    assert found["features.widths_px"].type == "float >= 1.5 and <= 64, ..."
    assert found["matching.keep"].type == "int >= 1 | none"
    assert "world units" in found["exploration.clearance"].meaning.lower()
    assert (found["exploration.controller"].default, found["exploration.controller"].thesis) == (
        "frontier",
        "thesis",
    )


def test_every_setting_has_a_description():
    assert [one.name for one in reference() if not one.meaning] == []
