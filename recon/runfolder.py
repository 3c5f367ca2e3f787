"""The output folder of a command: written whole or not at all, described by a manifest."""

import json
import shutil
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Self

from recon.errors import InputError
from recon.files import atomic_path, remove_temporaries
from recon.locks import locked
from recon.manifest import MANIFEST, RunPlan, digest, is_finished, read_manifest, versions

PARTIAL = "partial"


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
        if path.exists() and not (overwrite or resume):
            raise InputError(f"{path} exists; give --overwrite, --resume, or another -o")
        run = cls(path=path, plan=plan, identity=plan.identity())
        if resume and path.exists():
            run._check_same(read_manifest(path))
        elif path.exists():
            run._check_replaceable()
        return run

    def _check_replaceable(self) -> None:
        """Refuse to replace a folder that is not a run, or that contains an input."""
        if not self.path.is_dir():
            raise InputError(f"{self.path} is not a folder; give another -o")
        if any(self.path.iterdir()):
            read_manifest(self.path)
        for source in self.plan.inputs:
            if self.path.resolve() in [source.resolve(), *source.resolve().parents]:
                raise InputError(f"{source} lies in {self.path} and would be deleted with it")
        self.replaces = True

    def _check_same(self, manifest: dict[str, Any]) -> None:
        for name, value in self.identity.items():
            if manifest.get(name) != value:
                raise InputError(
                    f"{self.path} was made with different {name.removesuffix('_sha256')}; "
                    "resume with the same, or give --overwrite"
                )
        self.is_finished = manifest["state"] == "finished"

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
        with locked(self.path.with_name(f".{self.path.name}.lock"), busy):
            if self.replaces:
                self._put_aside()
            is_new = not self.path.exists()
            self.path.mkdir(exist_ok=True)
            try:
                yield from self._filled()
            except BaseException as error:
                self._fail(error, is_new)
                if isinstance(error, OSError) and error.errno and error.filename is None:
                    # A write to a file that is open, as on a full disk, does not name it.
                    raise OSError(error.errno, error.strerror, str(self.path)) from error
                raise
            shutil.rmtree(self._before, ignore_errors=True)

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

    @property
    def _before(self) -> Path:
        """Folder in which a replaced run is kept."""
        return self.path.with_name(f".{self.path.name}.before")

    def _put_aside(self) -> None:
        """Make room for the new run; of two earlier ones, a finished one is kept."""
        if self._before.exists() and not is_finished(self.path):
            shutil.rmtree(self.path)
            return
        shutil.rmtree(self._before, ignore_errors=True)
        self.path.rename(self._before)

    def _fail(self, error: BaseException, is_new: bool) -> None:
        """Restore the earlier run if there is one, else record the error in the manifest."""
        is_cut = isinstance(error, KeyboardInterrupt)
        if is_new and not is_cut and self._before.exists():
            shutil.rmtree(self.path)
            self._before.rename(self.path)
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
        outputs = sorted(p for p in self.path.rglob("*") if p.is_file() and p.name != MANIFEST)
        document = self.identity | {
            "state": self.state,
            "sources": [str(path.resolve()) for path in self.plan.inputs],
            "error": error,
            "input_paths": [str(path.resolve()) for path in self.plan.inputs],
            "versions": versions(),
            "outputs": {
                path.relative_to(self.path).as_posix(): digest(path)
                for path in outputs
                if PARTIAL not in path.relative_to(self.path).parts
            },
            "seconds": {stage: round(s, 3) for stage, s in self.seconds.items()},
        }
        self.write_json(MANIFEST, document)
