"""The top and front panes: the mapped cells, and draggable symbols."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from recon.app import marks
from recon.app.looks import name_of, top_of
from recon.records import FoundObject
from recon.settings import WorldSettings

Array = NDArray[np.float64]

GRAB_PX = 22.0
"""Distance at which the mouse grabs a symbol."""
CAMERA, TARGET, WAY = "#e8650a", "#0072b2", "#ffffff"
SKY = (198, 213, 228)
FONT = 12.0
"""Font size of a name in pixels."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class MapPane:
    """A pane of parallel rays: from above (x, z) or from the front (x, y)."""

    name: str
    axes: tuple[int, int]
    """World axes to the right and down; the second goes up in the front pane."""
    origin: Array
    """(2,) world values at the upper left corner of the image."""
    unit: float
    """World units per pixel."""
    is_upward: bool
    size: tuple[int, int]
    """Width and height in pixels."""

    def to_pixels(self, points: Array) -> Array:
        """(N, 2) pixels of world points (N, 3)."""
        at = points[:, list(self.axes)] - self.origin
        return at / self.unit * (1.0, -1.0 if self.is_upward else 1.0)

    def moved(self, point: Array, at: tuple[float, float]) -> Array:
        """The world point after dragging to a pixel; the third coordinate stays."""
        moved = point.copy()
        sign = -1.0 if self.is_upward else 1.0
        moved[self.axes[0]] = self.origin[0] + at[0] * self.unit
        moved[self.axes[1]] = self.origin[1] + sign * at[1] * self.unit
        return moved

    def grabbed(self, at: tuple[float, float], position: Array, target: Array) -> str | None:
        """The symbol grabbed at a pixel: "camera", "target" or None."""
        places = self.to_pixels(np.array([position, target]))
        away = np.hypot(*(places - at).T)
        if away.min() > GRAB_PX:
            return None
        return "camera" if away[0] <= away[1] else "target"

    def symbols(self, position: Array, target: Array, fov_deg: float) -> str:
        """The camera with its field of view, and the target."""
        (u, v), (target_u, target_v) = self.to_pixels(np.array([position, target])).tolist()
        wedge = self._wedge(position, target, fov_deg) if not self.is_upward else ""
        line = (
            f'<line x1="{u:.1f}" y1="{v:.1f}" x2="{target_u:.1f}" y2="{target_v:.1f}" '
            f'stroke="{CAMERA}" stroke-width="1.5" stroke-dasharray="5 4"/>'
        )
        camera = (
            f'<g data-testid="camera-symbol"><circle cx="{u:.1f}" cy="{v:.1f}" r="9" '
            f'fill="{CAMERA}" stroke="#fff" stroke-width="2"/></g>'
        )
        cross = f"M{target_u - 9:.1f},{target_v:.1f}h18M{target_u:.1f},{target_v - 9:.1f}v18"
        goal = (
            f'<g data-testid="target-symbol"><circle cx="{target_u:.1f}" cy="{target_v:.1f}" r="8" '
            f'fill="#fff" fill-opacity=".6" stroke="{TARGET}" stroke-width="2"/>'
            f'<path d="{cross}" stroke="{TARGET}" stroke-width="2"/></g>'
        )
        return wedge + line + goal + camera

    def _wedge(self, position: Array, target: Array, fov_deg: float) -> str:
        ahead = (target - position)[[0, 2]]
        angle = np.arctan2(ahead[1], ahead[0])
        reach = np.linalg.norm(ahead)
        half = np.radians(min(fov_deg, 170.0)) / 2.0
        ends = [
            position + reach * np.array([np.cos(angle + turn), 0.0, np.sin(angle + turn)])
            for turn in (-half, half)
        ]
        at = self.to_pixels(np.array([ends[0], position, ends[1]])).tolist()
        points = " ".join(f"{u:.1f},{v:.1f}" for u, v in at)
        return f'<polygon points="{points}" fill="{CAMERA}" fill-opacity=".18"/>'

    def names(self, objects: tuple[FoundObject, ...], selected: int | None) -> str:
        """The names of the found objects, with a ring around the selected one."""
        return "".join(self._name(found, found.id == selected) for found in objects)

    def _name(self, found: FoundObject, is_selected: bool) -> str:
        place = top_of(found) if self.is_upward else found.centre - 0.5 * found.size
        place[0] = found.centre[0]
        ((u, v),) = self.to_pixels(place[None]).tolist()
        name = marks.text(u, v - 4.0, name_of(found), FONT)
        if not is_selected:
            return name
        ((u, v),) = self.to_pixels(found.centre[None]).tolist()
        return name + marks.ring(u, v, 0.6 * float(found.size.max()) / self.unit, CAMERA)

    def way(self, positions: list[Array]) -> str:
        """The path so far."""
        if len(positions) < 2:
            return ""
        at = self.to_pixels(np.array(positions))
        return marks.polyline(np.column_stack([at, np.ones(len(at))]), WAY, 2.0)

    def with_cells(
        self, image: NDArray[np.uint8], cells: dict[tuple[int, int, int], tuple[int, int, int]],
        cell_size: float,
    ) -> NDArray[np.uint8]:  # fmt: skip
        """The image overlaid with the cells of the map."""
        if not cells:
            return image
        grown = image.copy()
        index = np.array(list(cells), np.float64)
        low = self.to_pixels(index * cell_size)
        high = self.to_pixels((index + 1.0) * cell_size)
        first, last = np.minimum(low, high), np.maximum(low, high)
        start = np.clip(first.round(), 0, self.size).astype(int)
        stop = np.clip(np.maximum(last.round(), first.round() + 1), 0, self.size).astype(int)
        for (left, top), (right, bottom), colour in zip(start, stop, cells.values(), strict=True):
            grown[top:bottom, left:right] = colour
        return grown


def top_pane(floor: WorldSettings, image: NDArray[np.uint8]) -> MapPane:
    """The pane from above."""
    height, width = image.shape[:2]
    return MapPane(
        name="top", axes=(0, 2), origin=np.array([-floor.size_x / 2.0, -floor.size_z / 2.0]),
        unit=floor.size_x / width, is_upward=False, size=(width, height),
    )  # fmt: skip


def front_pane(
    floor: WorldSettings, image: NDArray[np.uint8], height: int
) -> tuple[MapPane, NDArray[np.uint8]]:
    """The pane from the front, its image padded with sky to `height` pixels."""
    rows, width = image.shape[:2]
    above = max(height - rows, 0)
    sky = np.full((above, width, 3), image[0, 0] if rows else SKY, np.uint8)
    filled = np.vstack([sky, image])
    unit = floor.size_x / width
    pane = MapPane(
        name="front", axes=(0, 1),
        origin=np.array([-floor.size_x / 2.0, floor.height + above * unit]),
        unit=unit, is_upward=True, size=(width, above + rows),
    )  # fmt: skip
    return pane, filled
