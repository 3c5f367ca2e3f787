"""Job files: tables of jobs, globs and sweeps, read into named jobs."""

import itertools
import math
import os
import re
from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from recon.errors import InputError
from recon.files.documents import read_toml
from recon.runs.arguments import checked
from recon.runs.job import KINDS, Job
from recon.settings import PRESETS, QUALITIES, Settings, merged, updated

JOB_KEYS = ("name", "command", "input", "settings", "seed", "preset", "quality", "arguments")
FILE_KEYS = ("job", "sweep")
CHOICES: dict[str, dict[str, Any]] = {"preset": dict(PRESETS), "quality": dict(QUALITIES.items())}
"""Named sets of settings; later ones take precedence."""
NAME = re.compile(r"[^-./\x00-\x1f\x7f][^/\x00-\x1f\x7f]*")
"""Valid job names, which become folder names."""
SHEETS = re.compile(r"(summary|sweep|contact|confusion).*\.(json|csv|png)|.*\.refined\.json")
"""Names of the files of a batch."""
MAX_NAME = 200
"""Bytes of a name: those of a file system, 255 as a rule, less what names beside it add to it."""
MAX_JOBS = 100_000
"""More jobs would take gigabytes before the first of them begins."""


@dataclass(frozen=True, slots=True, kw_only=True)
class NamedJob:
    """One job of a batch."""

    name: str
    """Name of its run folder."""
    job: Job
    swept: tuple[tuple[str, Any], ...] = ()
    """The settings from a sweep, by "stage.name"."""


def read_jobs(path: Path) -> list[NamedJob]:
    """Every job of a job file, in order, with globs and sweeps expanded.

    Raises
    ------
    InputError
        For an unknown key or command, a value of the wrong type, and two jobs with the same name.
    """
    document: Mapping[str, Any] = read_toml(path)
    _check_keys(document, FILE_KEYS, str(path))
    tables = document.get("job", [])
    if not isinstance(tables, list) or not tables:
        raise InputError(f"{path} has no [[job]] table, but one per job is needed")
    sweep = _sweep(document.get("sweep", {}), path)
    jobs = (
        job
        for number, table in enumerate(tables, 1)
        for job in _jobs_of(table, path.parent, sweep, f"{path}, job {number}")
    )
    return _checked(jobs, str(path))


def jobs_of_glob(pattern: str, command: str) -> list[NamedJob]:
    """One job for each file or folder that matches a pattern."""
    table = {"command": command, "input": pattern}
    return _checked(_jobs_of(table, Path(), (), pattern), pattern)


def _checked(found: Iterable[NamedJob], source: str) -> list[NamedJob]:
    """The jobs, if they are not too many and each can have a folder of its own."""
    jobs = list(itertools.islice(found, MAX_JOBS + 1))
    _check_number(len(jobs), source)
    for job in jobs:
        _check_name(job.name, source)
    for name, number in Counter(job.name for job in jobs).items():
        if number > 1:
            raise InputError(f"{source}: {number} jobs are named {name!r}; give each its own name")
    return jobs


def _check_number(num_jobs: int, source: str) -> None:
    if num_jobs > MAX_JOBS:
        raise InputError(f"{source} has more than {MAX_JOBS} jobs; split it into several batches")


def _check_name(name: str, source: str) -> None:
    if not NAME.fullmatch(name) or SHEETS.fullmatch(name):
        raise InputError(f"{source}: name is {name!r}, but that of a new folder is needed")
    size = len(os.fsencode(name))
    if size > MAX_NAME:
        raise InputError(
            f"{source}: name {name[:40]!r}... has {size} bytes, but at most {MAX_NAME} are possible"
        )


def _check_keys(table: Mapping[str, Any], known: Sequence[str], source: str) -> None:
    for key in table:
        if key not in known:
            raise InputError(
                f"{source}: {key!r} is unknown, but one of {', '.join(known)} is needed"
            )


def _jobs_of(
    table: Any, folder: Path, sweep: tuple[dict[str, Any], ...], source: str
) -> Iterator[NamedJob]:
    """The jobs of one table: one for each match of a glob and each point of a sweep."""
    if not isinstance(table, Mapping):
        raise InputError(f"{source} is {table!r}, but a table is needed")
    _check_keys(table, JOB_KEYS, source)
    command = _command(table, source)
    found = [_matches(word, folder) for word in _words(table, source)]
    if len(found) == 1:
        groups: list[tuple[Path, ...]] = [(path,) for path in found[0]]
    else:
        groups = [tuple(path for paths in found for path in paths)]
    for group in groups:
        name = _name(table, group, len(groups) > 1, source)
        for point in sweep or ({},):
            yield NamedJob(
                name="-".join([name, *(_word(key, value) for key, value in point.items())]),
                job=_job(table, command, group, point, folder, source),
                swept=tuple(point.items()),
            )


def _word(key: str, value: Any) -> str:
    """A swept value in the name of a folder."""
    return f"{key}={value}".replace("/", "_")


