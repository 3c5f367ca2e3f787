"""Video files: left.* and right.*, or one file with both views side by side."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path

import cv2
import numpy as np

from recon.errors import InputError
from recon.libraries import silent
from recon.records import StereoPair
from recon.sequences.calibration.files import read_calibration
from recon.sequences.calibration.rectification import Rectifier, rectifier
from recon.sequences.depth import Image
from recon.sequences.frames import Frame, Recording, Skipped
from recon.sequences.readers.folder import find_times, given_poses
from recon.sequences.readers.reader import Reader
from recon.sequences.timestamps import FramePose, list_frame_poses
from recon.settings import SequenceSettings

ENDINGS = {".mp4", ".avi", ".mkv", ".mov", ".webm", ".m4v", ".mpg"}
MAX_FRAMES = 1 << 24
USUAL_RATE_HZ = 30.0
"""Frame rate of a file that does not state one."""


def is_video(path: Path) -> bool:
    """True if `path` is a video, or contains left.* and right.*."""
    return path.suffix.lower() in ENDINGS if path.is_file() else bool(_two_files(path))


def open_video(path: Path, settings: SequenceSettings) -> Recording:
    """The recording in `path`; calibration, poses.txt and times.txt are beside the videos."""
    files = [path] if path.is_file() else _two_files(path)
    if not files:
        raise InputError(f"{path} contains no left.* and right.* ({', '.join(sorted(ENDINGS))})")
    folder = files[0].parent
    clips = [_Clip.of(file) for file in files]
    calibration = read_calibration(folder)
    width, height = clips[0].size
    size = (width // 2, height) if len(clips) == 1 else clips[0].size
    num_frames = min(clip.num_frames for clip in clips)
    times = find_times(folder)
    poses = list_frame_poses(
        [f"{number:06d}" for number in range(num_frames)],
        np.arange(num_frames) / clips[0].rate_hz if times is None else times,
        given_poses(folder, settings),
        needs_pose=settings.poses == "given",
    )
    wanted = range(0, num_frames, settings.every)
    frames = _VideoFrames(files, poses, rectifier(calibration, size), wanted)
    return Recording(
        frames, skipped=_surplus(clips, num_frames), disparity_range=calibration.disparity_range
    )


@dataclass(frozen=True, slots=True, kw_only=True)
class _Clip:
    """A video file as described by its header."""

    path: Path
    size: tuple[int, int]
    """(width, height)"""
    num_frames: int
    rate_hz: float

    @classmethod
    def of(cls, path: Path) -> "_Clip":
        video = _opened(path)
        width, height, number, rate = (
            video.get(code)
            for code in (
                cv2.CAP_PROP_FRAME_WIDTH,
                cv2.CAP_PROP_FRAME_HEIGHT,
                cv2.CAP_PROP_FRAME_COUNT,
                cv2.CAP_PROP_FPS,
            )
        )
        if not 0 < number < MAX_FRAMES:
            raise InputError(f"{path} contains no frames")
        return cls(
            path=path,
            size=(int(width), int(height)),
            num_frames=int(number),
            rate_hz=rate if rate > 0 else USUAL_RATE_HZ,
        )


class _VideoFrames:
    """Frames decoded sequentially, in each iteration from the start."""

    def __init__(
        self,
        files: Sequence[Path],
        poses: Sequence[FramePose],
        rectify: Rectifier,
        wanted: Sequence[int],
    ) -> None:
        self._files, self._frame_poses = files, poses
        self._rectify, self._wanted = rectify, wanted

    def __len__(self) -> int:
        return len(self._wanted)

    def __getitem__(self, part: slice) -> "_VideoFrames":
        return _VideoFrames(self._files, self._frame_poses, self._rectify, self._wanted[part])

    def __iter__(self) -> Iterator[Frame]:
        videos = [_opened(file) for file in self._files]
        next_number = 0
        for number in self._wanted:
            # Frames in between are grabbed without conversion: seeking is not exact.
            for _ in range(number - next_number):
                for video in videos:
                    video.grab()
            grabbed = [video for video in videos if video.grab()]
            next_number = number + 1
            at, name = self._frame_poses[number], f"{number:06d}"
            load = partial(self._load, grabbed, at, name)
            yield Frame(name=name, stamp_s=at.stamp_s, load=load)

    def _load(self, videos: list[cv2.VideoCapture], at: FramePose, name: str) -> StereoPair:
        if at.fault:
            raise InputError(at.fault)
        images = [image for found, image in (v.retrieve() for v in videos) if found]
        if len(images) < len(self._files):
            raise InputError("it cannot be decoded: the video is truncated or damaged")
        left, right = images if len(images) == 2 else _halves(images[0])
        return self._rectify.pair(_rgb(left), _rgb(right), at.T_world_left, at.stamp_s, name)


def _halves(image: Image) -> tuple[Image, Image]:
    middle = image.shape[1] // 2
    return image[:, :middle], image[:, middle : 2 * middle]


def _rgb(bgr: Image) -> Image:
    return np.ascontiguousarray(bgr[..., ::-1])


def _surplus(clips: Sequence[_Clip], num_frames: int) -> list[Skipped]:
    """Frames at the end of the longer video, without a partner."""
    return [
        Skipped(f"{number:06d}", f"only {clip.path.name} has it")
        for clip in clips
        for number in range(num_frames, clip.num_frames)
    ]


def _two_files(path: Path) -> list[Path]:
    found = []
    for side in ("left", "right"):
        files = [f for f in sorted(path.glob(f"{side}.*")) if f.suffix.lower() in ENDINGS]
        found += files[:1]
    return found if len(found) == 2 else []


def _opened(path: Path) -> cv2.VideoCapture:
    # OpenCV's AVI parser prints messages about unexpected content.
    with silent():
        video = cv2.VideoCapture(str(path))
    if not video.isOpened():
        raise InputError(f"{path} is not a video that OpenCV can read")
    return video


READER = Reader(fits=is_video, open=open_video)
