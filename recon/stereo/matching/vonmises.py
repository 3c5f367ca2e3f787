"""The probabilistic matcher: likelihood of phase and magnitude in a correct pair (thesis 3.7).

Each channel (a scale at one direction) of a candidate pair has a phase difference and a magnitude
similarity c. In correct pairs the difference follows a von Mises mixture, narrower for larger c; in
wrong ones it is uniform. The similarity is the mean log likelihood ratio of the channels.
"""

import dataclasses
import json
from collections.abc import Iterable
from dataclasses import dataclass
from functools import cache
from importlib.resources import files

import numpy as np
from numpy.typing import NDArray

from recon.errors import InputError, check_shape
from recon.files.documents import parse_json, read_text
from recon.records import Features, Matches
from recon.settings import MatchingSettings
from recon.stereo.kernels.simd import Floats
from recon.stereo.matching.aggregation import Support
from recon.stereo.matching.mixture import Mixture, fit
from recon.stereo.matching.phase import match_by

Array = NDArray[np.float64]

_NUM_COSINES = 64
"""Bins of the cosine of the phase difference in the table that the matcher looks up."""
_WORTH = 3.7
"""Number of independent channels that all together are equivalent to, as they share pixels;
calibrates the probability (fitted to Venus, Sawtooth, Cones and Map; the others confirm it)."""
_FURTHER_RIVALS = 4.0
"""Weight of all rivals but the best; their odds are about the square of its odds. Where noise
created the pair, all of them are level."""
_SHIPPED = "vonmises_venus.json"
_FORMAT = "recon von Mises model"


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Model:
    """Statistics of correct pairs, by scale and magnitude similarity."""

    widths_px: tuple[float, ...]
    """(S,) widths of the training filters, fine to coarse."""
    mixtures: tuple[tuple[Mixture, ...], ...]
    """(S, B) of the phase difference, for c in B equal bins of 0 to 1."""
    share_right: Array
    """(S, B) share of the correct pairs whose c lies in the bin."""
    share_wrong: Array
    """(S, B) the same for wrong pairs."""

    def __post_init__(self) -> None:
        shape = (len(self.widths_px), len(self.mixtures[0]) if self.mixtures else 0)
        if not all(shape) or not (np.array(self.widths_px) > 0).all():
            raise InputError(f"widths_px are {self.widths_px}, but numbers > 0 are needed")
        if [len(row) for row in self.mixtures] != [shape[1]] * shape[0]:
            raise InputError(f"mixtures are not {shape[0]} rows of {shape[1]}")
        for name in ("share_right", "share_wrong"):
            share = getattr(self, name)
            check_shape(name, share, shape)
            if not ((share > 0).all() and np.isfinite(share).all()):
                raise InputError(f"{name} contains {share.min()}, but numbers > 0 are needed")

    def densities(self, phases_rad: Array) -> Array:
        """(S, B, N) density of the phase differences of correct pairs."""
        return np.array([[m.density(phases_rad) for m in row] for row in self.mixtures])

    def log_ratio(self, phases_rad: Array) -> Array:
        """(S, B, N) log likelihood ratio of correct to wrong pairs at some phase differences."""
        magnitude = np.log(self.share_right / self.share_wrong)
        ratio: Array = magnitude[..., None] + np.log(self.densities(phases_rad) * 2 * np.pi)
        return ratio

    def to_json(self) -> str:
        """The text of a model file."""
        mixtures = [
            [
                {name: getattr(m, name).tolist() for name in ("weights", "means_rad", "kappas")}
                for m in row
            ]
            for row in self.mixtures
        ]
        document = {
            "format": _FORMAT,
            "widths_px": list(self.widths_px),
            "mixtures": mixtures,
            "share_right": self.share_right.tolist(),
            "share_wrong": self.share_wrong.tolist(),
        }
        return json.dumps(document, indent=1)

    @classmethod
    def from_json(cls, text: str, source: str = "model") -> "Model":
        """Read a model file.

        Raises
        ------
        InputError
            If the text is not a model file.
        """
        try:
            document = parse_json(text, source)
            if document["format"] != _FORMAT:
                raise ValueError(f"format is {document['format']!r}")
            return cls(
                widths_px=tuple(float(width) for width in document["widths_px"]),
                mixtures=tuple(
                    tuple(Mixture(**{k: np.array(v, float) for k, v in m.items()}) for m in row)
                    for row in document["mixtures"]
                ),
                share_right=np.array(document["share_right"], dtype=np.float64),
                share_wrong=np.array(document["share_wrong"], dtype=np.float64),
            )
        except (ValueError, KeyError, TypeError, AttributeError) as error:
            raise InputError(f"{source} is not a {_FORMAT} ({error})") from error


def match(left: Features, right: Features, settings: MatchingSettings) -> Matches:
    """Match by the likelihood ratio; the score is the probability of the pair (Eqs 42, 43)."""
    model = load_model(settings.model)
    highest = model.log_ratio(np.zeros(1)).max()

    def lead(support: Support) -> Floats:
        # Log ratio of the pair to its best rival; support is the mean over channels / highest.
        ahead: Floats = (highest * support.score * (1 - support.rival)).astype(np.float32)
        return ahead

    # Ranked by the lead, since many probabilities round to 1.
    matches = match_by(left, right, settings, table(model, len(left.widths_px)), lead)
    odds_of_rival = np.exp(-_WORTH * matches.score)
    odds_of_rivals = odds_of_rival * (1 + _FURTHER_RIVALS * odds_of_rival)
    return dataclasses.replace(
        matches, score=1 / (1 + odds_of_rival), probability=1 / (1 + odds_of_rivals)
    )


