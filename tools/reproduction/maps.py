"""Figures 25 to 32 and the table of parameters: the explorer, its maps and its objects."""

import json
import tempfile
from collections.abc import Iterator
from functools import cache, partial
from pathlib import Path

from matplotlib.figure import Figure

from recon.cli import main
from recon.settings import Settings, with_preset
from recon.settings.reference import reference
from recon.world.library import find_scene
from recon.world.world import World
from reproduction.drawing import sheet, show
from reproduction.entry import Entry, Result, Row, number, table

WORK = Path(tempfile.mkdtemp(prefix="recon-reproduce-"))
SAME = "The same, by recon's own controller in a third of the pairs; the thesis's beside it."
TABLE: dict[str, tuple[str, str]] = {
    "eyes.width": ("ImWidth", "256"), "eyes.height": ("ImHeight", "256"),
    "world.size_x": ("WorldX", "200"), "world.size_z": ("WorldY (the depth)", "200"),
    "world.height": ("WorldZ (the height)", "30"), "map.cell_size": ("GridSize", "1"),
    "eyes.baseline": ("BaseLine", "0.3"), "eyes.focal_length": ("FocalLength", "0.1"),
    "eyes.fov_deg": ("FOV", "80"), "eyes.far": ("Far", "100"), "eyes.near": ("Near", "0.1"),
    "matching.max_disparity": ("MaxDisparity", "20"),
    "matching.min_disparity": ("MinDisparity", "-10"),
    "matching.max_row_offset_px": ("RowPermission", "1"),
    "map.min_count": ("CountThreshold", "5"),
    "recognition.hue_tolerance_deg": ("ColorThreshold_Hue", "7.0"),
    "exploration.object_turn_deg": ("ObjectTurnAngle", "40"),
    "exploration.robot_turn_deg": ("RobotTurnAngle", "45"),
    "exploration.clearance": ("ObjectClearance", "10"),
}  # fmt: skip


def entries() -> Iterator[Entry]:
    """List the entries of this part."""
    yield Entry(
        name="figure 25", title="States of the controller", make=_states,
        thesis="Meets, turns round an object, turns on the spot, heads for the unexplored.",
        difference="Drawn from a walk of the controller `thesis`: which activity followed which.",
    )  # fmt: skip
    yield Entry(
        name="figure 26", title="Flow of the map construction", make=_flow,
        thesis="View, disparity, map, decision, next view.",
        difference="The stages that a run reports, with the time each took.",
    )  # fmt: skip
    yield Entry(
        name="figure 27", title="The map of the village", difference=SAME,
        thesis="The cells whose belief of being occupied is high.",
        make=partial(_run_figures, "village", ("map3d",)),
    )  # fmt: skip
    for figure, label in ((28, "apple tree"), (29, "pine tree")):
        yield Entry(
            name=f"figure {figure}", title=f"Parts of the {label}s", difference=SAME,
            thesis=f"The cells of an {label} by hue, its top and its body.",
            make=partial(_run_figures, "village", ("parts",)),
        )  # fmt: skip
    yield Entry(
        name="figure 30", title="Labelled occupancy of the village", difference=SAME,
        thesis="Every object has its right label.",
        make=partial(_run_figures, "village", ("labels",)),
    )  # fmt: skip
    for figure, scene in ((31, "three_kinds"), (32, "three_apples")):
        yield Entry(
            name=f"figure {figure}", title=f"The world {scene}", difference=SAME,
            thesis="Map construction and recognition are completed: every object has its label.",
            make=partial(_run_figures, scene, ("map3d", "labels")),
        )  # fmt: skip
    yield Entry(
        name="table of parameters", title="Parameters of the program", make=_parameters,
        thesis="21 parameters, the same in all runs.",
        difference="--preset thesis takes them to the letter; recon's own defaults stand beside.",
    )  # fmt: skip


