"""Make recon's own textures: seamless 256 x 256 images, the same bytes every time.

    python tools/make_textures.py            writes recon/world/shipped/*.png

A texture covers 16 x 16 world units, so 16 texels are one unit. Phase stereo at 10 to 20 units
needs wavelengths of 4 to 12 px, or 6 to 20 texels; each image has most of its contrast there.
Leaves and grass are green, wood brown, brick red, roof slate blue: hues that distinguish parts.
"""

from collections.abc import Callable
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray

SIZE = 256
FOLDER = Path(__file__).parents[1] / "recon" / "world" / "shipped"

Array = NDArray[np.float64]
RGB = tuple[float, float, float]


def noise(rng: np.random.Generator, wave_u: float, wave_v: float) -> Array:
    """Seamless noise of mean 0 and deviation 1 about one wavelength (texels) along each axis."""
    frequency_v, frequency_u = np.meshgrid(
        np.fft.fftfreq(SIZE), np.fft.fftfreq(SIZE), indexing="ij"
    )
    radius = np.hypot(frequency_u * wave_u, frequency_v * wave_v)
    band = np.exp(-0.5 * (np.log(np.maximum(radius, 1e-9)) / 0.45) ** 2)
    spectrum = np.fft.fft2(rng.standard_normal((SIZE, SIZE))) * band
    image = np.fft.ifft2(spectrum).real
    return image / image.std()


def grain(rng: np.random.Generator, wave_u: float, wave_v: float) -> Array:
    """Noise of a wavelength and its double, 0 to 1."""
    mixed = noise(rng, wave_u, wave_v) + 0.6 * noise(rng, 2 * wave_u, 2 * wave_v)
    return 1.0 / (1.0 + np.exp(-1.4 * mixed))


def blend(dark: RGB, light: RGB, share: Array) -> Array:
    """Colours between two, (H, W, 3)."""
    return np.array(dark) + (np.array(light) - np.array(dark)) * share[..., None]


def coordinates() -> tuple[Array, Array]:
    """Texel coordinates u (columns) and v (rows), (H, W)."""
    v, u = np.mgrid[:SIZE, :SIZE].astype(np.float64)
    return u, v


def tiles(width: int, height: int, shift: bool) -> tuple[Array, NDArray[np.int64]]:
    """Distance to the nearest joint (texels) and number of the tile, rows shifted by half."""
    u, v = coordinates()
    row = (v // height).astype(np.int64)
    moved = (u + (row % 2) * (width // 2) * shift) % SIZE
    column = (moved // width).astype(np.int64)
    joint = np.minimum.reduce(
        [moved % width, width - 1 - moved % width, v % height, height - 1 - v % height]
    )
    return joint, row * (SIZE // width) + column


def tiled(
    rng: np.random.Generator, size: tuple[int, int], colours: tuple[RGB, RGB], joint_rgb: RGB
) -> Array:
    """Shifted tiles, each of its own tone, with joints."""
    joint, number = tiles(*size, shift=True)
    tone = rng.random(number.max() + 1)[number]
    face = blend(*colours, 0.45 * tone + 0.55 * grain(rng, 8, 8))
    return np.where((joint < 1.5)[..., None], np.array(joint_rgb), face)


def checker(rng: np.random.Generator) -> Array:
    """Black and white squares, slightly worn so that each is different."""
    u, v = coordinates()
    square = ((u // 16 + v // 16) % 2).astype(np.float64)
    return blend((25, 25, 25), (235, 235, 235), 0.75 * square + 0.25 * grain(rng, 10, 10))


def wood(rng: np.random.Generator) -> Array:
    """Bark: brown, in long upright ridges."""
    return blend((52, 30, 12), (178, 118, 62), grain(rng, 8, 22))


def brick(rng: np.random.Generator) -> Array:
    """Red bricks in courses."""
    return tiled(rng, (32, 16), ((128, 34, 22), (214, 92, 66)), (196, 176, 166))


def grass(rng: np.random.Generator) -> Array:
    """Green blades."""
    return blend((14, 62, 10), (122, 196, 60), grain(rng, 8, 11))


def roof(rng: np.random.Generator) -> Array:
    """Blue slates."""
    return tiled(rng, (16, 16), ((34, 52, 108), (112, 142, 212)), (18, 24, 52))


def sky(rng: np.random.Generator) -> Array:
    """Clouds on blue."""
    return blend((120, 168, 228), (246, 248, 252), grain(rng, 48, 32))


def earth(rng: np.random.Generator) -> Array:
    """Clods of ochre."""
    return blend((84, 66, 20), (206, 176, 84), grain(rng, 12, 12))


def cobra(rng: np.random.Generator) -> Array:
    """A snake's skin: olive lozenges with dark seams."""
    u, v = coordinates()
    lozenge = np.abs(np.sin(np.pi * (u + v) / 16) * np.sin(np.pi * (u - v) / 16))
    return blend((38, 34, 12), (206, 190, 92), 0.6 * lozenge + 0.4 * grain(rng, 9, 9))


def bubinga(rng: np.random.Generator) -> Array:
    """Red heartwood, veined along."""
    return blend((92, 24, 26), (198, 92, 82), grain(rng, 9, 30))


def leaves(rng: np.random.Generator) -> Array:
    """A crown's foliage: green clumps with deep gaps."""
    return blend((8, 48, 14), (104, 190, 72), grain(rng, 10, 10) ** 1.3)


def marble(rng: np.random.Generator) -> Array:
    """Near white, with grey veins."""
    vein = np.exp(-np.abs(noise(rng, 20, 20)) * 4.0)
    return blend((236, 234, 230), (96, 98, 106), np.clip(0.8 * vein + 0.3 * grain(rng, 8, 8), 0, 1))


MAKERS: tuple[Callable[[np.random.Generator], Array], ...] = (
    checker, wood, brick, grass, roof, sky, earth, cobra, bubinga, leaves, marble,
)  # fmt: skip


def main() -> None:
    """Write all textures."""
    FOLDER.mkdir(exist_ok=True)
    for seed, maker in enumerate(MAKERS):
        # Steps of 4 grey levels are invisible, and halve the file sizes.
        image = np.round(maker(np.random.default_rng(seed)) / 4.0) * 4.0
        pixels = np.clip(image, 0, 255).astype(np.uint8)
        path = FOLDER / f"{maker.__name__}.png"
        cv2.imwrite(str(path), pixels[..., ::-1], [cv2.IMWRITE_PNG_COMPRESSION, 9])


if __name__ == "__main__":
    main()
