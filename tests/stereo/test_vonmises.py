"""The mixture is fitted correctly; models are trained, saved, and rejected if invalid."""

import numpy as np
import pytest
from scipy.special import i0, i1

from recon.errors import InputError
from recon.settings import FeatureSettings, MatchingSettings
from recon.stereo.features import detect
from recon.stereo.matching import matching, mixture, vonmises
from recon.stereo.matching.mixture import Mixture
from scenes import noisy, textured_pair, truth_at


def sample(rng, size=4000):
    """Draw two thirds at 0.8 with kappa 20, and one third at -1.5 with kappa 5."""
    near, far = rng.vonmises(0.8, 20, size), rng.vonmises(-1.5, 5, size // 2)
    return np.concatenate([near, far])


def test_em_finds_the_components():
    found = mixture.fit(sample(np.random.default_rng(0)), 2)
    order = np.argsort(found.means_rad)
    np.testing.assert_allclose(found.means_rad[order], [-1.5, 0.8], atol=0.05)
    np.testing.assert_allclose(found.kappas[order], [5, 20], rtol=0.15)
    np.testing.assert_allclose(found.weights[order], [1 / 3, 2 / 3], atol=0.03)


def log_likelihoods(improve, phases, rounds=30):
    current = Mixture(
        weights=np.array([0.4, 0.4]), means_rad=np.array([-1.0, 1.0]), kappas=np.array([3.0, 4.0])
    )
    found = []
    for _ in range(rounds):
        found.append(np.log(current.density(phases)).mean())
        current = improve(current, phases)
    return np.array(found)


def fit_by_doubled_angles(current, phases):
    """Apply Eqs 32 and 36 literally: the thesis doubles the angle, as for axes."""
    density = current.components(phases)
    share = (density / density.sum(axis=0))[:-1]
    total = share.sum(axis=1)
    means = 0.5 * np.arctan2(share @ np.sin(2 * phases), share @ np.cos(2 * phases))
    length = (share * np.cos(2 * (phases - means[:, None]))).sum(axis=1) / total
    kappas = mixture.concentration(np.clip(length, 0, 1))
    return Mixture(weights=total / len(phases), means_rad=means, kappas=kappas)


def test_likelihood_never_falls_and_the_doubled_angle_is_worse():
    phases = sample(np.random.default_rng(1))
    single = log_likelihoods(mixture.improved, phases)
    doubled = log_likelihoods(fit_by_doubled_angles, phases)
    assert np.diff(single).min() > -1e-3  # the closed form of kappa is accurate to 0.9 percent
    assert single[-1] > doubled[-1] + 0.1


@pytest.mark.parametrize("kappa", [0.1, 1.0, 3.0, 10.0, 50.0])
def test_concentration_is_within_one_percent(kappa):
    length = i1(kappa) / i0(kappa)
    assert mixture.concentration(np.array(length)) == pytest.approx(kappa, rel=0.009)


def test_density_integrates_to_one():
    found = mixture.fit(sample(np.random.default_rng(2)), 3)
    phases = np.linspace(-np.pi, np.pi, 2000, endpoint=False)
    assert found.density(phases).mean() * 2 * np.pi == pytest.approx(1.0, abs=1e-6)


def test_too_few_phases_are_rejected():
    with pytest.raises(InputError, match="there are 3 phases, but 2 components need at least 4"):
        mixture.fit(np.zeros(3), 2)


@pytest.fixture(scope="module")
def trained():
    left, right, _ = textured_pair(seed=11)
    pair = detect(left, FeatureSettings()), detect(right, FeatureSettings())
    matches = matching.match(*pair, MatchingSettings(max_disparity=16))
    return vonmises.train([(*pair, matches)], np.random.default_rng(0))


def test_model_round_trips_through_json(trained):
    again = vonmises.Model.from_json(trained.to_json())
    phases = np.linspace(-3, 3, 7)
    np.testing.assert_allclose(again.log_ratio(phases), trained.log_ratio(phases))


def test_correct_matches_have_small_phases_and_similar_magnitudes(trained):
    ratio = trained.log_ratio(np.array([0.0, np.pi]))
    assert (ratio[:, -1, 0] > 1.0).all()
    assert (ratio[:, -1, 1] < 0.0).all()
    assert (ratio[:, -1, 0] > ratio[:, 0, 0] + 1.0).all()


def test_training_is_reproducible(trained):
    left, right, _ = textured_pair(seed=11)
    pair = detect(left, FeatureSettings()), detect(right, FeatureSettings())
    matches = matching.match(*pair, MatchingSettings(max_disparity=16))
    assert vonmises.train([(*pair, matches)], np.random.default_rng(0)).to_json() == (
        trained.to_json()
    )


def test_trained_model_matches_another_scene_with_probabilities_as_scores(
    trained, tmp_path, plane, plane_features
):
    path = tmp_path / "model.json"
    path.write_text(trained.to_json())
    settings = MatchingSettings(matcher="vonmises", max_disparity=16, model=str(path))
    matches = matching.match(*plane_features, settings)
    error = np.abs(matches.disparity_px - truth_at(plane[2], matches))
    assert np.mean(error <= 1) > 0.97
    assert ((matches.score >= 0.5) & (matches.score <= 1)).all()


@pytest.mark.parametrize("text", ["", "{}", "[1]", '{"format": "other"}', "not json"])
def test_invalid_model_is_rejected_with_its_name(text):
    with pytest.raises(InputError, match=r"m\.json is not a recon von Mises model"):
        vonmises.Model.from_json(text, "m.json")


def test_missing_model_file_is_named(plane_features):
    settings = MatchingSettings(matcher="vonmises", model="nowhere/model.json")
    with pytest.raises(InputError, match=r"nowhere/model\.json cannot be read"):
        matching.match(*plane_features, settings)


def test_single_bin_uses_phase_only(plane_features):
    matches = matching.match(*plane_features, MatchingSettings(max_disparity=16))
    model = vonmises.train([(*plane_features, matches)], np.random.default_rng(0), num_bins=1)
    assert model.share_right.tolist() == [[1.0]] * 3


def test_training_without_examples_is_rejected():
    with pytest.raises(InputError, match="0 examples"):
        vonmises.train([], np.random.default_rng(0))


def test_nearly_certain_matches_are_still_ranked(plane_features):
    matches = vonmises.match(*plane_features, MatchingSettings(max_disparity=16))
    assert np.sum(matches.score > 0.9999) > 300
    # Ranked by position, they would all lie in the uppermost rows.
    rows = matches.points_px[:300, 1]
    assert rows.min() < 30
    assert rows.max() > 90


def matches_in_noise(*images):
    rng = np.random.default_rng(3)
    pair = [detect(noisy(image, 25, rng), FeatureSettings()) for image in images]
    return vonmises.match(*pair, MatchingSettings(max_disparity=40, min_disparity=-20))


def test_probability_does_not_exceed_the_share_of_correct_matches(plane):
    matches = matches_in_noise(*plane[:2])
    right = np.abs(matches.disparity_px - truth_at(plane[2], matches)) <= 1
    for low, high in [(0.5, 0.8), (0.8, 0.95), (0.95, 1.0)]:
        within = (matches.score >= low) & (matches.score <= high)
        assert within.sum() > 50
        assert right[within].mean() >= matches.score[within].mean()


def test_no_match_of_unrelated_images_is_probable(plane):
    matches = matches_in_noise(plane[0], textured_pair(seed=9)[1])
    assert len(matches) > 100
    assert matches.score.max() < 0.8
