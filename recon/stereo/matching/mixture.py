"""Mixtures of von Mises densities, fitted to phases by expectation-maximisation (3.7.1)."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.special import i0e

from recon.errors import InputError, check_finite, check_shape

Array = NDArray[np.float64]

_LARGEST_KAPPA = 500.0
_TURN = 2.0 * np.pi
_ROUNDING = 1e-9
_NUM_ROUNDS = 100


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Mixture:
    """A sum of von Mises densities and a uniform one, on the circle."""

    weights: Array
    """(W,) shares of the components; the remainder to 1 is uniform."""
    means_rad: Array
    """(W,)"""
    kappas: Array
    """(W,) concentrations."""

    def __post_init__(self) -> None:
        for name in ("weights", "means_rad", "kappas"):
            values = getattr(self, name)
            check_shape(name, values, (len(self.weights),))
            check_finite(name, values)
        if (self.weights < 0).any() or self.weights.sum() > 1 + _ROUNDING:
            raise InputError(f"weights are {self.weights}, but a sum of at most 1 is needed")
        if (self.kappas < 0).any():
            raise InputError(f"kappas contain {self.kappas.min()}, but 0 or more is needed")

    def components(self, phases_rad: Array) -> Array:
        """(W + 1, N) weighted densities of the components, the uniform one last (Eq 24)."""
        difference = phases_rad - self.means_rad[:, None]
        kappa = self.kappas[:, None]
        # exp(kappa cos x) / I0(kappa), both scaled by exp(-kappa) so that neither overflows.
        density = np.exp(kappa * (np.cos(difference) - 1)) / (_TURN * i0e(kappa))
        uniform = np.full((1, len(phases_rad)), (1 - self.weights.sum()) / _TURN)
        return np.concatenate([self.weights[:, None] * density, uniform])

    def density(self, phases_rad: Array) -> Array:
        """(N,) density of the mixture."""
        density: Array = self.components(phases_rad).sum(axis=0)
        return density


def fit(phases_rad: Array, num_components: int = 1, *, is_centred: bool = False) -> Mixture:
    """Fit a mixture to phases.

    Parameters
    ----------
    phases_rad : (N,) array
        Phase differences of correct pairs. They are periodic in a full turn: single angles, unlike
        the thesis, which doubles them (Eqs 32, 36) as for axes and so merges the components.
    num_components : int
    is_centred : bool
        Fix the means at 0, so that a pair is equally probable from the right and from the left.

    Returns
    -------
    Mixture
    """
    phases = np.asarray(phases_rad, dtype=np.float64)
    if phases.size < 2 * num_components:
        raise InputError(
            f"there are {phases.size} phases, but {num_components} components need at least "
            f"{2 * num_components}"
        )
    start = (np.arange(num_components) + 0.5) / num_components - 0.5
    mixture = Mixture(
        weights=np.full(num_components, 0.95 / num_components),
        means_rad=np.zeros(num_components) if is_centred else start * np.pi,
        kappas=np.linspace(2.0, 8.0, num_components),
    )
    for _ in range(_NUM_ROUNDS):
        mixture = improved(mixture, phases, is_centred)
    return mixture


def improved(mixture: Mixture, phases_rad: Array, is_centred: bool = False) -> Mixture:
    """One round of expectation (Eq 33) and maximisation; the likelihood never decreases."""
    density = mixture.components(phases_rad)
    share = (density / density.sum(axis=0))[:-1]
    total = np.maximum(share.sum(axis=1), 1e-12)
    resultant = share @ np.exp(1j * phases_rad) / total
    means = np.zeros(len(total)) if is_centred else np.angle(resultant)
    length = np.clip((resultant * np.exp(-1j * means)).real, 0.0, 1.0)
    return Mixture(weights=total / len(phases_rad), means_rad=means, kappas=concentration(length))


def concentration(resultant_length: Array) -> Array:
    """Kappa from the mean resultant length R, within 0.9 percent (Best and Fisher 1981).

    The thesis's Eq 37 is off by up to a third.
    """
    r = np.minimum(np.asarray(resultant_length, dtype=np.float64), 0.999)
    low = 2 * r + r**3 + 5 * r**5 / 6
    middle = -0.4 + 1.39 * r + 0.43 / (1 - r)
    high = 1 / np.maximum(r**3 - 4 * r**2 + 3 * r, 1e-9)
    kappa: Array = np.where(r < 0.53, low, np.where(r < 0.85, middle, high))
    return np.minimum(kappa, _LARGEST_KAPPA)
