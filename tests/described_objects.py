"""Properties that `objects.json` gives for every object, named or not, of any source."""


def assert_described(found, *, has_views=True, has_colours=True):
    """Check that every property of an object is given, as far as its source shows it."""
    is_unknown = found["label"] == "unknown"
    assert (found["reason"] is not None) == is_unknown
    assert found["probability"] is None or 0.0 < found["probability"] <= 1.0
    assert all(0.0 < chance <= 1.0 for _, chance in found["nearest"])
    assert found["box"]["unit"] in (None, "m")
    assert all(size > 0.0 for size in found["box"]["sizes"])
    assert 0.0 <= found["solid"]["explained"] <= 1.0
    assert found["solid"]["shape"] == "plane" or 0.0 <= found["seen"] <= 1.0
    assert found["pieces"] >= 1
    assert found["num_voxels"] >= 1
    assert "support" in found
    assert (found["colour"] is not None) == has_colours
    assert (found["views"] > 0) == has_views
