"""Synthetic pairs with exact truth: textured planes seen by two cameras."""

import cv2
import numpy as np


def textured_pair(shape=(120, 160), slope=(0.02, 0.01), middle=8.0, noise=1.5, seed=0, row_shift=0):
    """Render left and right uint8 images of a slanted plane, and the left disparity."""
    height, width = shape
    rng = np.random.default_rng(seed)
    white = rng.normal(size=(height, 2 * width)).astype(np.float32)
    texture = sum(cv2.GaussianBlur(white, (0, 0), s) * s for s in (1, 2, 4))
    texture = 128 + texture / texture.std() * 40
    v, u = np.indices(shape, dtype=np.float32)
    a, b = slope
    # The right pixel of a left one lies at u - d(u, v), with d linear in u and v.
    of_right = (u + middle - a * width / 2 + b * (v - height / 2)) / (1 - a)
    left = cv2.remap(texture, u + width / 2, v, cv2.INTER_LANCZOS4)
    right = cv2.remap(
        texture, (of_right + width / 2).astype(np.float32), v - row_shift, cv2.INTER_LANCZOS4
    )
    truth = middle + a * (u - width / 2) + b * (v - height / 2)
    return *(noisy(x, noise, rng) for x in (left, right)), truth.astype(np.float64)


def noisy(image, noise, rng):
    """Add noise of a standard deviation to an image, as uint8."""
    return np.clip(np.rint(image + rng.normal(0, noise, image.shape)), 0, 255).astype(np.uint8)


def step_pair(near=12, far=4, shape=(120, 200), seed=5):
    """Render a finely textured near square before a far wall, with the left truth."""
    rng = np.random.default_rng(seed)

    def texture(mean):
        noise = cv2.GaussianBlur(rng.normal(size=(shape[0], 2 * shape[1])), (0, 0), 1.2)
        return mean + 60 * noise / noise.std() * 0.4

    wall, square = texture(90), texture(170)
    rows, columns = slice(30, 90), slice(80, 140)
    left, right = wall[:, : shape[1]].copy(), wall[:, far : far + shape[1]].copy()
    left[rows, columns] = square[rows, columns]
    right[rows, columns.start - near : columns.stop - near] = square[rows, columns]
    truth = np.full(shape, float(far))
    truth[rows, columns] = near
    return left.clip(0, 255).astype(np.uint8), right.clip(0, 255).astype(np.uint8), truth


def truth_at(truth, matches):
    u, v = matches.points_px.astype(int).T
    return truth[v, u]
