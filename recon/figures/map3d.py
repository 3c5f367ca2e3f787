"""The map in 3D (thesis figure 27): the exposed faces of its cells in their colours."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from recon.figures import frame, names, scales
from recon.figures.canvas import QUIET, Sheet, Size
from recon.figures.cover import Cover
from recon.figures.partition import cells_of
from recon.figures.scene import Scene, box_of
from recon.figures.viewpoint import Box, Viewpoint, check, viewpoint
from recon.records import UNKNOWN, FoundObject, Voxels

Array = NDArray[np.float64]
SIZE: Size = (1200, 900)

PALE = 0.12
"""Opacity of the cells over which solids are drawn."""
UNITS = "world units"


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Standpoint:
    """Viewpoint of a 3D figure by name, and the unit of its lengths."""

    view: str = "default"
    """As accepted by `viewpoint`."""
    first: Array | None = None
    """(4, 4) pose of the first camera in the world, for the views from that camera."""
    unit: str = UNITS

    def __post_init__(self) -> None:
        check(self.view)

    def viewpoint(self, box: Box, size: Size) -> Viewpoint:
        """The camera that shows a box in an image of `size` pixels."""
        return viewpoint(self.view, box, size, self.first)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Stage:
    """The bounding box of a 3D figure, and the unit of its lengths."""

    box: Box
    unit: str
    with_numbers: bool = True


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Drawn:
    """Content of a 3D figure."""

    voxels: Voxels
    objects: tuple[FoundObject, ...]
    unit: str
    with_numbers: bool = True

    @property
    def box(self) -> Box:
        """Lowest and highest corner of cells and named objects."""
        return whole_box(self.voxels, self.objects)


def map3d(
    voxels: Voxels,
    objects: Sequence[FoundObject] = (),
    *,
    standpoint: Standpoint | None = None,
    with_solids: bool = False,
    title: str | None = None,
    with_numbers: bool = True,
    sheet: Sheet | None = None,
) -> Any:
    """The occupied cells, with the names of the objects above them.

    Parameters
    ----------
    voxels : Voxels
    objects : sequence of FoundObject
    standpoint : Standpoint, optional
    with_solids : bool
        Draw the objects' fitted solids instead of opaque cells.
    title : str, optional
        By default a description of the map.
    with_numbers : bool
        Number the edges of the box; the grid spacing is stated in any case.
    sheet : Sheet, optional

    Returns
    -------
    matplotlib Figure

    Raises
    ------
    InputError
        For an unknown view.
    """
    standpoint = standpoint or Standpoint()
    sheet = sheet or Sheet.of(SIZE)
    axes = space_axes(
        sheet, heading(voxels, standpoint.unit) if title is None else title, with_bar=False
    )
    if not len(voxels):
        return sheet.figure
    scene = Scene(frame.axes_size(axes))
    drawn = Drawn(
        voxels=voxels, objects=tuple(objects), unit=standpoint.unit, with_numbers=with_numbers
    )
    if with_solids:
        scene.add_cells(voxels, PALE)
        scene.add_solids(objects, voxels)
    else:
        scene.add_cells(voxels)
    camera = standpoint.viewpoint(drawn.box, frame.axes_size(axes))
    _draw(sheet, axes, scene, camera, drawn)
    return sheet.figure


def valued(
    voxels: Voxels,
    values: Array,
    label: str,
    *,
    standpoint: Standpoint | None = None,
    is_log: bool = False,
    sheet: Sheet | None = None,
) -> Any:
    """The occupied cells coloured by values (K,), with a colour bar."""
    standpoint = standpoint or Standpoint()
    sheet = sheet or Sheet.of(SIZE)
    axes = space_axes(sheet, f"Map: {label}", with_bar=True)
    if not len(voxels):
        return sheet.figure
    scale = scales.coloured(values, scales.COUNT, is_log=is_log)
    scene = Scene(frame.axes_size(axes))
    scene.add_cells(replace(voxels, colours=scales.rgb(scale, values)))
    drawn = Drawn(voxels=voxels, objects=(), unit=standpoint.unit)
    camera = standpoint.viewpoint(drawn.box, frame.axes_size(axes))
    _draw(sheet, axes, scene, camera, drawn)
    _add_bar(sheet, scale, (label, is_log), values)
    return sheet.figure


def heading(voxels: Voxels, unit: str) -> str:
    """The title of a map: number and size of its cells."""
    one = unit.removesuffix("s") if voxels.cell_size == 1.0 else unit
    return f"Map: {len(voxels):,} occupied cells of {voxels.cell_size:g} {one}"


def whole_box(voxels: Voxels, objects: Sequence[FoundObject]) -> Box:
    """The box of cells and named objects."""
    low, high = box_of(voxels)
    named = [found for found in objects if found.label != UNKNOWN]
    low = np.min([low, *(found.centre - found.size / 2.0 for found in named)], axis=0)
    high = np.max([high, *(found.centre + found.size / 2.0 for found in named)], axis=0)
    return low, high


def space_axes(sheet: Sheet, title: str, *, with_bar: bool) -> Any:
    """Axes that leave room for a title above and, if wanted, a colour bar to the right."""
    width, height = sheet.size
    sheet.place_by_hand()
    top = 1.9 * sheet.line_px / height if sheet.style.with_title and title else 0.0
    right = 7.0 * sheet.line_px / width if with_bar else 0.0
    axes = sheet.figure.add_axes((0.0, 0.0, 1.0 - right, 1.0 - top))
    sheet.dress(axes)
    axes.set_axis_off()
    if top:
        place = (0.6 * sheet.line_px / width, 1.0 - 0.5 * sheet.line_px / height)
        sheet.figure.text(*place, title, ha="left", va="top", fontsize=1.1 * sheet.font_size)
    return axes


def _draw(sheet: Sheet, axes: Any, scene: Scene, view: Viewpoint, drawn: Drawn) -> None:
    """Render a scene over its grid into axes, number the grid and name the objects."""
    size = frame.axes_size(axes)
    at = view.project(drawn.voxels.centres, size)
    at = at[at[:, 2] > 0]
    pixels = view.pixels_per_unit(at[:, 2], size) * drawn.voxels.cell_size
    cover = Cover(at[:, :2], 0.75 * pixels, size)
    stage = Stage(box=drawn.box, unit=drawn.unit, with_numbers=drawn.with_numbers)
    show_scene(sheet, axes, (scene, view), stage, cover)
    _name(sheet, axes, drawn, view, cover)


def show_scene(
    sheet: Sheet, axes: Any, seen: tuple[Scene, Viewpoint], stage: Stage, cover: Cover
) -> None:
    """Render a scene over the grid of its floor into axes, and number the grid."""
    scene, view = seen
    width, height = frame.axes_size(axes)
    scene.add_lines(frame.floor_lines(stage.box), max(1.0, width / 900))
    image = scene.image(view, is_clear=sheet.style.background == "transparent")
    axes.imshow(image, extent=(0, width, height, 0), aspect="auto", interpolation="none")
    axes.set(xlim=(0, width), ylim=(height, 0))
    numbered = frame.add_numbers(sheet, axes, stage.box, view, cover) if stage.with_numbers else []
    note = f"{', '.join(numbered)} in {stage.unit}" if numbered else ""
    grid = f"grid {frame.step_of(stage.box):g} {stage.unit}"
    axes.text(width - 0.6 * sheet.line_px, height - 0.5 * sheet.line_px,
              "; ".join(filter(None, (note, grid))), ha="right", va="bottom", color=QUIET,
              fontsize=0.85 * sheet.font_size)  # fmt: skip


def _name(sheet: Sheet, axes: Any, drawn: Drawn, view: Viewpoint, cover: Cover) -> None:
    """Write every named object's name beside it in the image."""
    size = frame.axes_size(axes)
    named = [found for found in drawn.objects if found.label != UNKNOWN]
    boxes = [_image_box(drawn.voxels, found, view, size) for found in named]
    texts = [
        names.Name(text=found.label, box=box)
        for found, box in zip(named, boxes, strict=True)
        if box is not None
    ]
    names.write(sheet, axes, texts, cover)


def _image_box(voxels: Voxels, found: FoundObject, view: Viewpoint, size: Size) -> Array | None:
    """Left, top, right and bottom of an object's cells in the image; None if it has none."""
    at = view.project(cells_of(voxels, found).centres, size)
    at = at[(at[:, 2] > 0) & (at[:, :2] >= 0).all(axis=1) & (at[:, :2] <= size).all(axis=1), :2]
    if not len(at):
        return None
    return np.concatenate([at.min(axis=0), at.max(axis=0)])


def _add_bar(sheet: Sheet, scale: Any, numbers: tuple[str, bool], values: Array) -> None:
    label, is_log = numbers
    width, _ = sheet.size
    line = sheet.line_px
    place = (1.0 - 6.2 * line / width, 0.2, 0.9 * line / width, 0.6)
    low, high = scale.get_clim()
    bar = sheet.figure.colorbar(
        scale, cax=sheet.figure.add_axes(place), extend=scales.beyond(values, low, high)
    )
    if is_log:
        scales.plain_numbers(bar)
    sheet.dress_bar(bar, label)
