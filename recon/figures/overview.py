"""One sheet of a run: what the eye saw, what was matched, the map with its names, the floor."""

from collections.abc import Mapping

from recon.figures.canvas import INK, Image, Size, new_figure, to_image

SIZE: Size = (1600, 1000)


def overview(images: Mapping[str, Image], size: Size = SIZE) -> Image:
    """Up to four images side by side: the large one first, the others in a column.

    Parameters
    ----------
    images : mapping of str to (H, W, 3) uint8
        By their titles, the large one first.
    """
    figure = new_figure(size)
    rows = max(len(images) - 1, 1)
    grid = figure.add_gridspec(rows, 2, width_ratios=(1.0 * rows, 1.0))
    for number, (title, image) in enumerate(images.items()):
        place = grid[:, 0] if number == 0 else grid[number - 1, 1]
        axes = figure.add_subplot(place)
        axes.imshow(image, cmap="gray" if image.ndim == 2 else None)
        axes.set_axis_off()
        axes.set_title(title, color=INK, fontsize=11, loc="left")
    return to_image(figure)
