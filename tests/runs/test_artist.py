"""Figures drawn by a second process are those of the first; without it nothing is lost."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

from recon.cli import main
from recon.runs.artist import SecondProcess


@pytest.fixture
def artist():
    second = SecondProcess(Path.cwd)
    yield second
    second.close()


def test_calls_are_done_in_order_and_their_errors_raised(artist, tmp_path):
    path = tmp_path / "figure"
    for text in ("first", "second"):
        artist.draw(Path.write_text, path, text)
    artist.draw(Path.rename, path, tmp_path / "renamed")
    artist.draw(Path.read_text, path)
    with pytest.raises(FileNotFoundError):
        artist.finish()
    assert (tmp_path / "renamed").read_text() == "second"


def test_what_a_killed_process_owes_is_drawn_by_this_one(artist, tmp_path):
    artist._process.kill()
    artist._process.join()
    artist.draw(Path.write_text, tmp_path / "figure", "drawn")
    artist.finish()
    assert (tmp_path / "figure").read_text() == "drawn"


def test_a_command_alone_draws_the_same_figures(tmp_path, monkeypatch):
    monkeypatch.setenv("NUMBA_NUM_THREADS", "2")
    started = []

    class Noted(SecondProcess):
        def draw(self, call, *arguments):
            started.append(self._process.pid)
            super().draw(call, *arguments)

    monkeypatch.setattr("recon.runs.execute.SecondProcess", Noted)
    run = tmp_path / "run"
    argv = ["explore", "three_kinds", "-q", "--max-pairs", "1", "-o", str(run)]
    assert main([*argv, "--set", "eyes.width=96", "--set", "eyes.height=96"], is_alone=True) == 0
    assert started
    for kind in ("labels", "map3d"):
        path = run / "figures" / f"{kind}.png"
        drawn = path.read_bytes()
        path.unlink()
        assert main(["figure", str(run), "--kind", kind]) == 0
        assert path.read_bytes() == drawn


FRESH = """
import sys
from pathlib import Path
from recon.runs.artist import SecondProcess
if __name__ == "__main__":
    if len(sys.argv) > 1:
        sys.modules["vtkmodules"] = sys
    artist = SecondProcess(Path.cwd)
    artist.draw(Path.write_text, Path("figure"), "drawn")
    artist.finish()
    artist.close()
    print(artist.start_method, Path("figure").read_text())
"""


@pytest.mark.skipif(sys.platform != "linux", reason="other systems cannot fork safely")
@pytest.mark.parametrize(("argument", "method"), [((), "fork"), (("drawn before",), "spawn")])
def test_a_process_that_has_not_drawn_is_forked(tmp_path, argument, method):
    (tmp_path / "fresh.py").write_text(FRESH)
    environment = {**os.environ, "PYTHONPATH": str(Path(__file__).parents[2])}
    call = [sys.executable, "fresh.py", *argument]
    done = subprocess.run(
        call, cwd=tmp_path, env=environment, capture_output=True, text=True, check=True
    )
    assert done.stdout.split() == [method, "drawn"]
