"""The end of a process."""

import subprocess
import sys

ENDING = """
import atexit, sys
from recon.processes import end
atexit.register(print, "registered")
print("printed")
class Slow:
    def __del__(self):
        print("taken apart")
kept = Slow()
end(3)
"""


def test_a_process_ends_with_its_code_and_output_but_takes_nothing_apart():
    ended = subprocess.run([sys.executable, "-c", ENDING], capture_output=True, text=True)
    assert ended.returncode == 3
    assert ended.stdout.split("\n") == ["printed", "registered", ""]
    usual = subprocess.run(
        [sys.executable, "-c", ENDING.replace("end(3)", "sys.exit(3)")],
        capture_output=True,
        text=True,
    )
    assert "taken apart" in usual.stdout
