"""The output folder of a command: written whole or not at all, described by a manifest."""

import json
import shutil
import time
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Self

from recon.errors import InputError
from recon.files import atomic_path, remove_temporaries
from recon.locks import locked
from recon.manifest import (
    MANIFEST,
    PARTIAL,
    RunPlan,
    is_finished,
    outputs,
    read_manifest,
    versions,
)


@dataclass(frozen=True, slots=True)
class EarlierRun:
    """The run that a new one replaces, kept beside the new one until that has finished."""

    path: Path
    """Of the new run."""
    is_finished: Callable[[Path], bool] = is_finished
    """True for a folder that is worth more than an unfinished one."""

    @property
    def place(self) -> Path:
        """The folder in which it is kept."""
        return self.path.with_name(f".{self.path.name}.before")

    def put_aside(self) -> None:
        """Make room for the new run; of two earlier ones, a finished one is kept."""
        if self.is_finished(self.place) and not self.is_finished(self.path):
            shutil.rmtree(self.path)
            return
        self.remove()
        self.path.rename(self.place)

    def restore(self) -> None:
        """Put it back in place of the new run, which need not exist."""
        shutil.rmtree(self.path, ignore_errors=True)
        self.place.rename(self.path)

    def remove(self) -> None:
        """Remove it, if there is one."""
        shutil.rmtree(self.place, ignore_errors=True)


@dataclass(slots=True, kw_only=True)
class RunFolder:
    """An open run; `write_text` and `write_json` write files atomically."""

    path: Path
    plan: RunPlan
    identity: dict[str, Any]
    """The plan's identity, computed once: its inputs may be many and large."""
    seconds: dict[str, float] = field(default_factory=dict)
    """Wall time by stage, for the manifest."""
    state: str = "running"
    is_finished: bool = False
    """True if an earlier call finished the same run: nothing is left to do."""
    replaces: bool = False
    """True if this run replaces an existing one."""

    @classmethod
    def prepare(cls, path: Path, plan: RunPlan, *, overwrite: bool, resume: bool) -> Self:
        """The folder of a run, refused if it contains another one.

        Raises
        ------
        InputError
            If `path` exists and neither flag was given, or if the run to resume has different
            settings, seed or inputs.
        """
        check_flags(path, overwrite=overwrite, resume=resume)
        path = named(path)
        run = cls(path=path, plan=plan, identity=plan.identity())
        if resume and path.exists():
            _check_same(path, run.identity)
            run.is_finished = is_finished(path)
        elif path.exists():
            _check_replaceable(path, plan.inputs)
            run.replaces = True
        return run

    @contextmanager
    def opened(self) -> Iterator[Self]:
        """Create the folder and record the final state on exit.

        A replaced run is kept beside the new one until that has finished, and restored if it fails.
        A run that fails on bad input leaves no folder behind. While it is open, no other process
        can open it.

        Raises
        ------
        InputError
            If another process has it open.
        OSError
            With the name of a file or of the folder, for instance if the disk is full.
        """
        self.path.parent.mkdir(parents=True, exist_ok=True)
        busy = f"{self.path} is being written by another process; wait for it, or give another -o"
        earlier = EarlierRun(self.path)
        with locked(self.path, busy):
            if self.replaces:
                earlier.put_aside()
            is_new = not self.path.exists()
            try:
                self.path.mkdir(exist_ok=True)
                yield from self._filled()
            except BaseException as error:
                self._fail(error, earlier, is_new)
                if isinstance(error, OSError) and error.errno and error.filename is None:
                    # A write to a file that is open, as on a full disk, does not name it.
                    raise OSError(error.errno, error.strerror, str(self.path)) from error
                raise
            earlier.remove()

    def _filled(self) -> Iterator[Self]:
        """Write the files common to all runs, before and after the block."""
        remove_temporaries(self.path)
        # First: without it, the folder is not recognised as a run that can be resumed.
        self._write_manifest()
        self.write_text("settings.toml", self.plan.settings_toml)
        began = time.perf_counter()
        yield self
        self.seconds["total"] = time.perf_counter() - began
        if self.state == "running":
            self.state = "finished"
            shutil.rmtree(self.path / PARTIAL, ignore_errors=True)
        self._write_manifest()

    def _fail(self, error: BaseException, earlier: EarlierRun, is_new: bool) -> None:
        """Restore the earlier run if there is one, else record the error in the manifest."""
        is_cut = isinstance(error, KeyboardInterrupt)
        if is_new and not is_cut and earlier.place.exists():
            earlier.restore()
        elif is_new and isinstance(error, InputError):
            shutil.rmtree(self.path)
        else:
            self.state = "interrupted" if is_cut else "failed"
            with suppress(OSError):  # on a full disk, report the first error
                self._write_manifest(error=str(error))

    def interrupt(self) -> None:
        """Record that the run stopped early on purpose and can be resumed."""
        self.state = "interrupted"

    @property
    def partial(self) -> Path:
        """Folder of the data needed to resume; removed once the run is finished."""
        folder = self.path / PARTIAL
        folder.mkdir(exist_ok=True)
        return folder

    def write_text(self, name: str, text: str) -> None:
        """Write one text file atomically."""
        with atomic_path(self.path / name) as part:
            part.write_text(text, encoding="utf-8")

    def write_json(self, name: str, document: object) -> None:
        """Write one JSON file atomically."""
        self.write_text(name, json.dumps(document, indent=2, allow_nan=False) + "\n")

    def _write_manifest(self, error: str | None = None) -> None:
        document = self.identity | {
            "state": self.state,
            "error": error,
            "input_paths": [str(path.resolve()) for path in self.plan.inputs],
            "versions": versions(),
            "outputs": outputs(self.path),
            "seconds": {stage: round(s, 3) for stage, s in self.seconds.items()},
        }
        self.write_json(MANIFEST, document)


