"""Mutations of small valid files, and every reader that is tested with them."""

import signal
import warnings
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import cv2
import numpy as np

from recon.errors import ReconError
from recon.exports import read, write
from recon.exports.formats import FORMATS
from recon.records import Mesh
from recon.runs.description import describe
from recon.settings import Settings
from recon.settings.files import to_toml
from recon.stereo.matching.vonmises import load_model
from tests.contained import contained_files
from tests.exports.maps import sample_cloud, sample_map
from tests.fuzzed_runs import run_files
from tests.sequences.fuzzed import valid_files

WORDS = [b"-1", b"0", b"nan", b"1e308", b"99999999999999999999", b"", b"x", b"\xff", b"1e-300"]
NUMBERS = [0, 1, 0x7F, 0xFF, 0x7FFF, 0xFFFF, 0x7FFFFFFF, 0x80000000, 0xFFFFFFFF, 2**63, 2**64 - 1]
SLOWEST_S = 20
"""Maximum processor time of a reader."""
LONGEST_S = 200
"""Maximum time between start and end of a reader: on a busy machine it waits for a processor."""
TIMERS = {signal.SIGPROF: signal.ITIMER_PROF, signal.SIGALRM: signal.ITIMER_REAL}
CONTAINED_SHARE = 0.1


@dataclass(frozen=True)
class Reader:
    """A reader and a valid file for it."""

    name: str
    """Name, and ending of the file."""
    read: Callable[[Path], Any]
    content: bytes
    share: float = 1.0
    """Share of the usual number of mutations, for slow readers."""


def mutated(content: bytes, rng: np.random.Generator) -> bytes:
    """Copy with one to four changes: bits, numbers, words, pieces, truncation."""
    changed = bytearray(content)
    for _ in range(rng.integers(1, 5)):
        at = int(rng.integers(0, max(len(changed), 1)))
        length = int(rng.integers(1, 40))
        match rng.integers(0, 7):
            case 0 if changed:
                changed[at] ^= 1 << int(rng.integers(0, 8))
            case 1:
                width = int(rng.choice([1, 2, 4, 8]))
                number = NUMBERS[rng.integers(len(NUMBERS))] % (1 << 8 * width)
                changed[at : at + width] = number.to_bytes(width, "little")
            case 2:
                _replace_word(changed, rng)
            case 3:
                del changed[at : at + length]
            case 4:
                changed[at:at] = changed[at : at + length]
            case 5:
                changed[at:at] = rng.bytes(length)
            case _:
                del changed[at:]
    return bytes(changed)


def _replace_word(changed: bytearray, rng: np.random.Generator) -> None:
    """Replace one of the words near the start, where headers are."""
    head = bytes(changed[:2000])
    words = head.split()
    if words:
        word = words[rng.integers(len(words))]
        at = head.find(word)
        changed[at : at + len(word)] = WORDS[rng.integers(len(WORDS))]


@contextmanager
def within(computing_s: float, waiting_s: float) -> Iterator[None]:
    """Raise `TimeoutError` if the block hangs: if it computes or waits too long."""

    def stop(number: int, _: object) -> None:
        what = "processor time" if number == signal.SIGPROF else "waiting"
        raise TimeoutError(f"still reading after {what} of {limits[number]:g} s")

    limits = {signal.SIGPROF: computing_s, signal.SIGALRM: waiting_s}
    before = {number: signal.signal(number, stop) for number in limits}
    for number, limit in limits.items():
        signal.setitimer(TIMERS[number], limit)
    try:
        yield
    finally:
        for number, handler in before.items():
            signal.setitimer(TIMERS[number], 0)
            signal.signal(number, handler)


def fault(reader: Reader, content: bytes, folder: Path) -> str | None:
    """Describe how a reader fails on a file; None if it reads it or rejects it properly."""
    path = folder / f"mutated{reader.name}"
    path.write_bytes(content)
    try:
        with within(SLOWEST_S, LONGEST_S), warnings.catch_warnings(action="error"):
            reader.read(path)
    except (ReconError, FileNotFoundError) as error:
        return "its error has several lines" if "\n" in str(error) else None
    except BaseException as error:
        if isinstance(error, KeyboardInterrupt):
            raise
        return f"{type(error).__name__}: {error}"
    return None


