"""The catalogue is TOML that users can extend, and its errors are located."""

import numpy as np
import pytest

from recon.errors import InputError
from recon.recognition.fitting.composite import Composite
from recon.recognition.naming.catalogue import FOLDER, read_catalogue, read_catalogues
from recon.recognition.recognition import recognise
from recon.recognition.synthetic import Orbit, observe, voxelise
from recon.settings import RecognitionSettings

LAMP = """
[[object]]
name = "lamp"
ratio = [1.3, 9.0]
parts = [
    { role = "foot", shapes = ["cylinder"] },
    { role = "shade", shapes = ["sphere"] },
]
"""


def test_village_catalogue_has_the_thesis_kinds_and_composite_ones():
    names = [kind.name for kind in read_catalogues(["village"])]
    assert names[:3] == ["apple tree", "pine tree", "cottage"]
    assert set(names[3:]) == {"house", "table", "bench", "lamp post"}


def test_catalogues_are_combined_and_none_is_empty():
    names = [kind.name for kind in read_catalogues(["none", "household"])]
    assert set(names) == {"box", "ball", "bottle", "mug", "chair", "table"}
    assert read_catalogues(["none"]) == ()
    # Both define a table.
    both = [kind.name for kind in read_catalogues(["village", "household"])]
    assert both.count("table") == 2


def test_user_catalogue_adds_a_kind(tmp_path):
    path = tmp_path / "mine.toml"
    path.write_text((FOLDER / "village.toml").read_text() + LAMP)
    lamp = Composite(
        shapes=("cylinder", "sphere"),
        axis=np.zeros(2),
        heights=np.array([0.0, 4.0, 10.0]),
        radii=(np.array([5.0]), np.array([])),
    )
    rng = np.random.default_rng(0)
    voxels = voxelise(observe(lamp, np.full((2, 3), 120.0), Orbit(eye_height=9.0), rng))
    mine = RecognitionSettings(catalogue=(str(path),))
    assert [one.label for one in recognise(voxels, mine).objects] == ["lamp"]
    # Without the new kind, it is unknown.
    assert {one.label for one in recognise(voxels, RecognitionSettings()).objects} == {"unknown"}


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("[[object]\n", "but a TOML file is needed"),
        ("", "object is missing"),
        (
            '[[object]]\nname = "x"\nparts = []\n',
            "object.0: exactly one of parts and learned is needed",
        ),
        (
            '[[object]]\nname = "x"\nparts = [{ role = "a", shapes = ["torus"] }]\n',
            "object.0.parts.0.shapes.0 is 'torus'",
        ),
        (
            '[[object]]\nname = "unknown"\nparts = [{ role = "a", shapes = ["cone"] }]\n',
            "object.0: its name is 'unknown', but one line other than 'unknown' is needed",
        ),
        (
            '[[object]]\nname = "a\\nb"\nparts = [{ role = "a", shapes = ["cone"] }]\n',
            r"object.0: its name is 'a\\nb'",
        ),
        (
            '[[object]]\nname = "x"\nmin_seen = 1.5\nparts = [{ role = "a", shapes = ["cone"] }]\n',
            r"bad.toml:3: object.0.min_seen is 1.5, but a number <= 1 is needed",
        ),
        (
            '[[object]]\nname = "x"\ncolour = 1\nparts = [{ role = "a", shapes = ["cone"] }]\n',
            "object.0.colour is unknown",
        ),
    ],
)
def test_error_names_the_file(tmp_path, text, message):
    path = tmp_path / "bad.toml"
    path.write_text(text)
    with pytest.raises(InputError, match=message) as error:
        read_catalogue(path)
    assert str(path) in str(error.value)


@pytest.mark.parametrize("name", ["nowhere", "no/where.toml", "x" * 300, "a\0b"])
def test_missing_catalogue_is_rejected(name):
    with pytest.raises(InputError, match="but a TOML file or one of household, village, none is"):
        read_catalogues([name])
