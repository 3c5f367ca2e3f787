"""The end of the program."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

ENDING = """
import atexit, sys, threading, time
from recon.cli.ending import end
from multiprocessing.util import Finalize
atexit.register(print, "registered")
Finalize(None, print, args=["pool told"], exitpriority=0)
print("printed")
class Slow:
    def __del__(self):
        print("taken apart")
kept = Slow()
def work():
    time.sleep(0.2)
    print("thread done")
threading.Thread(target=work).start()
end(3)
"""


def run(program):
    return subprocess.run([sys.executable, "-c", program], capture_output=True, text=True)


@pytest.mark.parametrize("module", ["recon.cli.ending", "recon.cli.main", "recon.cli"])
def test_program_ends_with_its_code_and_output_but_takes_nothing_apart(module):
    ended = run(f"import {module}\n{ENDING}")
    assert ended.returncode == 3
    # multiprocessing tells its pools to end only after the threads that feed them have.
    told = ["printed", "thread done", "registered", "pool told", ""]
    assert ended.stdout.split("\n") == told
    usual = run(ENDING.replace("end(3)", "sys.exit(3)"))
    assert "taken apart" in usual.stdout


def test_output_that_cannot_be_written_is_reported_at_the_end():
    program = [sys.executable, "-c", "from recon.cli.ending import end\nprint('lost')\nend(0)"]
    buffered = os.environ | {"PYTHONUNBUFFERED": ""}
    with Path("/dev/full").open("wb") as full:
        ended = subprocess.run(
            program, stdout=full, stderr=subprocess.PIPE, text=True, env=buffered
        )
    assert ended.returncode == 120
    assert "No space left on device" in ended.stderr
