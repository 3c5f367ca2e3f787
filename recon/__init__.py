"""recon reconstructs objects from stereo sequences.

The public Python interface: every name here is loaded when first used.

match_pair, process_pair     two images -> matches; a pair -> the map
open_sequence, World         sources of pairs: a recording, a simulated world
Mapper                       the loop from pairs to a map, one pair at a time
reconstruct, explore         a whole recording; a whole world
locate                       the pose of a pair in a known map
VoxelMap, recognise, fit     cells that count points; named objects; one solid of one cloud
PartitionedMap               a map larger than memory, in a folder, loaded on demand
read, write                  clouds and maps in files of many formats
Job, execute, Events         what the command line calls
register                     your own plug-ins, by name
"""

import importlib
from typing import TYPE_CHECKING, Any

from recon.environment import prepare as _prepare

_prepare()

if TYPE_CHECKING:
    from recon.camera import StereoRig as StereoRig
    from recon.errors import InputError as InputError
    from recon.errors import MissingLibraryError as MissingLibraryError
    from recon.errors import ReconError as ReconError
    from recon.exploration.controllers import Controller as Controller
    from recon.exploration.explorable import Explorable as Explorable
    from recon.exploration.outcome import Exploration as Exploration
    from recon.exploration.state import State as State
    from recon.exports.formats import read as read
    from recon.exports.formats import write as write
    from recon.exports.partitions.partitioned import PartitionedMap as PartitionedMap
    from recon.localisation.locate import locate as locate
    from recon.mapping.mapper import Mapper as Mapper
    from recon.mapping.mapper import Step as Step
    from recon.mapping.pair import PairResult as PairResult
    from recon.mapping.pair import match_pair as match_pair
    from recon.mapping.pair import process_pair as process_pair
    from recon.plugins import register as register
    from recon.recognition.fitting.outliers import fit as fit
    from recon.records import Box as Box
    from recon.records import Cone as Cone
    from recon.records import Cylinder as Cylinder
    from recon.records import DisparityMap as DisparityMap
    from recon.records import Ellipsoid as Ellipsoid
    from recon.records import Features as Features
    from recon.records import FitFailure as FitFailure
    from recon.records import FoundObject as FoundObject
    from recon.records import Image as Image
    from recon.records import Matches as Matches
    from recon.records import Mesh as Mesh
    from recon.records import Part as Part
    from recon.records import Plane as Plane
    from recon.records import PointCloud as PointCloud
    from recon.records import PoseEstimate as PoseEstimate
    from recon.records import Recognition as Recognition
    from recon.records import Reconstruction as Reconstruction
    from recon.records import Sphere as Sphere
    from recon.records import StereoPair as StereoPair
    from recon.records import Trajectory as Trajectory
    from recon.records import TruncatedCone as TruncatedCone
    from recon.records import View as View
    from recon.records import Voxels as Voxels
    from recon.runs.api import explore as explore
    from recon.runs.api import open_sequence as open_sequence
    from recon.runs.api import recognise as recognise
    from recon.runs.api import reconstruct as reconstruct
    from recon.runs.api import rectifier as rectifier
    from recon.runs.events import Cancelled as Cancelled
    from recon.runs.events import Events as Events
    from recon.runs.execute import execute as execute
    from recon.runs.job import Job as Job
    from recon.runs.report import Report as Report
    from recon.settings import MatchingSettings as MatchingSettings
    from recon.settings import SequenceSettings as SequenceSettings
    from recon.settings import Settings as Settings
    from recon.stereo.dense.dense import match_dense as match_dense
    from recon.stereo.matching.matching import ImageMatcher as ImageMatcher
    from recon.version import __version__ as __version__
    from recon.voxelmap import VoxelMap as VoxelMap
    from recon.world.world import World as World
else:
    # A type checker that saw this function would accept any name as existing.
    def __getattr__(name: str) -> Any:
        if name not in _HOME_OF:
            raise AttributeError(f"recon has no {name}, but {', '.join(_HOME_OF)}")
        value = getattr(importlib.import_module(_HOME_OF[name]), name)
        globals()[name] = value
        return value


_HOMES = {
    "camera": "StereoRig",
    "errors": "InputError MissingLibraryError ReconError",
    "exploration.controllers": "Controller",
    "exploration.explorable": "Explorable",
    "exploration.outcome": "Exploration",
    "exploration.state": "State",
    "exports.formats": "read write",
    "exports.partitions.partitioned": "PartitionedMap",
    "localisation.locate": "locate",
    "mapping.mapper": "Mapper Step",
    "mapping.pair": "PairResult match_pair process_pair",
    "recognition.fitting.outliers": "fit",
    "records": "Box Cone Cylinder DisparityMap Ellipsoid Features FitFailure FoundObject Image "
    "Matches Mesh Part Plane PointCloud PoseEstimate Recognition Reconstruction Sphere StereoPair "
    "Trajectory TruncatedCone View Voxels",
    "runs.api": "explore open_sequence recognise reconstruct rectifier",
    "runs.events": "Cancelled Events",
    "runs.execute": "execute",
    "runs.job": "Job",
    "runs.report": "Report",
    "stereo.dense.dense": "match_dense",
    "plugins": "register",
    "settings": "MatchingSettings SequenceSettings Settings",
    "stereo.matching.matching": "ImageMatcher",
    "version": "__version__",
    "voxelmap": "VoxelMap",
    "world.world": "World",
}
_HOME_OF = {name: f"recon.{home}" for home, names in _HOMES.items() for name in names.split()}

__all__ = sorted(_HOME_OF)


def __dir__() -> list[str]:
    return sorted(__all__)
