"""A job: everything that determines the result of a run."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, Self

from recon.errors import InputError, check_number, check_type
from recon.manifest import RunPlan
from recon.plugins import Registry
from recon.runs.arguments import Argument, checked
from recon.settings import Settings, given_tree, merged, to_toml, updated

if TYPE_CHECKING:
    from recon.runs.work import Work

Tree = Mapping[str, Mapping[str, Any]]
Numbers = dict[str, Any]
"""Results of a job by the keys of its JSON document."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Job:
    """One call of a command, before or after its defaults are filled in.

    Parameters
    ----------
    kind : str
        Name of the command: "explore", "reconstruct", "disparity", ...
    inputs : tuple of Path
        The inputs.
    arguments : mapping
        Further arguments of the command, by the names in `Kind.takes`; a path is an input, too.
    settings : Settings
        Values not given follow from the kind and its inputs.
    """

    kind: str
    inputs: tuple[Path, ...] = ()
    arguments: Mapping[str, Any] = field(default_factory=dict)
    settings: Settings = field(default_factory=Settings)
    seed: int = 0

    def __post_init__(self) -> None:
        KINDS.check(self.kind)
        check_type("settings", self.settings, Settings)
        check_number("seed", self.seed, low=0)
        check_type("arguments", self.arguments, Mapping)
        inputs = (self.inputs,) if isinstance(self.inputs, str | Path) else self.inputs
        check_type("inputs", inputs, tuple, list)
        object.__setattr__(self, "inputs", tuple(Path(path) for path in inputs))

    def located(self) -> Self:
        """The same job with its inputs found and its arguments checked; none is read."""
        kind = KINDS.load(self.kind)
        kind.check_inputs(self)
        return replace(
            self,
            inputs=tuple(kind.find(path) for path in self.inputs),
            arguments=checked(self.kind, self.arguments, kind.takes),
        )

    def resolved(self) -> Self:
        """The same job with every default filled in, for which inputs may be read."""
        found = self.located()
        return replace(found, settings=resolve(found))

    def files(self) -> tuple[Path, ...]:
        """All files read: inputs, paths among the arguments, models and catalogues."""
        named = [value for value in self.arguments.values() if isinstance(value, Path)]
        words = [self.settings.matching.model, *self.settings.recognition.catalogue]
        models = [Path(word) for word in words if word is not None and Path(word).is_file()]
        return (*self.inputs, *named, *KINDS.load(self.kind).reads(self), *models)

    def plan(self) -> RunPlan:
        """The plan that the job's run folder has to match."""
        return RunPlan(
            command=self.kind,
            arguments={
                name: value.name if isinstance(value, Path) else value
                for name, value in self.arguments.items()
            },
            settings_toml=to_toml(self.settings),
            seed=self.seed,
            inputs=self.files(),
        )

    def identity(self) -> dict[str, Any]:
        """Everything that determines the result of the run, files by their content."""
        return self.plan().identity()


@dataclass(frozen=True, slots=True, kw_only=True)
class Kind:
    """One kind of job: its function and its defaults."""

    run: Callable[[Job, "Work"], Numbers]
    """Does the work, and returns the content of `metrics.json` and `--json`."""
    num_inputs: int | None = 1
    """Number of inputs; None = one or more."""
    base: Callable[[Job], Tree] = lambda job: {}
    """The settings that the kind and its inputs suggest, by stage and name."""
    find: Callable[[Path], Path] = lambda path: path
    """The file that an input refers to, possibly one shipped with recon."""
    takes: Mapping[str, Argument] = field(default_factory=dict)
    """Arguments besides inputs and settings, by name."""
    reads: Callable[[Job], tuple[Path, ...]] = lambda job: ()
    """Further files that are read."""
    folder: Callable[[Job], Path | None] = lambda job: None
    """The default run folder; None = no folder is written."""
    stages: tuple[str, ...] = ()
    """Stages that `seconds` of metrics.json always contains."""
    judged: Callable[[Job, Path], list[tuple[str, str]]] = lambda job, run_path: []
    """True names of the objects of a finished run, each with its assigned name."""

    def check_inputs(self, job: Job) -> None:
        """Raise `InputError` unless a job has as many inputs as its kind needs."""
        given = len(job.inputs)
        if given != (self.num_inputs if self.num_inputs is not None else max(given, 1)):
            need = "1 or more" if self.num_inputs is None else self.num_inputs
            raise InputError(f"{job.kind} has {given} inputs, but {need} are needed")


KINDS: Registry[Kind] = Registry(
    "recon.jobs",
    "kind of job",
    {
        "explore": "recon.runs.explore:EXPLORE",
        "reconstruct": "recon.runs.reconstruct:RECONSTRUCT",
        "disparity": "recon.runs.disparity:DISPARITY",
        "evaluate": "recon.runs.evaluate:EVALUATE",
        "trajectory": "recon.runs.trajectory:TRAJECTORY",
        "worlds": "recon.runs.worlds:WORLDS",
        "merge": "recon.runs.merge:MERGE",
        "recognise": "recon.runs.recognise:RECOGNISE",
        "learn": "recon.runs.learn:LEARN",
        "render": "recon.runs.render:RENDER",
        "localise": "recon.runs.localise:LOCALISE",
        "mesh": "recon.runs.mesh:MESH",
        "dense": "recon.runs.judged_dense:DENSE",
        "surface": "recon.runs.judged_surfaces:SURFACE",
    },
)
"""Every kind by name; a new kind needs its file and a line here."""


def resolve(job: Job) -> Settings:
    """The settings of a job: suggestions of its kind and inputs, overridden by given values."""
    base = KINDS.load(job.kind).base(job)
    return updated(Settings(), merged(base, given_tree(job.settings)), job.kind)
