"""Training of a model for the von Mises matcher from pairs (thesis 3.7)."""

from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import Any

import numpy as np

from recon.errors import ReconError
from recon.files import atomic_path, check_target
from recon.mapping.sparse import match_features
from recon.records import Features, Matches
from recon.runs.arguments import check_distinct
from recon.runs.evaluate import searching, stated_matching
from recon.sequences.pair_images import read_pair
from recon.sequences.readers.pair_dir import find_image
from recon.settings import Settings, updated
from recon.stereo.features import detect
from recon.stereo.matching.vonmises import train


def train_run(
    pair_dirs: Iterable[Path],
    settings: Settings,
    output: Path,
    *,
    seed: int = 0,
    overwrite: bool = False,
) -> dict[str, Any]:
    """Train on the confident matches of some pairs, without truth, and write the model.

    Returns
    -------
    dict
        The document of `recon train --json`.
    """
    check_target(output, overwrite=overwrite)
    pair_dirs = tuple(pair_dirs)
    check_distinct(pair_dirs)
    examples = list(_examples(pair_dirs, settings))
    if not any(len(matches) for _, _, matches in examples):
        raise ReconError("nothing was matched in any pair, so there is nothing to learn from")
    model = train(examples, np.random.default_rng(seed))
    with atomic_path(output) as part:
        part.write_text(model.to_json(), encoding="utf-8")
    num_matches = sum(len(matches) for _, _, matches in examples)
    return {"output": str(output), "num_pairs": len(examples), "num_matches": num_matches}


def _examples(
    pair_dirs: Iterable[Path], settings: Settings
) -> Iterator[tuple[Features, Features, Matches]]:
    for pair_dir in pair_dirs:
        ranged = searching(settings, stated_matching(pair_dir))
        chosen = updated(ranged, {"matching": {"matcher": "phase"}})
        images = read_pair(*(find_image(pair_dir, side) for side in ("left", "right")))
        left, right = (detect(image, chosen.features) for image in images)
        yield left, right, match_features(left, right, chosen)
