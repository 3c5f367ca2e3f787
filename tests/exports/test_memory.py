"""Memory used by readers, measured in a separate process."""

import io
import struct
import subprocess
import sys
import zipfile

import numpy as np

MEASURE_PEAK = """
import re, sys
from pathlib import Path
from recon.errors import InputError
from recon.exports import read
read(sys.argv[1])
def peak():
    # The peak in rusage would include the parent's memory at the time of the fork.
    return int(re.search("VmHWM:[^0-9]*([0-9]+)", Path("/proc/self/status").read_text())[1])
before = peak()
for path in sys.argv[2:]:
    try:
        read(path)
    except InputError:
        continue
    sys.exit(f"{path} was read")
print((peak() - before) >> 10)
"""


def write_false_files(folder):
    """Write small files that claim huge contents, for readers that need no extra."""
    claims = {
        "a.ply": "ply\nformat ascii 1.0\nelement vertex 1000000000\nproperty float x\n"
        "property float y\nproperty float z\nend_header\n1 2 3\n",
        "b.ply": "ply\nformat binary_little_endian 1.0\nelement vertex 3000000000\n"
        "property double x\nproperty double y\nproperty double z\nend_header\n",
        "c.pcd": "VERSION .7\nFIELDS x y z\nSIZE 8 8 8\nTYPE F F F\nCOUNT 1 1 1\nWIDTH 900000000\n"
        "HEIGHT 4\nPOINTS 3600000000\nDATA binary\n",
        "d.off": "OFF\n2000000000 0 0\n0 0 0\n",
        "e.stl": "",
        "f.npz": "",
    }
    for name, text in claims.items():
        (folder / name).write_text(text)
    (folder / "e.stl").write_bytes(bytes(80) + struct.pack("<I", 2**32 - 1))
    header = io.BytesIO()
    claim = {"descr": "<f8", "fortran_order": False, "shape": (1 << 28, 3)}
    np.lib.format.write_array_header_1_0(header, claim)
    with zipfile.ZipFile(folder / "f.npz", "w") as archive:
        archive.writestr("points.npy", header.getvalue())
    return [folder / name for name in claims]


def test_false_sizes_take_little_memory(tmp_path):
    """Each file claims gigabytes; reading it may take only a fraction of that."""
    (tmp_path / "sound.ply").write_text(
        "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float y\n"
        "property float z\nend_header\n1 2 3\n"
    )
    words = [
        sys.executable,
        "-c",
        MEASURE_PEAK,
        tmp_path / "sound.ply",
        *write_false_files(tmp_path),
    ]
    done = subprocess.run([*map(str, words)], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    assert 0 <= int(done.stdout) < 300  # the readers' libraries take 120


def test_real_data_is_seen_by_the_memory_measurement(tmp_path):
    """Negative control: 0.1 GB of real data shows up in the measurement."""
    np.save(tmp_path / "a.npy", np.zeros((1 << 22, 3)))
    (tmp_path / "none.ply").write_text("ply\n")
    first, later = "read(sys.argv[1])\n", "for path"
    child = MEASURE_PEAK.replace(first, "").replace(later, first + later)
    words = [sys.executable, "-c", child, tmp_path / "a.npy", tmp_path / "none.ply"]
    done = subprocess.run([*map(str, words)], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    assert int(done.stdout) > 90
