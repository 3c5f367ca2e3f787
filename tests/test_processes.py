"""Processes from which workers are forked."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

SLOW = """
import time
from pathlib import Path
Path("begun").touch()
time.sleep(1)
"""
INTERRUPTED = """
import os, signal, time
from concurrent.futures import ProcessPoolExecutor
from contextlib import suppress
from pathlib import Path
from recon.processes import begin_worker, start_server

if __name__ == "__main__":
    signal.signal(signal.SIGINT, signal.default_int_handler)  # background jobs may ignore it
    start = start_server("slow")
    while not Path("begun").exists():
        time.sleep(0.01)
    with suppress(KeyboardInterrupt):
        os.killpg(0, signal.SIGINT)
        time.sleep(600)
    with ProcessPoolExecutor(1, mp_context=start, initializer=begin_worker, initargs=(1,)) as pool:
        held_back = pool.submit(signal.pthread_sigmask, signal.SIG_BLOCK, ()).result()
    print(signal.SIGINT in held_back)
"""


@pytest.mark.skipif(sys.platform != "linux", reason="other systems cannot fork safely")
def test_ctrl_c_while_a_server_loads_its_modules_is_left_to_the_main_process(tmp_path):
    for name, text in {"slow": SLOW, "interrupted": INTERRUPTED}.items():
        (tmp_path / f"{name}.py").write_text(text)
    path = os.pathsep.join([str(tmp_path), str(Path(__file__).parents[1])])
    done = subprocess.run(
        [sys.executable, "interrupted.py"], cwd=tmp_path, env=os.environ | {"PYTHONPATH": path},
        capture_output=True, text=True, start_new_session=True, check=False,
    )  # fmt: skip
    assert (done.returncode, done.stderr) == (0, "")
    assert done.stdout == "False\n"
