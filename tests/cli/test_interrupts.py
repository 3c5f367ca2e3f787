"""Signals that end a command: one line, and code 130, wherever they arrive."""

import ctypes
import json
import os
import signal
import subprocess
import sys
import time

import pytest

from recon.cli import main
from recon.errors import InputError, ReconError
from tests.cli.test_main import run


@pytest.fixture
def listening():
    """Signals end this process, also where the caller of the tests ignores some (nohup)."""
    numbers = (signal.SIGTERM, signal.SIGHUP)
    before = [signal.signal(number, signal.SIG_DFL) for number in numbers]
    yield
    for number, handler in zip(numbers, before, strict=True):
        signal.signal(number, handler)


@pytest.mark.usefixtures("listening")
@pytest.mark.parametrize("number", [signal.SIGTERM, signal.SIGHUP])
def test_termination_signal_is_handled_like_ctrl_c(number, tmp_path, monkeypatch, capsys):
    def killed(*_, **__):
        os.kill(os.getpid(), number)

    monkeypatch.setattr("recon.runs.explore.World.from_file", killed)
    before = signal.getsignal(number)
    assert main(["explore", "village", "-o", str(tmp_path / "run")]) == 130
    assert capsys.readouterr().err.strip() == "recon: interrupted"
    assert json.loads((tmp_path / "run" / "manifest.json").read_text())["state"] == "interrupted"
    assert signal.getsignal(number) == before


INTERRUPTED = """
import sys
class Interrupt:
    def find_spec(self, name, *_):
        if name == "recon.cli.explore":
            raise KeyboardInterrupt
sys.meta_path.insert(0, Interrupt())
import recon.cli
"""


def test_interrupt_while_the_commands_are_loaded_is_one_line():
    done = subprocess.run(
        [sys.executable, "-c", INTERRUPTED], capture_output=True, text=True, check=False
    )
    assert (done.returncode, done.stderr) == (130, "recon: interrupted\n")


def drop_interrupt():
    """Interrupt this process inside a callback of machine code, which drops the exception."""
    ctypes.CFUNCTYPE(None)(lambda: signal.raise_signal(signal.SIGINT))()


def drop_and_fail(_job):
    drop_interrupt()
    raise RuntimeError("no compiled object yet")


def drop_and_go_on(_job):
    drop_interrupt()
    time.sleep(100)
    pytest.fail("the work was not interrupted")


def convert_interrupt(_job):
    try:
        signal.raise_signal(signal.SIGTERM)
    except KeyboardInterrupt as error:
        raise ReconError("Open3D does not load (initialization failed)") from error


@pytest.mark.usefixtures("listening")
@pytest.mark.parametrize("work", [drop_and_fail, drop_and_go_on, convert_interrupt])
def test_interrupt_that_machine_code_hides_ends_the_command(monkeypatch, capsys, tmp_path, work):
    monkeypatch.setattr("recon.runs.job.resolve", work)
    code, out, err = run(capsys, "explore", "village", "-o", str(tmp_path / "run"))
    assert (code, out, err.strip()) == (130, "", "recon: interrupted")


@pytest.mark.usefixtures("listening")
def test_signal_that_the_caller_ignores_stays_ignored(monkeypatch, capsys, tmp_path):
    signal.signal(signal.SIGHUP, signal.SIG_IGN)
    monkeypatch.setattr("recon.runs.job.resolve", lambda job: hung_up())
    code, _, err = run(capsys, "explore", "village", "-o", str(tmp_path / "run"))
    assert (code, err.strip()) == (2, "recon: went on")
    assert signal.getsignal(signal.SIGHUP) is signal.SIG_IGN


def hung_up():
    signal.raise_signal(signal.SIGHUP)
    raise InputError("went on")