def readers(folder: Path) -> dict[str, Reader]:
    """Collect every reader with its own valid file, by name."""
    recorded = [Reader(*one) for one in [*valid_files(), *run_files(folder)]]
    contained = [Reader(*one, share=CONTAINED_SHARE) for one in contained_files(folder)]
    found = [*_of_formats(folder), *_of_documents(), *recorded, *contained]
    return {one.name: one for one in found}


def _of_formats(folder: Path) -> Iterator[Reader]:
    mesh = Mesh(vertices=np.eye(4, 3), triangles=np.array([[0, 1, 2], [1, 2, 3]], np.int32))
    for ending in FORMATS.names():
        path = folder / f"sound{ending}"
        form = FORMATS.load(ending)
        if ending in (".zarr", ".e57", ".vtk", ".vtp", ".vtu", ".pgm"):
            continue
        data = mesh if form.write is None else sample_cloud(num=20)
        if form.write is not None and type(data) not in form.takes:
            data = sample_map(()).occupied(2)
        write(data, path)
        yield Reader(ending, read, path.read_bytes())
    for name, text in TEXTS.items():
        yield Reader(name, read, text.encode())


def _of_documents() -> Iterator[Reader]:
    model = Path(__file__).parents[1] / "recon" / "stereo" / "vonmises_venus.json"
    yield Reader(".model.json", lambda path: load_model(str(path)), model.read_bytes())
    scene = Path(__file__).parents[1] / "scenes" / "village.scene"
    yield Reader(".scene", describe, scene.read_bytes())
    image = np.random.default_rng(0).integers(0, 255, (16, 16), np.uint8)
    for ending in (".png", ".jpg", ".pfm", ".tif"):
        values = image.astype(np.float32) if ending == ".pfm" else image
        yield Reader(ending, describe, cv2.imencode(ending, values)[1].tobytes())
    for name, text in DOCUMENTS.items():
        yield Reader(name, describe, text.encode())


XYZ = "property float x\nproperty float y\nproperty float z\n"
TEXTS = {
    ".ascii.ply": f"ply\nformat ascii 1.0\nelement vertex 3\n{XYZ}element face 1\n"
    "property list uchar int vertex_indices\nend_header\n1 2 3\n4 5 6\n7 8 9\n3 0 1 2\n",
    ".ascii.pcd": "VERSION .7\nFIELDS x y z _ rgb\nSIZE 4 4 4 1 4\nTYPE F F F U F\nCOUNT 1 1 1 2 1"
    "\nWIDTH 2\nHEIGHT 1\nVIEWPOINT 0 0 0 1 0 0 0\nPOINTS 2\nDATA ascii\n"
    "1 2 3 0 0 4e-39\n4 5 6 0 0 4e-39\n",
    ".ascii.vtk": "# vtk DataFile Version 3.0\nt\nASCII\nDATASET POLYDATA\nPOINTS 2 float\n"
    "1 2 3 4 5 6\nPOINT_DATA 2\nSCALARS s float 1\nLOOKUP_TABLE default\n1 2\n",
    ".ascii.stl": "solid a\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\n"
    "vertex 0 1 0\nendloop\nendfacet\nendsolid a\n",
}
CAMERA = (
    "  intrinsics: [7, 7, 3, 2]\n  resolution: [6, 4]\n  camera_model: pinhole\n"
    "  distortion_model: radtan\n  distortion_coeffs: [0, 0, 0, 0]\n"
)
DOCUMENTS = {
    ".settings.toml": to_toml(Settings()),
    ".objects.json": '{"objects": [], "failures": {"a": 1}}',
    ".metrics.json": '{"num_pairs": 3, "seconds": {"total": 1.5}}',
    ".kitti.txt": "P0: 7 0 3 0 0 7 2 0 0 0 1 0\nP1: 7 0 3 -3.5 0 7 2 0 0 0 1 0\n",
    ".poses.txt": "1 0 0 0 0 1 0 0 0 0 1 0\n1 0 0 3 0 1 0 4 0 0 1 0\n",
    ".tum.txt": "0 0 0 0 0 0 0 1\n1 3 4 0 0 0 0 1\n",
    ".rig.yaml": f"cam0:\n{CAMERA}cam1:\n{CAMERA}"
    "  T_cn_cnm1: [[1, 0, 0, -0.1], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]\n",
}
