"""A kind of job: how sharp the images of a recording are."""

from pathlib import Path

import cv2
import numpy as np

from recon.runs.job import Job, Kind, Numbers
from recon.runs.work import Work
from recon.sequences import open_sequence


def measure(job: Job, work: Work) -> Numbers:
    """The median variance of the Laplacian of the left images."""
    source = open_sequence(job.inputs[0], job.settings.sequence)
    variances = []
    with work.stage("reading"):
        for pair in source:
            variances.append(cv2.Laplacian(pair.left, cv2.CV_64F).var())
            work.progress(len(variances), len(source))
    return {"num_pairs": len(variances), "sharpness": float(np.median(variances))}


SHARPNESS = Kind(
    run=measure,
    base=lambda job: {"sequence": {"poses": "none"}},
    folder=lambda job: Path("runs") / f"{job.inputs[0].resolve().name}_sharpness",
    stages=("reading",),
)
