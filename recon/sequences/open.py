"""One door to recordings of every form."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from importlib.metadata import entry_points
from pathlib import Path

from recon.errors import InputError
from recon.records import PairSource, StereoPair
from recon.sequences.calibration.refinement import StraightenedPairs, row_residual
from recon.sequences.frames import DerivedSource
from recon.sequences.odometry.odometry import EstimatedPoses
from recon.sequences.readers.bag import is_bag, open_bag
from recon.sequences.readers.euroc import is_euroc, open_euroc
from recon.sequences.readers.folder import is_folder, open_folder
from recon.sequences.readers.kitti import is_kitti, open_kitti
from recon.sequences.readers.pair_dir import is_pair_dir, open_pair_dir
from recon.sequences.readers.ring import is_ring, open_ring
from recon.sequences.readers.simulated import is_simulated, open_simulated
from recon.sequences.readers.video import is_video, open_video
from recon.sequences.region import RegionSource
from recon.settings import SequenceSettings


@dataclass(frozen=True, slots=True, kw_only=True)
class Reader:
    """How one form of recording is known and opened.

    Plug-ins name an object of this kind in the entry-point group `recon.sequences`.
    """

    fits: Callable[[Path], bool]
    """Whether a path holds this form, told by what is in it."""
    open: Callable[[Path, SequenceSettings], PairSource]


READERS = {  # tried in this order: a ring may have images called like a pair's
    "folder": Reader(fits=is_folder, open=open_folder),
    "kitti": Reader(fits=is_kitti, open=open_kitti),
    "euroc": Reader(fits=is_euroc, open=open_euroc),
    "ring": Reader(fits=is_ring, open=open_ring),
    "middlebury": Reader(fits=is_pair_dir, open=open_pair_dir),
    "video": Reader(fits=is_video, open=open_video),
    "bag": Reader(fits=is_bag, open=open_bag),
    "simulated": Reader(fits=is_simulated, open=open_simulated),
}


def open_sequence(path: Path, settings: SequenceSettings) -> DerivedSource:
    """The pairs of a recording, read one at a time as they are asked for.

    They are rectified, posed and cut to the region as the settings say, in recon's world (y up).
    Where the first pairs show that rows do not quite correspond, the right images are resampled.

    Raises
    ------
    InputError
        Where nothing is at `path`, no reader knows it, or nothing of it can be used.
    """
    recording = _recording(Path(path), settings)
    source: DerivedSource
    if settings.poses == "estimated":
        source = EstimatedPoses(recording)
    else:
        source = StraightenedPairs(recording, row_residual)
    if settings.poses == "given":
        source = PosedPairs(source)
    return source if settings.roi is None else RegionSource(source, settings.roi)


class PosedPairs(DerivedSource):
    """The pairs of a recording that has poses; without, a single pair needs none."""

    def __iter__(self) -> Iterator[StereoPair]:
        for number, pair in enumerate(self.source):
            if number and pair.T_world_left is None:
                raise InputError(
                    f"{pair.name} has no pose, but all pairs need one to be put together: add "
                    "poses.txt, or take --poses estimated or --poses none"
                )
            yield pair


def _recording(path: Path, settings: SequenceSettings) -> PairSource:
    if not path.exists():
        raise InputError(f"{path} does not exist, but a recording is needed")
    readers = READERS | _plug_ins()
    if settings.format != "auto":
        if settings.format not in readers:
            raise InputError(
                f"format is {settings.format!r}, but one of {', '.join(readers)} is needed"
            )
        return readers[settings.format].open(path, settings)
    for reader in readers.values():
        if reader.fits(path):
            return reader.open(path, settings)
    raise InputError(f"{path} is no recording that is known ({', '.join(readers)})")


def _plug_ins() -> dict[str, Reader]:
    return {entry.name: entry.load() for entry in entry_points(group="recon.sequences")}
