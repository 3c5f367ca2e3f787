"""Images rectified and saved, with their new calibration."""

from dataclasses import dataclass
from pathlib import Path

from recon.camera import StereoRig
from recon.errors import InputError
from recon.files import atomic_path
from recon.sequences.calibration.files import read_calibration
from recon.sequences.calibration.rectification import Rectifier, rectifier
from recon.sequences.depth import Image, Stretch
from recon.sequences.images import read_image
from recon.sequences.listing import Listed, list_pairs
from recon.sequences.pair_images import alike, read_pair
from recon.sequences.readers.folder import first_size, first_stretch


@dataclass(frozen=True, slots=True, kw_only=True)
class Rectified:
    """Statistics of the written files."""

    rig: StereoRig
    num_pairs: int
    skipped: tuple[str, ...]
    """Names of pairs that could not be read."""


def rectify_files(left: Path, right: Path, calib: Path, output: Path) -> Rectified:
    """Rectify two images, or two folders of images, into a rectified recording.

    Writes left/ and right/ (left.png and right.png for two files) and calib.txt below `output`.

    Raises
    ------
    InputError
        If the calibration is for another size, or nothing can be read.
    """
    if left.is_dir() != right.is_dir():
        raise InputError(
            f"{left} and {right} are a folder and a file, but two of the same kind are needed"
        )
    if left.is_dir():
        return _folders(left, right, calib, output)
    images = read_pair(left, right)
    rectify = rectifier(read_calibration(calib), (images[0].shape[1], images[0].shape[0]))
    try:
        rectified = rectify(*images)
    except InputError as error:
        raise InputError(f"{left} and {right}: {error}") from error
    output.mkdir(parents=True, exist_ok=True)
    for side, image in zip(("left", "right"), rectified, strict=True):
        _write(output / f"{side}.png", image)
    _write_calibration(output, rectify.rig)
    return Rectified(rig=rectify.rig, num_pairs=1, skipped=())


def _folders(left: Path, right: Path, calib: Path, output: Path) -> Rectified:
    listed = list_pairs(left, right)
    rectify = rectifier(read_calibration(calib), first_size(listed))
    eight_bits = first_stretch(listed)
    for side in ("left", "right"):
        (output / side).mkdir(parents=True, exist_ok=True)
    skipped = []
    for entry in listed:
        try:
            pair = _pair(entry, rectify, eight_bits)
        except InputError as error:
            skipped.append(f"{entry.name}: {error}")
            continue
        for side, image in zip(("left", "right"), pair, strict=True):
            _write(output / side / f"{entry.name}.png", image)
    if len(skipped) == len(listed):
        raise InputError(f"no pair could be read; the first is {skipped[0]}")
    _write_calibration(output, rectify.rig)
    return Rectified(rig=rectify.rig, num_pairs=len(listed) - len(skipped), skipped=tuple(skipped))


def _pair(entry: Listed, rectify: Rectifier, eight_bits: Stretch) -> tuple[Image, Image]:
    if entry.left is None or entry.right is None:
        raise InputError(f"it has no {'left' if entry.left is None else 'right'} image")
    return rectify(*alike(*(read_image(path, eight_bits) for path in (entry.left, entry.right))))


def _write(path: Path, image: Image) -> None:
    import PIL.Image

    with atomic_path(path) as temporary:
        PIL.Image.fromarray(image).save(temporary, "PNG")


def _write_calibration(folder: Path, rig: StereoRig) -> None:
    """Write calib.txt as KITTI rows: the right camera's fourth column is -focal times baseline."""
    f, b = rig.focal_px, rig.baseline
    rows = [
        f"P{number}: {f!r} 0 {cx!r} {-f * x!r} 0 {f!r} {rig.cy_px!r} 0 0 0 1 0\n"
        for number, (cx, x) in enumerate(((rig.cx_left_px, 0.0), (rig.cx_right_px, b)))
    ]
    with atomic_path(folder / "calib.txt") as temporary:
        temporary.write_text("".join(rows), encoding="utf-8")
