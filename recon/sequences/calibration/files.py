"""Calibration files of all formats, identified by their content."""

from dataclasses import replace
from pathlib import Path

from recon.errors import InputError
from recon.notices import notify
from recon.sequences.calibration import chains
from recon.sequences.calibration.cameras import RESIDUAL, Calibration
from recon.sequences.calibration.documents import MAX_BYTES, Document, read_document
from recon.sequences.calibration.opencv_files import is_opencv, is_ros, named_as_ros, opencv, ros
from recon.sequences.calibration.rows import Cameras, is_kitti, is_middlebury, kitti, middlebury
from recon.sequences.text import read_lines

PARTNERS = (("left", "right"), ("Left", "Right"), ("LEFT", "RIGHT"), ("cam0", "cam1"),
            ("camera0", "camera1"), ("infra1", "infra2"))  # fmt: skip
"""Words by which the file names of one rig differ."""
ENDINGS = (".txt", ".yaml", ".yml", ".xml", ".json")
KINDS = "OpenCV, ROS, Kalibr, OKVIS, VINS-Fusion, ORB-SLAM, KITTI, Middlebury"
"""The known kinds, in words."""
UNKNOWN = (".conf", ".ini", ".npz", ".mat", ".pkl", ".pickle")
"""Endings of other kinds: of ZED's cameras, and of arrays saved by scripts."""
MAX_DIFFERENCE = 0.01
"""Largest relative difference of two calibrations of one rig."""


def read_calibration(path: Path, cameras: Cameras | None = None) -> Calibration:
    """The two cameras of a calibration.

    KITTI's rows (3 x 4 projection matrices, with or without a label), KITTI raw's
    calib_cam_to_cam.txt, Middlebury's keys; OpenCV's YAML, XML or JSON, in one file or as
    intrinsics.yml and extrinsics.yml; ROS's left.yaml and right.yaml; the YAML of Kalibr, OKVIS,
    VINS-Fusion and ORB-SLAM. Middlebury's keys and all but KITTI's rows may state `residual_px`.

    Parameters
    ----------
    path : Path
        A file, one of a pair of files, or a folder that contains a calibration; others in it that
        state another rig cause a notice.
    cameras : (left, right), optional
        Numbers of the KITTI cameras that took the images; by default the first two.

    Raises
    ------
    InputError
        With the line or the key that is wrong or missing.
    """
    if path.is_dir():
        return _of_folder(path, cameras)
    if path.suffix.lower() in UNKNOWN:
        raise InputError(_unknown(str(path)))
    lines = read_lines(path, MAX_BYTES)
    try:
        if is_middlebury(lines):
            return middlebury(path)
        if is_kitti(lines):
            return kitti(path, cameras)
        document = read_document(path)
        found = _of_document(path, named_as_ros(document))
        return replace(found, residual_px=document.get(RESIDUAL, found.residual_px))
    except KeyError as error:
        raise InputError(f"{path} lacks {error.args[0]}") from error
    except InputError as error:
        raise error if str(path) in str(error) else InputError(f"{path}: {error}") from error
    except (ValueError, TypeError) as error:
        raise InputError(f"{path}: {error}") from error


def _of_folder(path: Path, cameras: Cameras | None) -> Calibration:
    chosen, found = _first(path, cameras)
    for file in _candidates(path):
        # Other text and JSON is mostly poses, which take long to parse.
        is_likely = "calib" in file.name.lower() or file.suffix.lower() not in (".txt", ".json")
        if file == chosen or not is_likely:
            continue
        try:
            difference = _difference(found, read_calibration(file, cameras))
        except InputError:
            continue
        if difference:
            notify(
                "calibration-contradictory",
                f"{chosen} and {file.name} state different {difference}; {chosen.name} is used",
            )
    return found