def check_flags(path: Path | None, *, overwrite: bool, resume: bool) -> None:
    """Refuse a folder that exists, and flags without a folder or contrary to each other."""
    if overwrite and resume:
        raise InputError("overwrite and resume exclude each other: give one of them")
    if path is None and (overwrite or resume):
        raise InputError(f"{'overwrite' if overwrite else 'resume'} needs a run folder: give -o")
    if path is not None and path.exists() and not (overwrite or resume):
        raise InputError(f"{path} exists; give --overwrite, --resume, or another -o")
    if path is not None:
        _check_folders(path)


def _check_folders(path: Path) -> None:
    """Raise `InputError` if a folder that is to hold the path is something else."""
    holder = next(parent for parent in path.absolute().parents if parent.exists())
    if not holder.is_dir():
        raise InputError(f"output is {path}, but {holder} is not a folder; give another -o")


def check_none_inside(path: Path, inputs: Iterable[Path]) -> None:
    """Raise `InputError` if replacing a folder would delete an input."""
    for source in inputs:
        place = source.resolve()
        if source.exists() and path.resolve() in [place, *place.parents]:
            raise InputError(f"{source} lies in {path} and would be deleted with it")


def named(path: Path) -> Path:
    """The same folder by a path that ends in its name, which `.` and `..` do not."""
    return path if path.name not in ("", "..") else path.resolve()


def _check_same(path: Path, identity: dict[str, Any]) -> None:
    """Refuse to resume a run of another identity."""
    manifest = read_manifest(path)
    for name, value in identity.items():
        if manifest.get(name) != value:
            raise InputError(
                f"{path} was made with different {name.removesuffix('_sha256')}; "
                "resume with the same, or give --overwrite"
            )


def _check_replaceable(path: Path, inputs: tuple[Path, ...]) -> None:
    """Refuse to replace a folder that is not a run, or that contains an input."""
    if not path.is_dir():
        raise InputError(f"{path} is not a folder; give another -o")
    if any(path.iterdir()):
        read_manifest(path)
    check_none_inside(path, inputs)
