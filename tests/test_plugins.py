"""Parts by name: built-in and installed ones, with uniform behaviour on failure."""

from importlib.metadata import EntryPoint, EntryPoints

import pytest

from recon.errors import InputError
from recon.plugins import Registry, register, say_once

OWN = {"join": "os.path:join"}
PLUGINS = {"split": "os.path:split", "broken": "no_such_module:part", "join": "os.path:basename"}


@pytest.fixture
def registry(monkeypatch):
    entries = EntryPoints(EntryPoint(name, value, "g") for name, value in PLUGINS.items())
    monkeypatch.setattr("recon.plugins.entry_points", lambda group: entries.select(group=group))
    return Registry("g", "matcher", OWN)


def test_plugin_is_loaded_by_name_without_replacing_a_built_in(registry):
    import os.path

    assert registry.load("join") is os.path.join
    assert registry.load("split") is os.path.split
    assert registry.names() == ["join", "split", "broken"]


def test_unknown_name_is_rejected_with_the_nearest(registry):
    with pytest.raises(InputError, match=r"matcher is 'jion', but one of .* \(nearest: join\)"):
        registry.load("jion")


def test_broken_plugin_is_named_in_one_line_and_others_still_load(registry, caplog):
    with pytest.raises(InputError, match=r"'broken' \(no_such_module:part\) does not load"):
        registry.load("broken")
    assert [name for name, _ in registry.parts()] == ["join", "split"]
    assert len(caplog.records) == 1
    assert "'broken'" in caplog.text


def test_registered_part_is_found_but_replaces_no_built_in(monkeypatch, caplog):
    monkeypatch.setattr("recon.plugins._registered", {})
    matchers = Registry("recon.matchers", "matcher", OWN)
    register("matchers", "mine", len)
    register("matchers", "join", len)
    assert matchers.load("mine") is len
    assert matchers.load("join") is not len
    assert "matcher 'join' is recon's own; the registered one is not used" in caplog.text
    assert dict(matchers.parts())["mine"] is len
    with pytest.raises(InputError, match=r"group is 'matcher', but one of .*matchers"):
        register("matcher", "mine", len)


def test_same_fault_is_reported_once(caplog):
    for _ in range(2):
        say_once("format 'one of a test' fails")
    assert [record.getMessage() for record in caplog.records] == ["format 'one of a test' fails"]