def _difference(one: Calibration, other: Calibration) -> str:
    """The quantity on which two calibrations differ, in words; empty if they may be of one rig.

    The focal length of a rectified rig may differ from that of its raw cameras.
    """
    if abs(other.baseline / one.baseline - 1) > MAX_DIFFERENCE:
        return f"baselines ({one.baseline:g} and {other.baseline:g})"
    focal, other_focal = (float(each.left.matrix[0, 0]) for each in (one, other))
    if not (one.is_rectified and other.is_rectified):
        return ""
    is_other = abs(other_focal / focal - 1) > MAX_DIFFERENCE
    return f"focal lengths ({focal:g} and {other_focal:g} px)" if is_other else ""


def _of_document(path: Path, document: Document) -> Calibration:
    if is_ros(document):
        return ros(*_two_sides(path))
    for fits, read in (
        (chains.is_kalibr, chains.kalibr),
        (chains.is_okvis, chains.okvis),
        (chains.is_orbslam, chains.orbslam),
    ):
        if fits(document):
            return read(document)
    if chains.is_vins(document):
        return chains.vins(document, path.parent)
    return opencv(_with_partner(path, document))


def _two_sides(path: Path) -> tuple[Document, Document]:
    """The documents of a left and a right file, given either of them."""
    for left, right in PARTNERS:
        for here, there in ((left, right), (right, left)):
            partner = path.with_name(path.name.replace(here, there))
            if here in path.name and partner.is_file():
                files = (path, partner) if here == left else (partner, path)
                left_document, right_document = map(read_document, files)
                return named_as_ros(left_document), named_as_ros(right_document)
    raise InputError(
        f"{path} contains one ROS camera, but there is no file of the other side beside it "
        "(left.yaml and right.yaml)"
    )


def _with_partner(path: Path, document: Document) -> Document:
    """Intrinsics with the extrinsics beside them, or vice versa."""
    has_step, has_cameras = "R" in document and "T" in document, is_opencv(document)
    if has_step and "M1" in document:
        return document
    for here, there in (("intrinsic", "extrinsic"), ("extrinsic", "intrinsic")):
        partner = path.with_name(path.name.replace(here, there))
        missing = not has_step if here == "intrinsic" else True
        if here in path.name and missing and partner.is_file():
            return {**read_document(partner), **document}
    if not has_cameras and not has_step:
        raise KeyError(f"K1 or M1: it is not a known calibration ({KINDS})")
    return document


def _first(path: Path, cameras: Cameras | None) -> tuple[Path, Calibration]:
    """The calibration of a folder and its file: calib.txt, or the first that is one.

    Raises
    ------
    InputError
        If there is none.
    """
    if (usual := path / "calib.txt").is_file():
        return usual, read_calibration(usual, cameras)
    faults = []
    for file in _candidates(path):
        try:
            return file, read_calibration(file, cameras)
        except InputError as error:
            faults.append((file, str(error)))
    raise InputError(_none_found(path, faults))


def _candidates(path: Path) -> list[Path]:
    """The files of a folder that may be calibrations, the most likely first."""
    files = [
        file
        for file in sorted(path.iterdir() if path.is_dir() else [])
        if file.suffix.lower() in ENDINGS and file.is_file() and file.name[0] != "."
    ]
    return sorted(files, key=_likelihood, reverse=True)


def _likelihood(file: Path) -> tuple[bool, bool]:
    """A sorting key: names with "calib" last, before them structured files, then plain text."""
    return "calib" in file.name.lower(), file.suffix.lower() != ".txt"


def _none_found(path: Path, faults: list[tuple[Path, str]]) -> str:
    likely = [fault for file, fault in faults if "calib" in file.name.lower()] or [
        fault for file, fault in faults if file.suffix.lower() in (".yaml", ".yml", ".xml")
    ]
    if likely:
        return likely[0]
    unknown = [file.name for file in sorted(path.iterdir()) if file.suffix.lower() in UNKNOWN]
    if unknown:
        return f"{path}: {_unknown(unknown[0])}"
    return f"{path} holds no calibration: calib.txt or a YAML file is needed"


def _unknown(name: str) -> str:
    """The message about a file of another kind."""
    return f"{name} is not a calibration of a known kind ({KINDS}); write it as one of them"
