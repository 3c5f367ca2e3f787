"""Kinds learned from clouds, maps and objects of runs, into a catalogue."""

import re
from pathlib import Path
from typing import Any

import numpy as np
import tomli_w

from recon.errors import InputError
from recon.files import atomic_path, check_target
from recon.files.documents import read_toml
from recon.recognition.clouds import gathered
from recon.recognition.naming.catalogue import read_catalogue
from recon.recognition.naming.descriptors import Learned
from recon.recognition.naming.kinds import NAME_NEED, may_be_named
from recon.recognition.naming.kinds import Kind as Entry
from recon.recognition.naming.learning import Lesson, learn
from recon.recognition.recognition import recognise
from recon.records import PointCloud, Voxels
from recon.runs.arguments import check_distinct, text, texts, word
from recon.runs.job import Job, Kind, Numbers
from recon.runs.recognise import read_scene
from recon.runs.work import Work
from recon.settings import RecognitionSettings, Settings

LEAST_CELLS = 30
"""Minimum number of cells of an example; fewer show no surface."""


def read_example(text: str, settings: Settings) -> Voxels:
    """The cells of an example: all of a cloud or a map, or the object ID of "RUN#ID".

    Raises
    ------
    InputError
        If the run has no such object, or the example is too small.
    """
    name, mark, number = text.rpartition("#")
    whole = re.fullmatch(r"\d+", number) is None or not mark
    scene = read_scene(Path(text if whole else name), settings)
    if not whole and isinstance(scene.data, PointCloud):
        raise InputError(f"{text}: {name} is a cloud, but only a run has objects to refer to")
    if not len(scene.data):
        raise InputError(f"{text} has no points, but {LEAST_CELLS} cells are needed to learn")
    cells = gathered(scene.data) if isinstance(scene.data, PointCloud) else scene.data
    if not whole:
        found = recognise(cells, _settings_of(Path(name), settings), scene.T_world_left)
        if int(number) >= len(found.objects):
            numbers = ", ".join(str(one.id) for one in found.objects) or "none"
            raise InputError(f"{text}: the objects of {name} are {numbers}")
        cells = cells.select(np.flatnonzero(found.label == int(number)))
    if len(cells) < LEAST_CELLS:
        raise InputError(f"{text} has {len(cells)} cells, but {LEAST_CELLS} are needed to learn")
    return cells


def _settings_of(run: Path, settings: Settings) -> RecognitionSettings:
    from recon.runs.reading import read_settings
    from recon.runs.recognise import run_of

    folder = run_of(run)
    return settings.recognition if folder is None else read_settings(folder).recognition


def _learn(job: Job, work: Work) -> Numbers:
    """Learn a kind and put it into a catalogue, replacing one of the same name."""
    name, target = str(job.arguments["name"]), Path(str(job.arguments["catalogue"]))
    texts: tuple[str, ...] = job.arguments["examples"]
    check_distinct(map(Path, texts))
    check_target(target, overwrite=True)  # a catalogue is added to
    if not may_be_named(name):
        raise InputError(f"name is {name!r}, but {NAME_NEED}")
    kinds = read_catalogue(target) if target.exists() else ()
    entries: list[dict[str, Any]] = read_toml(target)["object"] if kinds else []
    others: dict[str, Learned] = {
        kind.name: kind.learned for kind in kinds if kind.learned and kind.name != name
    }
    if any(kind.name == name and not kind.learned for kind in kinds):
        raise InputError(f"{target}: {name!r} already exists with parts; another name is needed")
    with work.stage("learn"):
        examples = [read_example(text, job.settings) for text in texts]
        lesson = learn(name, examples, others, job.settings.recognition.unit)
    kept = [entry for entry in entries if entry.get("name") != name]
    with atomic_path(target) as temporary:
        document = {"object": [*kept, _as_toml(Entry(name=name, learned=lesson.learned))]}
        temporary.write_text(tomli_w.dumps(document), encoding="utf-8")
    return _report(name, target, lesson)


def _as_toml(kind: Entry) -> dict[str, Any]:
    assert kind.learned is not None
    groups = {
        name: {"scale": group.scale, "examples": [list(row) for row in group.examples]}
        for name, group in kind.learned.groups.items()
    }
    learned: dict[str, Any] = {"threshold": kind.learned.threshold, "groups": groups}
    if kind.learned.unit:
        learned["unit"] = kind.learned.unit
    return {"name": kind.name, "learned": learned}


def _report(name: str, target: Path, lesson: Lesson) -> Numbers:
    return {
        "name": name,
        "catalogue": str(target),
        "num_examples": lesson.num_examples,
        "threshold": lesson.learned.threshold,
        "highest_probability": lesson.learned.ceiling,
        "descriptors": [
            {"name": group.name, "used": group.used, "reason": group.reason}
            for group in lesson.groups
        ],
    }


LEARN = Kind(
    run=_learn, num_inputs=None, takes={"name": word, "catalogue": text, "examples": texts}
)
