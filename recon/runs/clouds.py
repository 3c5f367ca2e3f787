"""The objects of maps and clouds from files, named."""

from recon.exports.formats import read
from recon.recognition import recognise
from recon.recognition.clouds import Up, recognise_cloud
from recon.records import Voxels
from recon.records.objects import as_json
from recon.runs.fit import as_cloud
from recon.runs.job import Job, Kind, Numbers
from recon.runs.work import Work
from recon.voxelmap import VoxelMap
from recon.voxelmap.occupancy import occupied


def _recognise(job: Job, work: Work) -> Numbers:
    """Name the objects of a map or a cloud; the document of `objects.json`."""
    (path,) = job.inputs
    up: Up = job.arguments.get("up", "y")
    data = read(path)
    if isinstance(data, VoxelMap):
        data = occupied(data, job.settings.map)
    with work.stage("recognise"):
        if isinstance(data, Voxels) and up == "y":
            return dict(as_json(recognise(data, job.settings.recognition)))
        return dict(as_json(recognise_cloud(as_cloud(data), job.settings.recognition, up)))


RECOGNISE = Kind(run=_recognise)
