"""Small stand-ins for the files that the pages use, in the folder in which a page is tested."""

import re
import shutil
from pathlib import Path

import cv2
import numpy as np

from recon.cli import main
from recon.exports import write
from recon.records import Mesh, PointCloud
from tests.exports.maps import sample_cloud, sample_map
from tests.recordings import render_drive
from tests.sequences.drawn_boards import draw_boards
from tests.sequences.recordings import RIG, write_folder, write_ros1

DOCS = Path(__file__).parents[1] / "docs"


def blocks(page: str) -> list[tuple[str, str]]:
    """Find language and text of each code block of a page."""
    return re.findall(r"^```(\w*)\n(.*?)^```", (DOCS / page).read_text(), re.M | re.S)


def block(page: str, language: str, begin: str = "") -> str:
    """Find the only block of a language on a page that contains `begin`."""
    (text,) = (text for kind, text in blocks(page) if kind == language and begin in text)
    return text


def mugs(folder: Path) -> None:
    """Write two clouds of mugs, a ring of views around a table, and the catalogue of the page."""
    rng = np.random.default_rng(3)
    for number, height in enumerate((2.0, 2.1), start=1):
        turn, up = rng.uniform(0, 2 * np.pi, 3000), rng.uniform(0, height, 3000)
        points = np.stack([np.cos(turn), up, np.sin(turn)], axis=1)
        write(PointCloud(points=points), folder / f"mug{number}.ply")
    size = ["--set", "eyes.width=240", "--set", "eyes.height=180"]
    assert main(["render", "cottage", "--views", "ring:8", *size, "-o", "table"]) == 0
    (folder / "own.toml").write_text(block("howto/catalogue.md", "toml"))


def jobs(folder: Path) -> None:
    """Write the job file of the page, with an exploration of one pair, and a recording."""
    text = block("howto/cluster.md", "toml", "[[job]]").replace("[2, 5]", "[2]")
    short = text.replace("seed = 1", 'seed = 1\nsettings = { "exploration.max_pairs" = 1 }')
    (folder / "jobs.toml").write_text(short)
    write_folder(folder / "recordings" / "first")


def drives(folder: Path) -> None:
    """Write a recording of a drive, and two chunked runs of it."""
    write_folder(folder / "recordings" / "drive")
    for name in ("north", "south"):
        where = ["recordings/drive", "--chunk", "2", "-o", f"runs/{name}", "-q"]
        assert main(["reconstruct", *where]) == 0


def places(folder: Path) -> None:
    """Write a drive, its run, and a copy of the drive as of another day."""
    drive(folder)
    shutil.copytree(folder / "drive", folder / "today")
    fast = ["--quality", "fast", "-q"]
    assert main(["reconstruct", "drive", "-o", "runs/drive", *fast]) == 0


def walk(folder: Path) -> None:
    """Write the results of a run, and files of other programs."""
    (folder / "runs/walk").mkdir(parents=True)
    sample_map().save(folder / "runs/walk/map.npz")
    write(sample_cloud(), folder / "runs/walk/cloud.ply")
    utm = np.array([[500050.0, 20.0, -5400050.0], [500060.0, 21.0, -5400060.0]])
    write(PointCloud(points=utm), folder / "scan.laz")
    triangle = Mesh(vertices=np.eye(3), triangles=np.array([[0, 1, 2]], np.int32))
    write(triangle, folder / "part.stl")
    (folder / "table.txt").write_text("0.1 1 2 3 9\n0.2 4 5 6 9\n")
    write_folder(folder / "drive")


def recordings(folder: Path) -> None:
    """Write a bag, and a drive with images of KITTI's size."""
    shutil.copy(write_ros1(folder / "bags"), folder / "recording.bag")
    wide = write_folder(folder / "drive")
    text = (wide / "calib.txt").read_text()
    (wide / "calib.txt").write_text(text.replace(f" {RIG.cx_left_px} ", " 620.0 "))
    for side in ("left", "right"):
        for file in (wide / side).iterdir():
            image = cv2.imread(str(file), cv2.IMREAD_GRAYSCALE)
            cv2.imwrite(str(file), cv2.resize(image, (1242, 375), interpolation=cv2.INTER_CUBIC))


def boards(folder: Path) -> None:
    """Write images of a 9 by 6 board, a copy of one pair, and a drive."""
    draw_boards(folder / "boards", board=(9, 6), square=0.025)
    for side in ("left", "right"):
        shutil.copy(folder / f"boards/{side}/{side}00.png", folder / f"{side}.png")
    drive(folder)


def scene(folder: Path) -> None:
    (folder / "own.scene").write_text(block("howto/scene.md", "", "# Shader count"))


def drive(folder: Path) -> None:
    size = ["--set", "eyes.width=320", "--set", "eyes.height=240", "--set", "eyes.fov_deg=40"]
    render_drive(folder, 3, size)


def drive_run(folder: Path) -> None:
    drive(folder)
    assert main(["reconstruct", "drive", "-o", "runs/drive", "--quality", "fast", "-q"]) == 0