@cache
def _run(scene: str, preset: str) -> Path:
    """Explore a scene, once."""
    folder = WORK / f"{scene}-{preset}"
    controller = ["--controller", "thesis"] if preset == "thesis" else []
    code = main(["explore", str(find_scene(scene)), "-o", str(folder), "-q", *controller])
    if code:
        raise RuntimeError(f"exploring {scene} ended with exit code {code}")
    return folder


def _run_figures(scene: str, kinds: tuple[str, ...]) -> Result:
    world = World.from_file(find_scene(scene), Settings())
    figure, axes = sheet(2)
    show(axes[0], world.top_view(), "the world from above")
    show(axes[1], world.front_view(), "and from the front")
    run = _run(scene, "default")
    images = tuple(
        path for kind in kinds for path in sorted((run / "figures").glob(f"{kind}*.png"))[:1]
    )
    return Result(figures=(figure,), images=images, tables=(_objects(scene, world),))


def _objects(scene: str, world: World) -> object:
    """Tabulate found and true objects, for both controllers."""
    rows: list[Row] = []
    for preset, title in (("default", "recon"), ("thesis", "controller thesis")):
        run = _run(scene, preset)
        metrics = json.loads((run / "metrics.json").read_text())
        found = json.loads((run / "objects.json").read_text())["objects"]
        labels = sorted(one["label"] for one in found)
        true = sorted(one.label for one in world.objects)
        right = sum(min(labels.count(label), true.count(label)) for label in set(true))
        rows.append((
            title, f"{right} of {len(true)}", str(metrics["num_pairs"]),
            number(metrics["path_length"], 0), metrics["stop_reason"],
        ))  # fmt: skip
    return table(("controller", "labels right", "pairs", "path, units", "ended"), rows)


def _states() -> Result:
    from reproduction.controller import transitions

    counts = transitions("three_kinds")
    return Result(
        figures=(_graph(counts),),
        tables=(table(("from", "to", "times"), [(a, b, str(n)) for (a, b), n in counts.items()]),),
    )


def _graph(counts: dict[tuple[str, str], int]) -> Figure:
    """Draw states in a ring, with arrows as thick as they were frequent."""
    import numpy as np

    names = sorted({name for pair in counts for name in pair})
    angles = np.linspace(0.0, 2.0 * np.pi, len(names), endpoint=False) + np.pi / 2.0
    place = {name: (np.cos(a), np.sin(a)) for name, a in zip(names, angles, strict=True)}
    figure, axes = sheet(1, width=5.5, height=5.0)
    for (a, b), count in counts.items():
        if a != b:
            axes[0].annotate(
                "", place[b], place[a],
                arrowprops={"arrowstyle": "-|>", "lw": 1 + np.log1p(count), "shrinkA": 34,
                            "shrinkB": 34, "connectionstyle": "arc3,rad=0.15"},
            )  # fmt: skip
    style = {"ha": "center", "va": "center", "fontsize": 9}
    for name, (x, y) in place.items():
        text = f"{name}\n({counts.get((name, name), 0)} repeats)"
        axes[0].text(x, y, text, bbox={"boxstyle": "round", "fc": "#eef4fa"}, **style)
    axes[0].set(xlim=(-1.6, 1.6), ylim=(-1.4, 1.4))
    axes[0].set_axis_off()
    return figure


def _flow() -> Result:
    seconds = json.loads((_run("village", "default") / "metrics.json").read_text())["seconds"]
    rows = [(stage, number(s, 2)) for stage, s in seconds.items()]
    return Result(tables=(table(("stage", "seconds, village"), rows),))


def _parameters() -> Result:
    known = {one.name: one for one in reference()}
    thesis = with_preset(Settings(), "thesis")
    rows = []
    for name, (printed, value) in TABLE.items():
        stage, _, field = name.partition(".")
        ours = getattr(getattr(thesis, stage), field)
        rows.append((printed, value, name, str(ours), str(known[name].default)))
    head = ("parameter", "thesis", "setting", "preset thesis", "recon's default")
    return Result(tables=(table(head, rows),))
