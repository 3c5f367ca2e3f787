"""Evaluation of many pairs with known truth (Tables 1 and 3)."""

import math
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from recon.errors import InputError
from recon.figures.kept import kept_matches, kept_pair
from recon.figures.kinds import Arrays
from recon.mapping.sparse import match_sparse
from recon.records import Features, Matches
from recon.runs.arguments import positive, texts
from recon.runs.disparity import match_files, matching_of, measure
from recon.runs.figures import leave_figure
from recon.runs.job import Job, Kind, Numbers
from recon.runs.outputs import as_document
from recon.runs.work import Work
from recon.sequences.calibration.files import read_calibration
from recon.sequences.pair_images import read_pair
from recon.sequences.readers.pair_dir import find_image
from recon.sequences.truth import DisparityTruth, read_right_truth, read_truth
from recon.settings import Settings, given_tree, updated
from recon.stereo.evaluation import coverage
from recon.stereo.features import detect
from recon.stereo.matching import vonmises
from recon.stereo.matching.matching import match, match_whole_images
from recon.stereo.subpixel import refine

# Margin beyond the largest true disparity if no calibration states a range.
MARGIN_PX = 4


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Trial:
    """One matcher on one pair with known truth."""

    pair_dir: Path
    settings: Settings
    truth: DisparityTruth
    truth_right_px: NDArray[np.float64] | None

    @property
    def name(self) -> str:
        """Name of the pair in tables."""
        return self.pair_dir.resolve().name

    def image(self, side: str) -> Path:
        """The file of one side."""
        return find_image(self.pair_dir, side)

    def row(self) -> dict[str, Any]:
        """Its metrics, by their JSON keys."""
        pair = match_files(self.image("left"), self.image("right"), self.settings)
        names = {"name": self.name, "matcher": self.settings.matching.matcher}
        shares = {"coverage": coverage(pair.matches, pair.left.shape[:2])}
        return as_document(names | measure(pair, self.truth, self.truth_right_px) | shares)


def _evaluate(job: Job, work: Work) -> Numbers:
    """Evaluate every matcher on every pair.

    The inputs are folders with left.*, right.* and disp_left.*.
    """
    names = job.arguments.get("matchers") or (job.settings.matching.matcher,)
    scale = job.arguments.get("truth_scale")
    check_names(job.inputs)
    trials = [t for path in job.inputs for t in _trials(path, job.settings, names, scale)]
    rows = []
    for trial in trials:
        with work.stage("stereo"):
            rows.append(trial.row())
        work.progress(len(rows), len(trials))
    if work.folder:
        with work.stage("figures"):
            for trial in trials:
                _leave_figures(work.folder.path, trial)
    return {"pairs": rows}


def check_names(paths: tuple[Path, ...]) -> None:
    """Raise `InputError` if two pair folders have the same name."""
    called = [path.resolve().name for path in paths]
    for name in called:
        if called.count(name) > 1:
            raise InputError(f"two pair folders are named {name}, but the names must differ")


def _trials(
    pair_dir: Path, settings: Settings, matchers: Iterable[str], truth_scale: float | None
) -> Iterator[Trial]:
    truth, right_px = read_truth(pair_dir, truth_scale), read_right_truth(pair_dir, truth_scale)
    ranged = searching(settings, own_matching(pair_dir, truth))
    for matcher in matchers:
        chosen = updated(ranged, {"matching": {"matcher": matcher}})
        yield Trial(pair_dir=pair_dir, settings=chosen, truth=truth, truth_right_px=right_px)


def searching(settings: Settings, stated: Numbers) -> Settings:
    """The settings with those of matching that are stated, except for what was given explicitly."""
    own = given_tree(settings)["matching"]
    return updated(
        settings, {"matching": {name: value for name, value in stated.items() if name not in own}}
    )


def own_matching(pair_dir: Path, truth: DisparityTruth) -> Numbers:
    """The calibration's settings, with a range slightly larger than the truth's if it has none."""
    high = math.ceil(np.nanmax(truth.disparity_px)) + MARGIN_PX
    return {"min_disparity": 0, "max_disparity": high} | stated_matching(pair_dir)


def stated_matching(pair_dir: Path) -> Numbers:
    """The settings of matching that follow from a pair's calibration; none if it has none."""
    try:
        return matching_of(read_calibration(pair_dir))
    except InputError:
        return {}


def _leave_figures(run_path: Path, trial: Trial) -> None:
    title = f"{trial.name}_{trial.settings.matching.matcher}"
    for kind, arrays in trial_arrays(trial).items():
        leave_figure(run_path, kind, arrays, f"{title}_{kind}")


def trial_arrays(trial: Trial) -> dict[str, Arrays]:
    """Arrays of a trial to be drawn, by the kind of figure.

    Error map, one scale against all (thesis figure 16), sub-pixel refinement (10, 15), model (17).
    """
    settings, truth = trial.settings, trial.truth.disparity_px
    left, right = read_pair(trial.image("left"), trial.image("right"))
    by_images = match_whole_images(left, right, settings.matching)
    if by_images is not None:
        return {"errors": kept_pair(left, by_images) | {"truth_px": truth}}
    features_left = detect(left, settings.features)
    features_right = detect(right, settings.features)
    whole = match(features_left, features_right, settings.matching)
    tuned = refine(whole, features_left, features_right)
    finest = updated(settings, {"features": {"widths_px": settings.features.widths_px[:1]}})
    one_scale = match_sparse(left, right, finest).matches
    # The row with the widest spread of points: one along a horizontal edge shows nothing.
    spread = np.unique(np.rint(whole.points_px // (8, 1)).astype(np.int64), axis=0)
    fullest = int(np.bincount(spread[:, 1], minlength=1).argmax())
    all_scales = kept_matches("all scales", tuned)
    along_row = kept_matches("matched", whole) | kept_matches("tuned", tuned)
    arrays: dict[str, Arrays] = {
        "errors": kept_pair(left, tuned) | {"truth_px": truth},
        "scales": {"left": left} | kept_matches("one scale", one_scale) | all_scales,
        "tuning": along_row | {"truth_px": truth, "row": np.array(fullest)},
    }
    if settings.matching.matcher == "vonmises":
        arrays["mixture"] = model_arrays(features_left, features_right, whole, settings)
    return arrays


def model_arrays(left: Features, right: Features, matches: Matches, settings: Settings) -> Arrays:
    """Densities of the model beside those of these pairs (thesis figure 17)."""
    model = vonmises.load_model(settings.matching.model)
    phases = np.linspace(-np.pi, np.pi, 361)
    measured = vonmises.phase_differences(left, right, matches)
    shown = min(len(measured), len(model.widths_px))
    titles = [f"filters {width:g} px wide" for width in left.widths_px[:shown]]
    drawn = {"phases_rad": phases, "densities": np.asarray(model.densities(phases)[:shown])}
    return {
        **drawn,
        "titles": np.array(titles, dtype=np.str_),
        **{f"measured_{number}": measured[number] for number in range(shown)},
    }


EVALUATE = Kind(
    run=_evaluate,
    num_inputs=None,
    takes={"matchers": texts, "truth_scale": positive},
    stages=("reading", "stereo", "figures"),
)