def _job(
    table: Mapping[str, Any],
    command: str,
    inputs: tuple[Path, ...],
    point: Mapping[str, Any],
    folder: Path,
    source: str,
) -> Job:
    return Job(
        kind=command,
        inputs=inputs,
        arguments=_arguments(table, command, folder, source),
        settings=_settings(table, point, source),
        seed=_seed(table, source),
    )


def _arguments(table: Mapping[str, Any], command: str, folder: Path, source: str) -> dict[str, Any]:
    """The arguments of a command; paths are relative to the folder of the job file."""
    given = _table(table, "arguments", source)
    if not given:  # loading the command takes a second
        return given
    try:
        found = checked(command, given, KINDS.load(command).takes)
    except InputError as error:
        raise InputError(f"{source}: {error}") from error
    return {
        name: folder / value if isinstance(value, Path) else value for name, value in found.items()
    }


def _settings(table: Mapping[str, Any], point: Mapping[str, Any], source: str) -> Settings:
    """Preset, quality, the table's own settings and the sweep's; later ones take precedence."""
    tree: Mapping[str, Any] = {}
    for key in CHOICES:
        if key in table:
            tree = merged(tree, _choice(_text(table, key, source), key, source))
    for changes in (_table(table, "settings", source), point):
        tree = merged(tree, changes)
    return updated(Settings(), tree, source)


def _table(table: Mapping[str, Any], key: str, source: str) -> dict[str, Any]:
    given = table.get(key, {})
    if not isinstance(given, Mapping):
        raise InputError(f"{source}: {key} is {given!r}, but a table is needed")
    return dict(given)


def _choice(word: str, key: str, source: str) -> Mapping[str, Any]:
    """The settings of a preset or of a quality."""
    known = CHOICES[key]
    if word not in known:
        raise InputError(f"{source}: {key} is {word!r}, but one of {', '.join(known)} is needed")
    tree: Mapping[str, Any] = known[word]
    return tree


def _sweep(table: Any, path: Path) -> tuple[dict[str, Any], ...]:
    """Every combination of the values of a sweep."""
    if not isinstance(table, Mapping):
        raise InputError(f"{path}: sweep is {table!r}, but a table is needed")
    flat = {
        f"{stage}.{name}": value
        for stage, values in merged(table).items()
        for name, value in _table({stage: values}, stage, f"{path}: sweep").items()
    }
    for key, values in flat.items():
        if not isinstance(values, list) or not values:
            raise InputError(f"{path}: sweep of {key} is {values!r}, but a list is needed")
    _check_number(math.prod(len(values) for values in flat.values()), str(path))
    return tuple(
        dict(zip(flat, point, strict=True)) for point in itertools.product(*flat.values()) if flat
    )


def _words(table: Mapping[str, Any], source: str) -> list[str]:
    given = table.get("input")
    words: list[Any] = given if isinstance(given, list) else [given]
    if not words or not all(isinstance(word, str) and word for word in words):
        raise InputError(f"{source}: input is {given!r}, but a path or a list is needed")
    return words


def _matches(word: str, folder: Path) -> list[Path]:
    """Paths for a word: a path, a glob or a shipped name, relative to a folder.

    A missing path is kept: only its job fails.
    """
    path = folder / word
    if path.exists() or not any(mark in word for mark in "*?["):
        is_shipped = path.name == word and not path.exists() and not Path(word).exists()
        # The worker, which loads the command, checks whether recon ships a recording of that name.
        return [Path(word) if is_shipped else path]
    root = Path(path.anchor or ".")
    pattern = str(path.relative_to(root)) if path.anchor else str(path)
    try:
        found = sorted(one for one in root.glob(pattern) if not one.name.startswith("."))
    except ValueError as error:
        raise InputError(f"{word} is not a pattern: {error}") from error
    if not found:
        raise InputError(f"{word} matches no file or folder in {folder.resolve()}")
    return found


def _name(
    table: Mapping[str, Any], inputs: tuple[Path, ...], is_one_of_many: bool, source: str
) -> str:
    own = table.get("name")
    if own is not None and not isinstance(own, str):
        raise InputError(f"{source}: name is {own!r}, but a word is needed")
    stem = inputs[0].resolve().name if inputs[0].is_dir() else inputs[0].stem
    return stem if own is None else f"{own}-{stem}" if is_one_of_many else own


def _command(table: Mapping[str, Any], source: str) -> str:
    command = _text(table, "command", source)
    try:
        KINDS.check(command)
    except InputError as error:
        raise InputError(f"{source}: {error}") from error
    return command


def _text(table: Mapping[str, Any], key: str, source: str) -> str:
    if key not in table:
        raise InputError(f"{source} has no {key}, but a word is needed")
    value = table[key]
    if not isinstance(value, str):
        raise InputError(f"{source}: {key} is {value!r}, but a word is needed")
    return value


def _seed(table: Mapping[str, Any], source: str) -> int:
    seed = table.get("seed", 0)
    if not isinstance(seed, int) or isinstance(seed, bool) or seed < 0:
        raise InputError(f"{source}: seed is {seed!r}, but a whole number >= 0 is needed")
    return seed