def load_model(path: str | None) -> Model:
    """The model of a file, or the one that recon ships, trained on Venus."""
    if path is None:
        return _parsed(files("recon.stereo").joinpath(_SHIPPED).read_text("utf-8"), _SHIPPED)
    try:
        return _parsed(read_text(path), path)
    except OSError as error:
        raise InputError(f"model {path} cannot be read ({error.strerror})") from error


@cache
def _parsed(text: str, source: str) -> Model:
    return Model.from_json(text, source)


def table(model: Model, num_scales: int) -> Floats:
    """Similarity by scale, c and cosine of the phase difference, scaled to a maximum of 1.

    Both signs of the phase are equivalent, so that matching is symmetric in left and right. Scales
    beyond the model's own use its last one.
    """
    cosine = (np.arange(_NUM_COSINES) + 0.5) * 2 / _NUM_COSINES - 1
    phase = np.arccos(cosine)
    ratio = np.logaddexp(model.log_ratio(phase), model.log_ratio(-phase)) - np.log(2)
    scales = np.minimum(np.arange(num_scales), len(ratio) - 1)
    similarity: Floats = (ratio / ratio.max())[scales].astype(np.float32)
    return similarity


def train(
    examples: Iterable[tuple[Features, Features, Matches]],
    rng: np.random.Generator,
    num_bins: int = 8,
) -> Model:
    """Learn a model from confident matches; no truth is needed.

    Parameters
    ----------
    examples : iterable of (left features, right features, matches)
        From images filtered identically. The better half of the matches counts as correct; the same
        left points with randomly shifted partners count as wrong.
    rng : Generator
    num_bins : int
        Number of bins of the magnitude similarity; 1 is the thesis's form, phase only.
    """
    right_pairs, wrong_pairs, widths = [], [], set()
    for left, right, matches in examples:
        best = matches.select(slice(0, max(1, len(matches) // 2)))
        right_pairs.append(_channels(left, right, best, np.rint(best.disparity_px)))
        wrong_pairs.append(_channels(left, right, best, _shifted(best, left, rng)))
        widths.add(left.widths_px)
    if len(widths) != 1:
        raise InputError(
            f"{len(right_pairs)} examples have {len(widths)} sets of filter widths, but one "
            "is needed"
        )
    return _learned(
        np.concatenate(right_pairs, 1), np.concatenate(wrong_pairs, 1), widths, num_bins
    )


def _learned(right: Array, wrong: Array, widths: set[tuple[float, ...]], num_bins: int) -> Model:
    bins = np.minimum((right[..., 1] * num_bins).astype(int), num_bins - 1)
    wrong_bins = np.minimum((wrong[..., 1] * num_bins).astype(int), num_bins - 1)
    mixtures = tuple(
        tuple(fit(_enough(phase[row == b]), is_centred=True) for b in range(num_bins))
        for phase, row in zip(right[..., 0], bins, strict=True)
    )
    return Model(
        widths_px=widths.pop(),
        mixtures=mixtures,
        share_right=_shares(bins, num_bins),
        share_wrong=_shares(wrong_bins, num_bins),
    )


def _enough(phases: Array) -> Array:
    """Phases to fit; uniform for a nearly empty bin."""
    return phases if phases.size >= 16 else np.linspace(-np.pi, np.pi, 64, endpoint=False)


def _shares(bins: NDArray[np.int64], num_bins: int) -> Array:
    """(S, B) share of each bin, none of them zero."""
    count = np.array([np.bincount(row, minlength=num_bins) for row in bins]) + 1.0
    return np.asarray(count / count.sum(axis=1, keepdims=True))


def _shifted(matches: Matches, left: Features, rng: np.random.Generator) -> Array:
    """Disparities wrong by at least three pixels, with partners inside the image."""
    width = left.grey.shape[1]
    u = matches.points_px[:, 0]
    wrong = u - rng.integers(0, width, len(matches))
    near = np.abs(wrong - matches.disparity_px) < 3
    return np.where(near, u - (u - matches.disparity_px + width // 2) % width, wrong)


def _channels(left: Features, right: Features, matches: Matches, disparity: Array) -> Array:
    """(S, O * M, 2) phase difference and similarity of magnitudes of every channel."""
    u, v = matches.points_px.astype(np.int64).T
    partner = np.clip(u - disparity, 0, left.grey.shape[1] - 1).astype(np.int64)
    here, there = _complex(left, u, v), _complex(right, partner, v)
    similarity = np.minimum(np.abs(here), np.abs(there)) / np.maximum(
        np.maximum(np.abs(here), np.abs(there)), 1e-9
    )
    channels = np.stack([np.angle(there * here.conj()), similarity], axis=-1)
    return channels.reshape(len(channels), -1, 2)


def phase_differences(left: Features, right: Features, matches: Matches) -> Array:
    """(S, O * M) phase differences of whole-pixel matches, by scale."""
    return _channels(left, right, matches, np.rint(matches.disparity_px))[..., 0]


def _complex(
    features: Features, u: NDArray[np.int64], v: NDArray[np.int64]
) -> NDArray[np.complex64]:
    """(S, O, M) responses at some pixels."""
    planes = features.planes[v, :, :, :, u]
    response: NDArray[np.complex64] = planes[..., 0] + 1j * planes[..., 1]
    return np.moveaxis(response, 0, -1)
