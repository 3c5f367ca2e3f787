"""Figures drawn by helper processes are the same; without helpers nothing is lost."""

import os
import signal
import subprocess
import sys
from pathlib import Path

import pytest

from recon.cli import main
from recon.processes import SPAWN
from recon.runs.artist import OtherProcesses, start_drawing

INTERRUPTED = """
import os
import signal
import sys
from pathlib import Path
from recon.runs.artist import OtherProcesses, start_drawing
if __name__ == "__main__":
    signal.signal(signal.SIGINT, signal.default_int_handler)  # background jobs may ignore it
    artist = OtherProcesses(start_drawing(), 1)
    artist.draw(Path.write_text, Path("first"), "drawn")
    artist.finish()
    artist.draw(Path.write_text, Path("second"), "drawn")
    os.killpg(0, signal.SIGINT)
"""


@pytest.fixture
def artist():
    others = OtherProcesses(SPAWN, 1)
    yield others
    others.close()


def test_calls_are_run_and_their_exceptions_raised(artist, tmp_path):
    path = tmp_path / "figure"
    for text in ("first", "second"):
        artist.draw(Path.write_text, path, text)
    artist.draw(Path.rename, path, tmp_path / "renamed")
    artist.draw(Path.read_text, path)
    with pytest.raises(FileNotFoundError):
        artist.finish()
    assert (tmp_path / "renamed").read_text() == "second"


def test_calls_of_a_killed_process_are_run_in_this_one(artist, tmp_path):
    artist.draw(os._exit, 1)
    artist._waiting.clear()
    for name in ("first", "second"):
        artist.draw(Path.write_text, tmp_path / name, "drawn")
        artist.finish()
        assert (tmp_path / name).read_text() == "drawn"


def test_figures_drawn_by_a_helper_process_are_the_same(tmp_path, monkeypatch):
    monkeypatch.setenv("NUMBA_NUM_THREADS", "2")
    drawn = []

    class RecordedCalls(OtherProcesses):
        def draw(self, call, *arguments):
            drawn.append(arguments[-1])
            super().draw(call, *arguments)

    monkeypatch.setattr("recon.runs.artist.OtherProcesses", RecordedCalls)
    run = tmp_path / "run"
    argv = ["explore", "three_kinds", "-q", "--max-pairs", "1", "-o", str(run)]
    assert main([*argv, "--set", "eyes.width=96", "--set", "eyes.height=96"], is_alone=True) == 0
    assert {"labels", "map3d"} < set(drawn)
    for kind in ("labels", "map3d"):
        path = run / "figures" / f"{kind}.png"
        before = path.read_bytes()
        path.unlink()
        assert main(["figure", str(run), "--kind", kind]) == 0
        assert path.read_bytes() == before


@pytest.mark.skipif(sys.platform != "linux", reason="other systems cannot fork safely")
def test_ctrl_c_is_handled_by_the_main_process_only(tmp_path):
    (tmp_path / "interrupted.py").write_text(INTERRUPTED)
    done = subprocess.run(
        [sys.executable, "interrupted.py"],
        cwd=tmp_path,
        env={**os.environ, "PYTHONPATH": str(Path(__file__).parents[2])},
        capture_output=True,
        text=True,
        start_new_session=True,
        check=False,
    )
    assert done.returncode == -signal.SIGINT
    assert done.stderr.count("Traceback") == 1  # of the main process
    assert (tmp_path / "second").read_text() == "drawn"


def test_workers_are_forked_only_if_safe():
    way = start_drawing().get_start_method()
    assert way == ("forkserver" if sys.platform == "linux" else "spawn")
