"""Points on solids in their own upright frame, for the tests of fits."""

import numpy as np


def rotation(rng):
    """Draw a random rotation (3, 3)."""
    q, r = np.linalg.qr(rng.normal(size=(3, 3)))
    q *= np.sign(np.diag(r))
    return q if np.linalg.det(q) > 0 else -q


def frustum(rng, bottom, top, height, count):
    """Sample an open frustum from z = 0 upwards uniformly."""
    share = rng.uniform(size=count)
    rho = np.sqrt(bottom**2 + share * (top**2 - bottom**2))
    z = share if bottom == top else (rho - bottom) / (top - bottom)
    turn = rng.uniform(0, 2 * np.pi, count)
    return np.column_stack([rho * np.cos(turn), rho * np.sin(turn), height * z])


def ball(rng, radii, count):
    """Sample points on an ellipsoid around the origin."""
    unit = rng.normal(size=(count, 3))
    return unit / np.linalg.norm(unit, axis=1, keepdims=True) * radii


def box(rng, sizes, count):
    """Sample the faces of a box around the origin uniformly."""
    sizes = np.asarray(sizes, float)
    areas = np.prod(sizes) / sizes
    face = rng.choice(3, count, p=areas / areas.sum())
    points = rng.uniform(-0.5, 0.5, (count, 3))
    points[np.arange(count), face] = rng.choice([-0.5, 0.5], count)
    return points * sizes


def make(kind, rng, count=400):
    """Sample points on a solid of a kind, of typical size."""
    makers = {
        "sphere": lambda: ball(rng, 2.0, count),
        "ellipsoid": lambda: ball(rng, [3.0, 2.0, 1.2], count),
        "cylinder": lambda: frustum(rng, 1.5, 1.5, 4.0, count),
        "cone": lambda: frustum(rng, 2.0, 0.0, 3.0, count),
        "truncated cone": lambda: frustum(rng, 2.5, 1.0, 3.0, count),
        "plane": lambda: np.column_stack([rng.uniform(-2, 2, (count, 2)), np.zeros(count)]),
        "box": lambda: box(rng, [2.0, 3.0, 4.0], count),
    }
    return makers[kind]()
