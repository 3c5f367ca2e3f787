"""The functions of `import recon` that join several packages."""

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from recon.errors import InputError, check_path
from recon.exploration.agent import explore as lead
from recon.exploration.controllers import Controller, check_controller
from recon.exploration.explorable import Explorable
from recon.exploration.outcome import Exploration, Step
from recon.exports.partitions.partitioned import PartitionedMap
from recon.mapping.mapper import Mapper
from recon.recognition.clouds import Up, recognise_cloud
from recon.recognition.recognition import recognise as name_objects
from recon.records import PointCloud, Recognition, Reconstruction, Voxels
from recon.runs.job import Job
from recon.runs.loops import DriveInMemory
from recon.runs.maps import shown
from recon.sequences import open_sequence as open_pairs
from recon.sequences.calibration.files import read_calibration
from recon.sequences.calibration.rectification import Rectifier
from recon.sequences.calibration.rectification import rectifier as rectifier_of
from recon.sequences.frames import DerivedSource
from recon.settings import Settings, explorers, updated
from recon.voxelmap import VoxelMap


def open_sequence(path: str | Path, **settings: Any) -> DerivedSource:
    """The pairs of a recording, read one at a time as they are asked for.

    Parameters
    ----------
    path : path
        A folder, video, bag or pair of images in any form that `recon reconstruct` reads.
    settings
        As the options of the command line: ``poses="estimated"``, ``every=2``, ``format="kitti"``.

    Returns
    -------
    iterable of StereoPair
        Rectified, with poses where they are known, and the search range where it is stated.
    """
    return open_pairs(checked_path(path), Settings.of(**settings).sequence)


def rectifier(calibration: str | Path, size: tuple[int, int]) -> Rectifier:
    """A rectifier, which makes pairs from the raw images of a rig.

    Parameters
    ----------
    calibration : path
        A calibration in any form that `recon reconstruct` reads.
    size : (width, height)
        Of the raw images, pixels.

    Returns
    -------
    Rectifier
        Its ``pair(left, right)`` gives a `StereoPair`.
    """
    if np.shape(size) != (2,) or not all(isinstance(one, int | np.integer) for one in size):
        raise InputError(f"size is {size!r}, but (width, height) in pixels is needed")
    read = read_calibration(checked_path(calibration))
    return replace(rectifier_of(read, size), disparity_range=read.disparity_range)


def reconstruct(path: str | Path, **settings: Any) -> Reconstruction[VoxelMap]:
    """Reconstruct a recording.

    Parameters
    ----------
    path : path
        As for `open_sequence`.
    settings
        Values by name: ``max_disparity=60``, ``map={"cell_size": 0.1}``, ``quality="fast"``,
        ``settings=Settings(...)``. Values not given follow from the recording.

    Returns
    -------
    Reconstruction
        `map`, its occupied `voxels`, `objects`, `trajectory`.
    """
    given = Settings.of(**settings)
    job = Job(kind="reconstruct", inputs=(checked_path(path),), settings=given).resolved()
    mapper, drive = Mapper(job.settings), DriveInMemory()
    for pair in open_pairs(job.inputs[0], job.settings.sequence):
        steps = mapper.process(pair)
        if job.settings.sequence.poses == "estimated":
            drive.add(pair, steps, mapper)
    drive.close(mapper, mapper.finish())
    return mapper.reconstruction()


def explore(
    source: Explorable,
    settings: Settings | None = None,
    controller: str | Controller = "",
    *,
    observe: Callable[[Step], None] | None = None,
    **values: Any,
) -> Exploration:
    """Let a controller explore a world, or any other source of pairs.

    Parameters
    ----------
    source : World, or any object with ``start()`` and ``take(view)``
        The explored source.
    settings : Settings, optional
        Defaults are those of the explorer: fast matching of disparities around zero.
    controller : str or Controller, optional
        "frontier", "thesis", the name of a plug-in or a controller itself; that of the settings
        where not given.
    observe : callable, optional
        Called with every `Step`.
    values
        More settings by name, as for `reconstruct`.

    Returns
    -------
    Exploration
        Its `reconstruction` holds map, objects and trajectory; complete whatever ended it.
    """
    for method in ("start", "take"):
        if not callable(getattr(source, method, None)):
            raise InputError(
                f"source is {source!r}, but something with start and take is needed, such as "
                "recon.World.from_file(...)"
            )
    chosen = Settings.of(settings, **values)
    if controller and isinstance(controller, str):
        chosen = updated(chosen, {"exploration": {"controller": controller}})
    own = None if isinstance(controller, str) else controller
    if own is not None:
        check_controller(repr(own), own)
    return lead(source, explorers(chosen), observe, controller=own)


def recognise(
    data: VoxelMap | PartitionedMap | Voxels | PointCloud,
    catalogue: str | Path | None = None,
    up: Up = "y",
    **settings: Any,
) -> Recognition:
    """Find and name the objects of a map or a cloud.

    Parameters
    ----------
    data : VoxelMap, PartitionedMap, Voxels or PointCloud
    catalogue : str or path, optional
        A TOML file of names and their rules, or the name of a shipped one.
    up : {"y", "-y", "z", "-z"}
        The direction that is up in `data`.
    settings
        Values by name, as for `reconstruct`.

    Returns
    -------
    Recognition
        `objects`, and a `label` for each cell or point.
    """
    if catalogue is not None:
        settings["recognition.catalogue"] = str(catalogue)
    chosen = Settings.of(**settings)
    if isinstance(data, VoxelMap | PartitionedMap):
        data, _ = shown(data, chosen.map)
    if isinstance(data, Voxels):
        if up == "y":
            return name_objects(data, chosen.recognition)
        data = PointCloud(points=data.means, colours=data.colours)
    if not isinstance(data, PointCloud):
        raise InputError(
            f"data is a {type(data).__name__}, but a VoxelMap, Voxels or a PointCloud is needed"
        )
    return recognise_cloud(data, chosen.recognition, up)


def checked_path(path: str | Path) -> Path:
    """The path; raises `InputError` if it is not one."""
    check_path(path)
    return Path(path)
