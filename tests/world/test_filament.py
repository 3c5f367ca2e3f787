"""Filament renders what the ray caster does, or says why it cannot."""

import dataclasses
import os
import subprocess
import sys

import numpy as np
import pytest

from recon.errors import MissingLibraryError
from recon.records import View
from recon.settings.settings import Settings
from recon.world import filament
from recon.world.cameras import camera_of
from recon.world.world import World

from .conftest import SCENES

VIEW = View(position=[2.0, 5.0, -20.0], target=[20.0, 4.0, -5.0])


@pytest.fixture(scope="module")
def drawn():
    fault = filament.filament_fault()
    if fault:
        pytest.skip(fault)
    settings = Settings()
    render = dataclasses.replace(settings.render, renderer="filament")
    return World.from_file(SCENES / "village.scene", dataclasses.replace(settings, render=render))


def test_both_renderers_give_the_same_depth(drawn, village):
    rig, T_world_left, eyes = village._stand(VIEW)
    camera = camera_of(T_world_left, rig, rig.cx_left_px, eyes).camera
    wanted = village.truth(VIEW).depth
    depth = drawn._renderer.depth(camera)
    both = np.isfinite(depth) & np.isfinite(wanted)
    assert (np.isfinite(depth) != np.isfinite(wanted)).mean() < 0.002
    assert np.percentile(np.abs(depth - wanted)[both], 99) < 1e-3
    assert (np.abs(depth - wanted)[both] > 0.1).mean() < 0.002
    assert np.median(np.abs(depth[:, 1:] - wanted[:, :-1])[both[:, 1:] & both[:, :-1]]) > 1e-6


def test_both_renderers_give_the_same_images(drawn, village):
    one, other = village.take(VIEW), drawn.take(VIEW)
    assert np.abs(one.left.astype(float) - other.left).mean() < 2
    assert np.abs(one.right.astype(float) - other.right).mean() < 2


@pytest.mark.parametrize("weather", [{"fog": 0.03}, {"sky": True}, {"blur_px": 1.0, "noise": 2.0}])
def test_both_renderers_give_the_same_image_effects(drawn, village, weather):
    worlds = (
        World(w.scene, w.eyes, dataclasses.replace(w.render, **weather), w.floor)
        for w in (drawn, village)
    )
    one, other = (world.take(VIEW).left.astype(float) for world in worlds)
    assert np.abs(one - other).mean() < 2
    assert np.abs(one - village.take(VIEW).left).mean() > 2 or "noise" in weather


def test_same_view_gives_the_same_bytes(drawn):
    np.testing.assert_array_equal(drawn.take(VIEW).left, drawn.take(VIEW).left)


def test_unavailable_renderer_raises_with_its_reason(monkeypatch):
    monkeypatch.setattr(filament, "filament_fault", lambda: "the filament renderer does not work")
    with pytest.raises(MissingLibraryError, match="the filament renderer does not work"):
        filament._stage.__wrapped__(32, 32)


def test_probe_names_the_cause_and_the_missing_package(monkeypatch):
    monkeypatch.setattr(filament, "_PROBE", "raise RuntimeError('no Vulkan here')")
    filament.filament_fault.cache_clear()
    fault = filament.filament_fault()
    filament.filament_fault.cache_clear()
    assert "no Vulkan here" in fault
    assert "mesa-vulkan-drivers" in fault
    assert "\n" not in fault


def test_library_output_is_kept_off_stdout():
    code = (
        "import ctypes\n"
        "from recon.world.filament import _quiet_stdout\n"
        "with _quiet_stdout():\n    ctypes.CDLL(None).puts(b'chatter')\n"
        "print('{}')\n"
    )
    result = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, check=True, env=os.environ
    )
    assert result.stdout == "{}\n"
    assert "chatter" in result.stderr
