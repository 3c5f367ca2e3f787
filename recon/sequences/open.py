"""Opening of recordings of any format."""

import os
from collections.abc import Hashable, Iterator, Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path

from recon.errors import InputError
from recon.geometry import LEVEL_CAMERA
from recon.plugins import Registry, say_once
from recon.records import PairSource, StereoPair
from recon.sequences.calibration.refinement import RefinedPairs, shared_row_residual
from recon.sequences.contradictions.checked import CheckedPairs
from recon.sequences.estimated_poses import EstimatedPoses
from recon.sequences.frames import DerivedSource
from recon.sequences.readers.reader import Reader
from recon.sequences.refined import Refined
from recon.sequences.region import RegionSource
from recon.settings import SequenceSettings

_READERS = "recon.sequences.readers"
READERS: Registry[Reader] = Registry(
    "recon.sequences",
    "format",
    {  # tried in this order: a ring may have images named like those of a pair
        "folder": f"{_READERS}.folder:READER",
        "kitti": f"{_READERS}.kitti:READER",
        "euroc": f"{_READERS}.euroc:READER",
        "ring": f"{_READERS}.ring:READER",
        "middlebury": f"{_READERS}.pair_dir:READER",
        "video": f"{_READERS}.video:READER",
        "bag": f"{_READERS}.bag:READER",
        "simulated": f"{_READERS}.simulated:READER",
    },
)
NESTED_LEVELS = 2
"""Depth to which nested folders are searched for a single recording."""


def open_sequence(
    path: Path,
    settings: SequenceSettings,
    refined: Refined | None = None,
    *,
    checks: bool = True,
) -> DerivedSource:
    """The pairs of a recording, read one at a time on demand.

    They are rectified, posed and cropped as set, in recon's world (y up). If the first pairs show
    that rows do not quite correspond, the right images are resampled.

    Parameters
    ----------
    refined : Refined, optional
        Earlier estimates for the recording: then a part, `source[i:j]`, is read without the pairs
        before it; videos and bags are skipped through without conversion.
    checks : bool
        Report contradictions between the pairs and the metadata, which takes much of the time.

    Raises
    ------
    InputError
        If `path` does not exist, no reader recognises it, or nothing in it is usable.
    """
    recording = open_recorded(path, settings, checks=checks)
    source: DerivedSource
    if refined is not None:
        source = refined.pairs(recording)
    elif settings.poses == "estimated":
        source = EstimatedPoses(recording)
    else:
        source = RefinedPairs(recording, partial(shared_row_residual, _images(path, settings)))
    if settings.poses == "given":
        source = PosedPairs(source)
    elif settings.poses == "none":
        source = UnposedPairs(source)
    return source if settings.roi is None else RegionSource(source, settings.roi)


def open_recorded(path: Path, settings: SequenceSettings, *, checks: bool = True) -> DerivedSource:
    """The pairs as recorded: rectified, in recon's world, without a pose where none is given."""
    recording = RangedPairs(_recording(Path(path), settings))
    if not checks:
        return recording
    return CheckedPairs(recording, has_given_poses=settings.poses == "given")


def _images(path: Path, settings: SequenceSettings) -> Hashable:
    """The images that a recording consists of, however it is posed and cropped."""
    topics = settings.left_topic, settings.right_topic
    return Path(path).resolve(), settings.format, settings.every, topics


class RangedPairs(DerivedSource):
    """Pairs with the search range stated by their recording."""

    def __iter__(self) -> Iterator[StereoPair]:
        for pair in self.source:
            if pair.disparity_range is None:
                yield replace(pair, disparity_range=self.disparity_range)
            else:
                yield pair


class PosedPairs(DerivedSource):
    """The pairs of a recording with poses; a single pair without one is level at the origin."""

    def __init__(self, source: PairSource) -> None:
        super().__init__(source)
        self._is_single = len(source) == 1

    def __iter__(self) -> Iterator[StereoPair]:
        for pair in self.source:
            if pair.T_world_left is None and not self._is_single:
                raise InputError(
                    f"{pair.name} has no pose, but all pairs need one to be combined: add "
                    "poses.txt, or give --poses estimated or --poses none"
                )
            yield _level(pair)


class UnposedPairs(DerivedSource):
    """Pairs without their poses; a single one is level at the origin."""

    def __init__(self, source: PairSource) -> None:
        super().__init__(source)
        self._is_single = len(source) == 1

    def __iter__(self) -> Iterator[StereoPair]:
        for pair in self.source:
            yield _level(pair) if self._is_single else replace(pair, T_world_left=None)


def _level(pair: StereoPair) -> StereoPair:
    """The pair with a pose: its own, else level at the origin, y up."""
    if pair.T_world_left is not None:
        return pair
    return replace(pair, T_world_left=LEVEL_CAMERA)


def _recording(path: Path, settings: SequenceSettings) -> PairSource:
    if not path.exists():
        raise InputError(f"{path} does not exist, but a recording is needed")
    if settings.format != "auto":
        reader = READERS.load(settings.format)
        return _opened(reader, _fitting_path(reader, path), settings)
    found = find_recording(path)
    if found is None:
        known = ", ".join(READERS.names())
        raise InputError(
            f"{path} is not a known recording ({known}); the simplest is a folder with left/, "
            "right/ and calib.txt"
        )
    return _opened(*found, settings)


def _opened(reader: Reader, path: Path, settings: SequenceSettings) -> PairSource:
    topic = settings.left_topic or settings.right_topic
    if topic is not None and not reader.has_topics:
        raise InputError(f"{path} has no topics, but {topic!r} was asked for; only a bag has them")
    return reader.open(path, settings)


def find_recording(path: Path) -> tuple[Reader, Path] | None:
    """The reader that recognises `path` or the only folder in it, and the path of the recording.

    Raises
    ------
    InputError
        If there is more than one recording.
    """
    readers = [*READERS.parts()]  # once: looking for plug-ins takes longer than all tests
    places = [path]
    for _ in range(NESTED_LEVELS + 1):
        found = [(one, place) for place in places if (one := _reader_of(place, readers))]
        if len(found) > 1:
            names = ", ".join(place.name for _, place in found[:3])
            raise InputError(f"{path} contains {len(found)} recordings ({names}, ...): name one")
        if found:
            return found[0]
        places = [inner for place in places for inner in _inside(place)]
    return None


def name_of(reader: Reader) -> str | None:
    """The name of a format, as for `--format`."""
    return next((name for name, one in READERS.parts() if one is reader), None)


def _inside(place: Path) -> list[Path]:
    """The readable folders and regular files in a folder: reading others may never end."""
    inner = sorted(place.iterdir()) if place.is_dir() else []
    return [
        one
        for one in inner
        if one.name[0] != "."
        and (Path(one).is_dir() or Path(one).is_file())
        and os.access(one, os.R_OK)
    ]


def _reader_of(path: Path, readers: Sequence[tuple[str, Reader]]) -> Reader | None:
    """The first reader that recognises a path; failing plug-ins are skipped."""
    for name, reader in readers:
        try:
            if reader.fits(path):
                return reader
        except PermissionError:  # no reader can see more
            raise
        # A third-party package may fail in any way.
        except Exception as error:
            say_once(f"format {name!r} fails ({error}); it is skipped")
    return None


def _fitting_path(reader: Reader, path: Path) -> Path:
    """`path`, or the only entry in it that the reader recognises."""
    if reader.fits(path):
        return path
    inner = [place for place in _inside(path) if reader.fits(place)]
    return inner[0] if len(inner) == 1 else path
