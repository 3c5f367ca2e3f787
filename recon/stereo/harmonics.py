"""Angular harmonics of the steerable filters: responses and energy of all directions at once.

Powers of cosine and sine in Eqs 12 and 13 become sums of cosines and sines of multiples of the
direction t: ``G(t) = a0 + a2 cos 2t + b2 sin 2t + a4 cos 4t + b4 sin 4t``, and H likewise with 1, 3
and 5. The responses in a few directions are then short sums, and so are the mean over all
directions of the energy ``G^2 + H^2`` and its second harmonic, which gives the orientation.
"""

import math

import numpy as np

from recon.stereo.kernels.simd import Floats, Lanes, kernel, load, store

DESCRIPTORS = 3
"""Number of directions that describe a pixel in matching: 0, 60 and 120 degrees."""

_ROOT = np.float32(math.sqrt(3) / 2)
"""Sine of 60 degrees."""

Even = tuple[Lanes, Lanes, Lanes, Lanes, Lanes]
"""a0, a2, b2, a4, b4"""
Odd = tuple[Lanes, Lanes, Lanes, Lanes, Lanes, Lanes]
"""a1, b1, a3, b3, a5, b5"""


@kernel
def of_even(basis: Even) -> Even:
    """Harmonics of a filter with basis c^4, c^3 s, .. s^4, without binomials, / 8."""
    g0, g1, g2, g3, g4 = basis
    outer, inner = g0 + g4, 6 * g2
    return 3 * outer + inner, 4 * (g0 - g4), 8 * (g1 + g3), outer - inner, 4 * (g1 - g3)


@kernel
def of_odd(basis: Odd) -> Odd:
    """Harmonics of a filter with basis c^5, c^4 s, .. s^5, without binomials, / 16."""
    h0, h1, h2, h3, h4, h5 = basis
    return (
        10 * (h0 + h4) + 20 * h2,
        10 * (h1 + h5) + 20 * h3,
        5 * (h0 - 3 * h4) - 10 * h2,
        5 * (3 * h1 - h5) + 10 * h3,
        h0 + 5 * h4 - 10 * h2,
        5 * h1 + h5 - 10 * h3,
    )


@kernel
def describe(even: Even, odd: Odd, planes: Floats, u: int) -> None:
    """Write the responses at 0, 60 and 120 degrees to (DESCRIPTORS, 2, W'), at column u."""
    a0, a2, b2, a4, b4 = even
    middle, side = a0 - 0.5 * (a2 + a4), _ROOT * (b2 - b4)
    store(planes[0, 0], u, a0 + a2 + a4)
    store(planes[1, 0], u, middle + side)
    store(planes[2, 0], u, middle - side)
    a1, b1, a3, _, a5, b5 = odd
    middle, side = 0.5 * (a1 + a5) - a3, _ROOT * (b1 - b5)
    store(planes[0, 1], u, a1 + a3 + a5)
    store(planes[1, 1], u, side + middle)
    store(planes[2, 1], u, side - middle)


@kernel
def add_energy(even: Even, odd: Odd, energy: Floats, u: int) -> None:
    """Add to (3, W') the mean energy over all directions, and its second harmonic."""
    a0, a2, b2, a4, b4 = even
    a1, b1, a3, b3, a5, b5 = odd
    sides = a2 * a2 + b2 * b2 + a4 * a4 + b4 * b4
    sides += a1 * a1 + b1 * b1 + a3 * a3 + b3 * b3 + a5 * a5 + b5 * b5
    cosine = 2 * (a0 * a2) + a2 * a4 + b2 * b4 + 0.5 * (a1 * a1 - b1 * b1)
    cosine += a1 * a3 + b1 * b3 + a3 * a5 + b3 * b5
    sine = 2 * (a0 * b2) + a2 * b4 - b2 * a4 + a1 * b1
    sine += a1 * b3 - b1 * a3 + a3 * b5 - b3 * a5
    store(energy[0], u, load(energy[0], u) + a0 * a0 + 0.5 * sides)
    store(energy[1], u, load(energy[1], u) + cosine)
    store(energy[2], u, load(energy[2], u) + sine)


@kernel
def measure(energy: Floats, modulus: Floats) -> None:
    """Strength of the response: an isotropic and a directional part."""
    mean, cosine, sine = energy[0], energy[1], energy[2]
    for u in range(modulus.size):
        along = np.sqrt(cosine[u] * cosine[u] + sine[u] * sine[u])
        modulus[u] = np.sqrt(mean[u] + along)
