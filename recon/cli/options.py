"""Options shared by several commands, and the settings they define."""

import math
import re
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar, TypeVar

import click

import recon
from recon.files import memory_limit, outside_allowed

if TYPE_CHECKING:
    from recon.settings import Settings

Command = TypeVar("Command", bound=Callable[..., Any])


class NamedPath(click.Path):
    """A path; an empty one, as of a shell variable that is not set, would be the current folder."""

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        """The path stated by `value`."""
        if not str(value):
            self.fail("it is empty, but a path is needed", param, ctx)
        return super().convert(value, param, ctx)


PATH = NamedPath(path_type=Path)


class FiniteRange(click.FloatRange):
    """A finite number in a range; click's own accepts NaN."""

    def convert(
        self, value: Any, param: click.Parameter | None, ctx: click.Context | None
    ) -> float:
        """The number stated by `value`."""
        number = float(super().convert(value, param, ctx))
        if not math.isfinite(number):
            self.fail(f"{value!r} is not a finite number.", param, ctx)
        return number


POSITIVE = FiniteRange(min=0, min_open=True)


class MemorySize(click.ParamType[Any]):
    """Bytes, as "4GB", "500 MB" or a plain number of bytes."""

    name = "SIZE"
    _units: ClassVar[dict[str, int]] = {"": 1, "kb": 1 << 10, "mb": 1 << 20, "gb": 1 << 30}

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> int:
        """The number of bytes stated by `value`."""
        match = re.fullmatch(r"([0-9.]+) *([kmg]?b?)", str(value).strip().lower())
        unit = match[2].rstrip("b") + "b" if match and match[2] else ""
        try:
            return int(float(match[1] if match else "") * self._units.get(unit, 1))
        except (ValueError, OverflowError):
            self.fail(f"{value!r}, but a size such as 4GB is needed.", param, ctx)


def _allow_memory(ctx: click.Context, _: click.Parameter, num_bytes: int | None) -> None:
    if num_bytes is not None:
        ctx.with_resource(memory_limit(num_bytes))


def _allow_outside(ctx: click.Context, _: click.Parameter, is_allowed: bool) -> None:
    if is_allowed:
        ctx.with_resource(outside_allowed())


SCENE = [
    click.option(
        "--allow-outside",
        is_flag=True,
        callback=_allow_outside,
        expose_value=False,
        help="Let a scene read textures and meshes outside its folder.",
    ),
]

REPORT = [
    click.option("--json", "as_json", is_flag=True, help="Print one JSON document on stdout."),
    click.option("-q", "--quiet", is_flag=True, help="Print errors only."),
    click.option("-v", "--verbose", is_flag=True, help="Print what is being done."),
    click.version_option(recon.__version__, prog_name="recon"),
]
"""Options of every command."""
OUTPUT = [
    click.option(
        "--max-memory",
        type=MemorySize(),
        callback=_allow_memory,
        expose_value=False,
        help="Largest size a file may unpack to, 4GB by default.",
    ),
    *REPORT,
]
"""Options of every command that reads files of others."""


def _given(
    _context: click.Context, _option: click.Parameter, names: tuple[str, ...]
) -> tuple[str, ...] | None:
    """Values of an option that may be repeated; None if it was not given."""
    return names or None


NAMES = [
    click.option("--recogniser", "recognition__recogniser", help="robust, thesis, or a plug-in."),
    click.option(
        "--catalogue", "recognition__catalogue", multiple=True, callback=_given,
        help="village, household, none, or a TOML file; repeatable.",
    ),
]  # fmt: skip

SETTINGS = [
    click.option("--settings", "settings_file", type=PATH, help="TOML file of settings."),
    click.option(
        "--set", "overrides", multiple=True, metavar="STAGE.NAME=VALUE",
        help="Change a setting (see recon settings); repeatable.",
    ),
    click.option(
        "--preset", type=click.Choice(["default", "thesis"]), default="default",
        help="Settings to start from.",
    ),
]  # fmt: skip


def run_folder(default: str = "runs/NAME") -> list[Callable[[Command], Command]]:
    """Options of a run folder, and of the seed that it depends on."""
    return [
        click.option("-o", "--output", type=PATH, help=f"Run folder, {default} by default."),
        click.option("--overwrite", is_flag=True, help="Replace an existing run."),
        click.option("--resume", is_flag=True, help="Continue an interrupted run."),
        click.option(
            "--seed",
            type=click.IntRange(min=0),
            default=0,
            show_default=True,
            help="Seed of all random numbers.",
        ),
    ]


QUALITY = click.option("--quality", type=click.Choice(["best", "fast"]), help="Accuracy or speed.")

# An option whose name in Python is STAGE__NAME sets that value.
KEEP = click.option(
    "--keep", "matching__keep", type=click.IntRange(min=1), metavar="K",
    help="Keep the K most confident matches.",
)  # fmt: skip
MATCHING = [
    click.option("--matcher", "matching__matcher", help="phase, vonmises, sgbm, or a plug-in."),
    QUALITY,
    KEEP,
]
TRUTH_SCALE = click.option(
    "--truth-scale", type=POSITIVE, help="Grey levels of truth per pixel of disparity."
)

SURFACE_FORM = [
    click.option(
        "--voxel", "surface__voxel", type=POSITIVE, metavar="S",
        help="Voxel size of the surface, world units.",
    ),
    click.option(
        "--watertight", "surface__watertight", is_flag=True, default=None,
        help="Save a closed mesh, extrapolated where nothing was seen.",
    ),
    click.option(
        "--depth", "surface__depth_maps", is_flag=True, default=None,
        help="Save a depth map per pair.",
    ),
]  # fmt: skip
SURFACE = [
    click.option(
        "--dense", "dense__enabled", is_flag=True, default=None,
        help="Match every pixel as well, and save dense.ply.",
    ),
    click.option(
        "--mesh", "surface__mesh", is_flag=True, default=None,
        help="Fuse all pixels into a mesh, mesh.ply.",
    ),
    *SURFACE_FORM,
]  # fmt: skip


def with_options(*groups: list[Callable[[Command], Command]]) -> Callable[[Command], Command]:
    """A decorator that adds the options of all groups, in their order."""

    def decorate(command: Command) -> Command:
        for option in reversed([option for group in groups for option in group]):
            command = option(command)
        return command

    return decorate


def build_settings(given: dict[str, Any]) -> "Settings":
    """Settings in increasing precedence: preset, file, quality, options, --set.

    Values not given follow from the kind of job and its inputs.

    Parameters
    ----------
    given : dict
        The options of a command.
    """
    from recon.files.documents import read_toml
    from recon.settings import Settings, parse_overrides, updated, with_preset
    from recon.settings import with_quality as qualified

    settings = with_preset(Settings(), given["preset"])
    if given["settings_file"] is not None:
        file = given["settings_file"]
        settings = updated(settings, read_toml(file), str(file))
    if given.get("quality") is not None:
        settings = qualified(settings, given["quality"])
    options = {
        name.replace("__", "."): value
        for name, value in given.items()
        if "__" in name and value is not None
    }
    settings = updated(settings, options, "options")
    return updated(settings, parse_overrides(given["overrides"]), "--set")
